// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calib/page/calibration_findings.hpp"
#include "report/cloud_view.hpp"
#include "report/html_page.hpp"
#include "report/map.hpp"
#include "report/plot/plot.hpp"
#include "report/table.hpp"
#include "report/text.hpp"

namespace fringetwin::calib {
namespace {

using report::figure_html, report::MapStyle, report::text_column;

constexpr int kMapWidthPx = 480;

/// Each value as a square, so that a small grid is not a stamp.
ImageF enlarged(const ImageF& grid, int width_px) {
  const int k = std::max(1, width_px / grid.width);
  ImageF out(grid.width * k, grid.height * k);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) out(x, y) = grid(x / k, y / k);
  return out;
}

std::string map_of(const ImageF& grid, const std::string& title, MapStyle style) {
  style.title = title;
  return fmt::format("<div class=\"map\"><h4>{}</h4>{}</div>", report::escape_html(title),
                     report::map_html(enlarged(grid, kMapWidthPx), style));
}

MapStyle value_style(const std::vector<const ImageF*>& images, const std::string& unit) {
  MapStyle style{.unit = unit};
  std::vector<float> all;
  for (const ImageF* image : images) all.insert(all.end(), image->data.begin(), image->data.end());
  const double high = report::percentile(all, 99.0);
  style.limits = {0.0, high > 0.0 ? high : 1.0};
  return style;
}

/// Limits for a map over the imager that grows beyond all bounds where no board was: up to twice what holds
/// at nine tenths of the corners.
MapStyle style_where_seen(const Calibration& c, int device, const ImageF& grid) {
  const auto& size = c.problem.imagersizes[device];
  std::vector<float> seen;
  for (const View& view : c.observations.views)
    for (const Corner& corner : view.corners) {
      if (view.device != device || !corner.seen()) continue;
      const auto cell = [](double q, int pixels, int cells) {
        return std::clamp(static_cast<int>((q + 0.5) / pixels * cells), 0, cells - 1);
      };
      seen.push_back(
          grid(cell(corner.q_px.x(), size[0], grid.width), cell(corner.q_px.y(), size[1], grid.height)));
    }
  MapStyle style{.unit = "px"};
  const double high = 2.0 * report::percentile(seen, 90.0);
  style.limits = {0.0, high > 0.0 ? high : 1.0};
  return style;
}

/// Mean residual (0: x, 1: y) and its rms (2) over cells of the imager.
std::array<ImageF, 3> residual_cells(const Calibration& c, int device) {
  constexpr int kColumns = 24;
  const auto& size = c.problem.imagersizes[device];
  const int rows = std::max(2, static_cast<int>(std::lround(1.0 * kColumns * size[1] / size[0])));
  ImageD sum_x(kColumns, rows), sum_y(kColumns, rows), sum_sq(kColumns, rows), n(kColumns, rows);
  for (std::size_t v = 0; v < c.observations.views.size(); ++v) {
    const View& view = c.observations.views[v];
    if (view.device != device) continue;
    for (std::size_t i = 0; i < view.corners.size(); ++i) {
      const Eigen::Vector2d r = c.residual_px(v, i);
      if (!r.allFinite()) continue;
      const int x = std::clamp(static_cast<int>((view.corners[i].q_px.x() + 0.5) / size[0] * kColumns), 0,
                               kColumns - 1);
      const int y =
          std::clamp(static_cast<int>((view.corners[i].q_px.y() + 0.5) / size[1] * rows), 0, rows - 1);
      sum_x(x, y) += r.x();
      sum_y(x, y) += r.y();
      sum_sq(x, y) += r.squaredNorm();
      n(x, y) += 1.0;
    }
  }
  std::array<ImageF, 3> out;
  out.fill(ImageF(kColumns, rows, std::nanf("")));
  for (std::size_t i = 0; i < n.size(); ++i) {
    if (n.data[i] == 0.0) continue;
    out[0].data[i] = static_cast<float>(sum_x.data[i] / n.data[i]);
    out[1].data[i] = static_cast<float>(sum_y.data[i] / n.data[i]);
    out[2].data[i] = static_cast<float>(std::sqrt(sum_sq.data[i] / n.data[i]));
  }
  return out;
}

std::string residual_maps(const Calibration& c) {
  std::string out;
  for (std::size_t d = 0; d < c.devices.size(); ++d) {
    const auto cells = residual_cells(c, static_cast<int>(d));
    MapStyle signed_style{.scale = report::Scale::diverging, .unit = "px"};
    const double a =
        std::max(report::symmetric_limits(cells[0]).high, report::symmetric_limits(cells[1]).high);
    signed_style.limits = {-a, a};
    const std::string& name = c.devices[d].name;
    const std::string body = "<div class=\"maps\">" +
                             map_of(cells[2], name + ": rms", value_style({&cells[2]}, "px")) +
                             map_of(cells[0], name + ": mean in x", signed_style) +
                             map_of(cells[1], name + ": mean in y", signed_style) + "</div>";
    out += figure_html(body,
                       fmt::format("Residuals of {} over its imager. A pattern in the means is a lens that "
                                   "the model does not describe; gray: no corner was seen there.",
                                   name),
                       "predicted - observed, mean (x, y) and rms (2-norm) per cell");
  }
  return out;
}

std::string residual_histogram(const Calibration& c) {
  std::vector<report::Plot> plots(1);
  report::Plot& plot = plots[0];
  plot.x_label = "residual, one coordinate [px]";
  plot.y_label = "share of all [%]";
  double limit = 0.0;
  for (const auto& device : c.devices) limit = std::max(limit, 3.0 * device.fit.rms_px);
  const char* colors[] = {report::color::kReal, report::color::kSimulated, report::color::kThird,
                          report::color::kFourth};
  for (std::size_t d = 0; d < c.devices.size(); ++d) {
    std::vector<float> values;
    for (std::size_t v = 0; v < c.observations.views.size(); ++v) {
      if (c.observations.views[v].device != static_cast<int>(d)) continue;
      for (std::size_t i = 0; i < c.observations.board.corners(); ++i)
        for (const double r : c.residual_px(v, i)) values.push_back(static_cast<float>(r));
    }
    auto series = report::histogram_series(report::histogram(values, 60, -limit, limit), c.devices[d].name,
                                           colors[d % 4]);
    series.style = report::Series::Style::line;
    plot.series.push_back(series);
  }
  return figure_html(report::plots_or_sentences(plots, "residuals")[0],
                     "Distribution of the residuals of the corners used.");
}

std::string uncertainty_maps(const Calibration& c, const Findings& findings) {
  std::string maps = "<div class=\"maps\">", crossed = maps;
  for (std::size_t d = 0; d < c.devices.size(); ++d)
    maps += map_of(findings.devices[d].sigma_px,
                   fmt::format("{} at {:.4g} mm", c.devices[d].name, findings.devices[d].distance_mm),
                   style_where_seen(c, static_cast<int>(d), findings.devices[d].sigma_px));
  std::string out = figure_html(
      maps + "</div>",
      "Projection uncertainty: how far (1 sigma, in the worst direction) the noise of the corners lets the "
      "projection of a point at the working distance be wrong. It grows where no board was seen: colours end "
      "at twice what holds at nine tenths of the corners, yellow is that or more.",
      "Var(q) = dq/db Var(b) (dq/db)^T, the point at rest relative to the boards");
  const CrossValidation& v = findings.cross_validation;
  if (!v.not_done.empty()) return out + "<p>No cross-validation: " + report::escape_html(v.not_done) + "</p>";
  for (std::size_t d = 0; d < v.devices.size(); ++d)
    crossed += map_of(v.devices[d].difference_px, c.devices[d].name + ": even - odd",
                      style_where_seen(c, static_cast<int>(d), v.devices[d].difference_px));
  report::Table table;
  table.columns = {text_column("even - odd"), {"rms", "px"}, {"largest", "px"}, {"over expected"}};
  for (std::size_t d = 0; d < v.devices.size(); ++d)
    table.add_row({c.devices[d].name, report::number(v.devices[d].rms_px, 2),
                   report::number(v.devices[d].max_px, 2), report::number(v.devices[d].relative, 2)});
  return out +
         figure_html(
             crossed + "</div>",
             fmt::format(
                 "The same rig calibrated from the even ({}) and from the odd ({}) frames: difference of the "
                 "projections at the working distance after the best rigid motion (colours as above). Over "
                 "expected: rms of the difference over its sigma at each place; well above 2 means error "
                 "beyond the corners' noise: a wrong lens model or a moving board.",
                 v.n_even, v.n_odd)) +
         table.html();
}

std::string board_view(const Calibration& c) {
  std::vector<Eigen::Vector3d> points;
  std::vector<float> value;
  const Board& board = c.observations.board;
  constexpr int kFine = 6;  // dots per corner spacing
  for (std::size_t f = 0; f < c.observations.frames.size(); ++f) {
    double sum = 0.0;
    int n = 0;
    for (const ViewResult& v : c.views)
      if (v.frame == static_cast<int>(f))
        sum += v.fit.rms_px * v.fit.rms_px * v.fit.n_corners, n += v.fit.n_corners;
    const auto rms = static_cast<float>(std::sqrt(sum / std::max(n, 1)));
    const Pose T = T_ref_board(c.problem, static_cast<int>(f));
    for (int row = 0; row <= kFine * (board.height_n - 1); ++row)
      for (int col = 0; col <= kFine * (board.width_n - 1); ++col) {
        if (row % kFine != 0 && col % kFine != 0) continue;  // the lines of the grid
        points.push_back(
            T * Eigen::Vector3d(col * board.spacing_mm / kFine, row * board.spacing_mm / kFine, 0.0));
        value.push_back(rms);
      }
  }
  std::string maps = "<div class=\"maps\">";
  for (const auto& [title, forward, up] :
       {std::tuple{"oblique", Eigen::Vector3d(0.5, 0.35, 1.0), Eigen::Vector3d(0, -1, 0)},
        std::tuple{"from above: x to the right, z up", Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1)}}) {
    report::CloudView view{.forward_world = forward,
                           .up_world = up,
                           .width_px = kMapWidthPx,
                           .height_px = kMapWidthPx * 3 / 4,
                           .dot_px = 2};
    const report::CloudPicture cloud = report::draw_cloud(points, value, view);
    MapStyle style = value_style({&cloud.value}, "px rms");
    style.title = fmt::format("boards, {}", title);
    maps += fmt::format("<div class=\"map\"><h4>{}</h4>{}{}</div>", style.title,
                        report::map_html(cloud.value, style),
                        report::scale_bar_html(cloud.mm_per_px, cloud.value.width));
  }
  return figure_html(
      maps + "</div>",
      "Every board where the solution puts it, in the frame of the first device; colour: rms of its corners "
      "in all devices. Boards all at one tilt or one distance leave focal length and centre uncertain.");
}

std::string warp_sentence(const Calibration& c, const Eigen::Vector2d& sigma_mm) {
  const auto part = [&](int i) {
    return sigma_mm[i] > 0.0 ? report::with_sigma(1000.0 * c.warp_mm[i], 1000.0 * sigma_mm[i])
                             : report::fixed(1000.0 * c.warp_mm[i], 1);
  };
  const bool is_flat = (c.warp_mm.cwiseAbs().array() <= 3.0 * sigma_mm.array()).all();
  return fmt::format("{}: {} µm by x and {} µm by y at its middle, relative to its borders.",
                     is_flat ? "The board is flat as far as the corners tell" : "The board is not flat",
                     part(0), part(1));
}

std::string warp_map(const Calibration& c, const Findings& findings) {
  constexpr int kColumns = 48;
  const Board& board = c.observations.board;
  const int rows =
      std::max(2, static_cast<int>(std::lround(kColumns * board.height_mm() / board.width_mm())));
  ImageF z(kColumns, rows);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < kColumns; ++x) {
      const double u = (x + 0.5) / kColumns, v = (y + 0.5) / rows;
      z(x, y) =
          static_cast<float>(1000.0 * 4.0 * (c.warp_mm.x() * u * (1.0 - u) + c.warp_mm.y() * v * (1.0 - v)));
    }
  MapStyle style{
      .scale = report::Scale::diverging, .limits = report::symmetric_limits(z, 100.0), .unit = "µm"};
  return figure_html("<div class=\"maps\" style=\"max-width: 400px\">" +
                         map_of(z, "deflection of the board", style) + "</div>",
                     warp_sentence(c, findings.warp_sigma_mm), "z = 4 wx u(1-u) + 4 wy v(1-v)");
}

std::string device_table(const Calibration& c, const Findings& findings) {
  report::Table t;
  t.columns = {text_column("device"), {"fx", "px"},       {"fy", "px"},       {"cx", "px"},
               {"cy", "px"},          {"rms", "px"},      {"worst", "px"},    {"corners"},
               {"outliers"},          {"σ centre", "px"}, {"σ corners", "px"}};
  for (std::size_t d = 0; d < c.devices.size(); ++d) {
    const DeviceResult& r = c.devices[d];
    const DeviceFindings& f = findings.devices[d];
    double worst = 0.0;
    for (const double s : f.corner_sigma_px) worst = std::isfinite(s) ? std::max(worst, s) : worst;
    std::vector<std::string> row{r.name};
    for (std::size_t i = 0; i < 4; ++i)
      row.push_back(std::isfinite(f.intrinsics_sigma[i])
                        ? report::with_sigma(r.intrinsics[i], f.intrinsics_sigma[i])
                        : report::fixed(r.intrinsics[i], 2));
    for (const auto& cell :
         {report::number(r.fit.rms_px, 3), report::number(r.fit.worst_px, 3),
          report::count(static_cast<unsigned long long>(r.fit.n_corners)), std::to_string(r.fit.n_outliers),
          report::number(f.centre_sigma_px, 2), report::number(worst, 2)})
      row.push_back(cell);
    t.add_row(row);
  }
  return t.html();
}

std::string pair_table(const Calibration& c, const Findings& findings) {
  if (findings.pairs.empty()) return "";
  report::Table t;
  t.columns = {text_column("measuring with"), {"baseline", "mm"}, {"shape known to", "µm rms"}};
  for (const PairFindings& p : findings.pairs)
    t.add_row({c.devices[p.first].name + " and " + c.devices[p.second].name,
               fmt::format("{:.3f} ± {:.2g}", p.baseline_mm, p.baseline_sigma_mm),
               report::number(1000.0 * p.shape_sigma_mm, 2)});
  return t.html() +
         "<p>Shape: the calibration's part of the error of points where the boards were, after the best "
         "rigid motion; a common turn or shift of everything measured is no error of shape.</p>";
}

std::string view_table(const Calibration& c) {
  report::Table t;
  t.columns = {text_column("device"), text_column("view"), text_column("file"),
               {"rms", "px"},         {"worst", "px"},     {"corners"},
               {"outliers"},          {"distance", "mm"},  {"tilt", "°"}};
  for (std::size_t v = 0; v < c.views.size(); ++v) {
    const View& view = c.observations.views[v];
    const Pose T = T_device_ref(c.problem, view.device) * T_ref_board(c.problem, view.frame);
    const double tilt = std::acos(std::clamp(std::abs(T.rotation(2, 2)), 0.0, 1.0)) * 180.0 / M_PI;
    const FitQuality& fit = c.views[v].fit;
    t.add_row({c.devices[view.device].name, c.observations.frames[view.frame], view.source,
               report::number(fit.rms_px, 3), report::number(fit.worst_px, 3), std::to_string(fit.n_corners),
               std::to_string(fit.n_outliers),
               report::number((T * Eigen::Vector3d(0.5 * c.observations.board.width_mm(),
                                                   0.5 * c.observations.board.height_mm(), 0.0))
                                  .z(),
                              4),
               report::fixed(tilt, 1)});
  }
  return t.html();
}

std::string parameter_table(const Calibration& c, const Findings& findings) {
  report::Table t;
  t.columns = {text_column("device"), text_column("parameter"), {"value"}, {"sigma"}};
  static const char* const kLens[] = {"fx px", "fy px", "cx px", "cy px", "k1", "k2", "p1", "p2",
                                      "k3",    "k4",    "k5",    "k6",    "s1", "s2", "s3", "s4"};
  static const char* const kPose[] = {"r1 rad", "r2 rad", "r3 rad", "t1 mm", "t2 mm", "t3 mm"};
  const bool splined = c.problem.lensmodel.starts_with("LENSMODEL_SPLINED");
  for (std::size_t d = 0; d < c.devices.size(); ++d) {
    const auto& k = c.devices[d].intrinsics;
    for (std::size_t i = 0; i < (splined ? 4 : std::min<std::size_t>(k.size(), 16)); ++i)
      t.add_row({c.devices[d].name, kLens[i], fmt::format("{:.9g}", k[i]),
                 report::number(findings.devices[d].intrinsics_sigma[i], 2)});
    if (d == 0) continue;
    const RotTrans rt = rt_from_pose(c.devices[d].T_device_ref);
    for (int i = 0; i < 6; ++i)
      t.add_row({c.devices[d].name, kPose[i], fmt::format("{:.9g}", rt[i]),
                 report::number(findings.devices[d].rt_sigma[i], 2)});
  }
  return t.html();
}

}  // namespace

std::string calibration_html(const Calibration& c, const CalibrateOptions& options, const Findings& findings,
                             const Origin& origin) {
  report::Page page;
  page.title = "Calibration";
  page.subtitle = fmt::format(
      "{} device{}, {} boards of {} x {} corners {:.6g} mm apart, {}", c.devices.size(),
      c.devices.size() == 1 ? "" : "s", c.observations.frames.size(), c.observations.board.width_n,
      c.observations.board.height_n, c.observations.board.spacing_mm, c.problem.lensmodel);
  page.summary_html =
      device_table(c, findings) +
      "<p>σ: projection uncertainty at the image's centre and at its worst corner, working distance.</p>" +
      pair_table(c, findings);
  page.note = fmt::format(
      "One joint solve of all devices, all board poses and the board's warp; regularisation {}, outlier "
      "rejection {}. Rms and worst residual are 2-norms per corner (per coordinate, weighted, as mrcal "
      "counts: {} px). Uncertainties follow from the corners' scatter of {} px and know nothing of a wrong "
      "lens model or a wrong board spacing.",
      c.problem.regularize ? "on" : "off", options.reject_outliers ? "on" : "off",
      report::number(c.fit.rms_component_px, 4), report::number(findings.observed_sigma_px, 3));
  if (findings.shared_noise > 0.0)
    page.note += fmt::format(
        " The projector's corners were read at the cameras' corners and share {:.0f} % of their noise; the "
        "uncertainties know that.",
        100.0 * findings.shared_noise);
  if (c.circle_correction_px > 0.0)
    page.note += fmt::format(" Circles' centres are corrected for perspective, by up to {} px.",
                             report::number(c.circle_correction_px, 2));
  page.warnings = c.warnings;
  page.sections = {{"residuals", "Residuals", residual_maps(c) + residual_histogram(c)},
                   {"uncertainty", "Uncertainty", uncertainty_maps(c, findings)},
                   {"boards", "Boards", board_view(c) + warp_map(c, findings)},
                   {"parameters", "Parameters", parameter_table(c, findings)},
                   {"views", "Every view", view_table(c)}};
  page.footer_html = origin_html(origin);
  return page.html();
}

}  // namespace fringetwin::calib
