// SPDX-License-Identifier: Apache-2.0
#include "cosim/doubt_description.hpp"

#include <utility>

#include "measure/description_warnings.hpp"

namespace fringetwin::cosim {

void doubt_description(Run& run) {
  if (!run.real.measurement) return;
  run.timer.start("doubt");
  for (std::string& sentence : measure::description_warnings(run.twin, run.real.images, *run.real.measurement,
                                                             &*run.simulated.measurement))
    run.real.measurement->warnings.push_back(std::move(sentence));
  run.timer.stop();
}

}  // namespace fringetwin::cosim
