// SPDX-License-Identifier: Apache-2.0
#include "compare/row_json.hpp"

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

}  // namespace fringetwin::compare
