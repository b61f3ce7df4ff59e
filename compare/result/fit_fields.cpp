// SPDX-License-Identifier: Apache-2.0
// Describes the numbers of fits (of one side, and simulated - real), of decodes and of triangulation as
// fields: key, unit, meaning and limit of each.
#include "compare/result/fields.hpp"
#include "compare/result/rows.hpp"

namespace fringetwin::compare {
namespace {

/// Adds a field that is found by its key alone, because measure::ObjectFit and FitRow hold their numbers in
/// maps instead of members.
Field& add(std::vector<Field>& all, const std::string& key, const std::string& unit,
           const std::string& meaning, Kind kind) {
  Field f;
  f.key = key, f.unit = unit, f.meaning = meaning, f.kind = kind;
  return all.emplace_back(std::move(f));
}

std::vector<Field> make_fit_fields() {
  using Worst = Limit::Worst;
  std::vector<Field> all;
  const auto number = [&all](const char* key, const char* unit, const char* meaning) -> Field& {
    return add(all, key, unit, meaning, Kind::number);
  };
  const auto positive = [&all](const char* key, const char* unit, const char* meaning) -> Field& {
    return add(all, key, unit, meaning, Kind::positive);
  };
  const auto vector = [&all](const char* key, const char* unit, const char* meaning) -> Field& {
    return add(all, key, unit, meaning, Kind::vector);
  };
  vector("center_mm", "mm", "centre of a sphere in the world")
      .limited({"center_mm", "largest |component| of a sphere centre's difference, mm",
                Worst::largest_difference});
  vector("center_sigma_mm", "mm", "its standard errors").error();
  positive("radius_mm", "mm", "radius of a sphere or cylinder")
      .limited({"radius_mm", "largest |difference| of a radius, mm", Worst::largest_difference});
  positive("radius_sigma_mm", "mm", "its standard error").error();
  vector("point_mm", "mm", "point of a plane (its centroid) or of a cylinder's axis");
  vector("normal", "", "unit normal of a plane");
  vector("axis", "", "unit direction of a cylinder's axis");
  positive("offset_sigma_mm", "mm", "standard error of a plane's place along its normal").error();
  positive("tilt_sigma_rad_0", "rad", "standard error of a plane's first tilt").error();
  positive("tilt_sigma_rad_1", "rad", "standard error of a plane's second tilt").error();
  positive("axis_sigma_rad_0", "rad", "standard error of an axis's first tilt").error();
  positive("axis_sigma_rad_1", "rad", "standard error of an axis's second tilt").error();
  vector("T_object_measured_r_rad", "rad", "turn that carries the measured points onto the CAD surface");
  vector("T_object_measured_t_mm", "mm", "shift that carries the measured points onto the CAD surface");
  number("offset_mm", "mm", "distance of the simulated plane's point from the real plane");
  positive("angle_rad", "rad", "angle between the normals or axes of the two sides");
  positive("axis_distance_mm", "mm", "distance of the simulated axis's point from the real axis");
  positive("mean_mm", "mm", "mean distance from the CAD surface");
  positive("p95_mm", "mm", "95th percentile of the distances from the CAD surface");
  positive("within_10um", "", "share of the points within 10 µm of the CAD surface");
  positive("rms_mm", "mm", "residual of the points used")
      .limited({"rms_mm", "largest residual rms of a simulated fit, outliers left out, mm"})
      .shown({"rms, outliers left out", "mm"});
  positive("rms_all_mm", "mm", "residual of all points within the gate")
      .limited({"rms_all_mm", "largest residual rms of a simulated fit over all points within the gate, mm"})
      .shown({"rms, all points within the gate", "mm"});
  add(all, "n_gated", "", "points within the gate", Kind::count);
  add(all, "n", "", "points used", Kind::count);
  return all;
}

}  // namespace

std::vector<Field> describe(const DecodeRow*) {
  using Row = DecodeRow;
  Fields<Row> f;
  f.add("camera", "", "camera of the twin", &Row::camera).named();
  f.add("direction", "", "direction of the fringes", &Row::direction).named().one_of({"x", "y"});
  f.add("n_valid", "", "pixels with a coordinate", &Row::n_valid);
  f.add("orders_checked", "", "pixels whose fringe order was held against their neighbours",
        &Row::orders_checked)
      .not_required();
  f.add("orders_changed", "", "of these, moved by a whole period", &Row::orders_changed).not_required();
  f.add("orders_left", "", "jumps that remain between neighbours", &Row::orders_left).not_required();
  return f.take();
}

std::vector<Field> describe(const measure::TriangulationSummary*) {
  using Row = measure::TriangulationSummary;
  Fields<Row> f;
  f.add("n_candidates", "", "valid pixels of the first camera that were tried", &Row::n_candidates);
  f.add("n_points", "", "points found", &Row::n_points);
  f.add("n_no_match", "", "pixels without that coordinate in the second image", &Row::n_no_match);
  f.add("n_ambiguous", "", "pixels with several matches", &Row::n_ambiguous);
  f.add("n_rejected", "", "pixels whose point was refused", &Row::n_rejected);
  f.add("n_mixed", "", "border pixels that were not tried", &Row::n_mixed);
  for (Field& field : f.all()) field.not_required();
  return f.take();
}

const std::vector<Field>& fit_fields() {
  static const std::vector<Field> all = make_fit_fields();
  return all;
}

}  // namespace fringetwin::compare
