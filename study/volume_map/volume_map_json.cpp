// SPDX-License-Identifier: Apache-2.0
#include <array>

#include "report/json.hpp"
#include "study/volume_map/volume_map.hpp"

namespace fringetwin::study {
namespace {

using report::Json, report::json_number, report::json_numbers;

Json json(const MapNumber& n) {
  return {{"mean", json_number(n.mean)},
          {"sigma", json_number(n.sigma)},
          {"interval", json_numbers(std::array{n.interval.low, n.interval.high})}};
}

Json json(const MapPosition& p) {
  Json out = {{"center_mm", json_numbers(p.center_mm)}, {"n", p.n}, {"failed", p.failed}};
  if (!p.reason.empty()) out["reason"] = p.reason;
  for (const auto& [name, number] : p.numbers) out[name] = json(number);
  return out;
}

Json json(const MapSpacing& s) {
  return {{"positions", {s.a, s.b}},
          {"length_mm", json_number(s.length_mm)},
          {"n", s.error_mm.n},
          {"error_mm", json(s.error_mm)}};
}

}  // namespace

std::string volume_map_json(const VolumeMapPlan& plan, const VolumeMap& map) {
  Json out = {{"schema", "fringetwin-volume-map/1"},
              {"object", plan.object},
              {"radius_mm", plan.radius_mm},
              {"center_mm", json_numbers(plan.center_mm)},
              {"size_mm", json_numbers(plan.size_mm)},
              {"counts", plan.counts},
              {"trials", plan.trials},
              {"coverage", plan.coverage},
              {"seed", plan.seed},
              {"factors", plan.inputs.factors()},
              {"measured", map.measured},
              {"worst", Json::object()},
              {"positions", Json::array()}};
  for (const auto& [name, w] : map.worst) out["worst"][name] = {{"mean_at", w.mean}, {"sigma_at", w.sigma}};
  for (const MapPosition& p : map.positions) out["positions"].push_back(json(p));
  Json spacing = {{"largest_mm", json(map.largest_mm)},
                  {"worst_mean", nullptr},
                  {"worst_sigma", nullptr},
                  {"pairs", Json::array()}};
  spacing["largest_mm"]["n"] = map.largest_mm.n;
  if (map.worst_spacing) {
    spacing["worst_mean"] = map.worst_spacing->mean;
    spacing["worst_sigma"] = map.worst_spacing->sigma;
  }
  for (const MapSpacing& s : map.spacings) spacing["pairs"].push_back(json(s));
  out["spacing"] = std::move(spacing);
  return out.dump(1) + "\n";
}

}  // namespace fringetwin::study
