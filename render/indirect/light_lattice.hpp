// SPDX-License-Identifier: Apache-2.0
// Chooses the pixels at which light over other surfaces is gathered, and interpolates it between them: it is
// smooth where one surface fills a square of pixels, but for corners that surfaces make. Squares that do not
// tell the light of their middles are quartered, down to single pixels.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "render/indirect/seen_image.hpp"
#include "render/indirect/surface_roughness.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::render {

/// The light that some pixels gathered, per unit of their own reflectivity.
struct LightOfPixels {
  std::vector<float> values = {};  ///< [pixel][number]: channel 0 the mean over all patterns, then any more
  std::vector<float> sigma = {};   ///< standard error of channel 0
  /// Other light of the same pixels, of which a tolerance is, too; empty: there is none.
  std::vector<float> beside = {};
};

class LightLattice {
 public:
  static constexpr int kFirstStepPx = 8;  ///< between the corners of the first squares
  using Gather = std::function<LightOfPixels(const std::vector<std::uint32_t>& pixels)>;

  /// Chooses pixels until squares between them tell the light of their middles, the first `channels` of
  /// `numbers`, to `tolerance` of it and what is beside it, or to what its noise lets see. Where quarters of
  /// squares are off as they were, that is noise of a rough surface or of the light: squares that are off by
  /// no more than is usual stay. `roughness`: of `seen`.
  LightLattice(const SeenImage& seen, RoughnessAtSteps& roughness, std::size_t channels, std::size_t numbers,
               float tolerance, const Gather& gather, int first_step_px = kFirstStepPx);

  const std::vector<std::uint32_t>& pixels() const { return pixels_; }
  /// The light of the first gathering.
  const std::vector<float>& values() const { return values_; }
  /// Returns the root mean square of the standard errors and of what light is off where surfaces are rough.
  double noise() const;
  /// Returns the root mean square of the mean light.
  double light() const;
  /// Interpolates one of so many `numbers` of `values` ([pixel of pixels()][number]); 0 where nothing is
  /// seen.
  ImageF interpolated(const std::vector<float>& values, std::size_t numbers, std::size_t number) const;

 private:
  struct Square {
    int x0, y0, x1, y1;       ///< pixels of its corners
    float larger_off = 0.0F;  ///< by how much the square that it is a quarter of was off, 0: of none
  };
  std::vector<Square> first_squares(int step) const;
  void gather_corners_and_middles(const std::vector<Square>& squares, const Gather& gather);
  void gather_new(const std::vector<std::uint32_t>& pixels, const Gather& gather);
  void want(int x, int y, std::vector<std::uint32_t>& pixels) const;
  /// `noise`: of a rough surface, smaller than what light tells.
  enum class Sees { smooth_surface, rough_surface, noise, edges };
  Sees seen_by(const Square& s, RoughnessAtSteps& roughness) const;
  std::array<std::size_t, 4> corners_of(const Square& s) const;
  /// How well the corners of a square tell the light of its middle.
  struct Told {
    bool enough = false;
    Sees sees = Sees::edges;
    float off = 0.0F;
    bool rough() const { return sees == Sees::rough_surface; }
    bool on_one_surface() const { return rough() || sees == Sees::smooth_surface; }
  };
  /// A rough square that waits for what quarters of others say.
  struct Waiting {
    Square square;
    Told told;
  };
  Told told_by(const Square& s, float tolerance, RoughnessAtSteps& roughness) const;
  bool sees_one_surface(const Square& s, const SurfaceLimits& limits) const;
  static std::optional<bool> quartering_helps(const std::vector<Square>& squares,
                                              const std::vector<Told>& told);
  void take(const Square& s, const Told& told);
  void release(const std::vector<Waiting>& waiting, bool helps, std::vector<Square>& smaller);
  static void quarter(const Square& s, float off, std::vector<Square>& out);

  const SeenImage& seen_;
  std::size_t channels_, numbers_;
  std::vector<std::int32_t> number_;  ///< per pixel: its number in pixels_, -1 none
  std::vector<std::uint32_t> pixels_;
  std::vector<float> values_, sigma_, beside_;
  std::vector<Square> squares_;  ///< between whose corners light is interpolated
  double off_sq_ = 0.0;          ///< sum over the rough ones of them
};

}  // namespace fringetwin::render
