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

namespace fringetwin::compare {
namespace {

using measure::CameraDecode;
using measure::DirectionDecode;

// The figures of right twins and of wrong ones: docs/metrics/verdict.md, "Other surfaces".
constexpr int kCore_px = 2;            ///< an area has a core: what is left without so many pixels of its rim
constexpr std::size_t kLeastCore = 9;  ///< px: a square of 7 x 7
constexpr double kMostOthers = 0.5;    ///< of the pixels of both sides: more are another description
constexpr double kLeastKnown = 0.1;    ///< of an area's pixels have a point that tells what they are
constexpr double kNearWhole = 0.05;    ///< periods: a wrong order is off by whole ones, but for noise
constexpr double kSigmasOfPoint = 3.0;  ///< a point says which surface it is on where the gate is as wide

/// What a pixel's phases say.
struct PixelPhase {
  bool is_other = false;  ///< more than half a fringe apart
  bool is_whole = false;  ///< and by whole periods: a wrong fringe order of the same place
};

/// The phases of one camera on both sides.
class PhasesOfBoth {
 public:
  PhasesOfBoth(const CameraDecode& real, const CameraDecode& simulated) {
    for (const DirectionDecode& r : real.directions) {
      const DirectionDecode* s = simulated.direction(r.axis);
      const bool known = s && !r.coordinate_px.empty() && !s->coordinate_px.empty() && !r.pitches_px.empty();
      if (known && r.unwrapped && s->unwrapped) pairs_.emplace_back(&r, s);
    }
  }
  PixelPhase operator()(std::size_t i) const {
    PixelPhase out{false, true};
    for (const auto& [real, simulated] : pairs_) {
      const double pitch_px = real->pitches_px[real->finest];
      const double periods = (simulated->coordinate_px.data[i] - real->coordinate_px.data[i]) / pitch_px;
      if (!(std::abs(periods) * kTwoPi > farthest_rad(*real))) continue;
      out.is_other = true;
      const bool has_phase = !real->wrapped_rad.empty();  // words of a code differ by whole ones always
      if (!has_phase || std::abs(periods - std::round(periods)) > kNearWhole) out.is_whole = false;
    }
    out.is_whole = out.is_whole && out.is_other;
    return out;
  }

 private:
  std::vector<std::pair<const DirectionDecode*, const DirectionDecode*>> pairs_;
};

/// What the pixels of an area say together.
struct AreaCounts {
  std::size_t n = 0, others = 0, whole = 0, core = 0;
  std::size_t known = 0, off = 0;  ///< with a real point that tells; of these near no object of the twin
  std::map<int, std::size_t> seen, shown;  ///< labels of the real and of the simulated points
  std::vector<double> before_mm, sigma_mm;
  Eigen::Vector2d pixels = Eigen::Vector2d::Zero();
  Eigen::Vector3d places_mm = Eigen::Vector3d::Zero();

  bool is_wrong_order() const { return 2 * whole > others; }
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
        camera_(twin.cameras[camera]),
        decode_real_(real.measurement->cameras[camera]),
        decode_simulated_(simulated.measurement->cameras[camera]),
        cloud_real_(real.measurement->cloud),
        cloud_simulated_(simulated.measurement->cloud),
        index_real_(points_of_pixels(twin, camera, cloud_real_)),
        index_simulated_(points_of_pixels(twin, camera, cloud_simulated_)),
        phases_(decode_real_, decode_simulated_),
        viewer_mm_(camera_.T_cam_world.inverse().translation_mm) {}

  std::vector<OtherSurfaceRow> rows() const {
    std::size_t both = 0, others = 0;
    ImageU8 other(decode_real_.width(), decode_real_.height(), 0);
    for (std::size_t i = 0; i < other.size(); ++i) {
      if (decode_real_.flags.data[i] != measure::kValid) continue;
      const bool on_both = is_on_both(i), is_other = on_both && phases_(i).is_other;
      both += on_both ? 1u : 0u;
      others += is_other ? 1u : 0u;
      other.data[i] = !on_both || is_other ? 1 : 0;
    }
    std::vector<OtherSurfaceRow> out;
    if (static_cast<double>(others) > kMostOthers * static_cast<double>(both)) return out;
    const ImageU8 core = eroded(other, kCore_px);
    if (std::ranges::none_of(core.data, [](unsigned char v) { return v != 0; })) return out;
    for (const std::vector<std::size_t>& area : all_areas(other)) {
      std::size_t in_core = 0;
      for (const std::size_t i : area) in_core += core.data[i];
      if (in_core < kLeastCore) continue;
      if (OtherSurfaceRow row = row_of(area); !row.why.empty()) out.push_back(std::move(row));
    }
    std::ranges::stable_sort(out, std::ranges::greater{}, &OtherSurfaceRow::n);
    return out;
  }

 private:
  bool is_on_both(std::size_t i) const {
    return decode_real_.flags.data[i] == measure::kValid &&
           decode_simulated_.flags.data[i] == measure::kValid;
  }

  AreaCounts counts_of(const std::vector<std::size_t>& area) const {
    AreaCounts out;
    out.n = area.size();
    const auto width = static_cast<std::size_t>(index_real_.width);
    for (const std::size_t i : area) {
      out.pixels += Eigen::Vector2d(static_cast<double>(i % width), static_cast<double>(i / width));
      const PixelPhase phase = is_on_both(i) ? phases_(i) : PixelPhase{};
      out.others += phase.is_other ? 1u : 0u;
      out.whole += phase.is_whole ? 1u : 0u;
      if (const int point = index_real_.data[i]; point >= 0) take_point(i, point, out);
    }
    return out;
  }

  void take_point(std::size_t i, int point, AreaCounts& out) const {
    const auto sigma_mm = static_cast<double>(cloud_real_.sigma_mm[point]);
    if (!(kSigmasOfPoint * sigma_mm <= nearest_.gate_mm())) return;
    const Eigen::Vector3d& real_mm = cloud_real_.p_world_mm[point];
    const int label = nearest_(real_mm);
    ++out.known;
    out.off += label == kNoObject ? 1u : 0u;
    ++out.seen[label];
    out.places_mm += real_mm;
    const int other = index_simulated_.data[i];
    if (other < 0) return;
    const Eigen::Vector3d& simulated_mm = cloud_simulated_.p_world_mm[other];
    if (const int shown = nearest_(simulated_mm); shown != kNoObject) ++out.shown[shown];
    out.before_mm.push_back((simulated_mm - viewer_mm_).norm() - (real_mm - viewer_mm_).norm());
    out.sigma_mm.push_back(sigma_mm);
  }

  /// Returns whether the area shows another surface, rather than wrong fringe orders of the same one, or what
  /// noise makes.
  bool is_another_surface(AreaCounts& counts, int seen, int shown) const {
    const bool any_points = cloud_real_.size() > 0;
    if (!any_points) return counts.others > 0 && !counts.is_wrong_order();
    if (static_cast<double>(counts.known) < kLeastKnown * static_cast<double>(counts.n)) return false;
    // a wrong order moves points that the projector's coordinate tells; two cameras' points it leaves out
    if (twin_.triangulate() == Triangulate::projector && counts.others > 0 && counts.is_wrong_order())
      return false;
    if (2 * counts.off > counts.known) return true;
    if (seen == kNoObject || shown == kUnknownObject || 2 * counts.others < counts.n) return false;
    if (seen != shown) return true;
    return !counts.is_wrong_order() &&
           std::abs(median(counts.before_mm)) > kSigmasOfPoint * median(counts.sigma_mm);
  }

  /// Returns a row without words where the area is none.
  OtherSurfaceRow row_of(const std::vector<std::size_t>& area) const {
    AreaCounts counts = counts_of(area);
    OtherSurfaceRow row;
    const int seen = 2 * counts.off > counts.known ? kNoObject : most_frequent(counts.seen),
              shown = most_frequent(counts.shown);
    if (!is_another_surface(counts, seen, shown)) return row;
    const auto n = static_cast<double>(counts.n);
    row.camera = camera_.name;
    row.n = counts.n, row.n_other_order = counts.others;
    row.middle_px = {counts.pixels.x() / n, counts.pixels.y() / n};
    if (shown >= 0) row.object = twin_.objects[shown].name;
    if (seen >= 0) row.seen = twin_.objects[seen].name;
    if (!counts.before_mm.empty()) row.before_mm = median(counts.before_mm);
    if (counts.known > 0) {
      const Eigen::Vector3d place_mm = counts.places_mm / static_cast<double>(counts.known);
      row.place_mm = {place_mm.x(), place_mm.y(), place_mm.z()};
    }
    row.why = sentence_of(row);
    return row;
  }

  const Twin& twin_;
  const NearestObject& nearest_;
  const Camera& camera_;
  const CameraDecode &decode_real_, &decode_simulated_;
  const measure::PointCloud &cloud_real_, &cloud_simulated_;
  Image<int> index_real_, index_simulated_;
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
