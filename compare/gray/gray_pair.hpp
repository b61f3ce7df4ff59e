// SPDX-License-Identifier: Apache-2.0
// Pairs the real and the simulated images of each camera for the comparison of gray values: both sides go in;
// the images and pixels that are compared, and the simulated irradiance E at each of them, come out.
#pragma once
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "compare/result/options.hpp"
#include "compare/result/rows.hpp"
#include "compare/result/side.hpp"

namespace fringetwin::compare {

/// Holds what both sides have of one camera. Points into Twin and Side, which must outlive it.
struct GrayPair {
  const Camera* camera = nullptr;
  const CameraImages* real = nullptr;  ///< straightened where the twin's camera has a response or maps
  const CameraImages* simulated =
      nullptr;  ///< DN as rendered with the twin's sensor, straightened; may be null
  const CameraImages* irradiance = nullptr;  ///< never null: irradiance, or the simulated DN themselves
  /// Irradiance E = e_scale * (value of `irradiance`) + e_offset.
  double e_scale = 1.0, e_offset = 0.0;
  bool from_dn = false;               ///< E comes from quantised (and perhaps noisy) gray values
  std::vector<PatternSpec> patterns;  ///< the whole sequence
  std::vector<int> images;            ///< sequence indices compared (phase steps and Gray code)
  std::vector<int> gain_images;       ///< those the gain is fitted on
  ImageU8 mask;                       ///< 1 where both decodes call the pixel valid
  /// Own what `real` and `simulated` point to where gray values are straightened.
  std::shared_ptr<const CameraImages> straight_real = {}, straight_simulated = {};

  /// Returns gain_images and the images of a code, which tell how far light is spread, in their order.
  std::vector<int> gain_and_code_images() const;
  /// Returns the images of a code that the gain is not fitted on, those beside phase steps.
  std::vector<int> code_images() const;
  int width() const { return mask.width; }
  int height() const { return mask.height; }
  /// Returns the real gray value in this image of the sequence at pixel i.
  double real_at(int image, std::size_t i) const { return static_cast<double>(real->images[image][i]); }
  /// Returns the value of `irradiance` in this image of the sequence at pixel i.
  double source_at(int image, std::size_t i) const {
    return static_cast<double>(irradiance->images[image][i]);
  }
  /// Returns the irradiance E there.
  double irradiance_at(int image, std::size_t i) const { return e_scale * source_at(image, i) + e_offset; }
};

/// Returns the images as a camera whose response is straight and whose pixels are all alike would have taken
/// them: black + f^-1(DN - black - the pixel's offset)/the pixel's factor. What is clipped stays beyond the
/// bounds, of which the upper one is what 999 of 1000 pixels reach.
std::shared_ptr<const CameraImages> straightened(const CameraImages& images, const Sensor& sensor);

/// Returns a mask that is 1 where no decode of either side calls the pixel invalid.
ImageU8 valid_in_both(const Camera& camera, std::size_t index, const Side& real, const Side& simulated);

/// Returns the pixels of a mask that are set, every k-th of them where there are more than `most`.
std::vector<std::size_t> set_pixels(const ImageU8& mask,
                                    std::size_t most = std::numeric_limits<std::size_t>::max());
/// Returns the phase at the pitch of this image; null where it has none, as an image of a code.
const ImageF* wrapped_phase(const measure::CameraDecode& decode, const PatternSpec& pattern);

/// Returns the step between the rows that enter sums over blocks of pixels: 2 for images of a megapixel or
/// more, whose blocks hold enough pixels with every second row, else 1.
inline int row_step(int width, int height) { return width * height >= 1'000'000 ? 2 : 1; }

/// Returns one pair per camera; none when a side has no images. Adds a warning for images that are left out.
std::vector<GrayPair> pair_gray(const Twin& twin, const Side& real, const Side& simulated,
                                const CompareOptions& options, std::vector<std::string>& warnings);

/// Holds the ranges of gray values that enter sums: a real value below saturation, a simulated value that is
/// not clipped, and a prediction, gain_dn E + black_level_dn, within [low_dn, high_dn].
struct UsableRange {
  double saturation_dn = 0.0;                  ///< of the real camera
  double sim_low = 0.0, sim_high = 0.0;        ///< values of `irradiance`, bounds excluded
  double gain_dn = 1.0, black_level_dn = 0.0;  ///< the prediction's line
  double low_dn = 0.0, high_dn = 0.0;
};
/// Holds how far a prediction keeps away from black and from saturation, where noise is cut off on one side.
struct ClipMargins {
  double low_dn = 0.0, high_dn = 0.0;
};
/// Returns the ranges that leave out clipped values. The prediction keeps away from black and saturation by
/// these margins, at least by 2 DN and at most by a quarter of the range; values of float images have no
/// bounds.
UsableRange usable_range(const GrayPair& pair, double gain_dn, double black_level_dn,
                         const ClipMargins& margins);

/// Returns whether a gray value enters sums; `v` is the pair's source_at() the pixel.
inline bool is_usable(const UsableRange& u, double real_dn, double v, double predicted_dn) {
  return real_dn < u.saturation_dn && v > u.sim_low && v < u.sim_high && predicted_dn >= u.low_dn &&
         predicted_dn <= u.high_dn;
}

}  // namespace fringetwin::compare
