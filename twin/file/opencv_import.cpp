// SPDX-License-Identifier: Apache-2.0
#include "twin/file/opencv_import.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <opencv2/core.hpp>
#include <opencv2/core/persistence.hpp>

#include "twin/base/errors.hpp"
#include "twin/base/not_copyable.hpp"
#include "twin/lens/linear.hpp"
#include "twin/lens/pose.hpp"

namespace fringetwin {
namespace {

/// Files print rotations with 6 or more digits; a matrix further from a rotation is something else.
constexpr double kRotationTolerance = 1e-5;

/// OpenCV prints its own report on stderr before it throws; ours is enough.
class SilentOpenCv : NotCopyable {
 public:
  SilentOpenCv() : previous_(cv::redirectError(ignore)) {}
  ~SilentOpenCv() { cv::redirectError(previous_); }

 private:
  static int ignore(int, const char*, const char*, const char*, int, void*) { return 0; }
  cv::ErrorCallback previous_;
};

cv::FileStorage open_storage(const std::filesystem::path& file) {
  if (!std::filesystem::is_regular_file(file))
    throw UserError(ExitCode::input, file.string(), "there is no such calibration file");
  const SilentOpenCv silent;
  cv::FileStorage storage;
  std::string reason = "not a YAML, XML or JSON file";
  bool opened = false;
  try {
    opened = storage.open(file.string(), cv::FileStorage::READ);
  } catch (const cv::Exception& e) {
    reason = e.err;
  }
  if (!opened)
    throw UserError(ExitCode::input, file.string(), "OpenCV cannot read the calibration: " + reason);
  return storage;
}

bool is_matrix(const cv::FileNode& node) {
  return node.isMap() && !node["data"].empty() && !node["dt"].empty();
}

cv::Mat to_matrix(const cv::FileNode& node, const std::string& where) {
  const SilentOpenCv silent;
  try {
    return node.mat();
  } catch (const cv::Exception&) {
    throw UserError(ExitCode::input, where, "has not as many numbers as its rows and columns say");
  }
}

/// Returns the matrix `key` of the first file that has it, as doubles; `where` = file and key.
cv::Mat1d find_matrix(const std::vector<std::filesystem::path>& files, const std::string& key,
                      std::string* where) {
  for (const auto& file : files) {
    const cv::FileStorage storage = open_storage(file);
    const cv::FileNode node = storage[key];
    if (node.empty()) continue;
    *where = file.string() + ": " + key;
    if (!is_matrix(node)) throw UserError(ExitCode::input, *where, "is not an OpenCV matrix");
    const cv::Mat matrix = to_matrix(node, *where);
    if (matrix.channels() != 1 || matrix.dims != 2 || matrix.empty())
      throw UserError(ExitCode::input, *where, "is not a single-channel two-dimensional matrix");
    cv::Mat1d converted;
    matrix.convertTo(converted, CV_64F);
    if (!cv::checkRange(converted, true))
      throw UserError(ExitCode::input, *where, "has an element that is not finite");
    return converted;
  }
  std::string names, keys;
  for (const auto& file : files) {
    names += (names.empty() ? "" : ", ") + file.string();
    for (const std::string& k : list_opencv_keys(file)) keys += (keys.empty() ? "" : ", ") + k;
  }
  throw UserError(ExitCode::input, names, fmt::format("there is no matrix '{}'", key),
                  "matrices there: " + (keys.empty() ? "none" : keys));
}

void append_camera_matrix(const cv::Mat1d& M, const std::string& where, std::vector<double>* intrinsics) {
  if (M.rows != 3 || M.cols != 3)
    throw UserError(ExitCode::input, where,
                    fmt::format("a camera matrix is 3x3, this is {}x{}", M.rows, M.cols));
  const bool last_row_ok = M(2, 0) == 0.0 && M(2, 1) == 0.0 && M(2, 2) == 1.0;
  if (!last_row_ok || M(1, 0) != 0.0 || !(M(0, 0) > 0.0) || !(M(1, 1) > 0.0))
    throw UserError(ExitCode::input, where, "is not a camera matrix [fx 0 cx; 0 fy cy; 0 0 1]");
  if (M(0, 1) != 0.0)
    throw UserError(ExitCode::input, where,
                    fmt::format("has skew {:g}, which no OpenCV lens model has", M(0, 1)));
  intrinsics->insert(intrinsics->end(), {M(0, 0), M(1, 1), M(0, 2), M(1, 2)});
}

std::string append_distortion(const cv::Mat1d& D, const std::string& where, std::vector<double>* intrinsics) {
  if (D.rows != 1 && D.cols != 1)
    throw UserError(
        ExitCode::input, where,
        fmt::format("distortion coefficients are one row or column, this is {}x{}", D.rows, D.cols));
  int n = static_cast<int>(D.total());
  const cv::Mat1d k = D.reshape(1, 1);
  if (n == 14) {  // OpenCV writes 14 for the rational model, too; the tilt is then zero
    if (k(0, 12) != 0.0 || k(0, 13) != 0.0)
      throw UserError(ExitCode::input, where, "has a tilted sensor (coefficients 13 and 14)",
                      "calibrate without CALIB_TILTED_MODEL");
    n = 12;
  }
  if (n != 4 && n != 5 && n != 8 && n != 12)
    throw UserError(ExitCode::input, where, fmt::format("has {} distortion coefficients", n),
                    "4, 5, 8, 12 (or 14 without tilt) are known");
  for (int i = 0; i < n; ++i) intrinsics->push_back(k(0, i));
  return "LENSMODEL_OPENCV" + std::to_string(n);
}

Eigen::Vector3d to_vector(const cv::Mat1d& m, const std::string& where) {
  if (m.total() != 3)
    throw UserError(ExitCode::input, where, fmt::format("must have 3 elements, is {}x{}", m.rows, m.cols));
  const cv::Mat1d row = m.reshape(1, 1);
  return {row(0, 0), row(0, 1), row(0, 2)};
}

/// A 3x3 rotation matrix (rounded to the nearest rotation) or a Rodrigues vector.
Eigen::Vector3d to_rotation_vector(const cv::Mat1d& m, const std::string& where) {
  if (m.total() == 3) return to_vector(m, where);
  if (m.rows != 3 || m.cols != 3)
    throw UserError(ExitCode::input, where,
                    fmt::format("a rotation is a 3x3 matrix or 3 elements, this is {}x{}", m.rows, m.cols));
  Eigen::Matrix3d R;
  for (int row = 0; row < 3; ++row)
    for (int col = 0; col < 3; ++col) R(row, col) = m(row, col);
  const double deviation = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  const double determinant = R.determinant();
  if (!(deviation <= kRotationTolerance) || !(determinant > 0.0))
    throw UserError(
        ExitCode::input, where,
        fmt::format("is no rotation: determinant {:.6g}, |R^T R - I| = {:.3g}", determinant, deviation));
  return vector_from_rotation(nearest_rotation(R));
}

}  // namespace

OpenCvModel import_opencv(const std::vector<std::filesystem::path>& files, const OpenCvDevice& device) {
  OpenCvModel model;
  std::string where;
  const cv::Mat1d M = find_matrix(files, device.matrix_key, &where);
  append_camera_matrix(M, where, &model.intrinsics);
  const cv::Mat1d D = find_matrix(files, device.distortion_key, &where);
  model.lensmodel = append_distortion(D, where, &model.intrinsics);

  RotTrans rt = RotTrans::Zero();
  if (!device.rotation_key.empty()) {
    const cv::Mat1d R = find_matrix(files, device.rotation_key, &where);
    rt.head<3>() = to_rotation_vector(R, where);
  }
  if (!device.translation_key.empty()) {
    const cv::Mat1d T = find_matrix(files, device.translation_key, &where);
    rt.tail<3>() = to_vector(T, where);
  }
  Eigen::Map<RotTrans>(model.rt_device_ref.data()) = rt;
  return model;
}

std::vector<std::string> list_opencv_keys(const std::filesystem::path& file) {
  const cv::FileStorage storage = open_storage(file);
  std::vector<std::string> keys;
  for (const cv::FileNode& node : storage.root())
    if (is_matrix(node))
      keys.push_back(fmt::format("{} ({}x{})", node.name(), static_cast<int>(node["rows"]),
                                 static_cast<int>(node["cols"])));
  return keys;
}

}  // namespace fringetwin
