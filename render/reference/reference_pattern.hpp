// SPDX-License-Identifier: Apache-2.0
// What the projector throws, once more and in other ways than waveform.cpp and the shaders: brute-force
// sums and quadratures in double, for the reference renderer.
#pragma once
#include <Eigen/Core>
#include <vector>

#include "twin/twin.hpp"

namespace fringetwin::render {

/// Radius (px, per axis) of the circle of confusion at depth z_mm of the projector's frame; 0 without
/// [projector.optics]. An emitter's cone has the diameter D |z - s|/s there, D = focal length / f-number,
/// and a pixel spans z/f_px.
Eigen::Vector2d reference_defocus_px(const Projector& projector, double z_mm);

/// Factor of a white image by the dark gaps between the projector's pixels; 1 without them.
double reference_pixel_gaps(const Projector& projector, const Eigen::Vector2d& q_px);

/// Factor of everything projected at q by the field of the projector's light; 1 without it.
double reference_light_field(const Projector& projector, const Eigen::Vector2d& q_px);

/// What a pixel raster of these levels lights at q: response, then the Gaussian blur of its square pixels.
double reference_shown_level(const Projector& projector, const ImageF& levels, const Eigen::Vector2d& q_px);

/// One image of the sequence, without the factors of gaps and field.
class ReferencePattern {
 public:
  /// `shift_px`: by how much it lies further along its axis. `of_image`: harmonics of the orders 1, 2, ...
  /// besides those of its pitch.
  ReferencePattern(const Twin& twin, const PatternSpec& pattern, double shift_px = 0.0,
                   Harmonics of_image = {});
  double operator()(const Eigen::Vector2d& q_px, const Eigen::Vector2d& defocus_px) const;

 private:
  double response(double value) const;
  double frame_buffer(long pixel) const;
  Harmonics harmonics_at(const Eigen::Vector2d& q_px) const;
  double harmonics(const Harmonics& list, double x, double radius, double sigma, int lowest = 2) const;
  double raster(double x, double radius, double sigma) const;
  double full_contrast(const Eigen::Vector2d& q_px, const Eigen::Vector2d& defocus_px) const;
  double spread_light(const Harmonics& list, double x, double radius, double sigma, double further_px) const;
  double mean_over_a_period() const;
  double shown_at(double x) const;
  double sum_pieces(double x, double radius, double width, double start, double sigma) const;
  double convolve(double x, double sigma) const;
  double smooth(double x, double radius, double further_px) const;
  double waveform(double x, double radius, double sigma) const;

  Projector projector_;
  Fringes fringes_;
  PatternSpec spec_;
  Harmonics of_image_;
  Axis axis_ = Axis::x;
  double pitch_px_ = 1.0, origin_px_ = 0.0, shift_px_ = 0.0;
  double contrast_ = 1.0, mean_ = 0.0;  ///< of the pitch; the mean over a period, where a contrast is stated
  std::vector<double> fourier_;         ///< of the response over one period
};

}  // namespace fringetwin::render
