// SPDX-License-Identifier: Apache-2.0
// Describes the numbers of fits, of one side and simulated - real, as fields: key, unit, meaning and limit of
// each.
#include "compare/result/fields.hpp"

namespace fringetwin::compare {
namespace {

std::vector<Field> make_fit_fields() {
  using Worst = Limit::Worst;
  std::vector<Field> all;
  // found by its key alone: measure::ObjectFit and FitRow hold their numbers in maps instead of members
  const auto add = [&all](const char* key, const char* meaning, Kind kind) -> Field& {
    Field& f = all.emplace_back();
    f.key = key, f.unit = unit_of_key(key), f.meaning = meaning, f.kind = kind;
    return f;
  };
  const auto positive = [&add](const char* key, const char* meaning) -> Field& {
    return add(key, meaning, Kind::positive);
  };
  const auto vector = [&add](const char* key, const char* meaning) -> Field& {
    return add(key, meaning, Kind::vector);
  };
  vector("center_mm", "centre of a sphere in the world")
      .limited({"center_mm", "largest |component| of a sphere centre's difference, mm",
                Worst::largest_difference});
  vector("center_sigma_mm", "its standard errors").error();
  positive("radius_mm", "radius of a sphere or cylinder")
      .limited({"radius_mm", "largest |difference| of a radius, mm", Worst::largest_difference});
  positive("radius_sigma_mm", "its standard error").error();
  vector("point_mm", "point of a plane (its centroid) or of a cylinder's axis");
  vector("normal", "unit normal of a plane");
  vector("axis", "unit direction of a cylinder's axis");
  positive("offset_sigma_mm", "standard error of a plane's place along its normal").error();
  positive("tilt_sigma_rad_0", "standard error of a plane's first tilt").in("rad").error();
  positive("tilt_sigma_rad_1", "standard error of a plane's second tilt").in("rad").error();
  positive("axis_sigma_rad_0", "standard error of an axis's first tilt").in("rad").error();
  positive("axis_sigma_rad_1", "standard error of an axis's second tilt").in("rad").error();
  positive("axis_shift_sigma_mm_0", "standard error of an axis's place along the first direction")
      .in("mm")
      .error();
  positive("axis_shift_sigma_mm_1", "standard error of an axis's place along the second direction")
      .in("mm")
      .error();
  vector("center_noise_sigma_mm", "standard errors of a centre by noise alone").error();
  vector("center_form_sigma_mm", "what form and outline add to them").error();
  struct SigmaKey {
    const char *key, *what;
  };
  for (const SigmaKey& p :
       {SigmaKey{"radius_noise_sigma_mm", "standard error of a radius by noise alone"},
        SigmaKey{"radius_form_sigma_mm", "what form and outline add to it"},
        SigmaKey{"offset_noise_sigma_mm", "standard error of a plane's place by noise alone"},
        SigmaKey{"offset_form_sigma_mm", "what form and outline add to it"},
        SigmaKey{"tilt_noise_sigma_rad_0", "standard error of a plane's first tilt by noise alone"},
        SigmaKey{"tilt_form_sigma_rad_0", "what form and outline add to it"},
        SigmaKey{"tilt_noise_sigma_rad_1", "standard error of a plane's second tilt by noise alone"},
        SigmaKey{"tilt_form_sigma_rad_1", "what form and outline add to it"},
        SigmaKey{"axis_noise_sigma_rad_0", "standard error of an axis's first tilt by noise alone"},
        SigmaKey{"axis_form_sigma_rad_0", "what form and outline add to it"},
        SigmaKey{"axis_noise_sigma_rad_1", "standard error of an axis's second tilt by noise alone"},
        SigmaKey{"axis_form_sigma_rad_1", "what form and outline add to it"},
        SigmaKey{"axis_shift_noise_sigma_mm_0",
                 "standard error of an axis's place along the first direction by noise alone"},
        SigmaKey{"axis_shift_form_sigma_mm_0", "what form and outline add to it"},
        SigmaKey{"axis_shift_noise_sigma_mm_1",
                 "standard error of an axis's place along the second direction by noise alone"},
        SigmaKey{"axis_shift_form_sigma_mm_1", "what form and outline add to it"}})
    positive(p.key, p.what).in(std::string(p.key).find("_rad") != std::string::npos ? "rad" : "mm").error();
  vector("tilt_direction_0", "direction across a normal or axis along which its first tilt is stated");
  vector("tilt_direction_1", "direction across a normal or axis along which its second tilt is stated");
  vector("T_object_measured_r_rad", "turn that carries the measured points onto the CAD surface");
  vector("T_object_measured_r_sigma_rad", "its standard errors").error();
  vector("T_object_measured_t_mm", "shift that carries the measured points onto the CAD surface");
  vector("T_object_measured_t_sigma_mm", "its standard errors").error();
  vector("object_turn_rad", "the same turn in the object's frame");
  vector("object_turn_sigma_rad", "its standard errors").error();
  vector("object_shift_mm", "how far that carries the CAD's middle, in the object's frame");
  vector("object_shift_sigma_mm", "its standard errors").error();
  add("offset_mm", "distance of the simulated plane's point from the real plane", Kind::number);
  struct Across {
    const char *key, *meaning, *unit, *shown;
  };
  for (const Across& a :
       {Across{"tilt_rad_0", "first tilt between the planes of the two sides", "rad", "first tilt"},
        Across{"tilt_rad_1", "second tilt between the planes of the two sides", "rad", "second tilt"},
        Across{"axis_rad_0", "first tilt between the axes of the two sides", "rad", "first tilt"},
        Across{"axis_rad_1", "second tilt between the axes of the two sides", "rad", "second tilt"},
        Across{"axis_shift_mm_0", "distance of the axes along the first direction", "mm", "first shift"},
        Across{"axis_shift_mm_1", "distance of the axes along the second direction", "mm", "second shift"}})
    add(a.key, a.meaning, Kind::number).in(a.unit).shown({a.shown, a.unit});
  positive("angle_rad", "angle between the normals or axes of the two sides");
  positive("axis_distance_mm", "distance of the simulated axis's point from the real axis");
  positive("mean_mm", "mean distance from the CAD surface");
  positive("p95_mm", "95th percentile of the distances from the CAD surface");
  positive("within_10um", "share of the points within 10 µm of the CAD surface");
  positive("rms_mm", "residual of the points used")
      .limited({"rms_mm", "largest residual rms of a simulated fit, outliers left out, mm"})
      .shown({"rms, outliers left out", "mm"});
  positive("rms_all_mm", "residual of all points within the gate")
      .limited({"rms_all_mm", "largest residual rms of a simulated fit over all points within the gate, mm"})
      .shown({"rms, all points within the gate", "mm"});
  add("n_gated", "points within the gate", Kind::count);
  add("n", "points used", Kind::count);
  return all;
}

}  // namespace

const std::vector<Field>& fit_fields() {
  static const std::vector<Field> all = make_fit_fields();
  return all;
}

}  // namespace fringetwin::compare
