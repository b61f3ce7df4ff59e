// SPDX-License-Identifier: Apache-2.0
#include "compare/result/row_json.hpp"

namespace fringetwin::compare {

using report::Json;
using report::json_number;

Json noise_json(const NoiseRow& r) {
  return {{"camera", r.camera},
          {"direction", r.direction},
          {"prediction", r.sensor_known ? "sensor" : "quantisation"},
          {"gray_measured_dn", json_number(r.gray_measured_dn)},
          {"gray_predicted_dn", json_number(r.gray_predicted_dn)},
          {"gray_ratio", json_number(r.gray_ratio)},
          {"gray_ratio_sigma", json_number(r.gray_ratio_sigma)},
          {"n", r.n},
          {"phase_measured_rad", json_number(r.phase_measured_rad)},
          {"phase_predicted_rad", json_number(r.phase_predicted_rad)},
          {"phase_ratio", json_number(r.phase_ratio)},
          {"phase_ratio_sigma", json_number(r.phase_ratio_sigma)},
          {"n_phase", r.n_phase}};
}

Json shift_json(const ShiftRow& r) {
  Json out = {{"camera", r.camera}, {"block_px", kShiftBlock}};
  for (const auto& [name, c] : {std::pair{"dx", &r.dx}, std::pair{"dy", &r.dy}}) {
    const std::string key = name;
    out[key + "_px"] = json_number(c->mean_px);
    out[key + "_sigma_px"] = json_number(c->mean_sigma_px);
    out[key + "_rms_px"] = json_number(c->rms_px);
    out[key + "_largest_px"] = json_number(c->largest_px);
    out["n_blocks_" + key] = c->n_blocks;
  }
  out["chi2_before"] = json_number(r.chi2_before);
  out["chi2_after"] = json_number(r.chi2_after);
  out["n"] = r.n;
  return out;
}

Json indicator_json(const Indicator& r) {
  return {{"name", r.name},
          {"objects", r.objects},
          {"unit", "mm"},
          {"simulated", json_number(r.simulated.mm)},
          {"simulated_sigma_mm", json_number(r.simulated.sigma_mm)},
          {"real", json_number(r.real.mm)},
          {"real_sigma_mm", json_number(r.real.sigma_mm)},
          {"difference", json_number(r.difference_mm())},
          {"z", json_number(r.z())}};
}

}  // namespace fringetwin::compare
