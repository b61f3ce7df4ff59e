// SPDX-License-Identifier: Apache-2.0
#include "tests/support/program/rendered_rig.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "calib/board/corners_vnl.hpp"
#include "calib/solve/circle_bias.hpp"
#include "tests/support/program/cli_runner.hpp"
#include "twin/lens/lens.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::testing {
namespace {
namespace fs = std::filesystem;

constexpr int kLens = 8, kPose = 6, kParameters = 3 * kLens + 2 * kPose;

Eigen::VectorXd true_parameters(const RenderedBoards& scene) {
  Eigen::VectorXd out(kParameters);
  Eigen::Index at = 0;
  for (const auto& device : scene.devices()) {
    for (const double v : device.intrinsics) out[at++] = v;
    if (device.name == "left") continue;
    out.segment<kPose>(at) = device.rt_cam_world;
    at += kPose;
  }
  return out;
}

/// Returns the corners that `calibrate` found in the pictures.
calib::Observations found_corners(const RenderedBoards& scene, const fs::path& vnl) {
  calib::Observations o;
  o.board = scene.board;
  std::vector<std::string> globs;
  for (const auto& device : scene.devices()) {
    o.devices.push_back({device.name, device.size, device.intrinsics[0]});
    globs.push_back(device.name + "-*");
  }
  calib::assign_views(calib::read_corners_vnl(vnl, true), globs, o);
  o.sort();
  return o;
}

struct TrueDevice {
  Lens lens;
  Pose T_device_world;
};

/// Returns where a corner ought to be found: its picture; of a circle the centroid of its picture, and in the
/// projector what lights the place on the board that the cameras take for the centre (mean of both).
Eigen::Vector2d ideal_corner(const RenderedBoards& scene, const std::vector<TrueDevice>& devices,
                             std::size_t d, const Pose& T_world_board, const Eigen::Vector3d& corner_mm) {
  const auto centroid = [&](std::size_t camera) {
    return *calib::disc_centroid_px(devices[camera].lens, devices[camera].T_device_world * T_world_board,
                                    corner_mm, 0.5 * scene.circle_diameter_mm);
  };
  const Pose T = devices[d].T_device_world * T_world_board;
  if (!(scene.circle_diameter_mm > 0.0)) return *devices[d].lens.project(T * corner_mm);
  if (d < 2) return centroid(d);
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  for (std::size_t camera = 0; camera < 2; ++camera) {
    const Pose back = (devices[camera].T_device_world * T_world_board).inverse();
    const Eigen::Vector3d ray = back.rotation * *devices[camera].lens.unproject(centroid(camera));
    place += 0.5 * (back.translation_mm - back.translation_mm.z() / ray.z() * ray);
  }
  return *devices[d].lens.project(T * place);
}

/// rms per coordinate of found - true, per device.
std::vector<double> corner_noise_px(const RenderedBoards& scene, const calib::Observations& o) {
  std::vector<double> sum(3, 0.0), n(3, 0.0);
  std::vector<TrueDevice> devices;
  for (const auto& d : scene.devices())
    devices.push_back({Lens("LENSMODEL_OPENCV4", {d.intrinsics.begin(), d.intrinsics.end()},
                            Eigen::Vector2i(d.size[0], d.size[1]), d.name),
                       pose_from_rt(d.rt_cam_world)});
  for (const calib::View& view : o.views) {
    const auto d = static_cast<std::size_t>(view.device);
    const Pose T = scene.T_world_board(std::stoi(o.frames[static_cast<std::size_t>(view.frame)]));
    for (std::size_t i = 0; i < view.corners.size(); ++i) {
      if (!view.corners[i].seen()) continue;
      const Eigen::Vector2d off =
          view.corners[i].q_px - ideal_corner(scene, devices, d, T, o.board.point_mm(i));
      sum[d] += off.squaredNorm();
      n[d] += 2.0;
    }
  }
  for (std::size_t d = 0; d < 3; ++d) sum[d] = std::sqrt(sum[d] / n[d]);
  return sum;
}

/// Sigmas that corners with this noise leave to any unbiased estimate: (J^T V^-1 J)^-1 at the true rig and
/// poses (Cramér-Rao), J of all lenses, poses, boards and the warp, V = the noise measured against the truth,
/// per device, independent from corner to corner.
Eigen::VectorXd bound_of(const RenderedBoards& scene, calib::Observations o,
                         const std::vector<double>& noise_px) {
  calib::Seed seed{"LENSMODEL_OPENCV4", {}, {}, {}};
  const auto devices = scene.devices();
  for (std::size_t d = 0; d < 3; ++d) {
    seed.intrinsics.emplace_back(devices[d].intrinsics.begin(), devices[d].intrinsics.end());
    seed.T_device_ref.push_back(pose_from_rt(devices[d].rt_cam_world));
    o.devices[d].sigma_px = noise_px[d];
  }
  for (calib::View& view : o.views)
    for (calib::Corner& c : view.corners) c.weight = c.seen() ? 1.0 : -1.0;
  for (const std::string& frame : o.frames) seed.T_ref_board.push_back(scene.T_world_board(std::stoi(frame)));
  MrcalProblem problem = calib::make_problem(o, seed);
  problem.regularize = false;
  const MrcalLinearisation at_truth = mrcal_linearise(problem);
  const Eigen::MatrixXd JtJ = Eigen::MatrixXd(at_truth.Jt * at_truth.Jt.transpose());
  const Eigen::VectorXd variance = SymmetricFactor(JtJ).inverse().diagonal();
  const double least_px = *std::min_element(noise_px.begin(), noise_px.end());  // of weight 1
  const Eigen::VectorXd sigma =
      least_px * (variance.cwiseSqrt().array() * at_truth.state_scale.array().abs()).matrix();
  Eigen::VectorXd out(kParameters);
  Eigen::Index at = 0;
  for (std::size_t d = 0; d < 3; ++d) {
    out.segment<kLens>(at) = sigma.segment<kLens>(at_truth.intrinsics_at[d]);
    at += kLens;
    if (d == 0) continue;
    out.segment<kPose>(at) = sigma.segment<kPose>(at_truth.extrinsics_at[d - 1]);
    out.segment<3>(at + 3) *= 1000.0;  // m -> mm
    at += kPose;
  }
  return out;
}

}  // namespace

void expect_the_rig_is_found(const RenderedBoards& scene, const CornerLimits& limits) {
  const fs::path dir = scratch_folder("calibrate_rendered");
  std::vector<std::string> args{"calibrate",
                                "--twin",
                                (dir / "rough.toml").string(),
                                "--object-spacing",
                                fmt::format("{}", 1e-3 * scene.board.spacing_mm),
                                "--object-width-n",
                                std::to_string(scene.board.width_n),
                                "--object-height-n",
                                std::to_string(scene.board.height_n),
                                "--outdir",
                                (dir / "rig").string()};
  if (scene.circle_diameter_mm > 0.0)
    args.insert(args.end(), {"--board", "circles", "--circle-diameter",
                             fmt::format("{}", 1e-3 * scene.circle_diameter_mm)});
  for (const std::string& folder : scene.render(dir)) args.push_back(folder);
  const RunResult run = run_fringetwin(args);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  std::printf("%s", run.out.c_str());

  const auto json = read_json(dir / "rig" / "calibration.json");
  ASSERT_EQ(json["boards"].size(), static_cast<std::size_t>(scene.n_boards));
  const calib::Observations corners = found_corners(scene, dir / "rig" / "corners.vnl");
  const std::vector<double> noise_px = corner_noise_px(scene, corners);
  std::printf("corners against the truth, rms per coordinate: left %.4f, right %.4f, projector %.4f px\n",
              noise_px[0], noise_px[1], noise_px[2]);
  EXPECT_LT(std::max(noise_px[0], noise_px[1]), limits.camera_px);
  EXPECT_LT(noise_px[2], limits.projector_px);

  const auto& names = json["covariance"]["parameters"];
  ASSERT_EQ(names.size(), static_cast<std::size_t>(kParameters));
  Eigen::MatrixXd covariance(kParameters, kParameters);
  Eigen::VectorXd found(kParameters);
  Eigen::Index at = 0;
  for (const auto& device : json["devices"]) {
    for (const auto& v : device["intrinsics"]) found[at++] = v;
    if (device["name"] != "left")
      for (const auto& v : device["rt_device_ref"]) found[at++] = v;
  }
  for (Eigen::Index i = 0; i < kParameters; ++i)
    for (Eigen::Index k = 0; k < kParameters; ++k)
      covariance(i, k) =
          json["covariance"]["matrix"][static_cast<std::size_t>(i)][static_cast<std::size_t>(k)];
  const Eigen::VectorXd sigma = covariance.diagonal().cwiseSqrt();
  const Eigen::VectorXd error = ((found - true_parameters(scene)).array() / sigma.array()).matrix();
  const Eigen::VectorXd ratio = (sigma.array() / bound_of(scene, corners, noise_px).array()).matrix();
  int beyond_three = 0;
  for (Eigen::Index i = 0; i < kParameters; ++i) {
    const std::string name = names[static_cast<std::size_t>(i)];
    std::printf("%-13s %12.6g, sigma %9.3g, error %+5.2f sigma, sigma %.2f of the bound\n", name.c_str(),
                found[i], sigma[i], error[i], ratio[i]);
    EXPECT_LT(std::abs(error[i]), 3.96) << name;
    EXPECT_LE(ratio[i], 2.0) << name;
    EXPECT_GT(ratio[i], 0.5) << name;
    beyond_three += std::abs(error[i]) > 3.0;
  }
  const Eigen::MatrixXd correlation =
      sigma.cwiseInverse().asDiagonal() * covariance * sigma.cwiseInverse().asDiagonal();
  const double chi2 = error.dot(Eigen::VectorXd(solve_symmetric(correlation, error)));
  std::printf("chi2 %.2f of 36 parameters; %d beyond 3 sigma\n", chi2, beyond_three);
  EXPECT_LT(chi2, 64.10);
}

}  // namespace fringetwin::testing
