// SPDX-License-Identifier: Apache-2.0
#include "measure/swapped_images.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "twin/base/constants.hpp"

namespace fringetwin::measure {
namespace {

/// When other readings are tried: right twins reject up to 3.2 % and lack the pixels that only one camera
/// sees. It costs the time of a measurement; what is said depends on the bounds below alone.
constexpr double kManyRejected = 0.2, kFewPoints = 0.5;
/// Of the pixels with a match, at most this share is rejected when a reading is right: of right twins
/// 0.1 ... 3.2 % are, at steps of the depth; of exchanged or mirrored images 29 % and more.
constexpr double kMostRejected = 0.05;
constexpr double kLeftRejected = 0.25;  ///< and this part of what is rejected as described,
/// of all pixels, at least this share has a point, and so many times as many as described. Where the
/// description matches next to nothing, so that there is nothing to reject, many times as many tell it alone.
constexpr double kFewestWithPoint = 0.3, kTimesMore = 1.3, kManyTimesMore = 5.0;
/// Readings as good as the best to this share of its points are told with it.
constexpr double kAsGood = 0.9;

enum class Flip { none, sideways, upside_down, turned };
constexpr std::array kFlips{Flip::none, Flip::sideways, Flip::upside_down, Flip::turned};

template <class T>
void flip(Image<T>& image, Flip how) {
  if (how == Flip::sideways || how == Flip::turned)
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width / 2; ++x) std::swap(image(x, y), image(image.width - 1 - x, y));
  if (how == Flip::upside_down || how == Flip::turned)
    for (int y = 0; y < image.height / 2; ++y)
      for (int x = 0; x < image.width; ++x) std::swap(image(x, y), image(x, image.height - 1 - y));
}

/// Returns what points are made of, of images that are flipped.
CameraDecode flipped(const CameraDecode& decoded, Flip how) {
  CameraDecode out = decoded;
  flip(out.flags, how);
  for (DirectionDecode& d : out.directions) {
    flip(d.coordinate_px, how);
    flip(d.coordinate_sigma_px, how);
  }
  return out;
}

/// Leaves bands of rows, in which pixels have neighbours as points need them: a few thousand pixels tell it.
void thin(CameraDecode& decoded) {
  constexpr int kEvery = 32, kBand = 4, kFewestRows = 64;
  if (decoded.height() < kFewestRows) return;
  for (DirectionDecode& d : decoded.directions)
    for (int y = 0; y < decoded.height(); ++y)
      for (int x = 0; x < decoded.width() && y % kEvery >= kBand; ++x) d.coordinate_px(x, y) = kNaN;
}

struct TriedReading {
  std::string text;
  double rejected = 1.0;  ///< of the pixels with a match
  double points = 0.0;    ///< of all pixels
};

bool fits_better(const TriedReading& described, const TriedReading& other) {
  if (other.rejected > kMostRejected || other.points < kFewestWithPoint) return false;
  return other.points >= kManyTimesMore * described.points ||
         (other.points >= kTimesMore * described.points &&
          other.rejected <= kLeftRejected * described.rejected);
}

std::string flip_text(Flip how) {
  if (how == Flip::sideways) return "mirrored left to right";
  return how == Flip::upside_down ? "upside down" : "turned by 180 degrees";
}

TriedReading tried(const Twin& twin, std::string text, CameraDecode first, const CameraDecode& second) {
  thin(first);
  TriangulationSummary summary;
  triangulate_stereo(twin, first, second, &summary);
  TriedReading out{.text = std::move(text)};
  if (summary.n_candidates == 0) return out;
  out.rejected = rejected_share(summary);
  out.points = static_cast<double>(summary.n_points) / static_cast<double>(summary.n_candidates);
  return out;
}

std::vector<TriedReading> other_places(const Twin& twin, const CameraDecode& first,
                                       const CameraDecode& second) {
  std::vector<TriedReading> out;
  if (first.flags.same_size(second.flags))
    out.push_back(tried(
        twin,
        fmt::format("the images of \"{}\" and \"{}\" exchanged", twin.cameras[0].name, twin.cameras[1].name),
        second, first));
  for (const Flip a : kFlips)
    for (const Flip b : kFlips) {
      if ((a == Flip::none && b == Flip::none) || (a != b && a != Flip::none && b != Flip::none)) continue;
      const std::string whose = a == b ? "the images of both cameras "
                                : a == Flip::none
                                    ? fmt::format("the images of \"{}\" ", twin.cameras[1].name)
                                    : fmt::format("the images of \"{}\" ", twin.cameras[0].name);
      out.push_back(
          tried(twin, whose + flip_text(a == Flip::none ? b : a), flipped(first, a), flipped(second, b)));
    }
  return out;
}

}  // namespace

std::optional<std::string> swapped_images(const Twin& twin, const Measurement& measured) {
  const TriangulationSummary& all = measured.triangulation;
  const bool few = static_cast<double>(all.n_points) < kFewPoints * static_cast<double>(all.n_candidates);
  if (!(few || rejected_share(all) > kManyRejected) || !can_triangulate(twin) ||
      twin.triangulate() != Triangulate::stereo)
    return std::nullopt;
  const TriedReading described = tried(twin, "", measured.cameras[0], measured.cameras[1]);
  std::vector<TriedReading> good;
  double most = 0.0;
  for (TriedReading& reading : other_places(twin, measured.cameras[0], measured.cameras[1]))
    if (fits_better(described, reading)) {
      most = std::max(most, reading.points);
      good.push_back(std::move(reading));
    }
  std::erase_if(good, [=](const TriedReading& reading) { return reading.points < kAsGood * most; });
  if (good.empty()) return std::nullopt;
  std::vector<std::string> texts;
  for (const TriedReading& reading : good) texts.push_back(reading.text);
  return fmt::format(
      "the images do not show what their cameras see: {:.0f} % of the pixels of camera \"{}\" have a point "
      "and "
      "{:.0f} % of those with a match are rejected; with {} it would be {:.0f} % and {:.1f} %",
      100.0 * described.points, twin.cameras[0].name, 100.0 * described.rejected,
      fmt::join(texts, ", or with "), 100.0 * good.front().points, 100.0 * good.front().rejected);
}

}  // namespace fringetwin::measure
