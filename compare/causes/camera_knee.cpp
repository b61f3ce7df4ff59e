// SPDX-License-Identifier: Apache-2.0
#include "compare/causes/camera_knee.hpp"

namespace fringetwin::compare {
namespace {

/// Of the range above black. A fit from here finds knees from 15 to 75 % of it, and a dim capture reaches it.
constexpr double kFirstPlace = 0.4;
constexpr double kLowestPlace = 0.02, kPlaceStep = 0.005;
constexpr double kSlopeStep = 1e-3;  ///< ten of these, and derivatives by the place are taken anew
constexpr double kLeastSlope = 0.05, kMostSlope = 20.0;

/// The knee of a response: where it is, and the slope beyond.
struct Knee {
  double at_dn = 0.0, slope = 1.0;
  CameraResponse curve() const { return knee_response(at_dn, slope); }
};

/// Returns the knee that a camera has; one that bends nothing, at this place, where it is straight.
Knee knee_of(const CameraResponse& response, double else_at_dn) {
  if (response.straight()) return {else_at_dn, 1.0};
  return {response.corners.front().in_dn, response.last_slope};
}

/// Light goes through one knee instead of another, as a camera with the response `as_given` is straightened.
void bend(const CameraResponse& as_given, const Knee& from, const Knee& to, double gain_dn,
          std::vector<float>& irradiance) {
  const CameraResponse before = from.curve(), after = to.curve();
#pragma omp parallel for schedule(static)
  for (std::size_t i = 0; i < irradiance.size(); ++i) {
    const double light_dn = before.inverse(as_given(gain_dn * static_cast<double>(irradiance[i])));
    irradiance[i] = static_cast<float>(as_given.inverse(after(light_dn)) / gain_dn);
  }
}

}  // namespace

std::vector<Parameter> knee_parameters(const Twin& twin, std::size_t camera) {
  const Sensor& sensor = twin.cameras[camera].sensor;
  if (sensor.response.corners.size() > 1) return {};
  const double range_dn = sensor.max_dn() - sensor.black_level_dn, first_dn = kFirstPlace * range_dn;
  const Knee start = knee_of(sensor.response, first_dn);
  const auto knee_in = [=](const Twin& t) { return knee_of(t.cameras[camera].sensor.response, first_dn); };
  const auto set = [=](Twin& t, const Knee& knee) { t.cameras[camera].sensor.response = knee.curve(); };
  const std::string& name = twin.cameras[camera].name;

  Parameter slope{.group = "camera_knee",
                  .name = name + ".response.slope",
                  .unit = "",
                  .start = start.slope,
                  .step = kSlopeStep};
  slope.smallest = kLeastSlope, slope.largest = kMostSlope;
  slope.change = [=](Twin& t, double d) {
    Knee knee = knee_in(t);
    knee.slope += d;
    set(t, knee);
  };
  // before the place moves, in a prediction: `in.twin` has closed parameters at their start
  slope.effect = [=, as_given = sensor.response](const EffectInput& in, std::vector<float>& irradiance) {
    const double at_dn = knee_in(in.twin).at_dn;
    bend(as_given, {at_dn, in.from}, {at_dn, in.to}, in.samples.curve_gain_dn(), irradiance);
  };

  Parameter place{.group = "camera_knee",
                  .name = name + ".response.knee_dn",
                  .unit = "DN",
                  .start = start.at_dn,
                  .step = kPlaceStep * range_dn};
  place.smallest = kLowestPlace * range_dn, place.largest = range_dn;
  place.change = [=](Twin& t, double d) {
    Knee knee = knee_in(t);
    knee.at_dn += d;
    set(t, knee);
  };
  place.effect = [=, as_given = sensor.response](const EffectInput& in, std::vector<float>& irradiance) {
    const double s = knee_in(in.fitted).slope;
    bend(as_given, {in.from, s}, {in.to, s}, in.samples.curve_gain_dn(), irradiance);
  };
  place.acts_beside_others = place.grows_with_gain = true;
  for (Parameter* p : {&slope, &place}) p->is_closed = p->is_of_sensor = true, p->camera = camera;
  return {slope, place};
}

}  // namespace fringetwin::compare
