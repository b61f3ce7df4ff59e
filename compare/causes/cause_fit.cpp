// SPDX-License-Identifier: Apache-2.0
#include "compare/causes/cause_fit.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "compare/causes/cause_regions.hpp"
#include "compare/causes/group_fit.hpp"
#include "compare/geometry/moved_fits.hpp"
#include "compare/verdict/explained.hpp"

namespace fringetwin::compare {
namespace {

constexpr int kMostSteps = 12;
/// Of the largest |z| of a fit: what the method adds to a fit does not quite move along, so that a right
/// cause of a large difference may leave more than noise.
constexpr double kStillApart = 0.25;

void tell(GroupFit& fit, const Twin& twin, CauseFit& out) {
  for (std::size_t k = 0; k < out.fitted.size(); ++k) {
    const Parameter& p = out.fitted[k];
    const GroupFit::Known& known = fit.known()[k];
    out.told.push_back({p.name, p.unit, p.shown(p.start), p.shown(known.value),
                        known.told ? p.shown_sigma(known.value, known.sigma) : 0.0});
    out.tried.fitted += known.told ? 1.0 : 0.0;
  }
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

}  // namespace

CauseFit fit_cause(const Sensitivity& sensitivity, const Twin& twin, const std::vector<Parameter>& parameters,
                   FreePerPixel free, CauseStart start) {
  CauseFit out{.sensors = sensitivity, .fitted = {}};
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
                .most_steps = kMostSteps,
                .wanted_chi2 = sensitivity.chi2_limit(static_cast<double>(count_values(sensitivity))),
                .free = free},
               start.values, std::move(start.predicted));
  if (!start.columns.rough.empty()) fit.use_columns(std::move(start.columns), start_values(out.fitted));
  fit.run();
  if (free == FreePerPixel::nothing) fit.settle_sensors();  // else those that go with what pixels have
  out.values = fit.values();
  out.converged = fit.converged();
  out.chi2 = fit.chi2();
  out.n = fit.n();
  tell(fit, twin, out);
  out.predicted = fit.predicted();
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

void hold_against_fits(const std::vector<FitRow>& fits, const Twin& twin, CauseFit& cause) {
  const auto z_with = [&](const Eigen::VectorXd& values) {
    Twin changed = twin;
    for (std::size_t k = 0; k < cause.fitted.size(); ++k)
      cause.fitted[k].change(changed, values[static_cast<Eigen::Index>(k)] - cause.fitted[k].start);
    return z_by_name(moved_fits(fits, twin, changed));
  };
  const std::map<std::string, double> before = z_with(start_values(cause.fitted)),
                                      after = z_with(cause.values);
  std::map<std::string, double> variance;  // of each z, by the errors of the values
  for (std::size_t k = 0; k < cause.fitted.size(); ++k) {
    Eigen::VectorXd values = cause.values;
    values[static_cast<Eigen::Index>(k)] += cause.told[k].sigma;
    for (const auto& [name, z] : z_with(values)) variance[name] += std::pow(z - after.at(name), 2);
  }
  double most_before = 0.0;
  for (const auto& [name, z] : before) most_before = std::max(most_before, std::abs(z));
  for (const auto& [name, z] : after)
    cause.fit_z = std::fmax(cause.fit_z, std::abs(z) / std::sqrt(1.0 + variance[name]));
  if (cause.fit_z > std::max(most_sigmas_of(after.size()), kStillApart * most_before))
    cause.tried.passes = false;
}

}  // namespace fringetwin::compare
