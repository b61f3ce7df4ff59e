// SPDX-License-Identifier: Apache-2.0
#include "cosim/brightness.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "twin/base/constants.hpp"
#include "twin/base/parallel.hpp"

namespace fringetwin::cosim {
namespace {

constexpr double kBeyond = 1e-3;   // share above the peak: no hot pixel, but a part that fills 1 % counts
constexpr double kFarApart = 2.0;  // a gain that was only roughly set is within that
constexpr std::size_t kBins = 1U << 16;  // a camera has at most 16 bit

using Counts = std::vector<std::size_t>;

/// Adds how often each gray value is there. A camera's are whole: adding a half rounds as std::lround() does,
/// which no compiler makes one instruction of.
void add_counts(const GrayImage& image, Counts& count) {
  image.for_each([&count](float value) {
    const float inside = std::min(std::max(0.0F, value), static_cast<float>(kBins - 1));  // 0 for NaN
    ++count[static_cast<std::size_t>(inside + 0.5F)];
  });
}

}  // namespace

double peak_dn(const Twin& twin, const CameraImages& images) {
  const std::vector<PatternSpec> patterns = expand_sequence(twin.fringes);
  std::vector<const GrayImage*> chosen;
  std::size_t n = 0;
  for (std::size_t k = 0; k < images.images.size(); ++k) {
    const bool step = k < patterns.size() && patterns[k].kind == PatternSpec::Kind::phase_step;
    if (twin.fringes.steps > 0 && !step) continue;
    chosen.push_back(&images.images[k]);
    n += images.images[k].size();
  }
  if (n == 0) return kNaN;
  constexpr int kParts = 16;  // a histogram for each image would take as long as a small image itself
  std::vector<Counts> counts(std::min<std::size_t>(kParts, chosen.size()), Counts(kBins, 0));
  for_each_parallel(static_cast<int>(counts.size()), [&](int part) {
    const auto first = static_cast<std::size_t>(part);
    for (std::size_t k = first; k < chosen.size(); k += counts.size()) add_counts(*chosen[k], counts[first]);
  });
  Counts count(kBins, 0);
  for (const Counts& part : counts)
    for (std::size_t level = 0; level < kBins; ++level) count[level] += part[level];
  auto left = static_cast<std::size_t>(kBeyond * static_cast<double>(n));
  std::size_t level = kBins - 1;
  for (; level > 0 && count[level] <= left; --level) left -= count[level];
  return static_cast<double>(level);
}

std::vector<std::string> brightness_warnings(const Twin& twin, const std::vector<CameraImages>& real,
                                             const std::vector<CameraImages>& simulated) {
  std::vector<std::string> out;
  for (std::size_t c = 0; c < std::min({twin.cameras.size(), real.size(), simulated.size()}); ++c) {
    if (real[c].radiance || simulated[c].radiance) continue;
    const Sensor& sensor = twin.cameras[c].sensor;
    const double black = sensor.black_level_dn, full = std::exp2(sensor.bit_depth) - 1.0,
                 of_real = peak_dn(twin, real[c]), of_twin = peak_dn(twin, simulated[c]),
                 above_real = of_real - black, above_twin = of_twin - black;
    // One gray value more or less is rounding: nothing follows from images that are that dark.
    if (!(std::max(above_real, above_twin) > 4.0)) continue;
    const double factor = std::max(above_real, 1.0) / std::max(above_twin, 1.0);
    if (factor <= kFarApart && factor >= 1.0 / kFarApart) continue;
    const bool clipped = of_twin >= full || of_real >= full;
    out.push_back(
        fmt::format("{}: images peak at {:.0f} DN, the real ones at {:.0f}: thresholds, noise and "
                    "saturation are not those "
                    "of the rig; [camera.sensor] gain_dn = {:.3g} in place of {:.3g} would make them {}alike",
                    twin.cameras[c].name, of_twin, of_real, sensor.gain_dn * factor, sensor.gain_dn,
                    clipped ? "more " : ""));
  }
  return out;
}

void add_brightness_warnings(Run& run) {
  if (!run.simulated.measurement) return;
  std::vector<std::string>& warnings = run.simulated.measurement->warnings;
  const std::vector<std::string> first = brightness_warnings(run.twin, run.real.images, run.simulated.images);
  warnings.insert(warnings.begin(), first.begin(), first.end());
}

}  // namespace fringetwin::cosim
