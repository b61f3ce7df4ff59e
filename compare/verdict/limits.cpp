// SPDX-License-Identifier: Apache-2.0
#include "compare/verdict/limits.hpp"

#include <algorithm>
#include <cmath>

#include "twin/base/errors.hpp"

namespace fringetwin::compare {
namespace {

/// The worst of several values; NaN when there is none or one is unknown.
class Worst {
 public:
  explicit Worst(bool smallest_is_worst = false) : smallest_(smallest_is_worst) {}
  void add(double value) {
    if (!any_)
      value_ = value;
    else if (std::isnan(value) || std::isnan(value_))
      value_ = kUnknown;
    else
      value_ = smallest_ ? std::min(value_, value) : std::max(value_, value);
    any_ = true;
  }
  double value() const { return value_; }

 private:
  bool smallest_ = false, any_ = false;
  double value_ = kUnknown;
};

double worst_center(const Comparison& c) {
  Worst worst;
  for (const FitRow& row : c.fits) {
    const auto at = row.difference_vectors.find("center_mm");
    if (at != row.difference_vectors.end())
      worst.add(at->second.cwiseAbs().maxCoeff());
    else if (row.kind == "sphere")
      worst.add(kUnknown);
  }
  return worst.value();
}

double worst_radius(const Comparison& c) {
  Worst worst;
  for (const FitRow& row : c.fits) {
    const auto at = row.difference.find("radius_mm");
    if (at != row.difference.end())
      worst.add(std::abs(at->second));
    else if (row.kind == "sphere" || row.kind == "cylinder")
      worst.add(kUnknown);
  }
  return worst.value();
}

double worst_fit_rms(const Comparison& c, const std::string& key) {
  Worst worst;
  for (const FitRow& row : c.fits) {
    const bool usable = row.simulated && row.simulated->usable && row.simulated->numbers.contains(key);
    worst.add(usable ? row.simulated->numbers.at(key) : kUnknown);
  }
  return worst.value();
}

double value_of(const std::string& name, const Comparison& c) {
  if (name == "center_mm") return worst_center(c);
  if (name == "radius_mm") return worst_radius(c);
  if (name == "rms_mm" || name == "rms_all_mm") return worst_fit_rms(c, name);
  Worst worst(name == "gain_r2");
  if (name == "phase_rms_rad")
    for (const PhaseRow& row : c.phase) worst.add(row.rms_rad);
  if (name == "phase_mean_relative")
    for (const PhaseRow& row : c.phase) worst.add(row.mean_relative);
  if (name == "order_disagree_fraction")
    for (const PhaseRow& row : c.phase) worst.add(row.order_disagree_fraction());
  if (name == "gray_rms_dn")
    for (const GainRow& row : c.gain) worst.add(row.rms_after_dn);
  if (name == "noise_ratio_error")
    for (const NoiseRow& row : c.noise) {
      worst.add(std::abs(row.gray_ratio - 1.0));
      worst.add(std::abs(row.phase_ratio - 1.0));
    }
  if (name == "gain_r2")
    for (const GainRow& row : c.gain) worst.add(row.r2);
  return worst.value();
}

}  // namespace

const std::map<std::string, std::string>& limit_names() {
  static const std::map<std::string, std::string> names{
      {"center_mm", "largest |component| of a sphere centre's difference, mm"},
      {"radius_mm", "largest |difference| of a radius, mm"},
      {"rms_mm", "largest residual rms of a simulated fit, outliers left out, mm"},
      {"rms_all_mm", "largest residual rms of a simulated fit over all points within the gate, mm"},
      {"order_disagree_fraction", "largest share of pixels whose fringe orders differ on the two sides"},
      {"phase_rms_rad", "largest rms of the phase difference at the finest pitch, rad"},
      {"phase_mean_relative", "largest mean |phase difference| / mean |phase|"},
      {"gray_rms_dn", "largest gray residual after the gain fit, DN"},
      {"noise_ratio_error", "largest |measured / predicted noise - 1| of gray values and phase"},
      {"gain_r2", "smallest R² of the gain fit (at least)"}};
  return names;
}

std::vector<LimitRow> check_limits(const std::map<std::string, double>& limits, const Comparison& comparison,
                                   const std::string& where) {
  std::vector<LimitRow> rows;
  for (const auto& [name, limit] : limits) {
    if (!limit_names().contains(name)) {
      std::string known;
      for (const auto& [key, meaning] : limit_names()) known += (known.empty() ? "" : ", ") + key;
      throw UserError(ExitCode::usage, where, "[limits] has no quantity named \"" + name + "\"",
                      "use one of " + known);
    }
    LimitRow row{name, value_of(name, comparison), limit, false};
    row.pass = name == "gain_r2" ? row.value >= limit : row.value <= limit;  // false for NaN
    rows.push_back(row);
  }
  return rows;
}

}  // namespace fringetwin::compare
