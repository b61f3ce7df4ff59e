// SPDX-License-Identifier: Apache-2.0
// Computes the light that the projector really throws for a pattern, in double precision: pattern value ->
// response, and harmonics beside it -> blur (docs/CONVENTIONS.md), as a function of the projector coordinate
// and as samples of it.
#pragma once
#include <cstddef>
#include <vector>

#include "render/base/phase_series.hpp"
#include "twin/twin.hpp"

namespace fringetwin::render {

/// Returns true when the response maps every value onto itself.
bool is_linear(const ProjectorResponse& response);
/// Returns true when the light of every phase step is mean + amplitude cos(phase): the waveform is a sine,
/// the response linear, and there are no harmonics.
bool throws_pure_cosines(const Twin& twin);

/// Returns the factor by which a Gaussian blur multiplies harmonic k of a period of `pitch_px`,
/// exp(-2 (pi k sigma / pitch)^2): the Fourier transform of a unit Gaussian of sigma `sigma_px`.
double blur_attenuation(int harmonic, double sigma_px, double pitch_px);

/// Returns how far beyond the projector's image a pattern is tabulated: 2 px and the circle of confusion.
double pattern_margin_px(const Projector& projector);

/// Returns the even Fourier series of response(mean + amplitude cos t) up to `harmonics`, each coefficient to
/// about 1e-15: Gauss-Legendre panels split at the kinks of the response and graded towards the
/// branch point of a power law at value 0.
PhaseSeries cosine_series(const ProjectorResponse& response, double mean, double amplitude, int harmonics);

/// Returns the Fourier series of the light of a phase step before blur, up to `harmonics`: the response to
/// the fringes' waveform, and the added harmonics. Its sines are left out where there can be none.
PhaseSeries fringe_series(const ProjectorResponse& response, const Fringes& fringes, const Harmonics& added,
                          int harmonics);

/// Returns the total variation of the response to one period of the waveform: harmonic k of a waveform of
/// total variation V is at most V/(pi k) in size.
double total_variation(const ProjectorResponse& response, const Fringes& fringes);

/// One image of the sequence after response and Gaussian blur, as a function of the projector coordinate.
/// Build once, evaluate often. Without blur: response(pattern_value(x)) + harmonic_light(x), its swing about
/// the mean over a period times the contrast of the pitch. With pixel structure x is that of the pixel's
/// centre, the value rounded to the frame buffer's levels; with gaps between the pixels it is relative to a
/// white image there (gap_waveform).
class EffectivePattern {
 public:
  EffectivePattern(const Twin& twin, const PatternSpec& pattern);
  /// Returns the fraction of full scale at `coordinate_px` along the pattern's axis. The pattern continues
  /// beyond the projector's image; whether light reaches a point there is the renderer's business.
  double operator()(double coordinate_px) const;
  /// Returns its values at first_px + i / per_px, those of blurred code images to 3e-8 of full scale.
  std::vector<double> table(double first_px, double per_px, std::size_t n) const;

 private:
  enum class Method { direct, series, convolution, edges, pixels };
  struct Edge {
    double position_px = 0.0;
    double before = 0.0;  ///< value left of it
    double step = 0.0;
  };
  double full_contrast(double coordinate_px) const;
  double light(double phase_rad) const;
  double convolve(double coordinate_px) const;
  double sum_edges(double coordinate_px) const;
  double mix_pixels(double coordinate_px) const;
  double pixel_value(double center_px) const;
  /// Returns where the projector shows what the pattern has there: see shown_px_.
  double shown_at(double center_px) const;
  void find_edges(double size_px);
  void find_breaks();

  Method method_ = Method::direct;
  Fringes fringes_;
  PatternSpec pattern_;
  ProjectorResponse response_;
  double sigma_px_ = 0.0, pitch_px_ = 1.0, origin_px_ = 0.0, shift_rad_ = 0.0;
  double shown_px_ =
      0.0;  ///< of a code under a halo: the image's size, whose first and last pixels go on; else 0
  double margin_px_ = 0.0, pixel_fill_ = 1.0, levels_ = 0.0;
  double contrast_ = 1.0, mean_light_ = 0.0;  ///< the mean: over a period, where there is a contrast
  PhaseSeries series_;          ///< blurred, phase steps; with convolution the added harmonics alone
  std::vector<double> breaks_;  ///< t within one turn where the light is not smooth
  std::vector<Edge> edges_;     ///< ascending, Gray images
  double first_value_ = 0.0;    ///< left of all edges
};

}  // namespace fringetwin::render
