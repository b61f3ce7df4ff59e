// SPDX-License-Identifier: Apache-2.0
#include "compare/verdict/indicators.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "compare/geometry/fit_rows.hpp"
#include "compare/result/fit_keys.hpp"
#include "measure/fit/shape_fits.hpp"

namespace fringetwin::compare {
namespace {

using Eigen::Vector3d;
using measure::ObjectFit;
using Fit = std::optional<ObjectFit>;

constexpr double kShare = 0.95;

Vector3d vector(const ObjectFit& fit, const std::string& key) {
  return value_or(fit.vectors, key, Vector3d::Constant(kNaN));
}

const SphereShape* nominal_sphere(const Twin& twin, const std::string& object) {
  const Object* found = twin.find_object(object);
  return found ? std::get_if<SphereShape>(&found->shape) : nullptr;
}

/// Returns the name of the form indicator of a kind of shape, "" where it has none.
std::string form_of(const std::string& kind) {
  std::string form;
  for_every_shape([&](const auto& shape) {
    if (kind == shape.kKind) form = measure::form_indicator(shape);
  });
  return form;
}

Ranges ranges(const Fit& fit) { return fit && fit->usable ? deviation_ranges(fit->deviation_mm) : Ranges{}; }

Indicator::Value size(const Fit& fit, const SphereShape& nominal) {
  if (!fit || !fit->usable) return {};
  return {2.0 * (value_or(fit->numbers, "radius_mm", kNaN) - nominal.radius_mm),
          2.0 * value_or(fit->numbers, "radius_sigma_mm", kNaN)};
}

/// The sigma is that along the line of the centres; correlation between a centre's components is not kept by
/// the fits.
Indicator::Value spacing(const Fit& a, const Fit& b, double nominal_mm) {
  if (!a || !b || !a->usable || !b->usable) return {};
  const Vector3d way = vector(*b, "center_mm") - vector(*a, "center_mm");
  const Vector3d along = way.normalized();
  const double sigma = std::hypot(along.cwiseProduct(vector(*a, "center_sigma_mm")).norm(),
                                  along.cwiseProduct(vector(*b, "center_sigma_mm")).norm());
  return {way.norm() - nominal_mm, sigma};
}

void add(std::vector<Indicator>& rows, Indicator row) {
  if (std::isfinite(row.simulated.mm) || std::isfinite(row.real.mm)) rows.push_back(std::move(row));
}

}  // namespace

Ranges deviation_ranges(const std::vector<float>& deviation_mm) {
  std::vector<double> d;
  for (const float x : deviation_mm)
    if (std::isfinite(x)) d.push_back(static_cast<double>(x));
  if (d.empty()) return {};
  // the interval starts at one of the n - k + 1 smallest and ends at one of as many largest values
  const auto n = static_cast<std::ptrdiff_t>(d.size());
  const auto k = std::clamp<std::ptrdiff_t>(std::lround(std::ceil(kShare * static_cast<double>(n))), 1, n);
  const std::ptrdiff_t starts = n - k + 1;
  std::partial_sort(d.begin(), d.begin() + starts, d.end());
  const double low = d.front();
  std::vector<double> ends(static_cast<std::size_t>(starts));
  std::partial_sort_copy(d.begin(), d.end(), ends.begin(), ends.end(), std::greater<>());
  std::ranges::reverse(ends);
  Ranges out{ends.back() - low, ends.back() - low};
  for (std::ptrdiff_t i = 0; i < starts; ++i) out.p95_mm = std::min(out.p95_mm, ends[i] - d[i]);
  return out;
}

std::vector<std::string> indicator_names(const std::string& kind) {
  const std::string form = form_of(kind);
  if (form.empty()) return {};
  std::vector<std::string> names{form, form + "_95"};
  if (kind == SphereShape::kKind) names.emplace_back("sphere_size");
  return names;
}

std::vector<Indicator> indicators(const Twin& twin, const std::vector<FitRow>& fits) {
  std::vector<Indicator> rows;
  for (const FitRow& fit : fits) {
    const std::string form = form_of(fit.kind);
    if (form.empty()) continue;
    const Ranges s = ranges(fit.simulated), r = ranges(fit.real);
    add(rows, {form, {fit.object}, {s.all_mm, kNaN}, {r.all_mm, kNaN}});
    add(rows, {form + "_95", {fit.object}, {s.p95_mm, kNaN}, {r.p95_mm, kNaN}});
    if (const SphereShape* nominal = nominal_sphere(twin, fit.object))
      add(rows, {"sphere_size", {fit.object}, size(fit.simulated, *nominal), size(fit.real, *nominal)});
  }
  for (std::size_t i = 0; i < fits.size(); ++i)
    for (std::size_t j = i + 1; j < fits.size(); ++j) {
      const SphereShape *a = nominal_sphere(twin, fits[i].object), *b = nominal_sphere(twin, fits[j].object);
      if (!a || !b) continue;
      const double nominal_mm = (b->center_mm - a->center_mm).norm();
      add(rows, {"sphere_spacing",
                 {fits[i].object, fits[j].object},
                 spacing(fits[i].simulated, fits[j].simulated, nominal_mm),
                 spacing(fits[i].real, fits[j].real, nominal_mm)});
    }
  return rows;
}

}  // namespace fringetwin::compare
