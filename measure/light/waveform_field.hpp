// SPDX-License-Identifier: Apache-2.0
// Estimates how the form of the fringes varies over a camera's image: lenses and a projector that is not in
// focus everywhere show the same fringe differently here and there (docs/metrics/measure.md, "Plain
// fringes").
#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "measure/light/light_factors.hpp"
#include "twin/image/gray_image.hpp"

namespace fringetwin::measure {

/// Phase steps of one pitch, all or some of those that a period has.
struct PitchImages {
  int steps_total = 0;
  std::vector<int> step = {};
  std::vector<const GrayImage*> image = {};  ///< in steady light
  std::vector<double> shift_rad = {};
};

/// Cosine and sine of the harmonics 2, 3 ... of one pitch, over the fringe's amplitude, as polynomials of the
/// place in the image, up to the fourth order: as many orders as tell more than chance would.
class WaveformField {
 public:
  /// Fits it to the pixels that are lit and not clipped, 200,000 of them at most; each has its mean, its
  /// amplitude and its phase, and the weight of its noise. `waveform`: of LightFactors that these steps told,
  /// the form where it is the same all over. Any number of threads gives the same.
  WaveformField(const PitchImages& steps, const std::vector<double>& waveform, const LightOptions& options,
                double clipped_dn);

  bool varies() const { return of_term_.cols() > 1; }
  /// Returns the form at a pixel, an index into the images.
  Eigen::VectorXd at(std::size_t pixel) const {
    const auto width = static_cast<std::size_t>(width_);
    return of_term_ * terms(static_cast<double>(pixel % width), static_cast<double>(pixel / width));
  }

 private:
  friend class WaveformFieldFit;
  /// The rectangle of the image that holds all lit pixels.
  struct Part {
    int x0, y0, x1, y1;
  };
  /// Returns Legendre's P_i(u) P_j(v) at a place of the image, u and v from -1 to 1 across the lit part and
  /// no farther beside it, the lowest orders i + j first, as many as `of_term_` has columns.
  Eigen::VectorXd terms(double x, double y) const;

  int width_;
  Part part_;
  Eigen::MatrixXd of_term_;  ///< a column per term
};

}  // namespace fringetwin::measure
