// SPDX-License-Identifier: Apache-2.0
#include "calib/page/projector_result.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "calib/solve/lit_points.hpp"
#include "report/json.hpp"
#include "report/map.hpp"
#include "report/text.hpp"
#include "twin/file/cameramodel.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::calib {
namespace {

using report::Json, report::json_number;
using P = ProjectorParameter;

/// Mean residual of each tile, one pixel per tile.
ImageF tile_map(const ProjectorFromPoints& solved, const ProjectorFiles& files) {
  const int across = files.camera_width_px / kTilePx + 1, down = files.camera_height_px / kTilePx + 1;
  ImageF map(across, down, std::numeric_limits<float>::quiet_NaN());
  for (const auto& [tile, mean_px] : solved.tile_mean_px)
    map(tile % across, tile / across) = static_cast<float>(mean_px);
  // as wide as the colour bar's text needs
  const int enlarged = std::max(1, 960 / across);
  ImageF large(across * enlarged, down * enlarged);
  for (int y = 0; y < large.height; ++y)
    for (int x = 0; x < large.width; ++x) large(x, y) = map(x / enlarged, y / enlarged);
  return large;
}

Json by_convention(const ProjectorFromPoints& solved) {
  Json out = Json::array();
  if (!solved.rows)
    for (const int i : {P::fy, P::cy, P::t + 1}) out.push_back(P::names()[i]);
  if (solved.intrinsics().size() == 4) out.push_back(P::names()[P::k1]);
  return out;
}

}  // namespace

std::vector<std::string> projector_lines(const ProjectorFromPoints& solved) {
  std::vector<std::string> out;
  std::string numbers = "projector:";
  for (const int i : {P::fx, P::fy, P::cx, P::cy}) {
    if (solved.sigma[i] > 0.0)
      numbers +=
          fmt::format(" {} {} px", P::names()[i], report::with_sigma(solved.parameters[i], solved.sigma[i]));
  }
  out.push_back(numbers);
  const Eigen::Vector3d center = solved.T_projector_world().inverse().translation_mm;
  out.push_back(
      fmt::format("its centre in the world: {:.3f}, {:.3f}, {:.3f} mm", center.x(), center.y(), center.z()));
  out.push_back(
      fmt::format("{} points, {} outliers; residual {:.4g} px rms, {:.3g} times its noise; of tiles of {} px "
                  "{:.3g} px, of which "
                  "noise makes {:.2g}",
                  solved.n_points, solved.n_outliers, solved.rms_px, std::sqrt(solved.chi2), kTilePx,
                  solved.tile_rms_px, solved.tile_expected_px));
  out.push_back(fmt::format("a column is known to {:.3g} px over the points", solved.column_sigma_px));
  if (!solved.rows)
    out.push_back(
        "only columns were projected: fy = fx, and the centre's place along the columns and the row are by "
        "convention");
  return out;
}

void write_projector(const ProjectorFromPoints& solved, const ProjectorFiles& files, const Origin& origin) {
  CameraModelFile model{.lensmodel = solved.lensmodel, .intrinsics = solved.intrinsics()};
  const RotTrans rt = rt_from_pose(solved.T_projector_world());
  std::ranges::copy(rt, model.rt_cam_ref.begin());
  for (int i = 3; i < 6; ++i) model.rt_cam_ref[i] /= files.mm_per_model_unit;
  model.imagersize = files.imagersize_px;
  model.comments = {" generated with  " + report::shell_command(origin.argv)};
  for (const std::string& line : projector_lines(solved)) model.comments.push_back(" " + line);
  write_cameramodel(files.dir / "projector.cameramodel", model);

  const ImageF map = tile_map(solved, files);
  report::write_map_png(files.dir / "projector_residual.png", map,
                        {.scale = report::Scale::diverging,
                         .limits = report::symmetric_limits(map),
                         .unit = "projector px",
                         .title = "decoded column minus the projector's, means of tiles"});

  Json out;
  out["schema"] = "fringetwin-projector/1";
  out["provenance"] = {
      {"argv", origin.argv}, {"version", origin.version}, {"inputs_sha256", origin.inputs_sha256}};
  out["model"] = "projector.cameramodel";
  out["lensmodel"] = solved.lensmodel;
  out["imagersize"] = files.imagersize_px;
  for (int i = 0; i < P::count; ++i) {
    out["parameters"][P::names()[i]] = json_number(solved.parameters[i]);
    out["sigma"][P::names()[i]] = json_number(solved.sigma[i]);
  }
  out["by_convention"] = by_convention(solved);
  out["rows_decoded"] = solved.rows;
  out["n_points"] = solved.n_points;
  out["n_outliers"] = solved.n_outliers;
  out["rms_px"] = json_number(solved.rms_px);
  out["chi2"] = json_number(solved.chi2);
  out["tile_px"] = kTilePx;
  out["tile_rms_px"] = json_number(solved.tile_rms_px);
  out["tile_expected_px"] = json_number(solved.tile_expected_px);
  out["column_sigma_px"] = json_number(solved.column_sigma_px);
  out["rows_px"] = solved.rows_px;
  write_text_file(files.dir / "projector.json", out.dump(2) + "\n");
}

}  // namespace fringetwin::calib
