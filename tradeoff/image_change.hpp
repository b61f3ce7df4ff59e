// SPDX-License-Identifier: Apache-2.0
// Compares two renderings of the same pixels: the gray values of all images on both sides go in, weighted rms
// differences of phase and gray value come out (docs/metrics/tradeoff.md).
#pragma once
#include <cstddef>
#include <vector>

#include "tradeoff/pixel_subset.hpp"
#include "twin/image/gray_image.hpp"
#include "twin/image/image.hpp"
#include "twin/twin.hpp"

namespace fringetwin::tradeoff {

/// Holds weighted rms differences over a subset's pixels. Those over all pixels estimate the whole image:
/// edge and interior pixels are weighted by their shares in it.
struct ImageChange {
  double phase_rms_rad = 0.0;           ///< finest pitch of each direction, all lit pixels
  double phase_interior_rms_rad = 0.0;  ///< interior pixels only
  double gray_rms_dn = 0.0;             ///< all pixels and images
  double gray_interior_rms_dn = 0.0, gray_edge_rms_dn = 0.0;
  std::size_t n_phase = 0;  ///< pixels modulated on both sides
  std::size_t n_gray = 0, n_interior = 0;
};

/// Holds the gray values of some pixels of one camera: [pixel][image].
using PixelValues = std::vector<std::vector<double>>;
/// Returns scale * image + offset at the pixels.
PixelValues take_pixels(const std::vector<ImageF>& images, const std::vector<SubsetPixel>& pixels,
                        double scale, double offset);
PixelValues take_pixels(const std::vector<GrayImage>& images, const std::vector<SubsetPixel>& pixels);

/// Adds up the change over the pixels of all cameras.
class ChangeSum {
 public:
  /// A pixel's phase counts when the amplitude of its fringe is at least `min_modulation_dn` on both sides.
  ChangeSum(const Fringes& fringes, double min_modulation_dn);
  /// Adds the pixels of one camera, with their gray values on the sides a and b, DN. `interior`, when given,
  /// replaces the pixels' own class.
  void add(const std::vector<SubsetPixel>& pixels, const PixelValues& a, const PixelValues& b,
           const std::vector<bool>* interior = nullptr);
  ImageChange result() const;

 private:
  struct MeanSquare {
    double sum = 0.0, weight = 0.0;
    std::size_t n = 0;
    void add(double value, double w);
    double rms() const;
  };
  struct Group {
    std::size_t first_image = 0;
    int steps = 0;
  };
  std::vector<Group> groups_;  ///< first step of the finest pitch of each direction
  double min_modulation_dn_;
  MeanSquare phase_, phase_interior_, gray_, gray_interior_, gray_edge_;
  std::size_t n_phase_ = 0, n_gray_ = 0, n_interior_ = 0;
};

}  // namespace fringetwin::tradeoff
