// SPDX-License-Identifier: Apache-2.0
#include "measure/swapped_images.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "twin/base/constants.hpp"

namespace fringetwin::measure {
namespace {

/// When other readings are tried: right twins reject up to 3.2 %, and have points at most pixels that both
/// cameras can see. What is said depends on the bounds below alone.
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

/// The rows that are tried: bands of them, in which pixels have neighbours as points need them. A few
/// thousand pixels tell it.
bool is_in_a_band(int y, int height) {
  constexpr int kEvery = 32, kBand = 4, kFewestRows = 64;
  return height < kFewestRows || y % kEvery < kBand;
}

enum class Rows { all, bands };

/// Returns an image that is flipped; outside the rows, which are those before, it is filled.
template <class T>
Image<T> flipped(const Image<T>& image, Flip how, Rows rows, T fill) {
  Image<T> out(image.width, image.height, fill);
  const bool sideways = how == Flip::sideways || how == Flip::turned,
             upside_down = how == Flip::upside_down || how == Flip::turned;
  for (int y = 0; y < image.height; ++y) {
    if (rows == Rows::bands && !is_in_a_band(y, image.height)) continue;
    const auto from = image.data.begin() + static_cast<std::ptrdiff_t>(image.index(0, y));
    const auto to =
        out.data.begin() + static_cast<std::ptrdiff_t>(out.index(0, upside_down ? image.height - 1 - y : y));
    if (sideways)
      std::reverse_copy(from, from + image.width, to);
    else
      std::copy(from, from + image.width, to);
  }
  return out;
}

/// Returns the coordinates and their sigmas, flipped, and nothing else: no phases, amplitudes or means.
CameraDecode flipped(const CameraDecode& decoded, Flip how, Rows rows) {
  CameraDecode out;
  out.flags = ImageU8(decoded.width(), decoded.height());
  for (const DirectionDecode& d : decoded.directions) {
    DirectionDecode copy;
    copy.axis = d.axis;
    copy.pitches_px = d.pitches_px;
    copy.finest = d.finest;
    copy.smoothed = d.smoothed;
    copy.coordinate_px = flipped(d.coordinate_px, how, rows, kNaN);
    copy.coordinate_sigma_px =
        flipped(d.coordinate_sigma_px, how, rows, std::numeric_limits<float>::quiet_NaN());
    out.directions.push_back(std::move(copy));
  }
  return out;
}

/// Tells which coordinates a camera saw in each epipolar plane, whatever depth they are seen at: pixels of
/// the other camera with one between them can have a match.
class EpipolarRanges {
 public:
  EpipolarRanges(const Twin& twin, const CameraDecode& second) {
    const Pose T_cam0_cam1 = twin.cameras[0].T_cam_world * twin.cameras[1].T_cam_world.inverse();
    const Eigen::Vector3d baseline = T_cam0_cam1.translation_mm.normalized();
    across_.row(0) = baseline.unitOrthogonal();
    across_.row(1) = baseline.cross(baseline.unitOrthogonal());
    ranges_.resize(second.directions.size() * kPlanes);
    for_each_of_a_grid(second, [&](int x, int y) {
      const auto ray = twin.cameras[1].lens.unproject({static_cast<double>(x), static_cast<double>(y)});
      if (!ray) return;
      const std::size_t plane = plane_of(T_cam0_cam1.rotation * *ray);
      for (std::size_t k = 0; k < second.directions.size(); ++k)
        ranges_[k * kPlanes + plane].add(second.directions[k].coordinate_px(x, y));
    });
  }
  /// Returns the share of the first camera's decoded pixels whose coordinates lie in these ranges.
  double matchable_share(const Twin& twin, const CameraDecode& first) const {
    std::size_t decoded = 0, matchable = 0;
    for_each_of_a_grid(first, [&](int x, int y) {
      const auto ray = twin.cameras[0].lens.unproject({static_cast<double>(x), static_cast<double>(y)});
      ++decoded;
      if (!ray) return;
      const std::size_t plane = plane_of(*ray);
      bool holds = true;
      for (std::size_t k = 0; k < first.directions.size(); ++k)
        holds = holds && ranges_[k * kPlanes + plane].holds(first.directions[k].coordinate_px(x, y));
      matchable += holds ? 1 : 0;
    });
    return decoded == 0 ? 0.0 : static_cast<double>(matchable) / static_cast<double>(decoded);
  }

 private:
  static constexpr std::size_t kPlanes = 720;  ///< of half a degree
  struct Range {
    double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
    void add(double value) { low = std::min(low, value), high = std::max(high, value); }
    bool holds(double value) const { return value >= low && value <= high; }
  };
  /// Visits pixels with all coordinates, of a grid of 200 by 200.
  template <class Visit>
  static void for_each_of_a_grid(const CameraDecode& decoded, const Visit& visit) {
    constexpr int kAcross = 200;
    const int step_x = std::max(1, decoded.width() / kAcross),
              step_y = std::max(1, decoded.height() / kAcross);
    for (int y = 0; y < decoded.height(); y += step_y)
      for (int x = 0; x < decoded.width(); x += step_x)
        if (std::ranges::all_of(decoded.directions, [&](const DirectionDecode& d) {
              return std::isfinite(d.coordinate_px(x, y));
            }))
          visit(x, y);
  }
  std::size_t plane_of(const Eigen::Vector3d& ray_cam0) const {
    const Eigen::Vector2d q = across_ * ray_cam0;
    const double turns = std::atan2(q.y(), q.x()) / (2.0 * std::numbers::pi) + 0.5;
    return std::min(kPlanes - 1, static_cast<std::size_t>(turns * static_cast<double>(kPlanes)));
  }

  Eigen::Matrix<double, 2, 3> across_;  ///< axes across the baseline, in the frame of camera 0
  std::vector<Range> ranges_;           ///< of each direction in each plane
};

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

/// `first` has bands of rows alone.
TriedReading tried(const Twin& twin, std::string text, const CameraDecode& first,
                   const CameraDecode& second) {
  TriangulationSummary summary;
  triangulate_stereo(twin, first, second, &summary);
  TriedReading out{.text = std::move(text)};
  if (summary.n_candidates == 0) return out;
  out.rejected = rejected_share(summary);
  out.points = static_cast<double>(summary.n_points) / static_cast<double>(summary.n_candidates);
  return out;
}

/// Tries the flips of the first camera's images that go with one of the second's.
void add_flips(const Twin& twin, const CameraDecode& first, const CameraDecode& second, Flip of_second,
               std::vector<TriedReading>& readings) {
  for (const Flip of_first : kFlips) {
    const bool is_described = of_first == Flip::none && of_second == Flip::none;
    const bool differ = of_first != of_second && of_first != Flip::none && of_second != Flip::none;
    if (is_described || differ) continue;
    const std::string whose =
        of_first == of_second
            ? "the images of both cameras "
            : fmt::format("the images of \"{}\" ", twin.cameras[of_first == Flip::none ? 1 : 0].name);
    readings.push_back(tried(twin, whose + flip_text(of_first == Flip::none ? of_second : of_first),
                             flipped(first, of_first, Rows::bands), second));
  }
}

std::vector<TriedReading> swapped_readings(const Twin& twin, const CameraDecode& first,
                                           const CameraDecode& second) {
  std::vector<TriedReading> out;
  if (first.flags.same_size(second.flags))
    out.push_back(tried(
        twin,
        fmt::format("the images of \"{}\" and \"{}\" exchanged", twin.cameras[0].name, twin.cameras[1].name),
        flipped(second, Flip::none, Rows::bands), first));
  for (const Flip of_second : kFlips)
    if (of_second == Flip::none)
      add_flips(twin, first, second, of_second, out);
    else
      add_flips(twin, first, flipped(second, of_second, Rows::all), of_second, out);
  return out;
}

}  // namespace

bool rays_miss_each_other(const Twin& twin, const Measurement& measured) {
  if (!can_triangulate(twin) || twin.triangulate() != Triangulate::stereo) return false;
  const TriangulationSummary& all = measured.triangulation;
  if (all.n_candidates < kFewestJudgedPixels) return false;
  if (judged_pixels(all) >= kFewestJudgedPixels && rejected_share(all) > kManyRejected) return true;
  const auto points = static_cast<double>(all.n_points), candidates = static_cast<double>(all.n_candidates);
  if (points >= kFewPoints * candidates) return false;
  const EpipolarRanges seen(twin, measured.cameras[1]);
  return points < kFewPoints * candidates * seen.matchable_share(twin, measured.cameras[0]);
}

std::optional<std::string> swapped_images(const Twin& twin, const Measurement& measured) {
  if (!rays_miss_each_other(twin, measured)) return std::nullopt;
  const CameraDecode &first = measured.cameras[0], &second = measured.cameras[1];
  const TriedReading described = tried(twin, "", flipped(first, Flip::none, Rows::bands), second);
  std::vector<TriedReading> good;
  double most = 0.0;
  for (TriedReading& reading : swapped_readings(twin, first, second))
    if (fits_better(described, reading)) {
      most = std::max(most, reading.points);
      good.push_back(std::move(reading));
    }
  std::erase_if(good, [=](const TriedReading& reading) { return reading.points < kAsGood * most; });
  if (good.empty()) return std::nullopt;
  std::vector<std::string> texts;
  for (const TriedReading& reading : good) texts.push_back(reading.text);
  return fmt::format(
      "the images do not show what their cameras see: {:.0f} % of the pixels of camera \"{}\" have a "
      "point, and {:.0f} % of those with a match are rejected; with {} it would be {:.0f} % and {:.1f} %",
      100.0 * described.points, twin.cameras[0].name, 100.0 * described.rejected,
      fmt::join(texts, ", or with "), 100.0 * good.front().points, 100.0 * good.front().rejected);
}

}  // namespace fringetwin::measure
