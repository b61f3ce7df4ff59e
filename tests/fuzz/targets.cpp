// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/target.hpp"

namespace fringetwin::fuzz {

extern const Target twin_target, capture_set_target, study_target, cameramodel_target, lens_target,
    opencv_target, kalibr_target, matrices_target, corners_target, ply_target, obj_target, stl_target,
    png_target, tiff_target, exr_target, patterns_target, journal_target, result_json_target,
    calibration_json_target, shard_target, study_store_target;

const std::vector<const Target*>& all_targets() {
  static const std::vector<const Target*> targets = {&twin_target,
                                                     &capture_set_target,
                                                     &study_target,
                                                     &cameramodel_target,
                                                     &lens_target,
                                                     &opencv_target,
                                                     &kalibr_target,
                                                     &matrices_target,
                                                     &corners_target,
                                                     &ply_target,
                                                     &obj_target,
                                                     &stl_target,
                                                     &png_target,
                                                     &tiff_target,
                                                     &exr_target,
                                                     &patterns_target,
                                                     &journal_target,
                                                     &result_json_target,
                                                     &calibration_json_target,
                                                     &shard_target,
                                                     &study_store_target};
  return targets;
}

}  // namespace fringetwin::fuzz
