// SPDX-License-Identifier: Apache-2.0
#include "compare/parameters/camera_curves.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "twin/base/errors.hpp"

namespace fringetwin::compare {
namespace {

using Effect = std::function<void(const EffectInput&, std::vector<float>&)>;

constexpr double kFullSignal = 0.75;    ///< of full scale: the middle of the response's polynomials' range is
constexpr double kLargestSignal = 1.2;  ///< half of it; they stay as they are beyond this many times
constexpr double kSmallestSignal = 1e-6;  ///< of full scale: below, a power is not taken
/// Of the range above black. A fit from here finds knees from 15 to 75 % of it, and a dim capture reaches it.
constexpr double kFirstPlace = 0.4;
constexpr double kLowestPlace = 0.02, kPlaceStep = 0.005;
constexpr double kSlopeStep = 1e-3;  ///< ten of these, and derivatives by the place are taken anew
constexpr double kLeastSlope = 0.05, kMostSlope = 20.0;

/// The signal r, as a part of the sensor's range above black, becomes r^value.
Effect response_gamma_effect(double range_dn) {
  return [=](const EffectInput& in, std::vector<float>& irradiance) {
    const double unit = range_dn / in.samples.curve_gain_dn();
    for (float& value : irradiance) {
      const double r = std::max(static_cast<double>(value) / unit, kSmallestSignal);
      value = static_cast<float>(unit * std::pow(r, in.to / in.from));
    }
  };
}

/// The signal r grows by value r^2 (order 2) or by value T_order(2 r/0.75 - 1), Chebyshev's polynomial.
Effect response_term_effect(double range_dn, int order) {
  return [=](const EffectInput& in, std::vector<float>& irradiance) {
    const double unit = range_dn / in.samples.curve_gain_dn();
    for (float& value : irradiance) {
      const double r = std::max(static_cast<double>(value) / unit, 0.0);
      const double z = 2.0 * std::min(r / kFullSignal, kLargestSignal) - 1.0;
      const double term = order == 2   ? r * r
                          : order == 3 ? z * (4.0 * z * z - 3.0)
                                       : 8.0 * z * z * (z * z - 1.0) + 1.0;
      value = static_cast<float>(static_cast<double>(value) + (in.to - in.from) * unit * term);
    }
  };
}

/// Returns a parameter that bends gray values.
Parameter curve(const std::string& group, const std::string& name, double start, double step, Effect effect) {
  Parameter p{.group = group, .name = name, .unit = "", .start = start, .step = step};
  p.effect = std::move(effect);
  p.is_of_sensor = true;
  return p;
}

double range_of(const Sensor& sensor) { return sensor.max_dn() - sensor.black_level_dn; }

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

constexpr double kBendsFrom = 0.05;  ///< of the range: straight below, so that the gain is the slope there
/// Of a bend's table, over what the camera gives: within R/4,000 of a curve of 0.05, whose second derivative
/// is 2.5 at most.
constexpr int kTablePoints = 40;
constexpr double kMostBend = 0.5;
constexpr int kMostNewtonSteps = 20;

/// A smooth bend of gray values above black: x + R c s^2 T_k(2 s - 1), straight up to R/20 and beyond R.
struct Bend {
  double range_dn;
  int order;  ///< k: 0, 1 or 2

  struct Point {
    double value, slope;
  };
  Point at(double x_dn, double c) const {
    const double r = x_dn / range_dn, s = std::clamp((r - kBendsFrom) / (1.0 - kBendsFrom), 0.0, 1.0),
                 z = 2.0 * s - 1.0;
    const double t = order == 0   ? 1.0
                     : order == 1 ? z
                                  : 2.0 * z * z - 1.0,
                 dt = order == 0   ? 0.0
                      : order == 1 ? 2.0
                                   : 8.0 * z;
    const double slope = c * (2.0 * s * t + s * s * dt) / (1.0 - kBendsFrom);
    const double beyond_dn = std::max(0.0, x_dn - range_dn);
    return {x_dn + range_dn * c * s * s * t + slope * beyond_dn, 1.0 + slope};
  }
  double operator()(double x_dn, double c) const { return at(x_dn, c).value; }
  /// Returns what is bent to y.
  double inverse(double y_dn, double c) const {
    double x_dn = y_dn;
    for (int step = 0; step < kMostNewtonSteps; ++step) {
      const Point p = at(x_dn, c);
      const double change_dn = (y_dn - p.value) / std::max(p.slope, kLeastSlope);
      x_dn += change_dn;
      if (std::abs(change_dn) < 1e-9 * range_dn) break;
    }
    return x_dn;
  }
};

/// Puts corners on a curve where the response `as_given` gives equal distances, as far as bends need it to
/// give the whole range; it stays the same curve. Again, it adds none.
void add_corners(CameraResponse& f, const CameraResponse& as_given, double range_dn) {
  std::vector<CameraResponse::Corner> all = f.corners;
  for (int k = 1; k <= static_cast<int>((1.0 + kMostBend) * kTablePoints); ++k) {
    const double in_dn = as_given.inverse(k * range_dn / kTablePoints);
    if (std::ranges::none_of(f.corners, [&](const CameraResponse::Corner& c) {
          return std::abs(c.in_dn - in_dn) < 1e-6 * range_dn;
        }))
      all.push_back({in_dn, f(in_dn)});
  }
  std::ranges::sort(all, {}, &CameraResponse::Corner::in_dn);
  f.corners = std::move(all);
}

/// Bends what a camera gives, which gave `as_given` before all bends. Throws UserError(usage) where the curve
/// would not rise.
void bend_response(CameraResponse& f, const CameraResponse& as_given, const Bend& bend, double c) {
  if (c == 0.0) return;
  add_corners(f, as_given, bend.range_dn);
  for (CameraResponse::Corner& corner : f.corners) corner.out_dn = bend(corner.out_dn, c);
  for (std::size_t k = 1; k < f.corners.size(); ++k)
    if (!(f.corners[k].out_dn > f.corners[k - 1].out_dn))
      throw UserError(ExitCode::usage, "response", "the camera's curve would not rise everywhere",
                      "refine without camera_response");
  const CameraResponse::Corner &last = f.corners.back(), &before = f.corners[f.corners.size() - 2];
  f.last_slope = (last.out_dn - before.out_dn) / (last.in_dn - before.in_dn);
}

/// The light goes through the bend of `to` instead of that of `from`; the gray values are straightened by the
/// response `as_given`.
Effect bend_effect(const CameraResponse& as_given, const Bend& bend) {
  return [=](const EffectInput& in, std::vector<float>& irradiance) {
    const double gain_dn = in.samples.curve_gain_dn();
#pragma omp parallel for schedule(static)
    for (std::size_t i = 0; i < irradiance.size(); ++i) {
      const double seen_dn = as_given(gain_dn * static_cast<double>(irradiance[i])),
                   bent_dn = bend(bend.inverse(seen_dn, in.from), in.to);
      irradiance[i] = static_cast<float>(as_given.inverse(bent_dn) / gain_dn);
    }
  };
}

}  // namespace

std::vector<Parameter> bend_parameters(const Twin& twin, std::size_t camera) {
  const Sensor& sensor = twin.cameras[camera].sensor;
  std::vector<Parameter> all;
  for (int order = 0; order < 3; ++order) {
    const Bend bend{range_of(sensor), order};
    Parameter p =
        curve("camera_response", fmt::format("{}.response.bend_{}", twin.cameras[camera].name, order + 1),
              0.0, 0.01, bend_effect(sensor.response, bend));
    p.change = [=, as_given = sensor.response](Twin& t, double d) {
      bend_response(t.cameras[camera].sensor.response, as_given, bend, d);
    };
    p.is_closed = p.told_at_gain = true;
    p.smallest = -kMostBend, p.largest = kMostBend;
    p.camera = camera;
    all.push_back(std::move(p));
  }
  return all;
}

std::vector<Parameter> response_parameters(const Camera& camera) {
  const double range_dn = range_of(camera.sensor);
  const auto term = [&](const char* name, double start, Effect effect) {
    return curve("camera_response", camera.name + ".response." + name, start, 0.01, std::move(effect));
  };
  Parameter gamma = term("gamma", 1.0, response_gamma_effect(range_dn));
  gamma.smallest = 0.2, gamma.largest = 5.0;
  return {gamma, term("square", 0.0, response_term_effect(range_dn, 2)),
          term("cubic", 0.0, response_term_effect(range_dn, 3)),
          term("quartic", 0.0, response_term_effect(range_dn, 4))};
}

std::vector<Parameter> knee_parameters(const Twin& twin, std::size_t camera) {
  const Sensor& sensor = twin.cameras[camera].sensor;
  if (sensor.response.corners.size() > 1) return {};
  const double range_dn = range_of(sensor), first_dn = kFirstPlace * range_dn;
  const Knee start = knee_of(sensor.response, first_dn);
  const auto knee_in = [=](const Twin& t) { return knee_of(t.cameras[camera].sensor.response, first_dn); };
  const auto term = [&](const char* name, double Knee::*number, double step, Effect effect) {
    Parameter p = curve("camera_knee", twin.cameras[camera].name + ".response." + name, start.*number, step,
                        std::move(effect));
    p.is_closed = true;
    p.change = [=](Twin& t, double d) {
      Knee knee = knee_in(t);
      knee.*number += d;
      t.cameras[camera].sensor.response = knee.curve();
    };
    return p;
  };
  const CameraResponse& as_given = sensor.response;
  // before the place moves, in a prediction: `in.twin` has closed parameters at their start
  Parameter slope =
      term("slope", &Knee::slope, kSlopeStep, [=](const EffectInput& in, std::vector<float>& irradiance) {
        const double at_dn = knee_in(in.twin).at_dn;
        bend(as_given, {at_dn, in.from}, {at_dn, in.to}, in.samples.curve_gain_dn(), irradiance);
      });
  slope.smallest = kLeastSlope, slope.largest = kMostSlope;
  Parameter place = term("knee_dn", &Knee::at_dn, kPlaceStep * range_dn,
                         [=](const EffectInput& in, std::vector<float>& irradiance) {
                           const double s = knee_in(in.fitted).slope;
                           bend(as_given, {in.from, s}, {in.to, s}, in.samples.curve_gain_dn(), irradiance);
                         });
  place.unit = "DN";
  place.smallest = kLowestPlace * range_dn, place.largest = range_dn;
  place.acts_beside_others = place.grows_with_gain = true;
  return {slope, place};
}

}  // namespace fringetwin::compare
