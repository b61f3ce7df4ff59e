// SPDX-License-Identifier: Apache-2.0
#include "measure/decode/plain_fringes.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>

#include "measure/light/light_steps.hpp"
#include "measure/decode/phase.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::measure {
namespace {

/// Each is some percent of the one before, as the harmonics are.
constexpr int kPasses = 4;
constexpr std::size_t kMostSteps = kMostLightSteps;

/// The numbers of a pitch's waveform as they vary over a camera's image, by Legendre's polynomials up to the
/// second order: lenses show the form of a fringe differently here and there.
class WaveformField {
 public:
  /// `images`, `shift_rad`: of all steps of the pitch, in steady light. `waveform`: the mean of the field, to
  /// begin with. The field is that alone where no more is told than chance makes of it.
  WaveformField(const std::vector<const ImageF*>& images, const std::vector<double>& waveform,
                const std::vector<double>& shift_rad, const LightOptions& options, double clipped_dn)
      : images_(images),
        options_(options),
        clipped_dn_(clipped_dn),
        steps_(static_cast<int>(images.size())),
        of_term_(Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(waveform.size()), kTerms)) {
    steps_.shift_rad =
        Eigen::Map<const Eigen::VectorXd>(shift_rad.data(), static_cast<Eigen::Index>(shift_rad.size()));
    steps_.move_by({});
    of_term_.col(0) = Eigen::Map<const Eigen::VectorXd>(waveform.data(), of_term_.rows());
    varies_ = improve();
    for (int pass = 1; varies_ && pass < kFieldPasses; ++pass) improve();
  }

  bool varies() const { return varies_; }
  /// Returns cosine and sine of the harmonics 2, 3 ... of a pixel, over its amplitude.
  Eigen::VectorXd at(std::size_t pixel) const { return of_term_ * terms(pixel); }

 private:
  static constexpr int kTerms = 6, kFieldPasses = 3;
  static constexpr std::size_t kMostPixels = 20'000, kFewestPixels = 2'000, kScatter = 7919;
  static constexpr double kCut = 9.0;       ///< times the middle of all: not of these fringes
  static constexpr double kChance = 5.0;    ///< standard deviations of chi2
  static constexpr double kNotTold = 1e-6;  ///< of the largest eigenvalue of the scaled equations
  using Terms = Eigen::Matrix<double, kTerms, 1>;

  struct Sums {
    Eigen::MatrixXd normal;
    Eigen::VectorXd right;
    double squares = 0.0, freedom = 0.0;
    std::vector<float> of_pixels = {};
  };

  Terms terms(std::size_t pixel) const {
    const auto width = static_cast<std::size_t>(images_.front()->width);
    const double x = 2.0 * (static_cast<double>(pixel % width) + 0.5) / images_.front()->width - 1.0,
                 y = 2.0 * (static_cast<double>(pixel / width) + 0.5) / images_.front()->height - 1.0;
    return {1.0, x, y, 1.5 * x * x - 0.5, x * y, 1.5 * y * y - 0.5};
  }

  /// Adds what a pixel tells; nothing where a value is clipped or its fringe is weak.
  void add_pixel(std::size_t pixel, Sums& sums) const {
    Eigen::VectorXd values(steps_.count());
    for (Eigen::Index k = 0; k < values.size(); ++k) {
      const auto dn = static_cast<double>(images_[static_cast<std::size_t>(k)]->data[pixel]);
      if (!(dn < clipped_dn_) || !(dn > 0.0)) return;
      values[k] = dn - options_.black_level_dn;
    }
    LightSteps steps = steps_;
    steps.waveform = at(pixel);
    StepFringe fringe = steps.sinusoid(values);
    if (!(fringe.amplitude >= options_.min_amplitude)) return;
    for (int i = 0; i < 3; ++i) fringe = PixelEquations(steps, fringe, values).better(fringe);
    const PixelEquations e(steps, fringe, values);
    const Eigen::VectorXd left = e.contrasts(e.residual);
    const double squares = left.squaredNorm();
    sums.of_pixels.push_back(static_cast<float>(squares));
    if (squares > most_squares_) return;
    const Eigen::MatrixXd harmonics = e.contrasts(e.harmonics), square = harmonics.transpose() * harmonics;
    const Eigen::VectorXd score = harmonics.transpose() * left;
    const Terms t = terms(pixel);
    const Eigen::Index m = of_term_.rows();
    for (Eigen::Index i = 0; i < kTerms; ++i) {
      for (Eigen::Index j = 0; j <= i; ++j) sums.normal.block(i * m, j * m, m, m) += t[i] * t[j] * square;
      sums.right.segment(i * m, m) += t[i] * score;
    }
    sums.squares += squares;
    sums.freedom += steps.freedom();
  }

  Sums sum_up() const {
    const std::size_t n = images_.front()->size(), stride = std::max<std::size_t>(1, n / kMostPixels);
    constexpr int kChunks = 32;  // sums that do not depend on the threads
    const Eigen::Index size = of_term_.size();
    std::vector<Sums> parts(kChunks, {Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(size)});
#pragma omp parallel for schedule(dynamic)
    for (int chunk = 0; chunk < kChunks; ++chunk)
      for (std::size_t j = static_cast<std::size_t>(chunk); j * stride < n; j += kChunks)
        add_pixel(std::min(n - 1, j * stride + j * kScatter % stride),
                  parts[static_cast<std::size_t>(chunk)]);
    Sums all = std::move(parts[0]);
    for (std::size_t k = 1; k < parts.size(); ++k) {
      all.normal += parts[k].normal;
      all.right += parts[k].right;
      all.squares += parts[k].squares;
      all.freedom += parts[k].freedom;
      all.of_pixels.insert(all.of_pixels.end(), parts[k].of_pixels.begin(), parts[k].of_pixels.end());
    }
    all.normal.triangularView<Eigen::StrictlyUpper>() = all.normal.transpose();
    return all;
  }

  /// Takes a step of Gauss and Newton; returns false where the first one tells no more than chance.
  bool improve() {
    const bool is_first = !std::isfinite(most_squares_);
    Sums s = sum_up();
    if (s.of_pixels.size() < kFewestPixels) return false;
    if (is_first) {
      most_squares_ = kCut * upper_median(s.of_pixels);
      s = sum_up();
    }
    const Eigen::VectorXd scale = s.normal.diagonal().cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scale.asDiagonal() * s.normal *
                                                               scale.asDiagonal());
    Eigen::VectorXd inverse = Eigen::VectorXd::Zero(scale.size());
    double told = 0.0;
    for (Eigen::Index i = 0; i < inverse.size(); ++i)
      if (eigen.eigenvalues()[i] > kNotTold * eigen.eigenvalues().maxCoeff())
        inverse[i] = 1.0 / eigen.eigenvalues()[i], told += 1.0;
    const Eigen::VectorXd change =
        scale.asDiagonal() *
        (eigen.eigenvectors() *
         (inverse.asDiagonal() * (eigen.eigenvectors().transpose() * (scale.asDiagonal() * s.right))));
    const double fall = change.dot(s.right), noise2 = (s.squares - fall) / std::max(1.0, s.freedom - told);
    if (is_first && !(fall > noise2 * (told + kChance * std::sqrt(2.0 * told)))) return false;
    of_term_ += change.reshaped(of_term_.rows(), kTerms);
    return true;
  }

  const std::vector<const ImageF*>& images_;
  const LightOptions& options_;
  double clipped_dn_;
  LightSteps steps_;
  Eigen::MatrixXd of_term_;  ///< a column per term
  double most_squares_ = std::numeric_limits<double>::infinity();
  bool varies_ = false;
};

/// Takes the harmonics and the shifts out of one pitch's steps.
class PitchPlain {
 public:
  /// `shift_rad`: of each of these steps.
  PitchPlain(const std::vector<int>& steps, int steps_total, const std::vector<double>& waveform,
             const WaveformField& field, const std::vector<double>& shift_rad, std::vector<ImageF*> images)
      : solver_(steps, steps_total), waveform_(waveform), field_(field), images_(std::move(images)) {
    for (int i = 0; i < solver_.count(); ++i) {
      step_.emplace_back(solver_.basis_cos(i), -solver_.basis_sin(i));
      turn_.push_back(step_.back() * std::polar(1.0, shift_rad[static_cast<std::size_t>(i)]));
    }
  }

  void run(double clipped_dn, double min_amplitude) {
    const auto n_pixels = static_cast<std::ptrdiff_t>(images_.front()->size());
#pragma omp parallel for schedule(static)
    for (std::ptrdiff_t i = 0; i < n_pixels; ++i)
      run_pixel(static_cast<std::size_t>(i), clipped_dn, min_amplitude);
  }

 private:
  void run_pixel(std::size_t pixel, double clipped_dn, double min_amplitude) const {
    double value[kMostSteps], added[kMostSteps] = {};
    const std::size_t n = images_.size();
    for (std::size_t i = 0; i < n; ++i) {
      value[i] = static_cast<double>(images_[i]->data[pixel]);
      if (!(value[i] < clipped_dn)) return;
    }
    Eigen::VectorXd of_pixel;
    std::span<const double> here = waveform_;
    if (field_.varies()) {
      of_pixel = field_.at(pixel);
      here = {of_pixel.data(), static_cast<std::size_t>(of_pixel.size())};
    }
    for (int pass = 0; pass < kPasses; ++pass) {
      const std::complex<double> fringe = solver_.fringe([&](std::size_t i) { return value[i] - added[i]; });
      const double amplitude = std::abs(fringe);
      if (!(amplitude >= min_amplitude)) return;
      const std::complex<double> at_first = fringe / amplitude;
      for (std::size_t i = 0; i < n; ++i)
        added[i] =
            amplitude * (harmonics_at(at_first * turn_[i], here) + (at_first * (turn_[i] - step_[i])).real());
    }
    for (std::size_t i = 0; i < n; ++i) images_[i]->data[pixel] = static_cast<float>(value[i] - added[i]);
  }

  /// Returns what a waveform has besides its cosine where that has this phase e^it.
  static double harmonics_at(const std::complex<double>& first, std::span<const double> waveform) {
    std::complex<double> power = first;
    double sum = 0.0;
    for (std::size_t h = 0; h + 1 < waveform.size(); h += 2) {
      power *= first;
      sum += waveform[h] * power.real() + waveform[h + 1] * power.imag();
    }
    return sum;
  }

  StepSolver solver_;
  const std::vector<double>& waveform_;
  const WaveformField& field_;
  std::vector<ImageF*> images_;                    ///< of these steps
  std::vector<std::complex<double>> step_, turn_;  ///< e^(i 2 pi n/N), and with the shift of the step
};

}  // namespace

CameraImages with_plain_fringes(CameraImages images, const Fringes& fringes, const LightFactors& light,
                                const LightOptions& options, std::vector<int> steps) {
  if (steps.empty()) steps = all_steps(fringes.steps);
  images = with_steady_light(std::move(images), light, options.black_level_dn);
  const std::vector<PatternSpec> sequence = expand_sequence(fringes);
  std::vector<std::vector<ImageF*>> of_pitch;
  std::vector<std::vector<const ImageF*>> all_of_pitch;
  std::vector<std::vector<double>> shifts, all_shifts;
  for (std::size_t k = 0; k < sequence.size(); ++k) {
    if (sequence[k].kind != PatternSpec::Kind::phase_step) continue;
    if (sequence[k].step == 0)
      of_pitch.emplace_back(), shifts.emplace_back(), all_of_pitch.emplace_back(), all_shifts.emplace_back();
    const double shift_rad = light.shift_rad.empty() ? 0.0 : light.shift_rad.at(k);
    all_of_pitch.back().push_back(&images.images.at(k));
    all_shifts.back().push_back(shift_rad);
    if (std::ranges::find(steps, sequence[k].step) == steps.end()) continue;
    of_pitch.back().push_back(&images.images.at(k));
    shifts.back().push_back(shift_rad);
  }
  FT_CHECK(light.waveform.size() == of_pitch.size(), "a waveform of each pitch");
  for (std::size_t p = 0; p < of_pitch.size(); ++p)
    if (!light.waveform[p].empty()) {
      const WaveformField field(all_of_pitch[p], light.waveform[p], all_shifts[p], options,
                                images.saturation_dn());
      PitchPlain(steps, fringes.steps, light.waveform[p], field, shifts[p], of_pitch[p])
          .run(images.saturation_dn(), options.min_amplitude);
    }
  return images;
}

}  // namespace fringetwin::measure
