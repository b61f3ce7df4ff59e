// SPDX-License-Identifier: Apache-2.0
#include "cosim/doubt_description.hpp"

#include "measure/description_warnings.hpp"

namespace fringetwin::cosim {

std::vector<measure::Doubt> doubts_about_real_side(Run& run) {
  if (!run.real.measurement) return {};
  run.timer.start("doubt");
  std::vector<measure::Doubt> doubts = measure::description_warnings(
      run.twin, run.real.images, *run.real.measurement, &*run.simulated.measurement);
  run.timer.stop();
  return doubts;
}

void add_to_warnings(Run& run, const std::vector<measure::Doubt>& doubts) {
  if (run.real.measurement) measure::put_first(doubts, run.real.measurement->warnings);
}

void add_first_warning(Run& run, const std::string& warning) {
  if (warning.empty() || !run.simulated.measurement) return;
  std::vector<std::string>& warnings = run.simulated.measurement->warnings;
  warnings.insert(warnings.begin(), warning);
}

}  // namespace fringetwin::cosim
