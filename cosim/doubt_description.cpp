// SPDX-License-Identifier: Apache-2.0
#include "cosim/doubt_description.hpp"

#include "measure/description_warnings.hpp"

namespace fringetwin::cosim {

std::vector<std::string> description_doubts(Run& run) {
  if (!run.real.measurement) return {};
  run.timer.start("doubt");
  std::vector<std::string> doubts = measure::description_warnings(
      run.twin, run.real.images, *run.real.measurement, &*run.simulated.measurement);
  run.timer.stop();
  return doubts;
}

}  // namespace fringetwin::cosim
