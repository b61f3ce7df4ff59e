// SPDX-License-Identifier: Apache-2.0
// Compares the renderer with the double-precision reference over a block of pixels.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "render/reference/reference.hpp"
#include "render/renderer.hpp"

namespace fringetwin::testing {

/// Pixels x0, x0 + stride ... < x0 + width, and the same in y.
struct PixelBlock {
  int x0 = 0, y0 = 0, width = 1, height = 1, stride = 1;
};
struct ReferenceBlockPixel {
  int x = 0, y = 0;
  /// An interior pixel (docs/CONVENTIONS.md): `pixel.interior` of the pixel and of its eight neighbours.
  bool interior = false;
  render::ReferencePixel pixel;
};
/// All pixels of the block inside the image (or only the interior ones), in rows, in parallel; the
/// result does not depend on the number of threads.
std::vector<ReferenceBlockPixel> reference_block(const render::Reference& reference, std::size_t camera,
                                                 const PixelBlock& block,
                                                 const render::ReferenceQuadrature& quadrature = {},
                                                 bool only_interior = false);

/// The default device's renderer, one per test program; nullptr when there is no Vulkan device.
render::Renderer* shared_renderer();
/// The same for helpers of tests; throws where there is no device.
render::Renderer& needed_renderer();
/// True when a missing device is a failure: CI or FRINGETWIN_REQUIRE_DEVICE is set.
bool device_required();

/// Skips the test in whose body it stands (or fails it, where a device is required) when there is no device.
#define REQUIRE_RENDERER()                                                              \
  do {                                                                                  \
    if (!::fringetwin::testing::shared_renderer()) {                                    \
      if (::fringetwin::testing::device_required()) FAIL() << "no Vulkan device found"; \
      GTEST_SKIP() << "no Vulkan device found";                                         \
    }                                                                                   \
  } while (false)

/// Argument of the first harmonic of N phase steps, (-pi, pi] (docs/CONVENTIONS.md: pattern n is
/// mean + amplitude cos(phase + 2 pi n/N)); `value(n)` is the image value of step n.
double stepped_phase(int steps, const std::function<double(int)>& value);
double wrap(double phase_rad);  ///< to (-pi, pi]

struct PitchAgreement {
  double phase_mean_rad = 0.0, phase_rms_rad = 0.0, phase_max_rad = 0.0;
};
struct Agreement {
  int n = 0;
  std::vector<PitchAgreement> pitches;  ///< all directions' pitches, in sequence order
  double gray_rms = 0.0;                ///< of full scale: gain_dn dE / (2^bits - 1), all images
  double gray_max = 0.0;
  double worst_phase_rms_rad() const;
  std::string text() const;  ///< one line for a log
};

enum class Pixels { interior, hit, all };

/// Compares images (irradiance, sequence order) with a reference block. `only` selects pixels.
Agreement compare(const Twin& twin, std::size_t camera, const std::vector<ImageF>& irradiance,
                  const std::vector<ReferenceBlockPixel>& truth, Pixels pixels = Pixels::interior);

/// Renders camera `camera` and compares it with the reference over the block.
Agreement agreement(const Twin& twin, std::size_t camera, const render::Sampling& sampling,
                    const PixelBlock& block, Pixels pixels = Pixels::interior,
                    const render::ReferenceQuadrature& quadrature = {});

/// Square block of about `side` x `side` pixels around the projection of a world point.
PixelBlock block_around(const Twin& twin, std::size_t camera, const Eigen::Vector3d& point_world_mm, int side,
                        int stride);
/// The whole image.
PixelBlock whole_image(const Twin& twin, std::size_t camera, int stride = 1);

}  // namespace fringetwin::testing
