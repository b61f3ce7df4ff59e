// SPDX-License-Identifier: Apache-2.0
#include "calib/page/calibration_findings.hpp"
#include "report/json.hpp"

namespace fringetwin::calib {
namespace {

using report::Json, report::json_number, report::json_numbers;

void put_fit(Json& out, const FitQuality& fit) {
  out["rms_px"] = json_number(fit.rms_px);
  out["rms_component_px"] = json_number(fit.rms_component_px);
  out["worst_px"] = json_number(fit.worst_px);
  out["n_corners"] = fit.n_corners;
  out["n_outliers"] = fit.n_outliers;
}

Json device_json(const Calibration& c, const Findings& findings, std::size_t d,
                 const std::string& model_file) {
  const DeviceResult& device = c.devices[d];
  const DeviceFindings& f = findings.devices[d];
  Json out = {{"name", device.name},
              {"model", model_file},
              {"imagersize", c.problem.imagersizes[d]},
              {"relative_corner_sigma", json_number(c.observations.devices[d].sigma_px)},
              {"intrinsics", device.intrinsics},
              {"intrinsics_sigma", json_numbers(f.intrinsics_sigma)},
              {"rt_device_ref", json_numbers(rt_from_pose(device.T_device_ref))},
              {"rt_device_ref_sigma", json_numbers(f.rt_sigma)}};
  put_fit(out, device.fit);
  out["projection_sigma"] = {{"distance_mm", json_number(f.distance_mm)},
                             {"centre_px", json_number(f.centre_sigma_px)},
                             {"corners_px", json_numbers(f.corner_sigma_px)},
                             {"centre_at_infinity_px", json_number(f.centre_at_infinity_sigma_px)}};
  return out;
}

Json cross_validation_json(const CrossValidation& v, const Calibration& c) {
  Json out = {{"n_even", v.n_even}, {"n_odd", v.n_odd}};
  if (!v.not_done.empty()) {
    out["not_done"] = v.not_done;
    return out;
  }
  out["devices"] = Json::array();
  for (std::size_t d = 0; d < v.devices.size(); ++d)
    out["devices"].push_back({{"name", c.devices[d].name},
                              {"rms_px", json_number(v.devices[d].rms_px)},
                              {"max_px", json_number(v.devices[d].max_px)},
                              {"relative_to_expected", json_number(v.devices[d].relative)}});
  out["shape_rms_mm"] = json_number(v.shape_rms_mm);
  return out;
}

/// Joint covariance of everything that describes the rig: "left.fx", …, "right.r1", …, "right.t3".
Json covariance_json(const Calibration& c, const Eigen::MatrixXd& m) {
  if (m.rows() == 0) return nullptr;
  static const char* const kLens[] = {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2",
                                      "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4"};
  static const char* const kPose[] = {"r1", "r2", "r3", "t1", "t2", "t3"};
  Json names = Json::array(), rows = Json::array();
  for (std::size_t d = 0; d < c.devices.size(); ++d) {
    for (std::size_t i = 0; i < c.devices[d].intrinsics.size(); ++i)
      names.push_back(c.devices[d].name + "." + kLens[i]);
    for (const char* name : kPose)
      if (d > 0) names.push_back(c.devices[d].name + "." + name);
  }
  for (Eigen::Index i = 0; i < m.rows(); ++i) rows.push_back(json_numbers(Eigen::VectorXd(m.row(i))));
  return {{"parameters", names}, {"matrix", rows}};
}

}  // namespace

std::string calibration_json(const Calibration& c, const CalibrateOptions& options, const Findings& findings,
                             const Origin& origin, const std::vector<std::string>& model_files) {
  const Board& board = c.observations.board;
  Json out;
  out["schema"] = "fringetwin-calibration/1";
  out["provenance"] = {
      {"argv", origin.argv}, {"version", origin.version}, {"inputs_sha256", origin.inputs_sha256}};
  out["lensmodel"] = c.problem.lensmodel;
  out["regularization"] = c.problem.regularize;
  out["outlier_rejection"] = options.reject_outliers;
  out["board"] = {{"width_n", board.width_n},
                  {"height_n", board.height_n},
                  {"spacing_mm", board.spacing_mm},
                  {"warp_mm", json_numbers(c.warp_mm)},
                  {"warp_sigma_mm", json_numbers(findings.warp_sigma_mm)}};
  if (options.circle_diameter_mm > 0.0) {
    out["board"]["circle_diameter_mm"] = options.circle_diameter_mm;
    out["board"]["largest_circle_correction_px"] = c.circle_correction_px;
  }
  put_fit(out, c.fit);
  out["corner_sigma_px"] = json_number(findings.observed_sigma_px);
  out["projector_shares_camera_noise"] = json_number(findings.shared_noise);
  out["devices"] = Json::array();
  for (std::size_t d = 0; d < c.devices.size(); ++d)
    out["devices"].push_back(device_json(c, findings, d, model_files[d]));
  out["covariance"] = covariance_json(c, findings.rig_covariance);
  out["pairs"] = Json::array();
  for (const PairFindings& p : findings.pairs)
    out["pairs"].push_back({{"devices", {c.devices[p.first].name, c.devices[p.second].name}},
                            {"baseline_mm", json_number(p.baseline_mm)},
                            {"baseline_sigma_mm", json_number(p.baseline_sigma_mm)},
                            {"shape_sigma_mm", json_number(p.shape_sigma_mm)}});
  out["cross_validation"] = cross_validation_json(findings.cross_validation, c);
  out["boards"] = Json::array();
  for (std::size_t f = 0; f < c.observations.frames.size(); ++f)
    out["boards"].push_back(
        {{"frame", c.observations.frames[f]},
         {"rt_ref_board", json_numbers(rt_from_pose(T_ref_board(c.problem, static_cast<int>(f))))}});
  out["views"] = Json::array();
  for (std::size_t v = 0; v < c.views.size(); ++v) {
    const View& view = c.observations.views[v];
    Json row = {{"device", c.devices[view.device].name},
                {"frame", c.observations.frames[view.frame]},
                {"source", view.source}};
    put_fit(row, c.views[v].fit);
    out["views"].push_back(row);
  }
  out["warnings"] = c.warnings;
  return out.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace fringetwin::calib
