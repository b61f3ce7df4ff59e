// SPDX-License-Identifier: Apache-2.0
// Parameters of when a camera's exposures begin, and what a change of them does to its gray values: the light
// of neighbouring patterns takes the place of that of the own one, or the other way round.
#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "compare/parameters/closed_columns.hpp"

namespace fringetwin::compare {
namespace {

/// At the border of a pattern a later exposure sees more of the one after, an earlier one more of the one
/// before: a fit that jumped from one slope to the other would go to and fro about exposures that are not
/// late at all. So far about the border the slope goes over from one to the other, periods.
constexpr double kBothSides = 5e-3;
/// Exposures on time lie on the border: what is within so much of it goes to and fro between the two slopes,
/// periods.
constexpr double kOnTime = 1e-3;
/// Where an exposure sees its own pattern for less than this, what the patterns alone give is not told well
/// by what the exposures saw: that stands for it.
constexpr double kMostlyOwn = 0.5;

/// One image of the samples in the order of the sequence: where it stands among them, and whether those
/// before and after it in the sequence are there, too.
struct TimedImage {
  std::size_t at = 0, image = 0;
  bool has_before = false, has_after = false;
};

std::vector<TimedImage> in_sequence(const GridSamples& s) {
  std::vector<TimedImage> images;
  for (std::size_t k = 0; k < s.images.size(); ++k)
    images.push_back({.at = k, .image = static_cast<std::size_t>(s.images[k])});
  std::ranges::sort(images, {}, &TimedImage::image);
  for (std::size_t k = 1; k < images.size(); ++k)
    if (images[k].image == images[k - 1].image + 1) images[k].has_before = images[k - 1].has_after = true;
  return images;
}

/// What the exposures of one row see, of each image of in_sequence(): shares, 0 of a pattern that is not
/// there, and what a change of the begin makes of them.
struct RowOfExposures {
  std::vector<double> before, own, after;
  std::vector<double> more_before, more_after;  ///< per period that it begins later
};

RowOfExposures exposures_of_row(const ExposureTiming& timing, const std::vector<TimedImage>& images,
                                double height) {
  RowOfExposures row;
  for (const TimedImage& image : images) {
    const double begin = timing.begin(image.image, height), beyond = begin + timing.exposure - 1.0;
    const ExposureParts parts = exposure_parts(begin, timing.exposure);
    row.before.push_back(image.has_before ? parts.share[0] : 0.0);
    row.after.push_back(image.has_after ? parts.share[2] : 0.0);
    row.own.push_back(1.0 - row.before.back() - row.after.back());
    const auto is_beyond = [](double by) { return std::clamp(0.5 + 0.5 * by / kBothSides, 0.0, 1.0); };
    row.more_before.push_back(image.has_before ? -is_beyond(-begin) / timing.exposure : 0.0);
    row.more_after.push_back(image.has_after ? is_beyond(beyond) / timing.exposure : 0.0);
  }
  return row;
}

/// Returns what the patterns alone give of what the exposures saw: solves the tridiagonal equations.
std::vector<double> of_patterns(const RowOfExposures& row, std::vector<double> seen) {
  if (std::ranges::any_of(row.own, [](double own) { return own < kMostlyOwn; })) return seen;
  std::vector<double> upper(seen.size());
  for (std::size_t k = 0; k < seen.size(); ++k) {
    const double pivot = row.own[k] - (k > 0 ? row.before[k] * upper[k - 1] : 0.0);
    upper[k] = row.after[k] / pivot;
    seen[k] = (seen[k] - (k > 0 ? row.before[k] * seen[k - 1] : 0.0)) / pivot;
  }
  for (std::size_t k = seen.size(); k-- > 1;) seen[k - 1] -= upper[k - 1] * seen[k];
  return seen;
}

/// Returns the row of a pixel in its camera's image.
double row_px(const GridSamples& s, std::size_t pixel) {
  return s.grid.first_y +
         s.grid.stride * static_cast<double>(s.cell[pixel] / static_cast<std::size_t>(s.grid.width));
}

/// The begin of the exposures is moved, of one image or of all, by so much per unit of the parameter in a row
/// of this height.
std::function<void(const EffectInput&, std::vector<float>&)> timing_effect(std::optional<std::size_t> image,
                                                                           double (*moved)(double height)) {
  return [=](const EffectInput& in, std::vector<float>& irradiance) {
    const GridSamples& s = in.samples;
    const Camera& camera = in.fitted.cameras[s.camera];
    const ExposureTiming timing = camera.timing.value_or(ExposureTiming{});
    const RowHeights heights = camera.row_heights();
    const std::vector<TimedImage> images = in_sequence(s);
    const std::size_t n = images.size();
#pragma omp parallel for schedule(static)
    for (std::size_t p = 0; p < s.n_pixels(); ++p) {
      const double height = heights.of(row_px(s, p)), later = (in.to - in.from) * moved(height);
      const RowOfExposures row = exposures_of_row(timing, images, height);
      std::vector<double> light;
      for (const TimedImage& i : images)
        light.push_back(static_cast<double>(in.before[p * n + i.at]) /
                        factor_of(camera.exposure_factors, i.image));
      light = of_patterns(row, std::move(light));
      for (std::size_t k = 0; k < n; ++k) {
        if (image && images[k].image != *image) continue;
        double change = 0.0;
        if (images[k].has_before) change += row.more_before[k] * (light[k - 1] - light[k]);
        if (images[k].has_after) change += row.more_after[k] * (light[k + 1] - light[k]);
        float& value = irradiance[p * n + images[k].at];
        value = static_cast<float>(static_cast<double>(value) +
                                   later * change * factor_of(camera.exposure_factors, images[k].image));
      }
    }
  };
}

ExposureTiming& timing_of(Twin& twin, std::size_t camera) {
  std::optional<ExposureTiming>& timing = twin.cameras[camera].timing;
  return timing ? *timing : timing.emplace();
}

/// Makes one image later.
void make_late(Twin& twin, std::size_t camera, std::size_t image, std::size_t n_images, double by) {
  ExposureTiming& timing = timing_of(twin, camera);
  std::vector<double> late;
  for (std::size_t k = 0; k < n_images; ++k) late.push_back(timing.late_of(k));
  late.at(image) += by;
  timing.late = std::move(late);
}

}  // namespace

std::vector<Parameter> timing_parameters(const Twin& twin, std::size_t camera,
                                         const std::vector<int>& compared) {
  const ExposureTiming timing = twin.cameras[camera].timing.value_or(ExposureTiming{});
  const std::string& name = twin.cameras[camera].name;
  const std::size_t n_images = expand_sequence(twin.fringes).size();
  const auto has_neighbours = [&](int image) {
    const auto is_there = [&](int other) {
      return other < 0 || other == static_cast<int>(n_images) ||
             std::ranges::find(compared, other) != compared.end();
    };
    return is_there(image - 1) && is_there(image + 1);
  };
  // with these limits no exposure reaches beyond the neighbouring patterns, whatever else is fitted
  double most_read_out = timing.exposure;
  for (std::size_t k = 0; k < n_images; ++k)
    most_read_out = std::min(
        {most_read_out, 2.0 * (timing.late_of(k) + timing.exposure), 2.0 * (1.0 - timing.late_of(k))});
  most_read_out = std::max(most_read_out, timing.read_out);
  const double reach = 0.5 * most_read_out;
  std::vector<Parameter> all;
  for (const int image : compared) {
    const auto at = static_cast<std::size_t>(image);
    Parameter& p = all.emplace_back(Parameter{.group = "timing",
                                              .name = fmt::format("{}.image_{}.late", name, image),
                                              .unit = "",
                                              .start = timing.late_of(at),
                                              .step = 3e-3});
    p.change = [=](Twin& t, double d) { make_late(t, camera, at, n_images, d); };
    if (has_neighbours(image)) p.effect = timing_effect(at, [](double) { return 1.0; });
    p.settled = kOnTime;
    p.smallest = std::min(p.start, reach - timing.exposure);
    p.largest = std::max(p.start, 1.0 - reach);
    // before the first pattern and after the last one nothing else is known to be shown: where no row sees
    // another pattern, nothing tells it
    const double rows = 0.5 * timing.read_out;
    if (at == 0) p.smallest = std::min(p.start, -rows);
    if (at + 1 == n_images) p.largest = std::max(p.start, 1.0 - timing.exposure + rows);
  }
  if (compared.empty()) return all;
  Parameter& p = all.emplace_back(Parameter{.group = "timing",
                                            .name = name + ".timing.read_out",
                                            .unit = "",
                                            .start = timing.read_out,
                                            .step = 3e-3});
  p.change = [=](Twin& t, double d) { timing_of(t, camera).read_out += d; };
  if (std::ranges::all_of(compared, has_neighbours))
    p.effect = timing_effect(std::nullopt, [](double height) { return height; });
  p.smallest = 0.0;
  p.largest = most_read_out;
  return all;
}

}  // namespace fringetwin::compare
