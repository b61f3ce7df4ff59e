// SPDX-License-Identifier: Apache-2.0
#include "twin/file/opencv_import.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

#include "twin/base/errors.hpp"
#include "twin/base/plain_text.hpp"
#include "twin/base/safe_file.hpp"
#include "twin/file/opencv_storage.hpp"
#include "twin/lens/linear.hpp"
#include "twin/lens/pose.hpp"
#include "twin/number/parse_number.hpp"

namespace fringetwin {
namespace {

/// Files print rotations with 6 or more digits; a matrix further from a rotation is something else.
constexpr double kRotationTolerance = 1e-5;

/// Far more than a camera matrix, distortion or pose has.
constexpr long kMostElements = 1000;
/// Characters of a sentence's list of matrices.
constexpr std::size_t kShownOfKeys = 200;

constexpr const char* kNoDistortion = "none";

const FileUse kOpencvFile{.what = "calibration", .hint = "check the path"};

/// Takes the next number off the front of `rest`, as cv::FileStorage writes them; empty at the end.
std::string_view next_element(std::string_view& rest) {
  for (;;) {
    rest.remove_prefix(std::min(rest.find_first_not_of(" \t\r\n,[]"), rest.size()));
    if (!rest.starts_with('#')) break;
    rest.remove_prefix(std::min(rest.find('\n'), rest.size()));
  }
  const std::string_view word = rest.substr(0, rest.find_first_of(" \t\r\n,[]#"));
  rest.remove_prefix(word.size());
  return word;
}

double to_element(std::string_view word, const std::string& where) {
  const std::string_view digits = word.substr(word.starts_with('+') || word.starts_with('-') ? 1 : 0);
  for (const char* special : {".Nan", ".nan", ".NaN", ".Inf", ".inf"})
    if (digits == special) throw UserError(ExitCode::input, where, "has an element that is not finite");
  const std::optional<double> value = parse_number<double>(word.substr(word.starts_with('+') ? 1 : 0));
  if (!value || !std::isfinite(*value))
    throw UserError(ExitCode::input, where, quoted_excerpt(word) + " is not a finite number",
                    "write plain numbers, not base64");
  return *value;
}

/// "M1 (3x3)"
std::string entry_label(const StoredEntry& entry) {
  return fmt::format("{} ({}x{})", entry.key, entry.rows, entry.cols);
}

std::string_view unquoted(std::string_view s) {
  const bool quoted = s.size() >= 2 && (s[0] == '"' || s[0] == '\'') && s.back() == s[0];
  return quoted ? s.substr(1, s.size() - 2) : s;
}

Eigen::MatrixXd to_matrix(const StoredEntry& entry, const std::string& where) {
  if (!entry.is_matrix()) throw UserError(ExitCode::input, where, "is not an OpenCV matrix");
  const auto rows = parse_number<int>(entry.rows), cols = parse_number<int>(entry.cols);
  const std::string_view type = unquoted(entry.dt);
  if (type.size() != 1 || std::string_view("ucwsifd").find(type[0]) == std::string_view::npos || !rows ||
      !cols || *rows < 1 || *cols < 1)
    throw UserError(ExitCode::input, where, "is not a single-channel two-dimensional matrix");
  if (long{*rows} * *cols > kMostElements)
    throw UserError(ExitCode::input, where,
                    fmt::format("is {}x{}, which no matrix of a calibration is", *rows, *cols));
  Eigen::MatrixXd matrix(*rows, *cols);
  std::string_view rest = entry.data;
  Eigen::Index n = 0;
  for (std::string_view word; !(word = next_element(rest)).empty() && n <= matrix.size(); ++n) {
    const double value = to_element(word, where);
    if (n < matrix.size()) matrix(n / *cols, n % *cols) = type == "f" ? static_cast<float>(value) : value;
  }
  if (n != matrix.size())
    throw UserError(ExitCode::input, where, "has not as many numbers as its rows and columns say");
  return matrix;
}

/// A matrix with the file that has it, and both in words.
struct FoundMatrix {
  Eigen::MatrixXd matrix;
  std::filesystem::path file;
  std::string where;
};

/// True when `name` is the whole path of the file or its end: "left.yml", "calib/left.yml".
bool names_file(std::string_view name, const std::string& file) {
  return file == name || (file.ends_with(name) && file[file.size() - name.size() - 1] == '/');
}

/// The matrix that was asked for and the files to look for it in.
struct Request {
  std::string_view name;
  std::vector<std::filesystem::path> files;
};

/// Takes the file off the front of "FILE:NAME", when it is one of the files. Names of files may have colons,
/// so each is tried.
Request parse_key(std::string_view key, const std::vector<std::filesystem::path>& files) {
  for (std::size_t colon = key.rfind(':'); colon != std::string_view::npos && colon > 0;
       colon = key.rfind(':', colon - 1)) {
    Request request{.name = key.substr(colon + 1), .files = {}};
    const std::string_view name = key.substr(0, colon);
    for (const auto& file : files)
      if (names_file(name, file.string())) request.files.push_back(file);
    // the whole path of one file may be the end of another's
    if (const auto whole = std::ranges::find(files, std::filesystem::path(name)); whole != files.end())
      request.files = {*whole};
    if (!request.files.empty()) return request;
  }
  return {.name = key, .files = files};
}

std::string joined(const std::vector<std::filesystem::path>& files) {
  std::string out;
  for (const auto& file : files) out += (out.empty() ? "" : ", ") + file.string();
  return out;
}

/// Returns the matrix `key` of the only file that has it.
FoundMatrix find_matrix(const std::vector<std::filesystem::path>& files, const std::string& key) {
  const Request request = parse_key(key, files);
  FoundMatrix out;
  std::vector<std::filesystem::path> having;
  std::string labels;
  std::size_t n_more = 0;
  for (const auto& file : request.files) {
    if (std::ranges::find(having, file) != having.end()) continue;  // named twice
    const std::string text = read_whole_text(file, kOpencvFile);
    const std::string where = fmt::format("{}: {}", file.string(), request.name);
    std::optional<StoredEntry> found;
    visit_opencv_storage(text, file, [&](const StoredEntry& entry) {
      if (entry.is_matrix()) {
        const std::string label = (labels.empty() ? "" : ", ") + entry_label(entry);
        if (labels.size() + label.size() > kShownOfKeys)
          ++n_more;
        else
          labels += label;
      }
      if (entry.key != request.name) return;
      if (found) throw UserError(ExitCode::input, where, "is given twice");
      found = entry;
    });
    if (!found) continue;
    having.push_back(file);
    if (having.size() == 1) out = {to_matrix(*found, where), file, where};
  }
  if (having.size() > 1)
    throw UserError(ExitCode::input, joined(having),
                    fmt::format("each of them has a matrix '{}'", request.name),
                    fmt::format("say which is meant: {}:{}", having.front().string(), request.name));
  if (!having.empty()) return out;
  if (n_more > 0) labels += fmt::format(" and {} more", n_more);
  throw UserError(ExitCode::input, joined(request.files),
                  fmt::format("there is no matrix '{}'", request.name),
                  "matrices there: " + (labels.empty() ? "none" : labels));
}

/// Returns image_width and image_height of the file, as OpenCV's samples of calibrations write them.
std::optional<std::array<int, 2>> stated_imagersize(const std::filesystem::path& file) {
  std::optional<int> width, height;
  const std::string text = read_whole_text(file, kOpencvFile);
  visit_opencv_storage(text, file, [&](const StoredEntry& entry) {
    if (entry.key == "image_width") width = parse_number<int>(entry.value);
    if (entry.key == "image_height") height = parse_number<int>(entry.value);
  });
  if (!width || !height) return std::nullopt;
  return std::array<int, 2>{*width, *height};
}

void append_camera_matrix(const Eigen::MatrixXd& M, const std::string& where,
                          std::vector<double>* intrinsics) {
  if (M.rows() != 3 || M.cols() != 3)
    throw UserError(ExitCode::input, where,
                    fmt::format("a camera matrix is 3x3, this is {}x{}", M.rows(), M.cols()));
  const bool last_row_ok = M(2, 0) == 0.0 && M(2, 1) == 0.0 && M(2, 2) == 1.0;
  if (!last_row_ok || M(1, 0) != 0.0 || !(M(0, 0) > 0.0) || !(M(1, 1) > 0.0))
    throw UserError(ExitCode::input, where, "is not a camera matrix [fx 0 cx; 0 fy cy; 0 0 1]");
  if (M(0, 1) != 0.0)
    throw UserError(ExitCode::input, where,
                    fmt::format("has skew {:g}, which no OpenCV lens model has", M(0, 1)));
  intrinsics->insert(intrinsics->end(), {M(0, 0), M(1, 1), M(0, 2), M(1, 2)});
}

std::string append_distortion(const Eigen::MatrixXd& D, const std::string& where,
                              std::vector<double>* intrinsics) {
  if (D.rows() != 1 && D.cols() != 1)
    throw UserError(
        ExitCode::input, where,
        fmt::format("distortion coefficients are one row or column, this is {}x{}", D.rows(), D.cols()));
  Eigen::Index n = D.size();  // in one row or column, so D(i) is the i-th
  if (n == 14) {              // OpenCV writes 14 for the rational model, too; the tilt is then zero
    if (D(12) != 0.0 || D(13) != 0.0)
      throw UserError(ExitCode::input, where, "has a tilted sensor (coefficients 13 and 14)",
                      "calibrate without CALIB_TILTED_MODEL");
    n = 12;
  }
  if (n != 4 && n != 5 && n != 8 && n != 12)
    throw UserError(ExitCode::input, where, fmt::format("has {} distortion coefficients", n),
                    "4, 5, 8, 12 (or 14 without tilt) are known");
  for (Eigen::Index i = 0; i < n; ++i) intrinsics->push_back(D(i));
  return "LENSMODEL_OPENCV" + std::to_string(n);
}

Eigen::Vector3d to_vector(const Eigen::MatrixXd& m, const std::string& where) {
  if (m.size() != 3)
    throw UserError(ExitCode::input, where,
                    fmt::format("must have 3 elements, is {}x{}", m.rows(), m.cols()));
  return {m(0), m(1), m(2)};
}

/// A 3x3 rotation matrix (rounded to the nearest rotation) or a Rodrigues vector.
Eigen::Vector3d to_rotation_vector(const Eigen::MatrixXd& m, const std::string& where) {
  if (m.size() == 3) return to_vector(m, where);
  if (m.rows() != 3 || m.cols() != 3)
    throw UserError(
        ExitCode::input, where,
        fmt::format("a rotation is a 3x3 matrix or 3 elements, this is {}x{}", m.rows(), m.cols()));
  const Eigen::Matrix3d R = m;
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
  const FoundMatrix M = find_matrix(files, device.matrix_key);
  append_camera_matrix(M.matrix, M.where, &model.intrinsics);
  model.matrix_file = M.file;
  model.stated_imagersize_px = stated_imagersize(M.file);
  model.lensmodel = "LENSMODEL_PINHOLE";
  if (device.distortion_key != kNoDistortion) {
    const FoundMatrix D = find_matrix(files, device.distortion_key);
    model.lensmodel = append_distortion(D.matrix, D.where, &model.intrinsics);
  }

  RotTrans rt = RotTrans::Zero();
  if (!device.rotation_key.empty()) {
    const FoundMatrix R = find_matrix(files, device.rotation_key);
    rt.head<3>() = to_rotation_vector(R.matrix, R.where);
  }
  if (!device.translation_key.empty()) {
    const FoundMatrix T = find_matrix(files, device.translation_key);
    rt.tail<3>() = to_vector(T.matrix, T.where);
  }
  Eigen::Map<RotTrans>(model.rt_device_ref.data()) = rt;
  return model;
}

std::vector<std::string> list_opencv_keys(const std::filesystem::path& file) {
  const std::string text = read_whole_text(file, kOpencvFile);
  std::vector<std::string> keys;
  visit_opencv_storage(text, file, [&](const StoredEntry& entry) {
    if (entry.is_matrix()) keys.push_back(entry_label(entry));
  });
  return keys;
}

}  // namespace fringetwin
