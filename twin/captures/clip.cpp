// SPDX-License-Identifier: Apache-2.0
#include "twin/captures/clip.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include "twin/base/constants.hpp"
#include "twin/base/parallel.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin {
namespace {

using Histogram = std::vector<std::uint64_t>;

constexpr double kLowestClip = 0.25;      // of full scale: below it is black or a dark scene
constexpr std::uint64_t kFewest = 50;     // values of a plateau
constexpr double kSpike = 8.0;            // over what stands below; right images have 3 at most
constexpr double kMostAbove = 0.1;        // of the plateau
constexpr double kHotValues = 5e-5;       // of all values: hot pixels may lie anywhere
constexpr double kWidest = 0.02;          // of full scale: read noises beyond it are no sensor's
constexpr std::size_t kPixels = 200'000;  // looked at for fringes that go on above

/// The images of one direction and pitch in the order of their steps.
std::vector<std::vector<const GrayImage*>> step_groups(const CameraImages& images, const Fringes& fringes) {
  std::map<std::pair<int, int>, std::vector<const GrayImage*>> groups;
  const std::vector<PatternSpec> patterns = expand_sequence(fringes);
  for (std::size_t i = 0; i < std::min(patterns.size(), images.images.size()); ++i)
    if (patterns[i].kind == PatternSpec::Kind::phase_step)
      groups[{patterns[i].direction, patterns[i].pitch}].push_back(&images.images[i]);
  std::vector<std::vector<const GrayImage*>> out;
  for (auto& [key, group] : groups)
    if (group.size() >= 3) out.push_back(std::move(group));
  return out;
}

Histogram histogram_of(const std::vector<std::vector<const GrayImage*>>& groups, std::size_t full) {
  std::vector<const GrayImage*> all;
  for (const auto& group : groups) all.insert(all.end(), group.begin(), group.end());
  std::vector<Histogram> parts(all.size());
  for_each_parallel(static_cast<int>(all.size()), [&](int k) {
    Histogram& h = parts[k];
    h.assign(full + 1, 0);
    all[k]->for_each([&](float v) {
      if (v >= 0.0F && v <= static_cast<float>(full)) ++h[static_cast<std::size_t>(v)];
    });
  });
  Histogram sum(full + 1, 0);
  for (const Histogram& h : parts)
    for (std::size_t v = 0; v <= full; ++v) sum[v] += h[v];
  return sum;
}

std::uint64_t count_of(const Histogram& h, std::size_t first, std::size_t end) {
  return std::accumulate(h.begin() + static_cast<std::ptrdiff_t>(std::min(first, h.size())),
                         h.begin() + static_cast<std::ptrdiff_t>(std::min(end, h.size())), std::uint64_t{0});
}

/// Returns the highest value but for a few hot pixels.
std::size_t top_of(const Histogram& h) {
  const double few = kHotValues * static_cast<double>(count_of(h, 0, h.size()));
  std::uint64_t above = 0;
  for (std::size_t v = h.size(); v-- > 0;)
    if (static_cast<double>(above += h[v]) > few) return v;
  return 0;
}

/// Values from `first` on, `width` of them.
struct Plateau {
  std::size_t first = 0, width = 1;
  double ratio = 0.0;
};

/// Returns how many values a window of this width holds below `first`: the mean of twenty windows, half the
/// fullest of them (values that come in steps of several DN stand like teeth), at least one.
double level_below(const Histogram& h, std::size_t first, std::size_t width) {
  std::uint64_t sum = 0, most = 0;
  for (std::size_t k = 5; k < 25; ++k) {
    const std::uint64_t n = count_of(h, first - (k + 1) * width, first - k * width);
    sum += n;
    most = std::max(most, n);
  }
  return std::max({1.0, static_cast<double>(sum) / 20.0, 0.5 * static_cast<double>(most)});
}

/// Returns the sharpest plateau of this width within `reach` of the top; ratio 0 where there is none.
Plateau sharpest(const Histogram& h, std::size_t top, std::size_t width, std::size_t reach) {
  Plateau best{0, width, 0.0};
  for (std::size_t down = 0; down <= reach && down + width <= top; ++down) {
    const std::size_t first = top + 1 - width - down;
    if (first < 26 * width) break;
    const std::uint64_t here = count_of(h, first, first + width);
    const std::uint64_t above = count_of(h, first + width, top + 1);
    if (here < kFewest || static_cast<double>(above) > kMostAbove * static_cast<double>(here)) continue;
    const double ratio = static_cast<double>(here) / level_below(h, first, width);
    if (ratio > best.ratio) best = {first, width, ratio};
  }
  return best;
}

/// Returns by how much the fringes of the pixels that hold the plateau go on above it, the median; NaN where
/// no pixel can tell. A pixel that clips in more than half of its steps cannot.
double excess_above(const std::vector<std::vector<const GrayImage*>>& groups, const Plateau& plateau) {
  std::vector<double> excess;
  const auto low = static_cast<double>(plateau.first), high = low + static_cast<double>(plateau.width);
  for (const auto& group : groups) {
    const double turn = kTwoPi / static_cast<double>(group.size());
    std::vector<double> cosine, sine;
    for (std::size_t n = 0; n < group.size(); ++n) {
      cosine.push_back(std::cos(turn * static_cast<double>(n)));
      sine.push_back(std::sin(turn * static_cast<double>(n)));
    }
    for (std::size_t i = 0; i < group.front()->size() && excess.size() < kPixels; ++i) {
      double mean = 0.0, c = 0.0, s = 0.0;
      std::size_t held = 0;
      for (std::size_t n = 0; n < group.size(); ++n) {
        const auto v = static_cast<double>((*group[n])[i]);
        held += v >= low && v < high ? 1u : 0u;
        mean += v, c += v * cosine[n], s += v * sine[n];
      }
      if (held == 0 || 2 * held > group.size()) continue;
      const auto steps = static_cast<double>(group.size());
      excess.push_back((mean + 2.0 * std::hypot(c, s)) / steps - low);
    }
  }
  return median(excess);
}

}  // namespace

std::optional<Clip> find_clip(const CameraImages& images, const Fringes& fringes, const Sensor& sensor) {
  if (images.radiance) return std::nullopt;
  const auto groups = step_groups(images, fringes);
  if (groups.empty()) return std::nullopt;
  const auto full = static_cast<std::size_t>((1 << images.bit_depth) - 1);
  const Histogram h = histogram_of(groups, full);
  const std::size_t top = top_of(h);
  if (top >= full || static_cast<double>(top) < kLowestClip * static_cast<double>(full)) return std::nullopt;
  const double read_dn = std::min(sensor.read_noise_dn.value_or(0.0), kWidest * static_cast<double>(full));
  const auto reach = static_cast<std::size_t>(std::ceil(3.0 * read_dn));
  // a clip after the read noise stands in one value, a clip before it within two read noises on either side
  Plateau best = sharpest(h, top, 1, reach);
  if (best.ratio < kSpike && read_dn > 0.0)
    best = sharpest(h, top, 1 + static_cast<std::size_t>(std::ceil(4.0 * read_dn)), reach);
  if (best.ratio < kSpike) return std::nullopt;
  const auto width = static_cast<double>(best.width);
  if (!(excess_above(groups, best) > width + 1.0)) return std::nullopt;
  const auto first = static_cast<double>(best.first);
  Clip clip{.dn = best.width == 1 ? first : std::floor(first + 0.5 * width - 3.0 * read_dn)};
  clip.n = count_of(h, static_cast<std::size_t>(clip.dn), full + 1);
  return clip;
}

}  // namespace fringetwin
