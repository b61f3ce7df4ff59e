// SPDX-License-Identifier: Apache-2.0
#include "compare/result/fit_json.hpp"

#include <cmath>

#include "compare/result/fit_keys.hpp"

namespace fringetwin::compare {
namespace {

using measure::ObjectFit;
using report::Json;
using report::json_number;

Json vector(const Eigen::Vector3d& v) {
  return Json::array({json_number(v[0]), json_number(v[1]), json_number(v[2])});
}

/// Returns the keys that every fit of a kind has, with null for each.
Json fit_template(const std::string& kind) {
  Json fit = Json::object();
  for (const std::string& key : keys_of_fit(kind)) fit[key] = nullptr;
  fit["rms_mm"] = nullptr;
  return fit;
}

Json values_json(const std::map<std::string, double>& numbers,
                 const std::map<std::string, Eigen::Vector3d>& vectors) {
  Json out = Json::object();
  for (const auto& [key, value] : vectors) out[key] = vector(value);
  for (const auto& [key, value] : numbers) out[key] = json_number(value);
  return out.empty() ? Json(nullptr) : out;
}

}  // namespace

Json fit_json(const std::optional<ObjectFit>& fit) {
  if (!fit) return nullptr;
  Json out = fit_template(fit->kind);
  if (fit->usable) {
    for (const auto& [key, value] : fit->numbers)
      out[key] = is_count_key(key) && std::isfinite(value) ? Json(std::llround(value)) : json_number(value);
    for (const auto& [key, value] : fit->vectors) out[key] = vector(value);
  }
  out["n"] = fit->n;
  if (!fit->warning.empty()) out["warning"] = fit->warning;
  return out;
}

Json bias_json(const std::optional<ObjectFit>& fit) {
  return fit ? values_json(fit->bias, fit->bias_vectors) : Json(nullptr);
}

Json fit_row_json(const FitRow& row) {
  Json difference = Json::object(), z = Json::object();
  for (const auto& [key, value] : row.difference_vectors) {
    difference[key] = vector(value);
    const auto at = row.z_vectors.find(key);
    z[key] = at == row.z_vectors.end() ? Json(nullptr) : vector(at->second);
  }
  for (const auto& [key, value] : row.difference) {
    difference[key] = json_number(value);
    const auto at = row.z.find(key);
    z[key] = at == row.z.end() ? Json(nullptr) : json_number(at->second);
  }
  const bool both = row.simulated && row.real;
  return {{"object", row.object},
          {"kind", row.kind},
          {"alignment", alignment_of(row.kind)},
          {"simulated", fit_json(row.simulated)},
          {"real", fit_json(row.real)},
          {"difference", both ? difference : Json(nullptr)},
          {"z", both ? z : Json(nullptr)},
          {"method_bias", bias_json(row.real && row.real->n > 0 ? row.real : row.simulated)},
          {"real_estimated", values_json(row.real_sigma_estimated, row.real_sigma_estimated_vectors)},
          {"z_estimated", values_json(row.z_estimated, row.z_estimated_vectors)}};
}

}  // namespace fringetwin::compare
