// SPDX-License-Identifier: Apache-2.0
#include "calib/import/check_import.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>
#include <map>
#include <sstream>

#include "calib/board/corners_vnl.hpp"
#include "calib/solve/triangulate.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/plain_text.hpp"
#include "twin/base/safe_file.hpp"
#include "twin/lens/lens.hpp"
#include "twin/number/parse_number.hpp"

namespace fringetwin::calib {
namespace {

constexpr std::size_t kMinPoints = 8;
constexpr double kInFront = 0.9;

std::optional<double> to_number(const std::string& word) {
  if (word == "-" || word == "nan" || word == "NaN") return std::nan("");
  const std::optional<double> value = parse_number<double>(word);
  return value && !std::isinf(*value) ? value : std::nullopt;
}

Correspondences read_table(const std::filesystem::path& file, std::size_t n_devices) {
  std::istringstream in(read_whole_text(
      file, {.kind = FileKind::table, .what = "file of observations", .hint = "check the path"}));
  Correspondences out{file, {}};
  int number = 0;
  bool heading_seen = false;
  for (std::string line; std::getline(in, line);) {
    ++number;
    line = line.substr(0, line.find('#'));
    for (char& c : line)
      if (c == ',' || c == ';' || c == '\t' || c == '\r') c = ' ';
    std::istringstream words(line);
    std::vector<double> row;
    std::string bad;
    std::size_t n_columns = 0;
    for (std::string word; words >> word; ++n_columns) {
      const auto value = to_number(word);
      if (!value && bad.empty()) bad = word;
      if (n_columns < 2 * n_devices) row.push_back(value.value_or(0.0));
    }
    if (n_columns == 0) continue;
    const std::string where = fmt::format("{}:{}", file.string(), number);
    if (!bad.empty() && out.q_px.empty() && !heading_seen) {
      heading_seen = true;
      continue;
    }
    if (!bad.empty()) throw UserError(ExitCode::input, where, quoted_excerpt(bad) + " is not a number");
    if (n_columns != 2 * n_devices)
      throw UserError(ExitCode::input, where,
                      fmt::format("has {} columns, {} devices have {}", n_columns, n_devices, 2 * n_devices),
                      "two columns per device, in the order of the devices");
    std::vector<Eigen::Vector2d> point;
    for (std::size_t d = 0; d < n_devices; ++d) point.emplace_back(row[2 * d], row[2 * d + 1]);
    out.q_px.push_back(std::move(point));
  }
  return out;
}

Correspondences read_vnl(const std::filesystem::path& file, const std::vector<ImportedDevice>& devices) {
  const std::vector<ImageCorners> images = read_corners_vnl(file);
  Observations o;
  o.file = file;
  std::vector<std::string> globs;
  for (const ImportedDevice& device : devices) {
    o.devices.push_back({device.name, device.imagersize_px});
    globs.push_back(device.name + "*");
  }
  assign_views(images, globs, o);
  Correspondences out{file, {}};
  std::map<std::pair<int, std::size_t>, std::size_t> index;  // frame, corner
  for (const View& view : o.views)
    for (std::size_t i = 0; i < view.corners.size(); ++i) {
      if (!view.corners[i].seen()) continue;
      const auto [at, is_new] = index.try_emplace({view.frame, i}, out.q_px.size());
      if (is_new) out.q_px.emplace_back(devices.size(), Eigen::Vector2d::Constant(std::nan("")));
      out.q_px[at->second][view.device] = view.corners[i].q_px;
    }
  return out;
}

struct RayPair {
  Eigen::Vector3d first, second;  // unit, in their devices' frames
  Eigen::Vector2d q_first, q_second;
};

/// Distances along both rays to where they are nearest.
std::optional<Eigen::Vector2d> depths(const RayPair& p, const Pose& T) {
  const Eigen::Vector3d a = T.rotation * p.first;
  Eigen::Matrix<double, 3, 2> A;
  A << a, -p.second;
  const Eigen::Matrix2d N = A.transpose() * A;
  if (std::abs(N.determinant()) < 1e-14) return std::nullopt;
  return N.inverse() * (A.transpose() * (-T.translation_mm));
}

ConventionFit try_convention(PoseConvention convention, const Pose& T, const std::vector<RayPair>& pairs,
                             const std::vector<Lens>& lenses, double focal_px) {
  ConventionFit fit{.convention = convention};
  double epipolar = 0.0, reprojection = 0.0;
  std::size_t in_front = 0, n_reprojected = 0;
  const std::vector<Pose> poses{Pose{}, T};
  for (const RayPair& p : pairs) {
    const Eigen::Vector3d normal = T.translation_mm.cross(T.rotation * p.first);
    const double sine = normal.norm() > 0.0 ? p.second.dot(normal) / normal.norm() : 1.0;
    epipolar += std::pow(focal_px * std::asin(std::clamp(sine, -1.0, 1.0)), 2);
    const auto d = depths(p, T);
    if (!d || !((*d)[0] > 0.0) || !((*d)[1] > 0.0)) continue;
    ++in_front;
    const auto point = triangulate(lenses, poses, {p.q_first, p.q_second}, (*d)[0] * p.first);
    if (!point) continue;
    const auto q0 = lenses[0].project(*point), q1 = lenses[1].project(T * *point);
    if (!q0 || !q1) continue;
    reprojection += 0.5 * ((*q0 - p.q_first).squaredNorm() + (*q1 - p.q_second).squaredNorm());
    ++n_reprojected;
  }
  const auto n = static_cast<double>(pairs.size());
  fit.epipolar_px = std::sqrt(epipolar / n);
  fit.in_front = static_cast<double>(in_front) / n;
  fit.reprojection_px = 2 * n_reprojected >= pairs.size()
                            ? std::sqrt(reprojection / static_cast<double>(n_reprojected))
                            : std::nan("");
  return fit;
}

std::vector<RayPair> ray_pairs(const Correspondences& seen, std::size_t d, const std::vector<Lens>& lenses) {
  std::vector<RayPair> pairs;
  for (const auto& q : seen.q_px) {
    if (!q[0].allFinite() || !q[d].allFinite()) continue;
    const auto a = lenses[0].unproject(q[0]), b = lenses[1].unproject(q[d]);
    if (a && b) pairs.push_back({*a, *b, q[0], q[d]});
  }
  return pairs;
}

}  // namespace

const char* convention_name(PoseConvention convention) {
  switch (convention) {
    case PoseConvention::as_given:
      return "as given";
    case PoseConvention::inverted:
      return "inverted";
    case PoseConvention::rotation_transposed:
      return "with R transposed";
    case PoseConvention::translation_negated:
      return "with T negated";
  }
  return "";
}

Pose with_convention(const Pose& given, PoseConvention convention) {
  switch (convention) {
    case PoseConvention::as_given:
      break;
    case PoseConvention::inverted:
      return given.inverse();
    case PoseConvention::rotation_transposed:
      return {given.rotation.transpose(), given.translation_mm};
    case PoseConvention::translation_negated:
      return {given.rotation, -given.translation_mm};
  }
  return given;
}

Correspondences read_correspondences(const std::filesystem::path& file,
                                     const std::vector<ImportedDevice>& devices) {
  Correspondences out =
      file.extension() == ".vnl" ? read_vnl(file, devices) : read_table(file, devices.size());
  if (out.q_px.empty()) throw UserError(ExitCode::input, file.string(), "holds no observations");
  return out;
}

std::vector<DeviceCheck> check_poses(const std::vector<ImportedDevice>& devices, const Correspondences& seen,
                                     double max_px) {
  const auto lens_of = [](const ImportedDevice& d) {
    return Lens(d.lensmodel, d.intrinsics, {d.imagersize_px[0], d.imagersize_px[1]}, d.name);
  };
  std::vector<DeviceCheck> out;
  for (std::size_t d = 1; d < devices.size(); ++d) {
    const std::vector<Lens> lenses{lens_of(devices[0]), lens_of(devices[d])};
    const std::vector<RayPair> pairs = ray_pairs(seen, d, lenses);
    if (pairs.size() < kMinPoints)
      throw UserError(ExitCode::input, seen.file.string(),
                      fmt::format("{} and {} see only {} points in common", devices[0].name, devices[d].name,
                                  pairs.size()),
                      fmt::format("at least {} are needed", kMinPoints));
    DeviceCheck check{.device = devices[d].name, .n = pairs.size()};
    for (const auto convention : {PoseConvention::as_given, PoseConvention::inverted,
                                  PoseConvention::rotation_transposed, PoseConvention::translation_negated}) {
      const Pose T = with_convention(devices[d].T_device_ref, convention) *
                     with_convention(devices[0].T_device_ref, convention).inverse();
      check.fits.push_back(try_convention(convention, T, pairs, lenses, devices[d].intrinsics[0]));
      const ConventionFit& fit = check.fits.back();
      if (fit.in_front < kInFront || fit.epipolar_px > max_px) continue;
      const ConventionFit& best = check.fits[static_cast<std::size_t>(check.best)];
      if (!check.fits_any || fit.epipolar_px * 1.5 < best.epipolar_px) check.best = convention;
      check.fits_any = true;
    }
    out.push_back(std::move(check));
  }
  return out;
}

}  // namespace fringetwin::calib
