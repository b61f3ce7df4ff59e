// SPDX-License-Identifier: Apache-2.0
#include "calib/page/photometry_page.hpp"

#include <fmt/format.h>

#include <cmath>

#include "report/html_page.hpp"
#include "report/plot/plot.hpp"
#include "report/table.hpp"
#include "report/text.hpp"

namespace fringetwin::calib {
namespace {

using report::figure_html, report::Plot, report::Series, report::text_column;

/// Returns the value with its standard error, "1.23 ± 0.04", or a dash where it is unknown.
std::string pm(const Estimate& e) {
  if (!std::isfinite(e.value)) return "–";
  return e.sigma > 0.0 ? report::with_sigma(e.value, e.sigma) : report::number(e.value, 4);
}

std::string sensor_table(const Photometry& p) {
  report::Table t;
  t.columns = {text_column("camera"),
               {"system gain", "DN/e-"},
               {"its inverse", "e-/DN"},
               {"read noise", "DN"},
               {"read noise", "e-"},
               {"black", "DN"},
               {"saturation", "DN"},
               text_column("from"),
               {"off the line", "% rms"},
               {"gain change", "%"},
               {"corners"}};
  for (const CameraPhotometry& c : p.cameras) {
    const PhotonTransfer none, &x = c.transfer ? *c.transfer : none;
    const Estimate change{100.0 * x.slope_change.value, 100.0 * x.slope_change.sigma};
    t.add_row({c.camera, pm(x.dn_per_electron), pm(x.electrons_per_dn), pm(x.read_noise_dn),
               pm(x.read_noise_electrons),
               c.black_measured ? pm(c.black_level_dn)
               : c.black_known  ? "the twin's"
                                : "not known",
               c.saturation.reached ? report::fixed(c.saturation.level_dn, 0) : "not reached",
               c.transfer ? c.noise_from : "–", c.transfer ? report::number(100.0 * x.residual_rms, 2) : "–",
               pm(change), c.flat ? report::fixed(c.flat->corner, 4) : "–"});
  }
  return t.html();
}

std::string projector_table(const Photometry& p) {
  report::Table t;
  t.columns = {text_column("camera"), text_column("direction"), {"gamma"}, {"off it", "% of range"},
               {"blur", "px"},        {"off a Gaussian", "%"},  {"pixels"}};
  for (const CameraPhotometry& c : p.cameras)
    for (const ProjectorPhotometry& d : c.directions)
      t.add_row({c.camera, axis_name(d.harmonics.axis), pm(d.gamma),
                 report::number(100.0 * d.gamma_misfit, 2), pm(d.blur_px),
                 report::number(100.0 * d.blur_misfit, 2), report::count(d.harmonics.n)});
  return t.rows.empty() ? "" : t.html();
}

std::string plot_html(const Plot& plot, const std::string& id) {
  return report::plots_or_sentences({plot}, id).front();
}

std::string transfer_section(const Photometry& p) {
  std::string out;
  for (std::size_t i = 0; i < p.cameras.size(); ++i) {
    const CameraPhotometry& c = p.cameras[i];
    if (!c.transfer) continue;
    Plot variance, residual;
    variance.title = c.camera;
    variance.x_label = residual.x_label = "level, DN";
    variance.y_label = "variance, DN²";
    residual.y_label = "off the line, %";
    residual.zero_line = true;
    residual.height_px = 200;
    Series points{"bins", {}, {}, {}, Series::Style::points}, line{"line", {}, {}, {}, Series::Style::line},
        off{"", {}, {}, {}, Series::Style::points}, band{"1 sigma of a bin", {}, {}, {}, Series::Style::band};
    line.color = report::color::kSimulated;
    band.color = report::color::kThird;
    for (const TransferBin& b : c.transfer->bins) {
      points.add(b.level_dn, b.variance_dn2);
      line.add(b.level_dn, b.line_dn2);
      off.add(b.level_dn, 100.0 * (b.variance_dn2 / b.line_dn2 - 1.0));
      band.add(b.level_dn, 100.0 * b.sigma_dn2 / b.line_dn2),
          band.y_low.push_back(-100.0 * b.sigma_dn2 / b.line_dn2);
    }
    variance.series = {line, points};
    residual.series = {band, off};
    const std::string body =
        plot_html(variance, fmt::format("ptc{}", i)) + plot_html(residual, fmt::format("ptr{}", i));
    const std::string caption = fmt::format(
        "Temporal variance of a gray value against its mean, from {}, {} samples. A straight line: shot "
        "noise on a linear sensor; its slope is the gain, its height at the black level read noise and "
        "rounding (1/12 DN²).",
        c.noise_from, report::count(c.transfer->n));
    out += figure_html(body, caption, "variance = (level - black) DN_per_electron + read_noise² + 1/12");
  }
  return out;
}

std::string response_figure(const ProjectorPhotometry& d, const std::string& where, const std::string& id) {
  if (d.curve_light.empty()) return "";
  Plot plot{
      .title = where,
      .x_label = "pattern value",
      .y_label = "light",
      .series = {{"measured", d.curve_level, d.curve_light, {}, Series::Style::line},
                 {fmt::format("gamma {:.3f}", d.gamma.value), d.curve_level, {}, {}, Series::Style::dashed}}};
  const double low = std::pow(std::max(0.0, d.curve_level.front()), d.gamma.value),
               high = std::pow(d.curve_level.back(), d.gamma.value);
  for (const double v : d.curve_level)
    plot.series[1].y.push_back((std::pow(std::max(0.0, v), d.gamma.value) - low) / (high - low));
  plot.series[1].color = report::color::kSimulated;
  return figure_html(
      plot_html(plot, id),
      "The projector's light against the value it is given, 0 and 1 at the ends of the projected range: what "
      "it gives for black cannot be told from other light.",
      "light(v) = sum_h r_h T_h((v - mean)/amplitude), r_h: harmonics before blur and camera pixel");
}

std::string mtf_figure(const ProjectorPhotometry& d, const std::string& where, const std::string& id) {
  if (d.mtf.empty()) return "";
  Plot plot{.title = where, .x_label = "period at the projector, px", .y_label = "contrast", .log_x = true};
  Series seen{"measured", {}, {}, {}, Series::Style::points},
      blur{"blur_px and camera", {}, {}, {}, Series::Style::points};
  blur.color = report::color::kSimulated;
  blur.point_type = 13;
  for (const MtfPoint& m : d.mtf) {
    seen.add(m.period_px, m.contrast.value);
    seen.labels.push_back(m.order == 1 ? "" : fmt::format("order {}", m.order));
    blur.add(m.period_px, m.gaussian * m.camera_factor);
  }
  plot.series = {seen, blur};
  return figure_html(plot_html(plot, id),
                     "Contrast of each order at each pitch relative to the same order at the coarsest pitch; "
                     "the diamonds are the fitted Gaussian blur times what the camera's pixel area takes.",
                     "gaussian = exp(-2 pi² blur_px² h² (1/pitch² - 1/coarsest²))");
}

std::string harmonics_table(const ProjectorPhotometry& d, const std::string& where) {
  report::Table t;
  t.caption = where + ": median over the pixels per pitch and order, DN, and in phase with the fundamental";
  t.columns = {{"pitch", "px"},
               {"order"},
               {"median", "DN"},
               {"in phase", "of the coarsest fundamental"},
               {"out of phase", "the same"}};
  for (const PitchHarmonics& h : d.harmonics.pitches)
    for (std::size_t k = 0; k < h.median_dn.size(); ++k)
      t.add_row({report::number(h.pitch_px, 6), std::to_string(k + 1), report::number(h.median_dn[k], 4),
                 pm(h.amplitude[k]), k == 0 ? "–" : pm(h.quadrature[k])});
  return t.html();
}

std::string projector_section(const Photometry& p) {
  std::string out;
  for (std::size_t i = 0; i < p.cameras.size(); ++i)
    for (std::size_t k = 0; k < p.cameras[i].directions.size(); ++k) {
      const ProjectorPhotometry& d = p.cameras[i].directions[k];
      const std::string where =
          fmt::format("{}, direction {}", p.cameras[i].camera, axis_name(d.harmonics.axis));
      const std::string id = fmt::format("{}{}", i, k);
      out += response_figure(d, where, "response" + id) + mtf_figure(d, where, "mtf" + id) +
             harmonics_table(d, report::escape_html(where));
    }
  return out;
}

/// Factors of the images' light, a row per camera and image; empty where no camera tells any.
std::string light_section(const Photometry& p) {
  report::Table t;
  t.columns = {text_column("camera"), {"image"}, {"light", "% of the mean"}};
  for (const CameraPhotometry& c : p.cameras)
    for (std::size_t k = 0; c.light && k < c.light->factor.size(); ++k)
      if (c.light->sigma[k] > 0.0 && std::isfinite(c.light->sigma[k]))
        t.add_row({c.camera, std::to_string(k), pm({100.0 * c.light->factor[k], 100.0 * c.light->sigma[k]})});
  return t.rows.empty() ? "" : t.html();
}

}  // namespace

std::string photometry_html(const Photometry& photometry, const Origin& origin) {
  report::Page page;
  page.title = "Photometry";
  page.subtitle =
      fmt::format("{} camera{}", photometry.cameras.size(), photometry.cameras.size() == 1 ? "" : "s");
  page.summary_html = sensor_table(photometry) + projector_table(photometry);
  page.note =
      "± is one standard error: the larger of the scatter of the values and a jackknife over 64 parts of the "
      "image. Ambient light and the projector's black look alike to a camera; the gain that turns irradiance "
      "into gray values depends on the scene and is fitted by cosim.";
  page.warnings = photometry.warnings;
  page.sections = {
      {"toml", "For twin.toml", "<pre>" + report::escape_html(photometry_toml(photometry)) + "</pre>"}};
  if (const std::string s = transfer_section(photometry); !s.empty())
    page.sections.push_back({"transfer", "Photon transfer", s});
  if (const std::string s = projector_section(photometry); !s.empty())
    page.sections.push_back({"projector", "Projector", s});
  if (const std::string s = light_section(photometry); !s.empty())
    page.sections.push_back({"light", "Light of the images", s});
  page.footer_html = origin_html(origin);
  return page.html();
}

}  // namespace fringetwin::calib
