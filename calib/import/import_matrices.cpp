// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <sstream>

#include "calib/import/imported_rig.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/plain_text.hpp"
#include "twin/base/safe_file.hpp"
#include "twin/lens/linear.hpp"
#include "twin/number/parse_number.hpp"

namespace fringetwin::calib {
namespace {

constexpr double kRotationTolerance = 1e-5;  // files print six digits or more
constexpr std::size_t kMostNumbers = 64;     // the largest matrix, a 4x4 pose, has 16

Eigen::MatrixXd read_matrix(const std::filesystem::path& file) {
  std::istringstream in(read_whole_text(file, {.what = "file of numbers", .hint = "check the path"}));
  std::vector<std::vector<double>> rows;
  std::size_t n_numbers = 0;
  int line_number = 0;
  for (std::string line; std::getline(in, line);) {
    ++line_number;
    line = line.substr(0, line.find('#'));
    for (char& c : line)
      if (std::string_view(",;[]()\t\r").find(c) != std::string_view::npos) c = ' ';
    std::istringstream words(line);
    std::vector<double> row;
    for (std::string word; words >> word;) {
      const std::optional<double> value =
          parse_number<double>(std::string_view(word).substr(word[0] == '+' ? 1 : 0));
      if (!value || !std::isfinite(*value))
        throw UserError(ExitCode::input, fmt::format("{}:{}", file.string(), line_number),
                        quoted_excerpt(word) + " is not a finite number",
                        "write plain numbers, as numpy.savetxt does");
      if (++n_numbers > kMostNumbers)
        throw UserError(ExitCode::input, fmt::format("{}:{}", file.string(), line_number),
                        fmt::format("holds more than {} numbers, no matrix of a calibration", kMostNumbers));
      row.push_back(*value);
    }
    if (row.empty()) continue;
    if (!rows.empty() && row.size() != rows[0].size())
      throw UserError(ExitCode::input, fmt::format("{}:{}", file.string(), line_number),
                      fmt::format("has {} numbers, the rows above have {}", row.size(), rows[0].size()));
    rows.push_back(std::move(row));
  }
  if (rows.empty()) throw UserError(ExitCode::input, file.string(), "holds no numbers");
  Eigen::MatrixXd m(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(rows[0].size()));
  for (Eigen::Index r = 0; r < m.rows(); ++r)
    for (Eigen::Index c = 0; c < m.cols(); ++c) m(r, c) = rows[r][c];
  return m;
}

std::vector<double> core_of(const Eigen::MatrixXd& K, const std::string& where) {
  if (K.rows() != 3 || K.cols() != 3)
    throw UserError(ExitCode::input, where,
                    fmt::format("a camera matrix is 3x3, this is {}x{}", K.rows(), K.cols()));
  if (K(2, 0) != 0.0 || K(2, 1) != 0.0 || K(2, 2) != 1.0 || K(1, 0) != 0.0 || !(K(0, 0) > 0.0) ||
      !(K(1, 1) > 0.0))
    throw UserError(
        ExitCode::input, where, "is not a camera matrix [fx 0 cx; 0 fy cy; 0 0 1]",
        K(0, 2) == 0.0 && K(2, 0) != 0.0 ? "it looks transposed (MATLAB's IntrinsicMatrix is)" : "");
  if (K(0, 1) != 0.0)
    throw UserError(ExitCode::input, where,
                    fmt::format("has skew {:g}, which no OpenCV lens model has", K(0, 1)));
  return {K(0, 0), K(1, 1), K(0, 2), K(1, 2)};
}

void append_distortion(const Eigen::MatrixXd& D, const std::string& where, ImportedDevice& out) {
  if (D.rows() != 1 && D.cols() != 1)
    throw UserError(
        ExitCode::input, where,
        fmt::format("distortion coefficients are one row or column, this is {}x{}", D.rows(), D.cols()));
  Eigen::Index n = D.size();
  if (n == 14 && D(12) == 0.0 && D(13) == 0.0) n = 12;
  if (n != 4 && n != 5 && n != 8 && n != 12)
    throw UserError(ExitCode::input, where, fmt::format("has {} distortion coefficients", n),
                    "4, 5, 8, 12 (or 14 without tilt) are known, in OpenCV's order k1 k2 p1 p2 k3 ...");
  for (Eigen::Index i = 0; i < n; ++i) out.intrinsics.push_back(D(i));
  out.lensmodel = fmt::format("LENSMODEL_OPENCV{}", n);
}

}  // namespace

Eigen::Matrix3d checked_rotation(const Eigen::Matrix3d& R, const std::string& where) {
  const double deviation = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(deviation <= kRotationTolerance) || !(R.determinant() > 0.0))
    throw UserError(
        ExitCode::input, where,
        fmt::format("is no rotation: determinant {:.6g}, |R^T R - I| = {:.3g}", R.determinant(), deviation));
  return nearest_rotation(R);
}

ImportedDevice import_matrices(const MatrixFiles& files, double mm_per_unit) {
  ImportedDevice out;
  for (const auto& file : {files.camera_matrix, files.distortion, files.rotation, files.translation})
    if (!file.empty()) out.where += (out.where.empty() ? "" : ", ") + file.string();
  out.intrinsics = core_of(read_matrix(files.camera_matrix), files.camera_matrix.string());
  out.lensmodel = "LENSMODEL_PINHOLE";
  if (!files.distortion.empty())
    append_distortion(read_matrix(files.distortion), files.distortion.string(), out);
  if (files.rotation.empty()) return out;
  const std::string where = files.rotation.string();
  const Eigen::MatrixXd R = read_matrix(files.rotation);
  const bool with_translation = R.cols() == 4 && (R.rows() == 3 || R.rows() == 4);
  if (R.size() == 3)
    out.T_device_ref.rotation = rotation_from_vector(Eigen::Vector3d(R(0), R(1), R(2)));
  else if ((R.rows() == 3 && R.cols() == 3) || with_translation)
    out.T_device_ref.rotation = checked_rotation(R.topLeftCorner<3, 3>(), where);
  else
    throw UserError(
        ExitCode::input, where,
        fmt::format("a rotation is 3x3, 3 numbers, 3x4 or 4x4, this is {}x{}", R.rows(), R.cols()));
  if (R.rows() == 4 && R.row(3) != Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0))
    throw UserError(ExitCode::input, where, "has another last row than 0 0 0 1");
  if (with_translation == !files.translation.empty())
    throw UserError(
        ExitCode::input, where,
        with_translation ? "holds a translation, and a file of it is named, too" : "holds no translation",
        with_translation ? "leave the second out" : "name its file after the rotation's");
  if (with_translation) {
    out.T_device_ref.translation_mm = mm_per_unit * R.topRightCorner<3, 1>();
    return out;
  }
  const Eigen::MatrixXd t = read_matrix(files.translation);
  if (t.size() != 3)
    throw UserError(ExitCode::input, files.translation.string(),
                    fmt::format("a translation has 3 numbers, this is {}x{}", t.rows(), t.cols()));
  out.T_device_ref.translation_mm = mm_per_unit * Eigen::Vector3d(t(0), t(1), t(2));
  return out;
}

}  // namespace fringetwin::calib
