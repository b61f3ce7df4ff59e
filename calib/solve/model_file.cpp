// SPDX-License-Identifier: Apache-2.0
// .cameramodel with the keys of mrcal 2.2's optimization_inputs, so that its tools can go on from here.
#include <algorithm>

#include "calib/board/npz.hpp"
#include "calib/solve/calibration.hpp"
#include "twin/file/cameramodel.hpp"

namespace fringetwin::calib {
namespace {

std::vector<double> flat(const std::vector<RotTrans>& poses) {
  std::vector<double> out;
  for (const RotTrans& rt : poses) out.insert(out.end(), rt.begin(), rt.end());
  return out;
}

std::string optimization_inputs(const MrcalProblem& p) {
  NpzWriter npz;
  std::vector<double> intrinsics, corners;
  for (const auto& k : p.intrinsics) intrinsics.insert(intrinsics.end(), k.begin(), k.end());
  for (const Eigen::Vector3d& c : p.corners) {
    corners.push_back(c.x());
    corners.push_back(c.y());
    corners.push_back(c.z() > 0.0 ? c.z() : -1.0);
  }
  std::vector<std::int32_t> indices, sizes;
  for (const auto& view : p.views) indices.insert(indices.end(), {view.frame, view.device, view.device - 1});
  for (const auto& size : p.imagersizes) sizes.insert(sizes.end(), size.begin(), size.end());
  const std::size_t n = p.intrinsics.size(), views = p.views.size();
  const auto width = static_cast<std::size_t>(p.width_n), height = static_cast<std::size_t>(p.height_n);
  npz.add("intrinsics", intrinsics, {n, p.intrinsics[0].size()});
  npz.add("extrinsics_rt_fromref", flat(p.rt_cam_ref), {n - 1, 6});
  npz.add("frames_rt_toref", flat(p.rt_ref_frame), {p.rt_ref_frame.size(), 6});
  npz.add("points", std::string());
  npz.add("observations_board", corners, {views, height, width, 3});
  npz.add("indices_frame_camintrinsics_camextrinsics", indices, {views, 3});
  npz.add("observations_point", std::string());
  npz.add("indices_point_camintrinsics_camextrinsics", std::string());
  npz.add("lensmodel", p.lensmodel);
  npz.add("imagersizes", sizes, {n, 2});
  npz.add("calobject_warp", std::vector<double>{p.warp_m.x(), p.warp_m.y()}, {2});
  npz.add("do_optimize_intrinsics_core", p.optimize_core);
  npz.add("do_optimize_intrinsics_distortions", p.optimize_distortion);
  npz.add("do_optimize_extrinsics", p.optimize_geometry);
  npz.add("do_optimize_frames", p.optimize_geometry);
  npz.add("do_optimize_calobject_warp", p.optimize_warp);
  npz.add("calibration_object_spacing", p.spacing_m);
  npz.add("do_apply_outlier_rejection", false);  // the outliers are marked already
  npz.add("do_apply_regularization", p.regularize);
  npz.add("verbose", false);
  return npz.bytes();
}

}  // namespace

void write_calibrated_model(const std::filesystem::path& file, const Calibration& c, int device,
                            const std::vector<std::string>& comments) {
  CameraModelFile model{.lensmodel = c.problem.lensmodel, .intrinsics = c.problem.intrinsics[device]};
  if (device > 0) {
    const RotTrans& rt = c.problem.rt_cam_ref[device - 1];
    std::ranges::copy(rt, model.rt_cam_ref.begin());
  }
  model.imagersize = c.problem.imagersizes[device];
  model.comments = comments;
  model.extra = "\n    'icam_intrinsics': " + std::to_string(device) +
                ",\n\n    # The optimization inputs contain all the data used to compute this model\n"
                "    'optimization_inputs': b'" +
                base85(optimization_inputs(c.problem)) + "',\n";
  write_cameramodel(file, model);
}

}  // namespace fringetwin::calib
