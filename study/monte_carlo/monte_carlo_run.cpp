// SPDX-License-Identifier: Apache-2.0
#include "study/monte_carlo/monte_carlo_run.hpp"

namespace fringetwin::study {

MonteCarloPlan complete_plan(const StudyFile& study) {
  MonteCarloPlan plan = study.monte_carlo.value().plan;
  plan.inputs = complete_inputs({plan.inputs, study.monte_carlo->calibration}, study.twin);
  return plan;
}

PointTask monte_carlo_task(const StudyFile& study, const MonteCarloPlan& plan) {
  return {study.twin, study.records, true, plan.inputs.calibration > 0};
}

StudyPoint first_trial(const StudyFile& study) {
  const MonteCarloPlan& plan = study.monte_carlo.value().plan;
  return point_of(plan.inputs, 0, draw_inputs(plan.inputs, plan.seed, DrawStream::trials, 0));
}

}  // namespace fringetwin::study
