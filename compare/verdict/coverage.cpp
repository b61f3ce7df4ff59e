// SPDX-License-Identifier: Apache-2.0
#include "compare/verdict/coverage.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include "compare/verdict/coverage_objects.hpp"
#include "compare/verdict/explained.hpp"
#include "compare/verdict/mask_areas.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/parallel.hpp"

namespace fringetwin::compare {
namespace {

constexpr int kGap_px = 2;    ///< radius that closes speckle before outlines are taken
constexpr int kThick_px = 2;  ///< what is left of an area without so many pixels of its rim is thick
// The allowances: docs/metrics/verdict.md, "Coverage", has the figures of right and of wrong twins.
constexpr double kThickShare = 1e-4, kInteriorShare = 3e-3, kBorderPerOutline = 0.5;
constexpr double kInteriorShareOfObject = 0.05;  ///< a small object has much of its camera's scatter
constexpr double kFewThick = 9.0, kFew = 25.0;   ///< px that are always allowed
constexpr double kLeastCovered = 0.5;
constexpr std::uint64_t kFewestOfObject = 25;  ///< px: of less no row is made
/// Values this many standard deviations of the fringes' noise below the clip reach it by chance: 4 of the
/// noise there, whose variance is at most about twice that of the middle gray values.
constexpr double kChanceOfClip = 6.0;

bool is_seen(PixelState state) { return state <= PixelState::order; }

ImageU8 mask_of(const Image<PixelState>& states, bool (*is_set)(PixelState)) {
  ImageU8 mask(states.width, states.height, 0);
  for (std::size_t i = 0; i < mask.size(); ++i) mask.data[i] = is_set(states.data[i]) ? 1 : 0;
  return mask;
}
ImageU8 measured(const Image<PixelState>& states) {
  return mask_of(states, [](PixelState s) { return s == PixelState::measured; });
}

/// Returns the mean gray value below which no fringe can have the modulation asked for: a fringe's amplitude
/// is never above its mean less the black level; the mean of N steps has read noise of 1/sqrt(N).
double dark_below_dn(const Twin& twin, const Camera& camera) {
  const Sensor& sensor = camera.sensor;
  return sensor.black_level_dn + twin.measure.min_modulation_dn +
         3.0 * sensor.read_noise_dn.value_or(0.0) / std::sqrt(std::max(1, twin.fringes.steps));
}

bool is_judged_on_cover(const CoverageRow& row) { return row.object != kNotInTheTwin; }

bool has_areas(const CoverageRow& row) {
  return static_cast<double>(row.n_thick()) > row.allowed_thick ||
         static_cast<double>(row.n_interior()) > row.allowed_interior;
}
/// False where the border is not judged.
bool has_wide_borders(const CoverageRow& row) {
  return static_cast<double>(row.n_border()) > row.allowed_border;
}
bool is_hardly_covered(const CoverageRow& row) {
  return is_judged_on_cover(row) && !(row.covered_fraction() >= kLeastCovered);
}

/// Returns whether the row is beyond its allowances by no more than areas that show another surface: of the
/// pixels that the real side alone measures without those of the areas so few are left.
bool is_told_by_surfaces(const CoverageRow& row, const std::vector<OtherSurfaceRow>& told) {
  if (row.explained || has_wide_borders(row) || is_hardly_covered(row)) return false;
  std::uint64_t n = 0;
  for (const OtherSurfaceRow& surface : told) {
    const std::string shown = surface.seen.empty() ? kNotInTheTwin : surface.seen;
    const bool is_here = row.object.empty() || row.object == shown;
    if (surface.camera == row.camera && is_here) n += surface.n - surface.n_other_order;
  }
  if (n == 0) return false;
  CoverageRow rest = row;
  rest.real_only.thick -= std::min(n, row.real_only.thick);
  rest.real_only.interior -= std::min(n, row.real_only.interior);
  return !has_areas(rest);
}

/// Returns why most of the pixels that one side lacks have no phase there.
std::string reason(const OneSided& pixels, const std::string& lacking) {
  const std::array<std::pair<std::uint64_t, std::string>, 4> reasons{{
      {pixels.lost_dark,
       lacking + " side is dark there: it lacks what the other side sees, or has it in shadow"},
      {pixels.lost_low_modulation, lacking + " side has too weak fringes there"},
      {pixels.lost_saturated, lacking + " side is saturated there"},
      {pixels.lost_order, lacking + " side has fringes there, but no fringe orders"},
  }};
  const auto most =
      std::ranges::max_element(reasons, [](const auto& a, const auto& b) { return a.first < b.first; });
  return fmt::format("the {} ({} of {})", most->second, most->first, pixels.n);
}

std::string place_text(const CoverageRow& row) {
  if (row.place_box_px.empty()) return "";
  const std::vector<double>& box = row.place_box_px;
  std::string text = fmt::format("; the largest area lies in pixels x {:.0f} to {:.0f}, y {:.0f} to {:.0f}",
                                 box[0], box[2], box[1], box[3]);
  if (!row.place_mm.empty())
    text += fmt::format(", near x {:.1f}, y {:.1f}, z {:.1f} mm", row.place_mm[0], row.place_mm[1],
                        row.place_mm[2]);
  if (!row.place_object.empty())
    text += row.place_object == kNotInTheTwin ? ", near no object of the twin"
                                              : ", on \"" + row.place_object + "\"";
  return text;
}

/// Says how many pixels which side alone measures, the larger number first; a side that is within all
/// allowances by itself is left out beside one that is not.
std::string areas_text(const CoverageRow& row) {
  std::string text;
  const auto is_fault = [&row](const OneSided& pixels) {
    return static_cast<double>(pixels.thick) > row.allowed_thick ||
           static_cast<double>(pixels.interior) > row.allowed_interior;
  };
  const bool one_is_enough = is_fault(row.real_only) || is_fault(row.simulated_only);
  const auto add = [&](const OneSided& pixels, const char* side, const char* lacking) {
    if (pixels.interior == 0 || (one_is_enough && !is_fault(pixels))) return;
    text += fmt::format(
        "{}{} pixels ({:.1f} %) are measured on the {} side only, {} of them away from "
        "outlines, {} in areas wider than 4 px: {}",
        text.empty() ? "" : "; ", pixels.n, 100.0 * CoverageRow::ratio(pixels.n, row.n_union()), side,
        pixels.interior, pixels.thick, reason(pixels, lacking));
  };
  const bool real_is_worse = std::pair(row.real_only.thick, row.real_only.interior) >=
                             std::pair(row.simulated_only.thick, row.simulated_only.interior);
  if (real_is_worse) add(row.real_only, "real", "simulated");
  add(row.simulated_only, "simulated", "real");
  if (!real_is_worse) add(row.real_only, "real", "simulated");
  return text + (row.n_thick() == 0 ? "; they are scattered, as noise or weak fringes make them" : "") +
         place_text(row);
}

std::string borders_text(const CoverageRow& row) {
  return fmt::format(
      "along {} px of outline {} pixels are measured on one side only ({:.0f} allowed): the "
      "outlines of the two sides differ",
      row.outline_px, row.n_border(), row.allowed_border);
}

std::string cover_text(const CoverageRow& row) {
  if (row.n_seen == 0) return "neither side has fringes anywhere";
  return fmt::format(
      "only {:.1f} % of the {} pixels seen are measured on both sides; {} are measured on "
      "neither, {} of these saturated",
      100.0 * row.covered_fraction(), row.n_seen, row.n_neither(), row.n_neither_saturated);
}

std::string reasons_of(const CoverageRow& row) {
  std::string text;
  const auto add = [&](bool holds, std::string (*sentence)(const CoverageRow&)) {
    if (holds) text += (text.empty() ? "" : "; ") + sentence(row);
  };
  add(has_areas(row), areas_text);
  add(has_wide_borders(row), borders_text);
  add(is_hardly_covered(row), cover_text);
  return text;
}

/// Returns where pixels are counted that are in this state on the side that lacks them.
std::uint64_t OneSided::*lost_as(PixelState state) {
  switch (state) {
    case PixelState::saturated:
      return &OneSided::lost_saturated;
    case PixelState::order:
      return &OneSided::lost_order;
    case PixelState::low_modulation:
      return &OneSided::lost_low_modulation;
    case PixelState::dark:
    case PixelState::measured:  // never asked: that side lacks nothing
      return &OneSided::lost_dark;
  }
  return &OneSided::lost_dark;
}

/// Counts a pixel that one side measured; `lost`: what it is on the other side.
void count_one_sided(PixelState lost, OneSided& pixels, bool border, bool thick) {
  ++pixels.n;
  ++(border ? pixels.border : pixels.interior);
  pixels.thick += thick ? 1u : 0u;
  ++(pixels.*lost_as(lost));
}

/// Returns the largest noise of the camera's fringes on either side.
double largest_noise_dn(std::size_t camera, const Side& real, const Side& simulated) {
  double noise_dn = 0.0;
  for (const Side* side : {&real, &simulated})
    for (const measure::DirectionDecode& d : side->measurement->cameras[camera].directions)
      noise_dn = std::max(noise_dn, d.noise_dn);
  return noise_dn;
}

/// Calls saturated what one side measured with a phase step so near to the clip that noise decides, where the
/// other side is saturated.
void saturate_by_chance(const Twin& twin, const CameraImages& images, double noise_dn,
                        const Image<PixelState>& other, Image<PixelState>& states) {
  const double near_dn = images.saturation_dn() - kChanceOfClip * noise_dn;
  std::vector<const GrayImage*> steps;
  const std::vector<PatternSpec> patterns = expand_sequence(twin.fringes);
  for (std::size_t k = 0; k < std::min(patterns.size(), images.images.size()); ++k)
    if (patterns[k].kind == PatternSpec::Kind::phase_step) steps.push_back(&images.images[k]);
  for (std::size_t i = 0; i < states.size(); ++i)
    if (states.data[i] == PixelState::measured && other.data[i] == PixelState::saturated &&
        std::ranges::any_of(
            steps, [&](const GrayImage* step) { return static_cast<double>((*step)[i]) >= near_dn; }))
      states.data[i] = PixelState::saturated;
}

/// The coverage of one camera.
class CameraCoverage {
 public:
  CameraCoverage(const Twin& twin, std::size_t camera, const Side& real, const Side& simulated)
      : twin_(twin),
        name_(twin.cameras[camera].name),
        states_real_(pixel_states(twin, camera, real)),
        states_simulated_(pixel_states(twin, camera, simulated)),
        index_real_(points_of_pixels(twin, camera, real.measurement->cloud)),
        index_simulated_(points_of_pixels(twin, camera, simulated.measurement->cloud)),
        points_real_{real_, real.measurement->cloud, index_real_},
        points_simulated_{simulated_, simulated.measurement->cloud, index_simulated_} {
    if (camera < real.images.size() && camera < simulated.images.size()) {
      const double noise_dn = largest_noise_dn(camera, real, simulated);
      saturate_by_chance(twin, real.images[camera], noise_dn, states_simulated_, states_real_);
      saturate_by_chance(twin, simulated.images[camera], noise_dn, states_real_, states_simulated_);
    }
    real_ = measured(states_real_), simulated_ = measured(states_simulated_);
    const ImageU8 closed_real = closed(real_, kGap_px), closed_simulated = closed(simulated_, kGap_px);
    border_ = dilated(either(edge(closed_real), edge(closed_simulated)), 1);
    const ImageU8 all = either(closed_real, closed_simulated), around = dilated(all, 1);
    outline_ = without(around, all);
    thick_ =
        either(eroded(without(real_, simulated_), kThick_px), eroded(without(simulated_, real_), kThick_px));
    const ImageU8 seen = either(mask_of(states_real_, is_seen), mask_of(states_simulated_, is_seen));
    labels_ = object_labels(twin, points_real_, points_simulated_, either(around, seen));
  }

  std::vector<CoverageRow> rows() const {
    const std::size_t objects = twin_.objects.size();
    std::vector<CoverageRow> all(objects + 2);  // of everything, of each object, of what is near none
    for (CoverageRow& row : all) row.camera = name_;
    for (std::size_t i = 0; i < objects; ++i) all[i + 1].object = twin_.objects[i].name;
    all.back().object = kNotInTheTwin;
    for (std::size_t i = 0; i < real_.size(); ++i) {
      add_pixel(i, all.front());
      if (const int label = labels_.data[i]; label != kUnknownObject)
        add_pixel(i, label == kNoObject ? all.back() : all[static_cast<std::size_t>(label) + 1]);
    }
    std::vector<CoverageRow> out;
    // single poor points lie off every object, the more the larger the image
    const double allowed_off = std::max(kFew, kInteriorShare * static_cast<double>(all.front().n_union()));
    for (CoverageRow& row : all) {
      const bool of_everything = row.object.empty();
      if (!of_everything && row.n_seen < kFewestOfObject) continue;
      if (!is_judged_on_cover(row) && static_cast<double>(row.real_only.interior) <= allowed_off) continue;
      judge(row, allowed_off);
      out.push_back(std::move(row));
    }
    return out;
  }

 private:
  void add_pixel(std::size_t i, CoverageRow& row) const {
    const PixelState r = states_real_.data[i], s = states_simulated_.data[i];
    const bool border = border_.data[i] != 0, thick = thick_.data[i] != 0;
    row.outline_px += outline_.data[i];
    if (!is_seen(r) && !is_seen(s)) return;
    ++row.n_seen;
    if (r == PixelState::measured && s == PixelState::measured)
      ++row.n_both;
    else if (r == PixelState::measured)
      count_one_sided(s, row.real_only, border, thick);
    else if (s == PixelState::measured)
      count_one_sided(r, row.simulated_only, border, thick);
    else if (r == PixelState::saturated || s == PixelState::saturated)
      ++row.n_neither_saturated;
  }

  void judge(CoverageRow& row, double allowed_off) const {
    const bool of_everything = row.object.empty();
    const auto all = static_cast<double>(row.n_union());
    row.allowed_thick = std::max(kFewThick, kThickShare * all);
    row.allowed_interior = std::max(kFew, (of_everything ? kInteriorShare : kInteriorShareOfObject) * all);
    if (!is_judged_on_cover(row)) row.allowed_interior = allowed_off;  // all of it is on one side
    if (of_everything)
      row.allowed_border = std::max(kFew, kBorderPerOutline * static_cast<double>(row.outline_px));
    row.explained = !has_areas(row) && !has_wide_borders(row) && !is_hardly_covered(row);
    if (row.explained) return;
    if (has_areas(row)) find_place(row);
    row.why = reasons_of(row);
  }

  std::string name_of(int label) const {
    if (label == kNoObject) return kNotInTheTwin;
    return label == kUnknownObject ? "" : twin_.objects[label].name;
  }

  /// Fills in where the largest area inside lies that one side alone measures.
  void find_place(CoverageRow& row) const {
    const bool on_real = row.real_only.interior >= row.simulated_only.interior;
    const PixelPoints &side = on_real ? points_real_ : points_simulated_,
                      &other = on_real ? points_simulated_ : points_real_;
    ImageU8 inside = without(without(side.measured, other.measured), border_);
    if (!row.object.empty())
      for (std::size_t i = 0; i < inside.size(); ++i)
        if (inside.data[i] != 0 && row.object != name_of(labels_.data[i])) inside.data[i] = 0;
    const std::vector<std::size_t> area = largest_area(inside);
    if (area.empty()) return;
    const auto width = static_cast<std::size_t>(inside.width);
    std::size_t left = width, right = 0;
    const auto [first, last] = std::minmax_element(area.begin(), area.end());
    const std::size_t top = *first / width, bottom = *last / width;
    Eigen::Vector3d sum_mm = Eigen::Vector3d::Zero();
    double points = 0.0;
    std::map<int, std::size_t> of_label;
    for (const std::size_t i : area) {
      left = std::min(left, i % width), right = std::max(right, i % width);
      ++of_label[labels_.data[i]];
      if (const int point = side.index.data[i]; point >= 0)
        sum_mm += side.cloud.p_world_mm[point], points += 1.0;
    }
    row.place_box_px = {static_cast<double>(left), static_cast<double>(top), static_cast<double>(right),
                        static_cast<double>(bottom)};
    if (points > 0.0) row.place_mm = {sum_mm.x() / points, sum_mm.y() / points, sum_mm.z() / points};
    const auto most =
        std::ranges::max_element(of_label, [](const auto& a, const auto& b) { return a.second < b.second; });
    row.place_object = name_of(most->first);
  }

  const Twin& twin_;
  std::string name_;
  Image<PixelState> states_real_, states_simulated_;
  ImageU8 real_, simulated_;  ///< 1 where the side measured the pixel
  Image<int> index_real_, index_simulated_;
  PixelPoints points_real_, points_simulated_;
  ImageU8 border_, outline_, thick_;
  Image<int> labels_;
};

}  // namespace

Image<PixelState> pixel_states(const Twin& twin, std::size_t camera, const Side& side) {
  const measure::CameraDecode& decode = side.measurement->cameras.at(camera);
  const bool radiance = camera < side.images.size() && side.images[camera].radiance;
  const double dark_dn = radiance ? 0.0 : dark_below_dn(twin, twin.cameras[camera]);
  Image<PixelState> out(decode.width(), decode.height(), PixelState::measured);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const unsigned char flags = decode.flags.data[i];
    if (flags == measure::kValid) continue;
    bool lit = false;
    for (const measure::DirectionDecode& d : decode.directions)
      lit = lit || (i < d.mean_dn.size() && static_cast<double>(d.mean_dn.data[i]) > dark_dn);
    out.data[i] = (flags & measure::kSaturated) != 0       ? PixelState::saturated
                  : !lit                                   ? PixelState::dark
                  : (flags & measure::kLowModulation) != 0 ? PixelState::low_modulation
                                                           : PixelState::order;
  }
  return out;
}

std::vector<CoverageRow> coverage_rows(const Twin& twin, const Side& real, const Side& simulated) {
  std::vector<CoverageRow> out;
  if (!real.measurement || !simulated.measurement) return out;
  FT_CHECK(real.measurement->cameras.size() == simulated.measurement->cameras.size(),
           "both sides measure the same cameras");
  std::vector<std::vector<CoverageRow>> of_camera(real.measurement->cameras.size());
  for_each_parallel(static_cast<int>(of_camera.size()),
                    [&](int c) { of_camera[c] = CameraCoverage(twin, c, real, simulated).rows(); });
  for (std::vector<CoverageRow>& rows : of_camera) std::ranges::move(rows, std::back_inserter(out));
  return out;
}

std::vector<ExplainedRow> explain_coverage(const Twin& twin, const std::vector<CoverageRow>& rows) {
  std::vector<ExplainedRow> out;
  for (const CoverageRow& row : rows) {
    if (row.object.empty()) {
      ExplainedRow& verdict = out.emplace_back();
      verdict.quantity = "coverage";
      verdict.region = row.camera;
      verdict.unit = "px";
      verdict.n = row.n_union();
      verdict.state = kExplained;
    }
    if (!row.explained)
      out.back().worsen(kNotExplained,
                        row.object.empty() ? row.why : fmt::format("of \"{}\" {}", row.object, row.why));
  }
  const auto any = [&](auto is_one) { return std::ranges::any_of(rows, is_one); };
  if (!any([](const CoverageRow& row) { return !row.object.empty(); })) return out;  // no points, no objects
  for (const FitRequest& fit : twin.measure.fits)
    if (!any([&](const CoverageRow& row) { return row.object == fit.object && row.n_union() > 0; }))
      out.push_back(
          not_compared("coverage", fit.object,
                       "no camera measured more than a few pixels of it: it is too dark, saturated, "
                       "hidden or out of view"));
  return out;
}

std::vector<std::string> coverage_warnings(const std::vector<CoverageRow>& rows,
                                           const std::vector<OtherSurfaceRow>& told) {
  std::vector<std::string> out;
  const CoverageRow* camera = nullptr;
  bool camera_tells_areas = false;
  for (const CoverageRow& row : rows) {
    const bool is_told = is_told_by_surfaces(row, told);
    if (row.object.empty()) camera = &row, camera_tells_areas = has_areas(row) && !is_told;
    if (row.explained || is_told) continue;
    const bool is_new =
        row.object.empty() || (has_areas(row) ? !camera_tells_areas : !is_hardly_covered(*camera));
    if (!is_new) continue;
    const std::string of = row.object.empty() ? "" : ", \"" + row.object + "\"";
    out.push_back(fmt::format("coverage of {}{}: {}", row.camera, of, row.why));
  }
  return out;
}

}  // namespace fringetwin::compare
