// SPDX-License-Identifier: Apache-2.0
#include "capture/adjust/preview.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "twin/base/errors.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::capture {
namespace {

/// Sum over both directions of the squares of the Sobel kernel's weights, /8 so that a ramp of 1 DN/px
/// gives 1.
constexpr double kSobelNoise = 2.0 * 12.0 / 64.0;

ImageF mean_of(const std::vector<ImageF>& images) {
  ImageF mean(images[0].width, images[0].height);
  for (const ImageF& image : images)
    for (std::size_t i = 0; i < mean.size(); ++i)
      mean.data[i] += image.data[i] / static_cast<float>(images.size());
  return mean;
}

double mean_of(const ImageF& image) {
  double sum = 0.0;
  for (const float v : image.data) sum += static_cast<double>(v);
  return sum / static_cast<double>(image.size());
}

/// Returns the variance of the noise of one picture's pixels, from two pictures of the same light.
double noise_variance(const ImageF& a, const ImageF& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double difference = static_cast<double>(a.data[i]) - static_cast<double>(b.data[i]);
    sum += difference * difference;
  }
  return sum / (2.0 * static_cast<double>(a.size()));
}

/// Mean squared gradient, DN^2/px^2.
double squared_gradient(const ImageF& image) {
  double sum = 0.0;
  for (int y = 1; y + 1 < image.height; ++y)
    for (int x = 1; x + 1 < image.width; ++x) {
      const auto at = [&](int dx, int dy) { return static_cast<double>(image(x + dx, y + dy)); };
      const double gx = at(1, -1) + 2.0 * at(1, 0) + at(1, 1) - at(-1, -1) - 2.0 * at(-1, 0) - at(-1, 1);
      const double gy = at(-1, 1) + 2.0 * at(0, 1) + at(1, 1) - at(-1, -1) - 2.0 * at(0, -1) - at(1, -1);
      sum += (gx * gx + gy * gy) / 64.0;
    }
  const double n = static_cast<double>(std::max(1, image.width - 2)) * std::max(1, image.height - 2);
  return sum / n;
}

/// Amplitude of the sinusoid through the steps; of white and black half their difference.
double amplitude_dn(const std::vector<ImageF>& steps, std::size_t pixel) {
  const double n = static_cast<double>(steps.size());
  if (steps.size() == 2)
    return 0.5 * std::abs(static_cast<double>(steps[0].data[pixel] - steps[1].data[pixel]));
  std::complex<double> sum;
  for (std::size_t k = 0; k < steps.size(); ++k)
    sum += static_cast<double>(steps[k].data[pixel]) *
           std::polar(1.0, -2.0 * std::numbers::pi * static_cast<double>(k) / n);
  return 2.0 / n * std::abs(sum);
}

std::vector<Pattern> finest_steps(const Fringes& fringes) {
  if (fringes.steps == 0) return {even_field(1.0, "white"), even_field(0.0, "black")};
  const std::vector<PatternSpec> sequence = expand_sequence(fringes);
  std::vector<Pattern> patterns;
  for (const Pattern& pattern : sequence_patterns(fringes)) {
    const PatternSpec& spec = sequence[pattern.index];
    if (spec.kind == PatternSpec::Kind::phase_step && spec.direction == 0 &&
        spec.pitch == fringes.directions.front().finest())
      patterns.push_back(pattern);
  }
  return patterns;
}

}  // namespace

PreviewNumbers preview_numbers(const std::string& camera, const std::vector<ImageF>& steps,
                               const ImageF& again, const Sensor& sensor, double min_modulation_dn) {
  FT_CHECK(steps.size() >= 2 && again.size() == steps[0].size(), "steps, and the first once more");
  PreviewNumbers out{.camera = camera};
  const ImageF mean = mean_of(steps);
  out.mean_dn = mean_of(mean);
  std::vector<double> modulations, contrasts;
  std::size_t n_saturated = 0;
  for (std::size_t i = 0; i < mean.size(); ++i) {
    const bool saturated = std::ranges::any_of(
        steps, [&](const ImageF& step) { return static_cast<double>(step.data[i]) >= sensor.max_dn(); });
    n_saturated += saturated;
    const double modulation = amplitude_dn(steps, i);
    if (saturated || modulation < min_modulation_dn) continue;
    modulations.push_back(modulation);
    const double light = static_cast<double>(mean.data[i]) - sensor.black_level_dn;
    if (light > 0.0) contrasts.push_back(modulation / light);
  }
  const double n = static_cast<double>(mean.size());
  out.saturated_share = static_cast<double>(n_saturated) / n;
  out.lit_share = static_cast<double>(modulations.size()) / n;
  out.modulation_dn = modulations.empty() ? 0.0 : upper_median(modulations);
  out.contrast = contrasts.empty() ? 0.0 : upper_median(contrasts);
  const double noise = noise_variance(steps[0], again) / static_cast<double>(steps.size());
  const double light = out.mean_dn - sensor.black_level_dn;
  if (light > 0.0) out.focus = std::max(0.0, squared_gradient(mean) - kSobelNoise * noise) / (light * light);
  return out;
}

Preview::Preview(const Twin& twin, const Rig& rig, PatternDisplay& display, const CapturePlan& plan)
    : twin_(twin),
      rig_(rig),
      display_(display),
      plan_(plan),
      patterns_(finest_steps(twin.fringes)),
      streams_(rig) {}

std::vector<PreviewNumbers> Preview::look() {
  std::vector<std::vector<ImageF>> steps(rig_.size());
  std::vector<ImageF> again(rig_.size());
  for (const RigCamera& camera : rig_) camera.device->check_input();
  for (std::size_t k = 0; k < patterns_.size(); ++k) {
    Step step;
    step.pattern = patterns_[k];
    step.pictures.resize(k == 0 ? 2 : 1);
    StepRecord record;
    record.shown = show_pattern(display_, twin_.fringes, patterns_[k]);
    for (const RigCamera& camera : rig_) camera.device->drain();
    StepImages grabbed = take_step_frames(rig_, step, plan_, &record);
    for (std::size_t c = 0; c < rig_.size(); ++c) {
      steps[c].push_back(std::move(grabbed.images[c][0]));
      if (k == 0) again[c] = std::move(grabbed.images[c][1]);
    }
  }
  std::vector<PreviewNumbers> numbers;
  for (std::size_t c = 0; c < rig_.size(); ++c)
    numbers.push_back(preview_numbers(rig_[c].name, steps[c], again[c], twin_.cameras.at(c).sensor,
                                      twin_.measure.min_modulation_dn));
  return numbers;
}

std::string PreviewNumbers::text() const {
  return fmt::format(
      "{}: saturated {:.2f} %, mean {:.1f} DN, lit {:.1f} %, modulation {:.1f} DN, contrast {:.3f}, focus "
      "{:.3g}",
      camera, 100.0 * saturated_share, mean_dn, 100.0 * lit_share, modulation_dn, contrast, focus);
}

}  // namespace fringetwin::capture
