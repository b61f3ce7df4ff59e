// SPDX-License-Identifier: Apache-2.0
#include "render/base/sampling.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>

#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::render {
namespace {

constexpr int kLargestGauss = 16;
constexpr int kMostSamples = 65536;

bool is_gauss_rule(int samples) {
  const auto root = static_cast<int>(std::lround(std::sqrt(static_cast<double>(samples))));
  return root * root == samples && root <= kLargestGauss;
}

[[noreturn]] void fail(const std::string& what, const std::string& hint = "") {
  throw UserError(ExitCode::usage, "render", what, hint);
}

// Returns the fewest samples of a fixed rule that meet the target. Measured on interior pixels of the paper's
// rig, quadrature alone (rad rms): 4 Gauss samples 1.7e-5, 9 below 1e-6 on curved shapes; 64 multi-jittered
// or Sobol points 2e-4, 256 3e-5.
int fixed_samples(Sampler sampler, double phase_error_rad) {
  if (sampler == Sampler::gauss) return phase_error_rad >= 5e-5 ? 4 : phase_error_rad >= 5e-6 ? 9 : 16;
  return phase_error_rad >= 2e-4 ? 64 : phase_error_rad >= 3e-5 ? 256 : 1024;
}

// Returns the share of contrast that the n-point rule leaves too much over a width of swing_rad: leading term
// for cos(x) (Abramowitz & Stegun 25.4.30).
double gauss_contrast_error(int n, double swing_rad) {
  double error = 1.0 / (2 * n + 1);
  for (int i = 1; i <= 2 * n; ++i) error *= swing_rad / (static_cast<double>(i) * i * i);
  for (int i = 1; i <= n; ++i) error *= static_cast<double>(i) * i * i * i;
  return error;
}

// Returns the sizes of the harmonics 2, 3, ... that the shown fringes have behind the projector's response,
// fraction of full scale, before blur. Empty where they have none, and of a waveform without blur: it has
// edges or bends, which no rule of points serves.
std::vector<double> shown_harmonics(const Twin& twin) {
  constexpr int kPoints = 1024;  // an edge lies half a point off at most: 1e-3 of its height
  const Fringes& fringes = twin.fringes;
  const ProjectorResponse& response = twin.projector->response;
  const bool is_sine = fringes.waveform.kind == Waveform::Kind::sine;
  if (is_sine ? response.kind == ProjectorResponse::Kind::linear : !(twin.projector->least_blur_px() > 0.0))
    return {};
  std::vector<std::complex<double>> sums(kHighestHarmonic + 1);
  for (int i = 0; i < kPoints; ++i) {
    const double turns = (i + 0.5) / kPoints,
                 light = response(fringes.mean + fringes.amplitude * fringes.waveform(turns));
    const std::complex<double> turn = std::polar(1.0, kTwoPi * turns);
    std::complex<double> power = 1.0;
    for (std::complex<double>& sum : sums) {
      sum += light * power;
      power *= turn;
    }
  }
  std::vector<double> sizes;
  for (std::size_t k = 2; k < sums.size(); ++k) sizes.push_back(2.0 / kPoints * std::abs(sums[k]));
  return sizes;
}

// Returns the size of a harmonic of a pitch at most, fraction of full scale: of the added light, and of the
// shown fringes behind their blur.
double harmonic_size(const Twin& twin, const std::vector<double>& shown, const DirectionFringes& direction,
                     std::size_t pitch, int order) {
  const Harmonics& added = direction.harmonics_of(pitch);
  const std::vector<double> more = twin.fringes.more_harmonics(direction);
  const auto i = static_cast<std::size_t>(order - 2);
  double size = i < added.size() ? std::hypot(added[i].cosine, added[i].sine) : 0.0;
  if (i < more.size()) size += more[i];
  if (i < shown.size()) {
    const double u = 0.5 * kTwoPi * order * twin.projector->least_blur_px() / direction.pitches_px[pitch];
    size += shown[i] * std::exp(-2.0 * u * u);
  }
  return size * direction.contrast_of(pitch);
}

// Returns the sum of what the rule leaves too much of the higher harmonics of the fringes of a pitch, the
// largest of all pitches. `swing_rad`: of the finest fringe in a pixel.
double harmonics_error(const Twin& twin, const std::vector<double>& shown, int n, double swing_rad) {
  double most = 0.0;
  for (const DirectionFringes& d : twin.fringes.directions)
    for (std::size_t p = 0; p < d.pitches_px.size(); ++p) {
      const double swing = swing_rad * twin.fringes.finest_pitch_px() / d.pitches_px[p];
      double error = 0.0;
      for (int k = 2; k <= kHighestHarmonic; ++k)
        error += harmonic_size(twin, shown, d, p, k) * std::min(1.0, gauss_contrast_error(n, k * swing));
      most = std::max(most, error);
    }
  return most;
}

}  // namespace

double single_precision_error_rad(const Twin& twin) {
  constexpr double kMeasuredRad = 5e-5, kMeasuredAt = 1701.22 / 13.0;
  const double finest = twin.fringes.finest_pitch_px();
  if (!twin.projector || !std::isfinite(finest)) return kMeasuredRad;
  const std::vector<double>& k = twin.projector->lens.intrinsics();  // all models begin with fx, fy
  return kMeasuredRad * std::max(k.at(0), k.at(1)) / finest / kMeasuredAt;
}

void check_sampling(const Sampling& sampling, double pixel_fill) {
  if (!(pixel_fill >= 0.0 && pixel_fill <= 2.0))
    fail(fmt::format("pixel_fill = {} is outside 0 ... 2", pixel_fill));
  if (!(sampling.phase_error_rad > 0.0))
    fail(fmt::format("phase_error_rad = {} must be positive", sampling.phase_error_rad));
  if (!(sampling.gray_error > 0.0))
    fail(fmt::format("gray_error = {} must be positive", sampling.gray_error));
  if (sampling.sampler == Sampler::adaptive) return;
  if (sampling.samples < 1 || sampling.samples > kMostSamples)
    fail(fmt::format("samples = {} is outside 1 ... {}", sampling.samples, kMostSamples));
  if (sampling.sampler == Sampler::gauss && !is_gauss_rule(sampling.samples))
    fail(fmt::format("sampler \"gauss\" takes n x n samples with n = 1 ... {}, not {}", kLargestGauss,
                     sampling.samples),
         "choose a square, or sampler = \"multi-jittered\"");
}

Sampling choose_sampling(const Twin& twin, const RenderOptions& options) {
  Sampling sampling{.precise = options.phase_error_rad < single_precision_error_rad(twin),
                    .phase_error_rad = options.phase_error_rad,
                    .gray_error = options.gray_error};
  if (options.samples) {
    sampling.samples = *options.samples;
    // A number that is no square cannot be a Gauss rule; without a named sampler the user gets the one
    // that takes any number.
    sampling.sampler =
        options.sampler.value_or(is_gauss_rule(sampling.samples) ? Sampler::gauss : Sampler::multi_jittered);
  } else {
    sampling.sampler = options.sampler.value_or(Sampler::adaptive);
    if (sampling.sampler != Sampler::adaptive)
      sampling.samples = fixed_samples(sampling.sampler, options.phase_error_rad);
  }
  if (sampling.sampler == Sampler::adaptive && options.samples)
    fail("samples have no meaning with sampler \"adaptive\"", "leave one of them out");
  check_sampling(sampling, options.pixel_fill);
  return sampling;
}

const char* sampler_name(Sampler sampler) {
  return sampler == Sampler::gauss            ? "gauss"
         : sampler == Sampler::multi_jittered ? "multi-jittered"
         : sampler == Sampler::sobol          ? "sobol"
                                              : "adaptive";
}

Sampling without_adaptation(const Sampling& sampling, const Twin& twin, const Camera& camera) {
  Sampling fixed = without_adaptation(sampling);
  if (sampling.sampler != Sampler::adaptive || !twin.projector) return fixed;
  // Taken for a surface that faces both and is as far from the camera as from the projector.
  const double swing_rad = kTwoPi / twin.fringes.finest_pitch_px() * twin.projector->lens.intrinsics().at(0) /
                           camera.lens.intrinsics().at(0) * camera.pixel_side_px();
  const std::vector<double> shown = shown_harmonics(twin);
  int n = static_cast<int>(std::lround(std::sqrt(static_cast<double>(fixed.samples))));
  while (n < 6 && std::max(gauss_contrast_error(n, swing_rad), harmonics_error(twin, shown, n, swing_rad)) >
                      sampling.gray_error)
    ++n;
  fixed.samples = n * n;
  return fixed;
}

Sampling without_adaptation(const Sampling& sampling) {
  if (sampling.sampler != Sampler::adaptive) return sampling;
  Sampling fixed = sampling;
  fixed.sampler = Sampler::gauss;
  fixed.samples = fixed_samples(Sampler::gauss, sampling.phase_error_rad);
  return fixed;
}

}  // namespace fringetwin::render
