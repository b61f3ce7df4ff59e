// SPDX-License-Identifier: Apache-2.0
// Writes a device of a twin as a calibration would.
#pragma once
#include <filesystem>

#include "twin/file/cameramodel.hpp"
#include "twin/lens/lens.hpp"
#include "twin/lens/pose.hpp"

namespace fringetwin::testing {

/// Writes a .cameramodel file in metres, as mrcal does.
inline void write_model_in_metres(const std::filesystem::path& file, const Lens& lens,
                                  const Pose& T_device_world) {
  CameraModelFile model;
  model.lensmodel = lens.model();
  model.intrinsics = lens.intrinsics();
  const RotTrans rt = rt_from_pose(T_device_world);
  for (std::size_t i = 0; i < 6; ++i)
    model.rt_cam_ref[i] = rt[static_cast<Eigen::Index>(i)] * (i < 3 ? 1.0 : 1e-3);
  model.imagersize = {lens.width(), lens.height()};
  write_cameramodel(file, model);
}

}  // namespace fringetwin::testing
