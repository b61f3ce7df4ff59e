// SPDX-License-Identifier: Apache-2.0
// Decides which gray values of one camera are compared: images, pixels, and the simulated irradiance that
// belongs to each of them.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "compare/result/options.hpp"
#include "compare/result/rows.hpp"
#include "compare/result/side.hpp"

namespace fringetwin::compare {

/// One camera of both sides. Points into Twin and Side, which must outlive it.
struct GrayPair {
  const Camera* camera = nullptr;
  const CameraImages* real = nullptr;
  const CameraImages* simulated = nullptr;   ///< DN as rendered with the twin's sensor; may be null
  const CameraImages* irradiance = nullptr;  ///< never null: irradiance, or the simulated DN themselves
  /// E = e_scale * irradiance value + e_offset.
  double e_scale = 1.0, e_offset = 0.0;
  bool from_dn = false;               ///< E comes from quantised (and perhaps noisy) gray values
  std::vector<PatternSpec> patterns;  ///< the whole sequence
  std::vector<int> images;            ///< sequence indices compared (phase steps and Gray code)
  std::vector<int> gain_images;       ///< those the gain is fitted on
  ImageU8 mask;                       ///< 1 where both decodes call the pixel valid

  int width() const { return mask.width; }
  int height() const { return mask.height; }
  double source_at(int image, std::size_t i) const {
    return static_cast<double>(irradiance->images[static_cast<std::size_t>(image)].data[i]);
  }
  double irradiance_at(int image, std::size_t i) const { return e_scale * source_at(image, i) + e_offset; }
};

/// Clears the pixels that a decode of that size calls invalid.
void clear_invalid(const measure::CameraDecode& decode, ImageU8& mask);

/// Returns the step between the rows that sums over blocks of pixels take: every second row of images of a
/// megapixel or more: half the time, and their blocks still hold pixels enough.
inline int row_step(int width, int height) { return width * height >= 1'000'000 ? 2 : 1; }

/// Pairs the cameras of the two sides; empty when a side has no images. Warnings say what was left out and
/// why.
std::vector<GrayPair> pair_gray(const Twin& twin, const Side& real, const Side& simulated,
                                const CompareOptions& options, std::vector<std::string>& warnings);

/// Which gray values enter sums: a valid pixel, a real value below saturation, a simulated value that
/// is not clipped, and a prediction within [low_dn, high_dn].
struct Usable {
  double saturation_dn = 0.0;                  ///< of the real camera
  double sim_low = 0.0, sim_high = 0.0;        ///< irradiance-source values strictly between
  double gain_dn = 1.0, black_level_dn = 0.0;  ///< prediction used for the clip test
  double low_dn = 0.0, high_dn = 0.0;
};
/// Returns the ranges that keep values away from a clip, for this gain and residual scale.
Usable clip_test(const GrayPair& pair, double gain_dn, double black_level_dn, double sigma_dn);

/// Says whether a gray value enters sums; `v`: value of the irradiance source.
inline bool is_usable(const Usable& u, double real_dn, double v, double predicted_dn) {
  return real_dn < u.saturation_dn && v > u.sim_low && v < u.sim_high && predicted_dn >= u.low_dn &&
         predicted_dn <= u.high_dn;
}

}  // namespace fringetwin::compare
