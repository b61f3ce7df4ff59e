// SPDX-License-Identifier: Apache-2.0
// Works out the results that a [[record]] may name besides those of result.json: what the images cost, how
// well they are exposed, how much of them is measured, and the indicators of the fitted spheres and planes.
#pragma once
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "measure/measurement.hpp"
#include "render/base/rendered_camera.hpp"
#include "study/noise/noise_theory.hpp"
#include "study/plan/study_tables.hpp"
#include "twin/captures/capture_set.hpp"

namespace fringetwin::study {

/// One virtual measurement: what was recorded by which rig, and what came of it.
struct VirtualMeasurement {
  const Twin& recording;
  const Twin& measuring;
  const std::vector<render::RenderedCamera>& rendered;  ///< order of recording.cameras, as all images
  const std::vector<CameraImages>& images;
  const measure::Measurement& measurement;
  std::map<std::string, NoiseTheory>& theory;  ///< of the recording twin, by object; filled where asked for
};

/// Returns those that any of the records asks for: "acquisition" {images, time_s}, "images" [{camera,
/// saturated, measured (first camera)}], "indicators" [{object, sphere_form, ...}], "theory" [{object, n,
/// ...}], all null of a twin that the theory does not know. docs/metrics/study.md, "Results of studies".
nlohmann::ordered_json image_results(const VirtualMeasurement& run, const std::vector<Record>& records);

}  // namespace fringetwin::study
