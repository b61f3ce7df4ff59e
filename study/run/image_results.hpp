// SPDX-License-Identifier: Apache-2.0
// Results that a [[record]] may name besides those of result.json: what the images cost, how well they are
// exposed, how much of them is measured, and the indicators of the fitted spheres and planes.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "measure/measurement.hpp"
#include "render/base/rendered_camera.hpp"
#include "study/noise/noise_theory.hpp"
#include "study/study_file.hpp"
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

/// JSON of those that any of the records asks for: "acquisition" {images, time_s}, "images" [{camera,
/// saturated, measured (first camera)}], "indicators" [{object, sphere_form, ...}], "theory" [{object, n,
/// ...}]. docs/METRICS.md, "Results of studies".
std::string image_results(const VirtualMeasurement& run, const std::vector<Record>& records);

}  // namespace fringetwin::study
