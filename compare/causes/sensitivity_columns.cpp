// SPDX-License-Identifier: Apache-2.0
// Derivatives of what is predicted by each parameter: in closed form, from images of other parameters, or
// from renderings of changed twins.
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <utility>

#include "compare/causes/own_levels.hpp"
#include "compare/causes/parameter_effects.hpp"
#include "compare/causes/sensitivity.hpp"
#include "compare/parameters/closed_columns.hpp"
#include "compare/parameters/parameters.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kWantedChange = 3e-3;     ///< of the images' size: 0.15 % of the derivative is curvature
constexpr double kExactChange = 2e-2;      ///< central: 0.01 %
constexpr double kMostCurvature = 0.03;    ///< of a central difference: 0.06 % of it is a third derivative
constexpr double kWantedCurvature = 0.02;  ///< of a shorter step
constexpr double kShortestChange = 3e-5;   ///< of the images' size: 0.3 % of a derivative is rounding
constexpr double kLonger = kExactChange / kWantedChange;  ///< than a quick derivative's step
constexpr int kMostAttempts = 4;
constexpr double kNoChange = 1e-7;  ///< of the images' size: rounding

Sensitivity::Values zeros(const Sensitivity::Values& like) {
  Sensitivity::Values out;
  for (const std::vector<float>& values : like) out.emplace_back(values.size(), 0.0F);
  return out;
}

/// Returns the root of the sum of squares of the first number that `numbers(camera's place, value)` gives
/// over that of the second, of all values that count of one camera, or of all; 0 where there is nothing to
/// divide by.
double root_of_ratio(const std::vector<GridSamples>& samples, std::optional<std::size_t> camera,
                     auto numbers) {
  double over = 0.0, under = 0.0;
  for (std::size_t c = 0; c < samples.size(); ++c) {
    if (camera && *camera != samples[c].camera) continue;
    for (std::size_t i = 0; i < samples[c].weight.size(); ++i) {
      if (samples[c].weight[i] == 0.0F) continue;
      const auto [a, b] = numbers(c, i);
      over += a * a;
      under += b * b;
    }
  }
  return under > 0.0 ? std::sqrt(over / under) : 0.0;
}

}  // namespace

double Sensitivity::relative_change(const Values& from, const Values& to,
                                    std::optional<std::size_t> camera) const {
  return root_of_ratio(samples_, camera, [&](std::size_t c, std::size_t i) {
    const auto a = static_cast<double>(from[c][i]), b = static_cast<double>(to[c][i]);
    return std::pair(b - a, a);
  });
}

int Sensitivity::derivative_samples(const Twin& twin, const std::vector<Parameter>& parameters) const {
  const bool is_fine = std::ranges::any_of(
      parameters, [](const Parameter& p) { return p.group == "harmonics_high" || p.group == "raster"; });
  return is_fine || holds_code(twin) ? residual_samples_ : kDerivativeSamples;
}

Sensitivity::Values Sensitivity::closed_column(const Twin& twin, const std::vector<Parameter>& parameters,
                                               const Eigen::VectorXd& values, std::size_t at,
                                               const Values& base) const {
  const Parameter& parameter = parameters[at];
  const bool bends = std::ranges::any_of(parameters, &Parameter::is_of_sensor);
  // harmonics are linear: of a long step less is rounded away
  const double step = parameter.harmonic > 0 && !bends ? 1.0 : parameter.step;
  const double up = std::min(values[at] + step, parameter.largest),
               down = std::max(values[at] - step, parameter.smallest);
  const Twin fitted = with_values(twin, parameters, values);
  const ParameterEffects sensors{twin, fitted, parameters, values};
  Values out = zeros(base);
  for (std::size_t c = 0; c < samples_.size(); ++c) {
    const GridSamples& s = samples_[c];
    if (parameter.camera && *parameter.camera != s.camera) continue;
    const bool bends_light = !parameter.is_of_sensor && sensors.bend(s);
    const OwnLevels own = parameter.is_of_sensor || bends_light
                              ? OwnLevels(s, base[c], light_for_own(s), own_, exposures_of(c))
                              : OwnLevels();
    std::vector<float> before = base[c];
    own.to_levels(before);
    if (bends_light) {
      sensors.unsee(s, before);
      own.to_irradiance(before);
    }
    std::vector<float> more = before, less = before;
    parameter.effect({fitted, fitted, s, before, values[at], up}, more);
    parameter.effect({fitted, fitted, s, before, values[at], down}, less);
    for (std::vector<float>* seen : {&more, &less}) {
      if (bends_light) {
        own.to_levels(*seen);
        sensors.see(s, *seen);
      }
      own.to_irradiance(*seen);
    }
    for (std::size_t i = 0; i < more.size(); ++i)
      out[c][i] =
          static_cast<float>((static_cast<double>(more[i]) - static_cast<double>(less[i])) / (up - down));
  }
  return out;
}

double Sensitivity::curvature(const Values& less, const Values& base, const Values& more,
                              std::optional<std::size_t> camera) const {
  return root_of_ratio(samples_, camera, [&](std::size_t c, std::size_t i) {
    const auto a = static_cast<double>(less[c][i]), b = static_cast<double>(more[c][i]);
    return std::pair(a + b - 2.0 * static_cast<double>(base[c][i]), b - a);
  });
}

/// A width may have to change by as much as itself to change the images by what is wanted of it. At edges
/// that move over the points of a pixel, on the other hand, no step is short enough: there the bend does not
/// fall with the step.
Sensitivity::Difference Sensitivity::central_difference(const std::function<Values(double)>& images_at,
                                                        double value, std::optional<std::size_t> camera,
                                                        const Values& base, Difference found,
                                                        DerivativeStep& step) const {
  found.from = images_at(value - found.step);
  const double bend = curvature(found.from, base, found.to, camera),
               shorter = std::max(kWantedCurvature / bend,
                                  kShortestChange / relative_change(base, found.to, camera));
  if (bend > kMostCurvature && shorter < 1.0 && !step.is_refused) {
    Difference nearer{images_at(value - shorter * found.step), images_at(value + shorter * found.step),
                      shorter * found.step};
    step.is_refused = !(curvature(nearer.from, base, nearer.to, camera) < std::sqrt(shorter) * bend);
    if (!step.is_refused) {
      found = std::move(nearer);
      step.length = found.step / kLonger;
      step.longest = std::abs(step.length);
    }
  }
  found.step *= 2.0;
  return found;
}

Sensitivity::Values Sensitivity::column(const Twin& twin, const std::vector<Parameter>& parameters,
                                        const Eigen::VectorXd& values, std::size_t at, const Values& base,
                                        Derivative derivative, DerivativeStep& step) const {
  const Parameter& parameter = parameters[at];
  if (tells_derivative(parameter)) return closed_column(twin, parameters, values, at, base);
  const auto images_at = [&](double value) {
    Eigen::VectorXd changed = values;
    changed[at] = value;
    return predicted(twin, parameters, changed, derivative_samples(twin, parameters), parameter.camera,
                     &base);
  };
  try {
    std::optional<Difference> found =
        one_sided(images_at, parameter, values[at], base, derivative == Derivative::exact, step);
    if (!found) return zeros(base);
    if (derivative == Derivative::exact && !parameter.is_switch) {
      // halfway to a bound, for at some bounds nothing can be rendered
      const double room = std::min(values[at] - parameter.smallest, parameter.largest - values[at]) / 2.0,
                   length = std::abs(found->step);
      if (length > room &&
          !(room * relative_change(base, found->to, parameter.camera) > kShortestChange * length))
        return column(twin, parameters, values, at, base, Derivative::quick, step);  // one side only
      if (length > room) *found = {{}, images_at(values[at] + room), room};
      *found = central_difference(images_at, values[at], parameter.camera, base, std::move(*found), step);
    }
    const Values& from = found->from.empty() ? base : found->from;
    Values& out = found->to;
    for (std::size_t c = 0; c < out.size(); ++c)
      for (std::size_t i = 0; i < out[c].size(); ++i)
        out[c][i] = static_cast<float>((static_cast<double>(out[c][i]) - static_cast<double>(from[c][i])) /
                                       found->step);
    return std::move(out);
  } catch (const UserError&) {
    return zeros(base);  // no lens can be made of it: the images say nothing about this parameter
  }
}

/// Looks for a step that changes the images as much as is wanted of the derivative.
std::optional<Sensitivity::Difference> Sensitivity::one_sided(const std::function<Values(double)>& images_at,
                                                              const Parameter& parameter, double value,
                                                              const Values& base, bool is_exact,
                                                              DerivativeStep& found) const {
  if (parameter.is_switch) {
    const double step = value > 0.5 ? -1.0 : 1.0;
    return Difference{{}, images_at(value + step), step};
  }
  const double wanted = is_exact ? kExactChange : kWantedChange, longer = is_exact ? kLonger : 1.0,
               most = DerivativeStep::of(parameter).longest;
  double longest = std::min(longer * found.longest, most), step = longer * found.length;
  const auto inside = [&](double v) { return v >= parameter.smallest && v <= parameter.largest; };
  bool is_all_room = false;
  Difference out;
  for (int attempt = 0;; ++attempt) {
    if (!inside(value + step)) step = -step;
    if (!inside(value + step)) {  // as far as there is room, but for the bound itself
      const double up = parameter.largest - value, down = value - parameter.smallest;
      step = (up >= down ? up : -down) / 2.0;
      if (!(std::max(up, down) > 0.0)) return std::nullopt;
      is_all_room = true;
    }
    out = {{}, images_at(value + step), step};
    const double change = relative_change(base, out.to, parameter.camera);
    if (change > wanted / 5.0 && change < wanted * 5.0) break;
    if (change < kShortestChange && longest < most) longest = found.longest = most;  // it bent somewhere else
    const bool cannot_grow = std::abs(step) >= longest || is_all_room;
    if (attempt == kMostAttempts || (change < wanted && cannot_grow)) {
      if (change < kNoChange) return std::nullopt;
      break;  // the images belong to this step, whatever its size
    }
    const double grown = step * std::clamp(wanted / std::max(change, 1e-12), 1e-3, 1e3);
    step = std::copysign(std::min(std::abs(grown), longest), step);
  }
  found.length = step / longer;
  return out;
}

bool Sensitivity::knows_places() const {
  return std::ranges::none_of(samples_, [](const GridSamples& s) { return s.projector_px.empty(); });
}

Sensitivity::Values Sensitivity::scaled_column(const Values& other, const Parameter& parameter) const {
  Values out = other;
  for (std::size_t c = 0; c < out.size(); ++c)
    for (std::size_t p = 0; p < samples_[c].n_pixels(); ++p) {
      const auto times = static_cast<float>(
          parameter.times ? parameter.times(samples_[c].projector_px[p].cast<double>()) : 1.0);
      const std::size_t n = samples_[c].images.size();
      for (std::size_t k = 0; k < n; ++k)
        out[c][p * n + k] *=
            parameter.only_image && *parameter.only_image != samples_[c].images[k] ? 0.0F : times;
    }
  return out;
}

void Sensitivity::find_unit_sums(const Twin& fitted, const std::vector<Parameter>& parameters) {
  const int points = derivative_samples(fitted, parameters);
  if (std::ranges::find(parameters, "raster", &Parameter::group) != parameters.end())
    find_waves(renderer_, fitted, points, samples_);
  int highest = 0;
  for (const Parameter& p : parameters)
    highest = std::max({highest, p.harmonic, p.does_as ? p.does_as->harmonic : 0});
  const bool are_late_or_move = std::ranges::any_of(
      parameters, [](const Parameter& p) { return p.group == "timing" || p.group == "motion"; });
  if (highest > 0 && harmonics_are_fringes(fitted) && !are_late_or_move)
    find_harmonics(renderer_, fitted, highest, points, samples_);
  else
    for (GridSamples& s : samples_) s.harmonics = nullptr, s.highest_harmonic = 1;
}

bool Sensitivity::tells_derivative(const Parameter& p) const {
  return p.effect && std::ranges::all_of(samples_, [&](const GridSamples& s) {
           return p.harmonic == 0 || p.harmonic <= s.highest_harmonic;
         });
}

/// Where exposures reach into other patterns an image changes with its neighbours, too. Seen through a curve,
/// a factor that is free in every pixel takes what is common to all images, and leaves the curve where it
/// was.
bool Sensitivity::renders_images_together(const Twin& fitted,
                                          const std::vector<Parameter>& parameters) const {
  return fitted.projector && fringes_have_overtones(fitted) && !sees_other_patterns(fitted) &&
         std::ranges::none_of(parameters, [this](const Parameter& p) {
           return p.group == "timing" || (p.is_of_sensor && own_ != FreePerPixel::nothing);
         });
}

const Sensitivity::Values& Sensitivity::column_beside(const Parameter& other, const Twin& twin,
                                                      const std::vector<Parameter>& parameters,
                                                      const Eigen::VectorXd& values, const Values& base,
                                                      Derivative derivative,
                                                      std::map<std::string, Values>& known) const {
  const auto [it, is_new] = known.try_emplace(other.name);
  if (!is_new) return it->second;
  std::vector<Parameter> with = parameters;
  with.push_back(other);
  Eigen::VectorXd at(values.size() + 1);
  at << values, other.start;
  DerivativeStep step = DerivativeStep::of(other);
  return it->second = column(twin, with, at, parameters.size(), base, derivative, step);
}

Sensitivity::Columns Sensitivity::columns(const Twin& twin, const std::vector<Parameter>& parameters,
                                          const Eigen::VectorXd& values, Derivative derivative,
                                          std::vector<DerivativeStep> steps) {
  const Twin fitted = with_values(twin, parameters, values);
  find_unit_sums(fitted, parameters);
  for (std::size_t k = steps.size(); k < parameters.size(); ++k)
    steps.push_back(DerivativeStep::of(parameters[k]));
  Columns out{
      predicted(twin, parameters, values, derivative_samples(twin, parameters)), {}, std::move(steps)};
  std::map<std::string, Values> of_others;  // that are no parameters, or come later
  const auto column_of = [&](const Parameter& other) -> const Values& {
    const auto found = std::ranges::find(parameters, other.name, &Parameter::name) - parameters.begin();
    if (found < std::ssize(out.each)) return out.each[static_cast<std::size_t>(found)];
    return column_beside(other, twin, parameters, values, out.rough, derivative, of_others);
  };
  const bool are_rendered = renders_images_together(fitted, parameters);
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const Parameter& p = parameters[k];
    const bool is_closed = tells_derivative(p) && !(p.effect_of_sinusoids && are_rendered);
    out.each.push_back(p.does_as && !is_closed && (knows_places() || !p.times)
                           ? scaled_column(column_of(*p.does_as), p)
                           : column(twin, parameters, values, k, out.rough, derivative, out.steps[k]));
  }
  for (const Parameter& p : parameters) out.exposes.push_back(p.group == "exposure");
  return out;
}

void Sensitivity::take_pose_slopes(const Columns& columns, const std::vector<std::size_t>& pose) {
  for (std::size_t c = 0; c < samples_.size(); ++c) {
    std::vector<std::vector<float>> slopes;
    for (const std::size_t at : pose) slopes.push_back(columns.each[at][c]);
    samples_[c].pose_slopes = std::make_shared<const std::vector<std::vector<float>>>(std::move(slopes));
  }
}

Sensitivity::Columns Sensitivity::columns_of_all_groups(const Twin& twin,
                                                        const std::vector<Parameter>& parameters,
                                                        const Eigen::VectorXd& values,
                                                        const std::vector<std::size_t>& pose,
                                                        const std::function<void(std::size_t)>& after) {
  const Twin fitted = with_values(twin, parameters, values);
  find_unit_sums(fitted, parameters);
  Columns out{predicted(twin, parameters, values, derivative_samples(twin, parameters)), {}, {}};
  for (const Parameter& p : parameters) out.steps.push_back(DerivativeStep::of(p));
  out.each.resize(parameters.size());
  std::size_t done = 0;
  std::map<std::string, Values> of_all_images;
  const bool are_rendered = renders_images_together(fitted, parameters);
  const auto fill = [&](bool closed) {
    for (std::size_t k = 0; k < parameters.size(); ++k) {
      const Parameter& p = parameters[k];
      if (tells_derivative(p) != closed) continue;
      out.each[k] = p.effect_of_sinusoids && p.does_as && are_rendered
                        ? scaled_column(column_beside(*p.does_as, twin, parameters, values, out.rough,
                                                      Derivative::quick, of_all_images),
                                        p)
                        : column(twin, parameters, values, k, out.rough, Derivative::quick, out.steps[k]);
      after(++done);
    }
  };
  fill(false);
  take_pose_slopes(out, pose);
  fill(true);
  return out;
}

}  // namespace fringetwin::compare
