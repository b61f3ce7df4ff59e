// SPDX-License-Identifier: Apache-2.0
// Says how far two renderings of the same pixels are apart, in phase and gray (docs/metrics/tradeoff.md).
#pragma once
#include <cstddef>
#include <vector>

#include "tradeoff/pixel_subset.hpp"
#include "twin/image/image.hpp"
#include "twin/twin.hpp"

namespace fringetwin::tradeoff {

/// Weighted rms over the subset. "all" estimates the whole image, edges with their share in it.
struct ImageChange {
  double phase_rms_rad = 0.0;           ///< finest pitch of each direction, all lit pixels
  double phase_interior_rms_rad = 0.0;  ///< interior pixels only
  double gray_rms_dn = 0.0;             ///< all pixels and images
  double gray_interior_rms_dn = 0.0, gray_edge_rms_dn = 0.0;
  std::size_t n_phase = 0;  ///< pixels modulated on both sides
  std::size_t n_gray = 0, n_interior = 0;
};

/// The gray values of some pixels of one camera: [pixel][image].
using PixelValues = std::vector<std::vector<double>>;
/// Returns scale * image + offset at the pixels.
PixelValues take_pixels(const std::vector<ImageF>& images, const std::vector<SubsetPixel>& pixels,
                        double scale = 1.0, double offset = 0.0);

/// Adds up the change over the pixels of all cameras.
class ChangeSum {
 public:
  /// A pixel has a phase when half its fringe's swing is at least `min_modulation_dn` on both sides.
  ChangeSum(const Fringes& fringes, double min_modulation_dn);
  /// Pixels of one camera on both sides, DN. `interior` overrides the pixels' own class when given.
  void add(const std::vector<SubsetPixel>& pixels, const PixelValues& a, const PixelValues& b,
           const std::vector<bool>* interior = nullptr);
  ImageChange result() const;

 private:
  struct Mean {
    double sum = 0.0, weight = 0.0;
    std::size_t n = 0;
    void add(double value, double w);
    double root() const;
  };
  struct Group {
    std::size_t first_image = 0;
    int steps = 0;
  };
  std::vector<Group> groups_;  ///< first step of the finest pitch of each direction
  double min_modulation_dn_;
  Mean phase_, phase_interior_, gray_, gray_interior_, gray_edge_;
  std::size_t n_phase_ = 0, n_gray_ = 0, n_interior_ = 0;
};

}  // namespace fringetwin::tradeoff
