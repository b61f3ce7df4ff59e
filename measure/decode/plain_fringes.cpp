// SPDX-License-Identifier: Apache-2.0
#include "measure/decode/plain_fringes.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <utility>

#include "measure/decode/phase.hpp"
#include "measure/light/waveform_field.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::measure {
namespace {

/// Each is some percent of the one before, as the harmonics are.
constexpr int kPasses = 4;
constexpr std::size_t kMostSteps = kMostLightSteps;

/// Takes the harmonics and the shifts out of one pitch's steps.
class PitchPlain {
 public:
  /// `shift_rad`: of each of these steps.
  PitchPlain(const std::vector<int>& steps, int steps_total, const WaveformField& field,
             const std::vector<double>& shift_rad, const std::vector<GrayImage*>& images)
      : solver_(steps, steps_total), field_(field), at_first_pixel_(field.at(0)), images_(images.size()) {
    std::ranges::transform(images, images_.begin(),
                           [](GrayImage* image) { return image->as_floats().data(); });
    n_pixels_ = images.front()->size();
    for (int i = 0; i < solver_.count(); ++i) {
      step_.emplace_back(solver_.basis_cos(i), -solver_.basis_sin(i));
      turn_.push_back(step_.back() * std::polar(1.0, shift_rad[static_cast<std::size_t>(i)]));
    }
  }

  void run(double clipped_dn, double min_amplitude) {
    const auto n_pixels = static_cast<std::ptrdiff_t>(n_pixels_);
#pragma omp parallel for schedule(static)
    for (std::ptrdiff_t i = 0; i < n_pixels; ++i)
      run_pixel(static_cast<std::size_t>(i), clipped_dn, min_amplitude);
  }

 private:
  void run_pixel(std::size_t pixel, double clipped_dn, double min_amplitude) const {
    double value[kMostSteps], added[kMostSteps] = {};
    const std::size_t n = images_.size();
    for (std::size_t i = 0; i < n; ++i) {
      value[i] = static_cast<double>(images_[i][pixel]);
      if (!(value[i] < clipped_dn)) return;
    }
    Eigen::VectorXd of_pixel;
    if (field_.varies()) of_pixel = field_.at(pixel);
    const Eigen::VectorXd& here = field_.varies() ? of_pixel : at_first_pixel_;
    for (int pass = 0; pass < kPasses; ++pass) {
      const std::complex<double> fringe = solver_.fringe([&](std::size_t i) { return value[i] - added[i]; });
      const double amplitude = std::abs(fringe);
      if (!(amplitude >= min_amplitude)) return;
      const std::complex<double> at_first = fringe / amplitude;
      for (std::size_t i = 0; i < n; ++i)
        added[i] =
            amplitude * (harmonics_at(at_first * turn_[i], here) + (at_first * (turn_[i] - step_[i])).real());
    }
    for (std::size_t i = 0; i < n; ++i) images_[i][pixel] = static_cast<float>(value[i] - added[i]);
  }

  /// Returns what a waveform has besides its cosine where that has this phase e^it.
  static double harmonics_at(const std::complex<double>& first, const Eigen::VectorXd& waveform) {
    std::complex<double> power = first;
    double sum = 0.0;
    for (Eigen::Index h = 0; h + 1 < waveform.size(); h += 2) {
      power *= first;
      sum += waveform[h] * power.real() + waveform[h + 1] * power.imag();
    }
    return sum;
  }

  StepSolver solver_;
  const WaveformField& field_;
  Eigen::VectorXd at_first_pixel_;  ///< its form
  std::size_t n_pixels_ = 0;
  std::vector<float*> images_;                     ///< values of these steps
  std::vector<std::complex<double>> step_, turn_;  ///< e^(i 2 pi n/N), and with the shift of the step
};

}  // namespace

CameraImages with_plain_fringes(CameraImages images, const Fringes& fringes, const LightFactors& light,
                                const LightOptions& options, std::vector<int> steps) {
  if (steps.empty()) steps = all_steps(fringes.steps);
  images = with_steady_light(std::move(images), light, options.black_level_dn);
  const std::vector<PatternSpec> sequence = expand_sequence(fringes);
  const auto is_among = [](const std::vector<int>& some, int step) {
    return std::ranges::find(some, step) != some.end();
  };
  std::vector<std::vector<GrayImage*>> of_pitch;
  std::vector<std::vector<double>> shifts;
  std::vector<PitchImages> telling;  // the form of each pitch
  for (std::size_t k = 0; k < sequence.size(); ++k) {
    if (sequence[k].kind != PatternSpec::Kind::phase_step) continue;
    const int step = sequence[k].step;
    if (step == 0)
      of_pitch.emplace_back(), shifts.emplace_back(), telling.push_back({.steps_total = fringes.steps});
    const double shift_rad = light.shift_rad.empty() ? 0.0 : light.shift_rad.at(k);
    if (light.steps.empty() || is_among(light.steps, step)) {
      telling.back().step.push_back(step);
      telling.back().image.push_back(&images.images.at(k));
      telling.back().shift_rad.push_back(shift_rad);
    }
    if (!is_among(steps, step)) continue;
    of_pitch.back().push_back(&images.images.at(k));
    shifts.back().push_back(shift_rad);
  }
  FT_CHECK(light.waveform.size() == of_pitch.size(), "a waveform of each pitch");
  for (std::size_t p = 0; p < of_pitch.size(); ++p)
    if (!light.waveform[p].empty()) {
      const WaveformField field(telling[p], light.waveform[p], options, images.saturation_dn());
      PitchPlain(steps, fringes.steps, field, shifts[p], of_pitch[p])
          .run(images.saturation_dn(), options.min_amplitude);
    }
  return images;
}

}  // namespace fringetwin::measure
