// SPDX-License-Identifier: Apache-2.0
#include "compare/strangers/other_surfaces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include "compare/phase/phase_rows.hpp"
#include "compare/verdict/coverage_objects.hpp"
#include "compare/verdict/mask_areas.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/parallel.hpp"
#include "twin/base/statistics.hpp"
#include "twin/number/evenly_spread.hpp"

namespace fringetwin::compare {
namespace {

using measure::CameraDecode;
using measure::DirectionDecode;

// The figures of right twins and of wrong ones: docs/metrics/verdict.md, "Other surfaces".
constexpr int kCore_px = 2;         ///< an area has a core: what is left without so many pixels of its rim
constexpr double kLeastCore = 9.0;  ///< px: a square of 7 x 7
/// Of the pixels of both sides: the more there are, the more areas chance has to make a large one of. A tenth
/// of what the coverage allows in all thick areas together.
constexpr double kLeastCoreShare = 1e-5;
constexpr double kMostOthers = 0.5;        ///< of the pixels of both sides: more are another description
constexpr double kLeastKnown = 0.1;        ///< of an area's pixels have a point that tells what they are
constexpr double kNearWhole = 0.05;        ///< periods: a wrong order is off by whole ones, but for noise
constexpr double kSigmasOfPoint = 3.0;     ///< a point says which surface it is on where the gate is as wide
constexpr std::size_t kMostAsked = 2'000;  ///< points of an area: shares to 1.1 % (standard error)
constexpr std::size_t kMostPhases = 100'000;  ///< of a direction: a median to far less than kNearWhole
constexpr double kSteepest = 3.0;             ///< depth over width of a step between neighbours: 72 degrees
constexpr double kTogether = 0.75;            ///< of the steps between neighbours are no steeper on a surface

/// What a pixel's phases say.
struct PixelPhase {
  bool is_other = false;  ///< more than half a fringe apart
  bool is_whole = false;  ///< and by whole periods: a wrong fringe order of the same place
};

/// The phases of one camera and direction on both sides.
class PhasesOfDirection {
 public:
  PhasesOfDirection(const DirectionDecode& real, const DirectionDecode& simulated)
      : real_(real), simulated_(simulated), pitch_px_(real.pitches_px[real.finest]) {
    std::vector<double> same;
    for (const std::size_t i : evenly_spread(real.coordinate_px.size(), kMostPhases))
      if (const double off = periods(i); !is_other(off)) same.push_back(off);
    if (const double usual = median(same); std::isfinite(usual)) usual_periods_ = usual;
  }
  /// Returns simulated - real.
  double periods(std::size_t i) const {
    return (simulated_.coordinate_px.data[i] - real_.coordinate_px.data[i]) / pitch_px_;
  }
  bool is_other(double periods) const { return std::abs(periods) * kTwoPi > farthest_rad(real_); }
  /// Returns whether the difference is whole periods beside that of the pixels of the same order.
  bool is_whole(double periods) const {
    if (real_.wrapped_rad.empty()) return true;  // words of a code differ by whole ones always
    const double beside = periods - usual_periods_;
    return std::abs(beside - std::round(beside)) <= kNearWhole;
  }

 private:
  const DirectionDecode &real_, &simulated_;
  double pitch_px_, usual_periods_ = 0.0;
};

/// The phases of one camera on both sides.
class PhasesOfBoth {
 public:
  PhasesOfBoth(const CameraDecode& real, const CameraDecode& simulated) {
    for (const DirectionDecode& r : real.directions) {
      const DirectionDecode* s = simulated.direction(r.axis);
      const bool known = s && !r.coordinate_px.empty() && !s->coordinate_px.empty() && !r.pitches_px.empty();
      if (known && r.unwrapped && s->unwrapped) directions_.emplace_back(r, *s);
    }
  }
  PixelPhase operator()(std::size_t i) const {
    PixelPhase out{false, true};
    for (const PhasesOfDirection& direction : directions_) {
      const double periods = direction.periods(i);
      if (!direction.is_other(periods)) continue;
      out.is_other = true;
      out.is_whole = out.is_whole && direction.is_whole(periods);
    }
    out.is_whole = out.is_whole && out.is_other;
    return out;
  }

 private:
  std::vector<PhasesOfDirection> directions_;
};

/// What the pixels of an area say together.
struct AreaCounts {
  std::size_t n = 0, others = 0, whole = 0;
  std::size_t known = 0;                   ///< with a real point that tells what they are
  std::size_t asked = 0;                   ///< of these, points whose object was looked for
  std::size_t off = 0;                     ///< of these near no object of the twin
  std::size_t steps = 0, small_steps = 0;  ///< between points that tell, of neighbouring pixels
  std::map<int, std::size_t> seen, shown;  ///< labels of the real and of the simulated points
  std::vector<double> before_mm, sigma_mm;
  Eigen::Vector2d pixels = Eigen::Vector2d::Zero();
  Eigen::Vector3d places_mm = Eigen::Vector3d::Zero();

  bool is_mostly_other() const { return 2 * others >= n; }
  bool is_wrong_order() const { return 2 * whole > others; }
  bool is_mostly_off() const { return 2 * off > asked; }
  /// False for scattered points, as wrong orders make them, and for those without neighbours.
  bool hangs_together() const {
    return steps > 0 && static_cast<double>(small_steps) >= kTogether * static_cast<double>(steps);
  }
};

int most_frequent(const std::map<int, std::size_t>& counts) {
  if (counts.empty()) return kUnknownObject;
  return std::ranges::max_element(counts, {}, [](const auto& entry) { return entry.second; })->first;
}

std::string distance_text(double mm, const std::string& nearer, const std::string& farther) {
  if (!std::isfinite(mm)) return "";
  return fmt::format(", about {:.3g} mm {}", std::abs(mm), mm > 0.0 ? nearer : farther);
}

std::string sentence_of(const OtherSurfaceRow& row) {
  const std::string where = fmt::format(": {} pixels around camera pixel ({:.0f}, {:.0f})", row.n,
                                        row.middle_px[0], row.middle_px[1]);
  if (row.place_mm.empty()) return "the rig shows something else there than the twin" + where;
  if (row.seen.empty())
    return "something stands there that the twin does not have, or has elsewhere" + where +
           (row.object.empty()
                ? ""
                : distance_text(row.before_mm, "before", "behind") + " \"" + row.object + "\"");
  if (row.seen == row.object)
    return fmt::format("\"{}\" lies elsewhere there than the twin says", row.seen) + where +
           distance_text(row.before_mm, "nearer", "farther away");
  return fmt::format("the twin has \"{}\" where the rig shows \"{}\"", row.object, row.seen) + where +
         distance_text(row.before_mm, "before it", "behind it");
}

class SurfacesOfCamera {
 public:
  SurfacesOfCamera(const Twin& twin, const NearestObject& nearest, std::size_t camera, const Side& real,
                   const Side& simulated)
      : twin_(twin),
        nearest_(nearest),
        camera_at_(camera),
        camera_(twin.cameras[camera]),
        decode_real_(real.measurement->cameras[camera]),
        decode_simulated_(simulated.measurement->cameras[camera]),
        cloud_real_(real.measurement->cloud),
        cloud_simulated_(simulated.measurement->cloud),
        phases_(decode_real_, decode_simulated_),
        viewer_mm_(camera_.T_cam_world.inverse().translation_mm) {}

  std::vector<OtherSurfaceRow> rows() {
    std::vector<OtherSurfaceRow> out;
    std::size_t both = 0;
    const ImageU8 core = eroded(candidates(both), kCore_px);
    if (std::ranges::none_of(core.data, [](unsigned char v) { return v != 0; })) return out;
    index_real_ = points_of_pixels(twin_, camera_at_, cloud_real_);
    index_simulated_ = points_of_pixels(twin_, camera_at_, cloud_simulated_);
    const double least_core = std::max(kLeastCore, kLeastCoreShare * static_cast<double>(both));
    // what touches an area by a band only, as an outline that lies elsewhere, is no part of it
    const ImageU8 wide = dilated(core, kCore_px);
    for (const std::vector<std::size_t>& area : all_areas(wide)) {
      std::size_t in_core = 0;
      for (const std::size_t i : area) in_core += core.data[i];
      if (static_cast<double>(in_core) < least_core) continue;
      if (OtherSurfaceRow row = row_of(area, wide); !row.why.empty()) out.push_back(std::move(row));
    }
    std::ranges::stable_sort(out, std::ranges::greater{}, &OtherSurfaceRow::n);
    return out;
  }

 private:
  bool is_on_both(std::size_t i) const {
    return decode_real_.flags.data[i] == measure::kValid &&
           decode_simulated_.flags.data[i] == measure::kValid;
  }

  /// Returns the pixels that may show another surface; none where most of those of both sides do. Counts
  /// these.
  ImageU8 candidates(std::size_t& both) const {
    std::size_t others = 0;
    ImageU8 out(decode_real_.width(), decode_real_.height(), 0);
    for (std::size_t i = 0; i < out.size(); ++i) {
      if (decode_real_.flags.data[i] != measure::kValid) continue;
      const bool on_both = is_on_both(i), is_other = on_both && phases_(i).is_other;
      both += on_both ? 1u : 0u;
      others += is_other ? 1u : 0u;
      out.data[i] = !on_both || is_other ? 1 : 0;
    }
    if (static_cast<double>(others) > kMostOthers * static_cast<double>(both)) std::ranges::fill(out.data, 0);
    return out;
  }

  /// Returns whether the pixel has a real point that says which surface it is on.
  bool tells(std::size_t i) const {
    const int point = index_real_.data[i];
    return point >= 0 &&
           kSigmasOfPoint * static_cast<double>(cloud_real_.sigma_mm[point]) <= nearest_.least_gate_mm();
  }

  AreaCounts counts_of(const std::vector<std::size_t>& area, const ImageU8& areas) const {
    AreaCounts out;
    out.n = area.size();
    const auto width = static_cast<std::size_t>(index_real_.width);
    std::vector<std::size_t> telling;
    for (const std::size_t i : area) {
      out.pixels += Eigen::Vector2d(static_cast<double>(i % width), static_cast<double>(i / width));
      const PixelPhase phase = is_on_both(i) ? phases_(i) : PixelPhase{};
      out.others += phase.is_other ? 1u : 0u;
      out.whole += phase.is_whole ? 1u : 0u;
      if (tells(i)) telling.push_back(i);
    }
    out.known = telling.size();
    for (const std::size_t at : evenly_spread(telling.size(), kMostAsked)) {
      take_point(telling[at], out);
      take_steps(telling[at], areas, out);
    }
    return out;
  }

  void take_point(std::size_t i, AreaCounts& out) const {
    const int point = index_real_.data[i], other = index_simulated_.data[i];
    const Eigen::Vector3d& real_mm = cloud_real_.p_world_mm[point];
    const int label = nearest_(real_mm);
    ++out.asked;
    out.off += label == kNoObject ? 1u : 0u;
    ++out.seen[label];
    out.places_mm += real_mm;
    if (other < 0) return;
    const Eigen::Vector3d& simulated_mm = cloud_simulated_.p_world_mm[other];
    if (const int shown = nearest_(simulated_mm); shown != kNoObject) ++out.shown[shown];
    out.before_mm.push_back((simulated_mm - viewer_mm_).norm() - (real_mm - viewer_mm_).norm());
    out.sigma_mm.push_back(static_cast<double>(cloud_real_.sigma_mm[point]));
  }

  /// Counts the steps from a pixel's point to those of the pixels right of it and below, in the same area.
  void take_steps(std::size_t i, const ImageU8& areas, AreaCounts& out) const {
    const auto width = static_cast<std::size_t>(areas.width);
    const bool has_right = i % width + 1 < width;
    for (const std::size_t next : {has_right ? i + 1 : areas.size(), i + width}) {
      if (next >= areas.size() || areas.data[next] == 0 || !tells(next)) continue;
      ++out.steps;
      out.small_steps += is_small_step(index_real_.data[i], index_real_.data[next]) ? 1u : 0u;
    }
  }

  /// Returns whether a surface that the camera does not see edge-on has the two points of neighbouring
  /// pixels.
  bool is_small_step(int from, int to) const {
    const Eigen::Vector3d a_mm = cloud_real_.p_world_mm[from] - viewer_mm_,
                          b_mm = cloud_real_.p_world_mm[to] - viewer_mm_;
    const double nearer_mm = std::min(a_mm.norm(), b_mm.norm());
    const double width_mm = nearer_mm * (a_mm.normalized() - b_mm.normalized()).norm();
    const double sigma_mm = std::hypot(static_cast<double>(cloud_real_.sigma_mm[from]),
                                       static_cast<double>(cloud_real_.sigma_mm[to]));
    return std::abs(a_mm.norm() - b_mm.norm()) <= kSteepest * width_mm + kSigmasOfPoint * sigma_mm;
  }

  /// Returns whether the area shows another surface, rather than wrong fringe orders of the same one, or what
  /// noise makes.
  bool is_another_surface(AreaCounts& counts, int seen, int shown) const {
    const bool any_points = cloud_real_.size() > 0, is_wrong = counts.is_wrong_order();
    if (!any_points) return counts.is_mostly_other() && !is_wrong;
    if (static_cast<double>(counts.known) < kLeastKnown * static_cast<double>(counts.n)) return false;
    // no other phase tells of a pixel that the real side alone measured whether its order is wrong
    if (!counts.is_mostly_other()) return counts.is_mostly_off() && counts.hangs_together();
    // a wrong order moves points that the projector's coordinate tells; two cameras' points it leaves out
    if (twin_.triangulate() == Triangulate::projector && is_wrong) return false;
    if (counts.is_mostly_off()) return true;
    if (seen == kNoObject || shown == kUnknownObject) return false;
    if (seen != shown) return true;
    return !is_wrong && std::abs(median(counts.before_mm)) > kSigmasOfPoint * median(counts.sigma_mm);
  }

  /// Returns a row without words where the area is none.
  OtherSurfaceRow row_of(const std::vector<std::size_t>& area, const ImageU8& areas) const {
    AreaCounts counts = counts_of(area, areas);
    OtherSurfaceRow row;
    const int seen = counts.is_mostly_off() ? kNoObject : most_frequent(counts.seen),
              shown = most_frequent(counts.shown);
    if (!is_another_surface(counts, seen, shown)) return row;
    const auto n = static_cast<double>(counts.n);
    row.camera = camera_.name;
    row.n = counts.n, row.n_other_order = counts.others;
    row.middle_px = {counts.pixels.x() / n, counts.pixels.y() / n};
    if (shown >= 0) row.object = twin_.objects[shown].name;
    if (seen >= 0) row.seen = twin_.objects[seen].name;
    if (!counts.before_mm.empty()) row.before_mm = median(counts.before_mm);
    if (counts.asked > 0) {
      const Eigen::Vector3d place_mm = counts.places_mm / static_cast<double>(counts.asked);
      row.place_mm = {place_mm.x(), place_mm.y(), place_mm.z()};
    }
    row.why = sentence_of(row);
    return row;
  }

  const Twin& twin_;
  const NearestObject& nearest_;
  std::size_t camera_at_;
  const Camera& camera_;
  const CameraDecode &decode_real_, &decode_simulated_;
  const measure::PointCloud &cloud_real_, &cloud_simulated_;
  Image<int> index_real_, index_simulated_;  ///< points_of_pixels(), once rows() has found an area
  PhasesOfBoth phases_;
  Eigen::Vector3d viewer_mm_;
};

}  // namespace

std::vector<OtherSurfaceRow> other_surfaces(const Twin& twin, const Side& real, const Side& simulated) {
  std::vector<OtherSurfaceRow> out;
  const NearestObject nearest(twin);
  if (!real.measurement || !simulated.measurement || !nearest.is_known()) return out;
  std::vector<std::vector<OtherSurfaceRow>> of_camera(real.measurement->cameras.size());
  for_each_parallel(static_cast<int>(of_camera.size()), [&](int c) {
    of_camera[c] = SurfacesOfCamera(twin, nearest, c, real, simulated).rows();
  });
  for (std::vector<OtherSurfaceRow>& rows : of_camera) std::ranges::move(rows, std::back_inserter(out));
  return out;
}

void hold_against_surfaces(const std::vector<OtherSurfaceRow>& surfaces, std::vector<ExplainedRow>& rows) {
  for (ExplainedRow& row : rows) {
    std::uint64_t n_other_order = 0;
    for (const OtherSurfaceRow& surface : surfaces) {
      if (row.quantity == "coverage" && row.region == surface.camera) row.worsen(kNotExplained, surface.why);
      if (row.quantity == "phase" && row.region.starts_with(surface.camera + " "))
        n_other_order += surface.n_other_order;
    }
    if (n_other_order > 0)
      row.worsen(kNotExplained,
                 fmt::format("{} pixels of other fringe order lie in areas that show another surface than "
                             "the twin (see coverage)",
                             n_other_order));
  }
}

}  // namespace fringetwin::compare
