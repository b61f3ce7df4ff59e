// SPDX-License-Identifier: Apache-2.0
#include "compare/verdict/calibration_covariance.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "report/json_file.hpp"
#include "twin/base/errors.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::compare {
namespace {

using ReadJson = nlohmann::json;

/// Relative to the sigmas: rounding of a solve with many views is far below.
constexpr double kAsymmetry = 1e-6, kNegative = 1e-6;
constexpr double kLargestVariance = 1e18;     ///< sigmas as large as any number of a twin may be
constexpr double kSmallestDirection = 1e-12;  ///< of the largest eigenvalue

// Order and names: calib/page/calibration_json.cpp.
constexpr std::array<const char*, 16> kLens = {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2",
                                               "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4"};
constexpr std::array<const char*, 6> kPose = {"r1", "r2", "r3", "t1", "t2", "t3"};

/// The place in a twin that a parameter like "left.fx" changes.
struct Target {
  std::size_t device = 0;  ///< camera; their number: the projector
  bool is_pose = false;
  std::size_t index = 0;
};

template <std::size_t n>
std::size_t index_of(const std::array<const char*, n>& names, const std::string& name) {
  return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
}

std::size_t find_device(const Twin& twin, const std::string& name) {
  for (std::size_t c = 0; c < twin.cameras.size(); ++c)
    if (twin.cameras[c].name == name) return c;
  return twin.projector && name == "projector" ? twin.cameras.size() : twin.cameras.size() + 1;
}

std::string device_names(const Twin& twin) {
  std::string names;
  for (const Camera& camera : twin.cameras) names += (names.empty() ? "" : ", ") + camera.name;
  return names + (twin.projector ? ", projector" : "");
}

Target find_target(const Twin& twin, const std::string& file, const std::string& parameter) {
  const auto dot = parameter.rfind('.');
  const std::string key = fmt::format("covariance.parameters: \"{}\"", parameter.substr(0, 60));
  const std::string device = parameter.substr(0, dot);
  Target target{.device = find_device(twin, device)};
  if (dot == std::string::npos || target.device > twin.cameras.size())
    throw UserError(ExitCode::input, file, key + " names no device of the twin (" + device_names(twin) + ")",
                    "calibrate with the twin's names (--names; the projector is \"projector\")");
  const std::string name = parameter.substr(dot + 1);
  target.index = index_of(kPose, name);
  target.is_pose = target.index < kPose.size();
  if (target.is_pose && target.device == 0)
    throw UserError(ExitCode::input, file,
                    key + " is a pose of the twin's first camera, which is the reference of all poses",
                    "name that camera first when calibrating");
  if (target.is_pose) return target;
  target.index = index_of(kLens, name);
  const Lens& lens =
      target.device < twin.cameras.size() ? twin.cameras[target.device].lens : twin.projector->lens;
  if (target.index >= std::min(kLens.size(), lens.intrinsics().size()))
    throw UserError(ExitCode::input, file,
                    fmt::format("{} is no parameter of the {} that the twin has there", key, lens.model()),
                    "use the lens models of this calibration in the twin");
  return target;
}

[[noreturn]] void refuse(const CalibrationCovariance& c, const std::string& what) {
  throw UserError(ExitCode::input, c.file.string(), what,
                  "give the calibration.json that `fringetwin calibrate` wrote");
}

ReadJson load(const CalibrationCovariance& c) {
  ReadJson json = report::read_json_file(
      c.file, {.what = "calibration", .hint = "give the calibration.json that `fringetwin calibrate` wrote"});
  if (!json.is_object() || !json.contains("schema") || json["schema"] != "fringetwin-calibration/1")
    refuse(c, "schema: this is no fringetwin calibration (fringetwin-calibration/1)");
  return json;
}

Eigen::MatrixXd read_matrix(const CalibrationCovariance& c, const ReadJson& rows) {
  const std::size_t n = c.parameters.size();
  const auto wrong_size = [&] {
    refuse(c, fmt::format("covariance.matrix must be {} x {}, as there are parameters", n, n));
  };
  if (!rows.is_array() || rows.size() != n) wrong_size();
  Eigen::MatrixXd m(n, n);
  for (std::size_t i = 0; i < n; ++i) {
    if (!rows[i].is_array() || rows[i].size() != n) wrong_size();
    for (std::size_t j = 0; j < n; ++j) {
      if (!rows[i][j].is_number()) refuse(c, fmt::format("covariance.matrix[{}][{}] is no number", i, j));
      m(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = rows[i][j].get<double>();
    }
  }
  return m;
}

/// Returns one over each parameter's own sigma; zero where it has none.
Eigen::VectorXd inverse_sigmas(const Eigen::MatrixXd& m) {
  return m.diagonal().unaryExpr([](double v) { return v > 0.0 ? 1.0 / std::sqrt(v) : 0.0; });
}

void check_covariance(const CalibrationCovariance& c) {
  const Eigen::MatrixXd& m = c.matrix;
  for (Eigen::Index i = 0; i < m.rows(); ++i) {
    if (m(i, i) > kLargestVariance)
      refuse(c,
             fmt::format("covariance.matrix[{}][{}] is {}, more than {}", i, i, m(i, i), kLargestVariance));
    if (!(m(i, i) >= 0.0)) refuse(c, fmt::format("covariance.matrix[{}][{}] is a negative variance", i, i));
    for (Eigen::Index j = 0; j < i; ++j) {
      const double scale = std::sqrt(m(i, i) * m(j, j));
      if (!(std::abs(m(i, j) - m(j, i)) <= kAsymmetry * scale))
        refuse(c, fmt::format("covariance.matrix is not symmetric at [{}][{}]", i, j));
      if (!(std::abs(m(i, j)) <= (1.0 + kNegative) * scale))
        refuse(c, fmt::format("covariance.matrix is no covariance: [{}][{}] is {} and the variances allow {}",
                              i, j, m(i, j), scale));
    }
  }
  const Eigen::VectorXd scale = inverse_sigmas(m);
  const SymmetricEigen eigen = symmetric_eigen(scale.asDiagonal() * m * scale.asDiagonal());
  if (eigen.values[0] < -kNegative * eigen.values[m.rows() - 1])
    refuse(c, "covariance.matrix is no covariance: some combination of parameters has a negative variance");
}

Lens changed_lens(const Lens& lens, std::size_t index, double change, const std::string& where) {
  std::vector<double> intrinsics = lens.intrinsics();
  intrinsics.at(index) += change;
  return Lens(lens.model(), intrinsics, {lens.width(), lens.height()}, where);
}

}  // namespace

CalibrationCovariance read_calibration_covariance(const Twin& twin) {
  CalibrationCovariance out;
  out.file = twin.calibration_uncertainty.value();
  const ReadJson json = load(out);
  if (!json.contains("covariance") || !json["covariance"].is_object())
    refuse(out, "covariance is missing or null (splined lenses have none)");
  const ReadJson& covariance = json["covariance"];
  if (!covariance.contains("parameters") || !covariance["parameters"].is_array() ||
      covariance["parameters"].empty())
    refuse(out, "covariance.parameters is missing or empty");
  std::set<std::string> seen;
  for (const ReadJson& name : covariance["parameters"]) {
    if (!name.is_string()) refuse(out, "covariance.parameters must be texts such as \"left.fx\"");
    out.parameters.push_back(name.get<std::string>());
    find_target(twin, out.file.string(), out.parameters.back());
    if (!seen.insert(out.parameters.back()).second)
      refuse(out, fmt::format("covariance.parameters: \"{}\" is there twice", out.parameters.back()));
  }
  const bool has_devices = json.contains("devices");
  if (has_devices && (!json["devices"].is_array() || json["devices"].empty()))
    refuse(out, "devices must be a list with an entry for each device");
  const ReadJson none;
  const ReadJson& first = has_devices ? json["devices"][0] : none;
  if (first.is_object() && (!first.contains("name") || first["name"] != twin.cameras[0].name))
    refuse(out,
           fmt::format("devices[0].name, the reference of the poses, must be the twin's first camera \"{}\"",
                       twin.cameras[0].name));
  if (!covariance.contains("matrix")) refuse(out, "covariance.matrix is missing");
  out.matrix = read_matrix(out, covariance["matrix"]);
  check_covariance(out);
  return out;
}

Twin with_rig_change(const Twin& twin, const CalibrationCovariance& covariance,
                     const Eigen::VectorXd& change) {
  FT_CHECK(static_cast<std::size_t>(change.size()) == covariance.parameters.size(), "one change each");
  Twin out = twin;
  const Pose T_ref_world = twin.cameras[0].T_cam_world;
  std::vector<RotTrans> pose_change(twin.cameras.size() + 1, RotTrans::Zero());
  for (std::size_t k = 0; k < covariance.parameters.size(); ++k) {
    const double d = change[k];
    const std::string& name = covariance.parameters[k];
    const Target target = find_target(twin, covariance.file.string(), name);
    if (target.is_pose) {
      pose_change[target.device][target.index] += d;
      continue;
    }
    const bool is_camera = target.device < out.cameras.size();
    Lens& lens = is_camera ? out.cameras[target.device].lens : out.projector->lens;
    // focal lengths and principal point are of the whole sensor, the lens is of the camera's image
    const double side_px = is_camera && target.index < 4 ? out.cameras[target.device].pixel_side_px() : 1.0;
    lens = changed_lens(lens, target.index, side_px * d,
                        covariance.file.string() + ": the lens as changed by " + name);
  }
  for (std::size_t device = 1; device < pose_change.size(); ++device) {
    if (pose_change[device].isZero(0.0)) continue;
    Pose& T_device_world =
        device < out.cameras.size() ? out.cameras[device].T_cam_world : out.projector->T_proj_world;
    const RotTrans rt = rt_from_pose(T_device_world * T_ref_world.inverse()) + pose_change[device];
    T_device_world = pose_from_rt(rt) * T_ref_world;
  }
  return out;
}

Eigen::MatrixXd one_sigma_changes(const Eigen::MatrixXd& m) {
  const Eigen::VectorXd scale = inverse_sigmas(m), sigma = m.diagonal().cwiseMax(0.0).cwiseSqrt();
  const SymmetricEigen eigen = symmetric_eigen(scale.asDiagonal() * m * scale.asDiagonal());
  const double least = kSmallestDirection * eigen.values[m.rows() - 1];
  Eigen::MatrixXd out(m.rows(), 0);
  for (Eigen::Index i = m.rows() - 1; i >= 0; --i) {
    if (!(eigen.values[i] > least)) continue;
    out.conservativeResize(Eigen::NoChange, out.cols() + 1);
    out.col(out.cols() - 1) = std::sqrt(eigen.values[i]) * sigma.cwiseProduct(eigen.vectors.col(i));
  }
  return out;
}

std::vector<Twin> one_sigma_away(const Twin& twin, const CalibrationCovariance& covariance) {
  const Eigen::MatrixXd changes = one_sigma_changes(covariance.matrix);
  std::vector<Twin> out;
  for (Eigen::Index i = 0; i < changes.cols(); ++i)
    out.push_back(with_rig_change(twin, covariance, changes.col(i)));
  return out;
}

}  // namespace fringetwin::compare
