// SPDX-License-Identifier: Apache-2.0
// Forty calibrations of the paper's rig (three devices, 25 boards, 0.1 px noise): do they scatter as each of
// them says?
//
// | check               | tolerance         | origin                                 |
// |---------------------|-------------------|----------------------------------------|
// | rms error of fx     | 0.30 px           | 0.25 for a correct joint solve, ± 11 % |
// | shape, L+R and L+P  | 0.0025, 0.0040 mm | 0.0020 and 0.0032 for the same         |
// | scatter / predicted | 1 ± 0.34          | 3 standard errors of an rms of 40      |
// | chi2 / 1440 numbers | 1 ± 0.14          | 3 standard errors + 0.03: sigma from residuals |
// | share of the noise  | 1, 0 ± 0.1        | 2000 corners in each device            |
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "calib/solve/calibrate.hpp"
#include "calib/solve/uncertainty.hpp"
#include "tests/support/calib/calib_draws.hpp"
#include "tests/support/calib/calib_rig.hpp"

namespace fringetwin::calib::scatter_test {
namespace {

using testing::draw_observations;
using testing::shape_error_mm;

struct Rms {
  double sum = 0.0;
  int n = 0;
  void add(double v) { sum += v * v, ++n; }
  double value() const { return std::sqrt(sum / n); }
};

TEST(Scatter, FortyDrawsScatterAsPredicted) {
  const testing::TrueRig rig = testing::true_paper_rig();
  const std::vector<Eigen::Vector3d> points = testing::volume(rig);
  std::mt19937_64 random(5);
  CalibrateOptions options;
  options.regularize = false;
  Rms fx[3], fx_sigma[3], translation[2], translation_sigma[2], shape[2], shape_sigma[2];
  constexpr std::array<std::pair<int, int>, 3> kPairs{{{0, 1}, {0, 2}, {1, 2}}};
  Rms baseline[3], baseline_sigma[3];
  constexpr int kDraws = 40;
  for (int draw = 0; draw < kDraws; ++draw) {
    const Calibration c = calibrate(draw_observations(rig, random), options);
    const Uncertainty uncertainty(c);
    for (int d = 0; d < 3; ++d) {
      fx[d].add(c.devices[static_cast<std::size_t>(d)].intrinsics[0] -
                rig.lenses[static_cast<std::size_t>(d)].intrinsics()[0]);
      fx_sigma[d].add(std::sqrt(uncertainty.intrinsics(d)(0, 0)));
    }
    for (std::size_t p = 0; p < kPairs.size(); ++p) {
      const auto [a, b] = kPairs[p];
      const auto length_mm = [&, a = a, b = b](const auto& pose) {
        return (pose(a) * pose(b).inverse()).translation_mm.norm();
      };
      baseline[p].add(length_mm([&](int d) { return c.devices[static_cast<std::size_t>(d)].T_device_ref; }) -
                      length_mm([&](int d) { return rig.T_device_ref[static_cast<std::size_t>(d)]; }));
      baseline_sigma[p].add(uncertainty.baseline_sigma_mm(a, b));
    }
    for (int d = 1; d < 3; ++d) {
      const auto k = static_cast<std::size_t>(d);
      const Eigen::Vector3d error =
          c.devices[k].T_device_ref.translation_mm - rig.T_device_ref[k].translation_mm;
      translation[d - 1].add(error.norm());
      translation_sigma[d - 1].add(std::sqrt(uncertainty.extrinsics(d).bottomRightCorner<3, 3>().trace()));
      shape[d - 1].add(shape_error_mm(rig, c, k));
      shape_sigma[d - 1].add(aligned_shape_sigma_mm(points, uncertainty.points(points, {{0}, {d}})));
    }
  }
  constexpr double kThreeErrors = 0.34;  // 3 / sqrt(2 * 40)
  for (int d = 0; d < 3; ++d) {
    std::printf("fx of device %d: scatter %.3f px, predicted %.3f px\n", d, fx[d].value(),
                fx_sigma[d].value());
    EXPECT_LE(fx[d].value(), 0.30);
    EXPECT_NEAR(fx[d].value() / fx_sigma[d].value(), 1.0, kThreeErrors);
  }
  for (std::size_t p = 0; p < kPairs.size(); ++p) {
    std::printf("baseline %zu: scatter %.4f mm, predicted %.4f\n", p, baseline[p].value(),
                baseline_sigma[p].value());
    EXPECT_NEAR(baseline[p].value() / baseline_sigma[p].value(), 1.0, kThreeErrors) << p;
  }
  for (int k = 0; k < 2; ++k) {
    std::printf("t of device %d: scatter %.4f mm, predicted %.4f; shape %.5f mm, predicted %.5f\n", k + 1,
                translation[k].value(), translation_sigma[k].value(), shape[k].value(),
                shape_sigma[k].value());
    EXPECT_NEAR(translation[k].value() / translation_sigma[k].value(), 1.0, kThreeErrors);
    EXPECT_NEAR(shape[k].value() / shape_sigma[k].value(), 1.0, kThreeErrors);
  }
  EXPECT_LE(shape[0].value(), 0.0025);
  EXPECT_LE(shape[1].value(), 0.0040);
}

Eigen::VectorXd parameters(const std::vector<std::vector<double>>& intrinsics,
                           const std::vector<Pose>& T_device_ref) {
  std::vector<double> all;
  for (std::size_t d = 0; d < intrinsics.size(); ++d) {
    all.insert(all.end(), intrinsics[d].begin(), intrinsics[d].end());
    const RotTrans rt = rt_from_pose(T_device_ref[d]);
    if (d > 0) all.insert(all.end(), rt.data(), rt.data() + 6);
  }
  return Eigen::VectorXd::Map(all.data(), static_cast<Eigen::Index>(all.size()));
}

TEST(Scatter, TheWholeRigAlsoWhenTheProjectorIsReadAtTheCamerasCorners) {
  constexpr int kDraws = 40;
  for (const testing::ProjectorCorners kind : {testing::ProjectorCorners::measured_by_itself,
                                               testing::ProjectorCorners::read_at_the_cameras_corners}) {
    testing::CalibrationDraws draws(kind);
    const Uncertainty uncertainty(draws.first());
    EXPECT_NEAR(uncertainty.shared(), kind == testing::ProjectorCorners::measured_by_itself ? 0.0 : 1.0, 0.1);
    std::vector<std::vector<double>> true_lenses;
    for (const Lens& lens : draws.rig().lenses) true_lenses.push_back(lens.intrinsics());
    const Eigen::VectorXd truth = parameters(true_lenses, draws.rig().T_device_ref);
    Calibration unaware = draws.first();
    unaware.observations.devices[2].is_projector = false;
    testing::Scatter scatter(uncertainty.rig()), naive(Uncertainty(unaware).rig());
    for (int draw = 0; draw < kDraws; ++draw) {
      const Calibration c = draws.next();
      std::vector<Pose> poses;
      for (const auto& device : c.devices) poses.push_back(device.T_device_ref);
      const Eigen::VectorXd error = parameters(c.problem.intrinsics, poses) - truth;
      scatter.add(error);
      naive.add(error);
    }
    scatter.expect_as_predicted(kind == testing::ProjectorCorners::measured_by_itself ? "rig"
                                                                                      : "rig, shared noise");
    std::printf("as if the projector's corners were independent: chi2 %.1f of %.0f; rms / sigma", naive.chi2,
                naive.n);
    for (Eigen::Index i = 0; i < naive.sum_sq.size(); ++i)
      std::printf(" %.2f", std::sqrt(naive.sum_sq[i] / naive.draws / naive.covariance(i, i)));
    std::printf("\n");
  }
}

}  // namespace
}  // namespace fringetwin::calib::scatter_test
