// SPDX-License-Identifier: Apache-2.0
#include "render/reference/reference_exposure.hpp"

#include <algorithm>
#include <cmath>

namespace fringetwin::render {
namespace {

/// Returns the integral over time, from the begin of the sequence on, of what is shown: 1 period each.
double shown_until(const std::vector<double>& of_patterns, double time) {
  if (time <= 0.0) return time * of_patterns.front();
  double sum = 0.0;
  for (std::size_t k = 0; k < of_patterns.size(); ++k)
    sum += of_patterns[k] * std::clamp(time - static_cast<double>(k), 0.0, 1.0);
  return sum + of_patterns.back() * std::max(0.0, time - static_cast<double>(of_patterns.size()));
}

}  // namespace

std::vector<double> reference_exposed(const Camera& camera, int y, const std::vector<double>& of_patterns) {
  if (!camera.timing || of_patterns.empty()) return of_patterns;
  const ExposureTiming& timing = *camera.timing;
  const double height = camera.channel ? camera.channel->sensor_px.y() : camera.lens.height(),
               row = camera.channel ? 2.0 * y + camera.channel->first_px().y() : y,
               after_middle = timing.read_out * (2.0 * row + 1.0 - height) / (2.0 * height);
  std::vector<double> seen;
  for (std::size_t k = 0; k < of_patterns.size(); ++k) {
    const double late = timing.late.empty()       ? 0.0
                        : timing.late.size() == 1 ? timing.late[0]
                                                  : timing.late.at(k);
    const double begin = static_cast<double>(k) + late + after_middle;
    seen.push_back((shown_until(of_patterns, begin + timing.exposure) - shown_until(of_patterns, begin)) /
                   timing.exposure);
  }
  return seen;
}

}  // namespace fringetwin::render
