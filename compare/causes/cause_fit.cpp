// SPDX-License-Identifier: Apache-2.0
#include "compare/causes/cause_fit.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "compare/causes/cause_regions.hpp"
#include "compare/causes/group_fit.hpp"
#include "compare/geometry/moved_fits.hpp"
#include "compare/verdict/explained.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::compare {
namespace {

constexpr int kMostSteps = 12;
/// Of the largest |z| of a fit: what the method adds to a fit does not quite move along, so that a right
/// cause of a large difference may leave more than noise.
constexpr double kStillApart = 0.25;
constexpr double kFarthestApart = 3.0;  ///< times the limit, however far they were apart
constexpr double kSettledZ = 0.01;      ///< a step of the values that changes no z by more is the last

void tell(GroupFit& fit, const Twin& twin, CauseFit& out) {
  Eigen::VectorXd beyond_noise = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(out.fitted.size()));
  for (std::size_t k = 0; k < out.fitted.size(); ++k) {
    const Parameter& p = out.fitted[k];
    const GroupFit::Known& known = fit.known()[k];
    out.told.push_back({p.name, p.unit, p.shown(p.start), p.shown(known.value),
                        known.told ? p.shown_sigma(known.value, known.sigma) : 0.0});
    out.tried.fitted += known.told ? 1.0 : 0.0;
    if (known.told && known.noise_sigma > 0.0)
      beyond_noise[static_cast<Eigen::Index>(k)] = known.sigma / known.noise_sigma;
  }
  if (!out.fitted.empty())
    out.covariance = beyond_noise.asDiagonal() * fit.covariance() * beyond_noise.asDiagonal();
  for (std::size_t c = 0; c < out.sensors.samples().size(); ++c) {
    const GridSamples& s = out.sensors.samples()[c];
    const Eigen::Vector2d sigma = fit.sensor_sigma(c);
    out.gain.push_back({twin.cameras[s.camera].name, s.gain_dn, sigma[0], s.black_level_dn, sigma[1]});
  }
}

std::uint64_t count_values(const Sensitivity& sensitivity) {
  std::uint64_t n = 0;
  for (const GridSamples& s : sensitivity.samples())
    n += static_cast<std::uint64_t>(std::ranges::count_if(s.weight, [](float w) { return w > 0.0F; }));
  return n;
}

/// Returns the sum over the values of the logarithm of their variance over that of the others' weights.
double log_variance_over(const Sensitivity& others, const Sensitivity& sensors) {
  double sum = 0.0;
  for (std::size_t c = 0; c < sensors.samples().size(); ++c) {
    const std::vector<float>&weight = sensors.samples()[c].weight, &other = others.samples()[c].weight;
    for (std::size_t i = 0; i < weight.size(); ++i)
      if (weight[i] > 0.0F && weight[i] != other[i])
        sum += 2.0 * std::log(static_cast<double>(other[i]) / static_cast<double>(weight[i]));
  }
  return sum;
}

/// Takes the noise of the values at what they have with the field, and with the gain and black level that go
/// with it: those of a twin without it may be a quarter off, and so the noise.
void weigh_with_field(Sensitivity& sensors, const Twin& twin, const Sensitivity::Values& predicted,
                      FreePerPixel free) {
  sensors.weigh_with_field_at(predicted, free);
  GroupFit(sensors, twin, {}, {.keep_scale = true, .free = free}, {}, predicted).run();
  sensors.weigh_with_field_at(predicted, free);
}

/// Returns the z of the fits with the objects moved and grown as these values say.
std::map<std::string, double> z_with(const std::vector<FitRow>& fits, const Twin& twin,
                                     const std::vector<Parameter>& parameters,
                                     const Eigen::VectorXd& values) {
  Twin changed = twin;
  for (std::size_t k = 0; k < parameters.size(); ++k)
    parameters[k].change(changed, values[static_cast<Eigen::Index>(k)] - parameters[k].start);
  return z_by_name(moved_fits(fits, twin, changed));
}

Eigen::VectorXd in_a_vector(const std::map<std::string, double>& z) {
  Eigen::VectorXd out(z.size());
  Eigen::Index k = 0;
  for (const auto& [name, value] : z) out[k++] = value;
  return out;
}

double most_of(const Eigen::VectorXd& z) { return z.size() > 0 ? z.cwiseAbs().maxCoeff() : 0.0; }

/// Returns whether both sides' fits agree, or nearly do where they were far apart before.
bool agrees(const Eigen::VectorXd& z, const Eigen::VectorXd& before) {
  const double limit = most_sigmas_of(static_cast<std::uint64_t>(z.size()));
  return most_of(z) <= std::clamp(kStillApart * most_of(before), limit, kFarthestApart * limit);
}

}  // namespace

CauseFit fit_cause(const Sensitivity& sensitivity, const Twin& twin, const std::vector<Parameter>& parameters,
                   FreePerPixel free, CauseStart start) {
  CauseFit out{.sensors = sensitivity, .fitted = {}};
  if (frees_factor(free)) out.sensors.leave_out_texture_edges();
  if (free != FreePerPixel::nothing && !start.predicted.empty())
    weigh_with_field(out.sensors, twin, start.predicted, free);
  out.tried.log_variance = log_variance_over(sensitivity, out.sensors);
  Twin changed = twin;
  for (const Parameter& p : parameters)
    if (!p.is_switch)
      out.fitted.push_back(p);
    else {
      p.change(changed, p.start > 0.5 ? -1.0 : 1.0);
      out.tried.fitted += 1.0;
    }
  GroupFit fit(out.sensors, changed, out.fitted,
               {.hold_gain = false,
                .keep_scale = true,
                .settles_sensors = true,
                .tells = !start.only_values,
                .most_steps = kMostSteps,
                .wanted_chi2 = sensitivity.chi2_limit(static_cast<double>(count_values(sensitivity))),
                .free = free},
               start.values, std::move(start.predicted));
  if (!start.columns.rough.empty())
    fit.use_columns(std::move(start.columns),
                    start.columns_at.size() > 0 ? start.columns_at : start_values(out.fitted));
  fit.run();
  if (free == FreePerPixel::nothing) fit.settle_sensors();  // else those that go with what pixels have
  out.values = fit.values();
  out.converged = fit.converged();
  out.chi2 = fit.chi2();
  out.n = fit.n();
  out.predicted = fit.predicted();
  if (!start.only_values) tell(fit, twin, out);
  if (auto columns = fit.give_columns()) std::tie(out.columns, out.columns_at) = std::move(*columns);
  if (start.only_values) return out;
  out.regions = fit.regions();
  if (out.regions.empty()) out.regions = cause_regions(out.sensors, twin.fringes, out.predicted, free);
  const auto n = static_cast<double>(fit.n());
  out.tried.fitted += static_cast<double>(count_values(sensitivity)) - n;
  out.tried.chi2 = out.chi2 * n + out.tried.fitted;
  out.tried.passes = out.chi2 <= sensitivity.chi2_limit(n) &&
                     std::ranges::any_of(out.regions, [](const CauseRegion& r) { return r.n > 0; }) &&
                     std::ranges::all_of(out.regions, &CauseRegion::passes);
  return out;
}

std::optional<Eigen::VectorXd> values_of_fits(const std::vector<FitRow>& fits, const Twin& twin,
                                              const std::vector<Parameter>& parameters) {
  constexpr int kMostFitSteps = 20;
  const auto z_at = [&](const Eigen::VectorXd& values) {
    return in_a_vector(z_with(fits, twin, parameters, values));
  };
  Eigen::VectorXd values = start_values(parameters), z = z_at(values);
  const Eigen::VectorXd before = z;
  if (!(most_of(z) > most_sigmas_of(static_cast<std::uint64_t>(z.size())))) return std::nullopt;
  for (int step = 0; step < kMostFitSteps; ++step) {
    Eigen::MatrixXd by_values(z.size(), values.size());
    for (Eigen::Index k = 0; k < values.size(); ++k) {
      Eigen::VectorXd changed = values;
      changed[k] += parameters[static_cast<std::size_t>(k)].step;
      by_values.col(k) = (z_at(changed) - z) / parameters[static_cast<std::size_t>(k)].step;
    }
    std::vector<Eigen::Index> moving;  // objects without a fit, and meshes, change no z: they stay
    for (Eigen::Index k = 0; k < values.size(); ++k)
      if ((by_values.col(k).array() != 0.0).any()) moving.push_back(k);
    if (moving.empty() || z.size() < static_cast<Eigen::Index>(moving.size())) return std::nullopt;
    const Eigen::MatrixXd of_moving = by_values(Eigen::all, moving);
    const Eigen::VectorXd part = -least_squares(of_moving, z);
    if (!part.allFinite()) return std::nullopt;
    Eigen::VectorXd change = Eigen::VectorXd::Zero(values.size());
    for (std::size_t i = 0; i < moving.size(); ++i) change[moving[i]] = part[static_cast<Eigen::Index>(i)];
    values += change;
    z = z_at(values);
    if (z.size() != before.size()) return std::nullopt;
    if ((by_values * change).cwiseAbs().maxCoeff() < kSettledZ) break;
  }
  return agrees(z, before) ? std::optional(values) : std::nullopt;
}

void hold_against_fits(const std::vector<FitRow>& fits, const Twin& twin, CauseFit& cause) {
  const auto z_at = [&](const Eigen::VectorXd& values) {
    return in_a_vector(z_with(fits, twin, cause.fitted, values));
  };
  const Eigen::VectorXd after = z_at(cause.values);
  if (after.size() == 0) return;
  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(after.size(), cause.values.size());
  for (Eigen::Index k = 0; k < cause.values.size(); ++k) {
    const double sigma = std::sqrt(cause.covariance(k, k));
    if (!(sigma > 0.0)) continue;
    Eigen::VectorXd values = cause.values;
    values[k] += sigma;
    slopes.col(k) = (z_at(values) - after) / sigma;
  }
  const Eigen::VectorXd z = with_uncertain_values(after, slopes, cause.covariance);
  cause.fit_z = most_of(z);
  cause.fits_agree = agrees(z, z_at(start_values(cause.fitted)));
  cause.tried.passes = cause.tried.passes && cause.fits_agree;
}

}  // namespace fringetwin::compare
