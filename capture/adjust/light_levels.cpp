// SPDX-License-Identifier: Apache-2.0
#include "capture/adjust/light_levels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "twin/base/errors.hpp"

namespace fringetwin::capture {
namespace {

constexpr int kPartsPerSide = 4;
constexpr double kSigmas = 8.0;
constexpr double kPixelSigmas = 2.0;  // of a pixel's own difference, to be worth a weight
constexpr double kLeastThreshold = 0.02, kGreatestThreshold = 0.25;
constexpr double kLeastDifferenceDn = 0.5;  // an integer's rounding shows no less

struct Statistics {
  std::vector<double> mean;
  std::vector<std::uint16_t> highest;
  double sigma = 0.0;  ///< of a single value, rms over the pixels
};

Statistics statistics(const std::vector<ImageU16>& frames) {
  const std::size_t n = frames.front().size();
  Statistics out{std::vector<double>(n), std::vector<std::uint16_t>(n), 0.0};
  std::vector<double> squares(n);
  for (const ImageU16& frame : frames) {
    FT_CHECK(frame.size() == n, "frames of one size");
    for (std::size_t i = 0; i < n; ++i) {
      const double value = frame.data[i];
      out.mean[i] += value;
      squares[i] += value * value;
      out.highest[i] = std::max(out.highest[i], frame.data[i]);
    }
  }
  const double count = static_cast<double>(frames.size());
  double sum = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    out.mean[i] /= count;
    sum += std::max(0.0, squares[i] / count - out.mean[i] * out.mean[i]) * count / (count - 1.0);
  }
  out.sigma = std::sqrt(sum / static_cast<double>(n));
  return out;
}

std::size_t part_of(std::size_t index, int width, int height) {
  const int x = static_cast<int>(index) % width, y = static_cast<int>(index) / width;
  return static_cast<std::size_t>(y * kPartsPerSide / height * kPartsPerSide + x * kPartsPerSide / width);
}

std::pair<double, double> mean_and_scatter(const std::vector<double>& values) {
  const double n = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  double squares = 0.0;
  for (const double v : values) squares += (v - mean) * (v - mean);
  return {mean, std::sqrt(squares / (n - 1.0))};
}

/// The even or the odd ones.
std::vector<ImageU16> half(const std::vector<ImageU16>& frames, std::size_t first) {
  std::vector<ImageU16> out;
  for (std::size_t i = first; i < frames.size(); i += 2) out.push_back(frames[i]);
  return out;
}

[[noreturn]] void refuse(const std::string& camera, const std::string& what, const std::string& hint) {
  throw UserError(ExitCode::device, fmt::format("camera \"{}\"", camera), what, hint);
}

}  // namespace

// Weights from one half of the frames, levels from the other: noise that made its way into the weights would
// else be seen again as light.
LightLevels::LightLevels(const std::string& camera, const std::vector<ImageU16>& black,
                         const std::vector<ImageU16>& white, int bit_depth) {
  FT_CHECK(black.size() >= 4 && white.size() >= 4, "several frames of each");
  choose_pixels(camera, half(black, 0), half(white, 0), bit_depth);
  const auto dark = raw_levels(half(black, 1)), bright = raw_levels(half(white, 1));
  std::vector<Part> kept;
  double best = 1e300;
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    const auto [black_level, black_scatter] = mean_and_scatter(dark[p]);
    const auto [white_level, white_scatter] = mean_and_scatter(bright[p]);
    const double scatter = std::hypot(black_scatter, white_scatter) / std::numbers::sqrt2;
    const double range = white_level - black_level;
    const double threshold = range > 0.0 ? std::max(kLeastThreshold, kSigmas * scatter / range)
                                         : std::numeric_limits<double>::max();
    best = std::min(best, threshold);
    if (threshold > kGreatestThreshold) continue;  // little light: other parts have enough
    kept.push_back(std::move(parts_[p]));
    kept.back().black = black_level;
    kept.back().range = range;
    threshold_ = std::max(threshold_, threshold);
  }
  parts_ = std::move(kept);
  if (!parts_.empty()) return;
  const std::string levels = fmt::format("({:.2f} and {:.2f} DN)", black_dn_, white_dn_);
  if (best > kSigmas)
    refuse(camera, "sees no change between the projector's black and white " + levels,
           "is it on and in view, the lens uncovered, the exposure long enough?");
  refuse(camera,
         fmt::format(
             "sees light that scatters by {:.0f} % of the change from black to white {} from frame to frame",
             100.0 * best / kSigmas, levels),
         "more light is needed, or an exposure that is a multiple of the projector's frame");
}

/// Those that are brighter in white, and not clipped there: a share of clipped light is not the light's
/// share.
void LightLevels::choose_pixels(const std::string& camera, const std::vector<ImageU16>& black,
                                const std::vector<ImageU16>& white, int bit_depth) {
  const Statistics dark = statistics(black), bright = statistics(white);
  const double sigma = std::hypot(dark.sigma, bright.sigma) / std::sqrt(static_cast<double>(black.size()));
  const double least = std::max(kLeastDifferenceDn, kPixelSigmas * sigma);
  const auto clip = static_cast<std::uint16_t>((1 << bit_depth) - 1);
  parts_.resize(kPartsPerSide * kPartsPerSide);
  std::size_t n_clipped = 0, n_darker = 0, n_lit = 0;
  for (std::size_t i = 0; i < dark.mean.size(); ++i) {
    const double difference = bright.mean[i] - dark.mean[i];
    n_darker += difference < -kSigmas * sigma - kLeastDifferenceDn;
    n_lit += difference > kSigmas * sigma + kLeastDifferenceDn;
    if (difference <= least) continue;
    if (bright.highest[i] >= clip) {
      ++n_clipped;
      continue;
    }
    const std::size_t part = part_of(i, black.front().width, black.front().height);
    parts_[part].pixels.push_back({static_cast<std::uint32_t>(i), static_cast<float>(difference)});
  }
  if (n_darker > n_lit)
    refuse(camera, "sees the projector's white darker than its black",
           "is the display inverted, or other light in the way?");
  std::erase_if(parts_, [](const Part& part) { return part.pixels.empty(); });
  if (parts_.empty() && n_clipped > 0)
    refuse(camera, "is saturated wherever the projector's white is seen",
           "shorten the exposure (--auto-exposure)");
  set_mean_levels(dark.mean, bright.mean);
}

/// Sets black_dn_ and white_dn_ to the means of the pixels in use, or of all where there is none.
void LightLevels::set_mean_levels(const std::vector<double>& black, const std::vector<double>& white) {
  std::size_t n = 0;
  for (const Part& part : parts_)
    for (const Pixel& pixel : part.pixels) {
      black_dn_ += black[pixel.index];
      white_dn_ += white[pixel.index];
      ++n;
    }
  if (n == 0) {
    black_dn_ = mean_and_scatter(black).first;
    white_dn_ = mean_and_scatter(white).first;
    return;
  }
  black_dn_ /= static_cast<double>(n);
  white_dn_ /= static_cast<double>(n);
}

double LightLevels::raw_level(const Part& part, const ImageU16& frame) {
  double sum = 0.0;
  for (const Pixel& pixel : part.pixels)
    sum += static_cast<double>(pixel.weight) * static_cast<double>(frame.data[pixel.index]);
  return sum;
}

/// Returns the levels by part, then by frame.
std::vector<std::vector<double>> LightLevels::raw_levels(const std::vector<ImageU16>& frames) const {
  std::vector<std::vector<double>> out;
  for (const Part& part : parts_) {
    out.emplace_back();
    for (const ImageU16& frame : frames) out.back().push_back(raw_level(part, frame));
  }
  return out;
}

std::vector<double> LightLevels::shares(const ImageU16& frame) const {
  std::vector<double> out;
  for (const Part& part : parts_) out.push_back((raw_level(part, frame) - part.black) / part.range);
  return out;
}

}  // namespace fringetwin::capture
