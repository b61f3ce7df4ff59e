// SPDX-License-Identifier: Apache-2.0
#include "compare/page/measurement_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "compare/page/pixel_fates.hpp"
#include "compare/page/report_parts.hpp"
#include "compare/phase/phase_rows.hpp"
#include "report/cloud_canvas.hpp"
#include "report/html_page.hpp"
#include "report/map.hpp"
#include "report/provenance.hpp"
#include "report/table.hpp"
#include "report/text.hpp"
#include "twin/base/progress.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::compare {
namespace {

using measure::DirectionDecode;
using measure::Measurement;
using measure::ObjectFit;
using report::text_column;

/// What all parts of the page need.
struct MeasuredPage {
  const std::filesystem::path& dir;
  const Twin& twin;
  const Measurement& measurement;
  std::string command;  ///< as typed
};

/// Returns "ball: radius 9.9998 ± 0.0001 mm, residual 0.56 µm rms".
std::string fit_sentence(const ObjectFit& fit) {
  if (!fit.usable) return fmt::format("{}: no fit", fit.object);
  const std::string radius =
      fit.numbers.contains("radius_mm") ? "radius " + fit_value_text(fit, "radius_mm", -1) + " mm, " : "";
  return fmt::format("{}: {}residual {} µm rms", fit.object, radius,
                     report::fixed(1000.0 * fit.numbers.at("rms_mm"), 2));
}

std::string measured_answer(const Measurement& m) {
  constexpr std::size_t kMostNamed = 3;
  if (m.cloud.size() == 0) return "No point was measured.";
  std::string answer = report::count(m.cloud.size()) + " points";
  for (std::size_t i = 0; i < std::min(m.fits.size(), kMostNamed); ++i)
    answer += "; " + fit_sentence(m.fits[i]);
  if (m.fits.size() > kMostNamed) answer += fmt::format("; {} more fits", m.fits.size() - kMostNamed);
  return answer + ".";
}

/// Returns what to do next, with the commands to type.
std::string measured_next_html(const MeasuredPage& page, const std::filesystem::path& captures) {
  const Twin& twin = page.twin;
  const auto next = [](const std::string& text, const std::vector<std::vector<std::string>>& commands) {
    std::string html;
    for (const auto& argv : commands)
      html += "<br><code>" + report::escape_html(report::shell_command(argv)) + "</code>";
    return next_paragraph(text, html);
  };
  const std::string file = twin.file.string(), simulated = (page.dir / "simulated").string();
  if (page.measurement.cloud.size() == 0) return next("find out below which pixels were masked, and why", {});
  if (!twin.projector || twin.objects.empty())
    return next(
        "describe projector and part in the twin, so that the measurement can be held against what the twin "
        "predicts",
        {});
  std::error_code error;
  if (twin.real.captures && !captures.empty() &&
      std::filesystem::equivalent(*twin.real.captures, captures, error))
    return next("hold the measurement against what the twin predicts:",
                {{"fringetwin", "cosim", file, "--out", (page.dir / "cosim").string()}});
  if (captures.empty()) return "";
  return next("hold the measurement against what the twin predicts:",
              {{"fringetwin", "render", file, "--out", simulated},
               {"fringetwin", "compare", file, "--real", captures.string(), "--sim", simulated, "--out",
                (page.dir / "compared").string()}});
}

/// Returns what the method itself adds to a number, "–" where that is not known.
std::string bias_text(const ObjectFit& fit, const std::string& key, int component) {
  const auto number = fit.bias.find(key);
  const auto vector = fit.bias_vectors.find(key);
  const double value = component < 0 && number != fit.bias.end()            ? number->second
                       : component >= 0 && vector != fit.bias_vectors.end() ? vector->second[component]
                                                                            : kNaN;
  return report::signed_fixed(value, 6);
}

std::string measured_fits_html(const Measurement& m) {
  if (m.fits.empty()) return "";
  report::Table table;
  table.caption =
      "Values with one standard error where it is known. Fits leave out points beyond four robust residual "
      "scales. Method: what the method itself adds, where --method-bias or the twin asks for it.";
  table.columns = {text_column("quantity"), text_column("unit"), {"measured"}, {"method"}};
  for (const ObjectFit& fit : m.fits) {
    table.add_row({fmt::format("{} ({})", fit.object, fit.kind)}, "group");
    const auto add = [&](const std::string& key, int component) {
      auto [name, unit] = name_and_unit(key);
      if (component >= 0) name += fmt::format(" {}", "xyz"[component]);
      table.add_row({name, unit, fit_value_text(fit, key, component), bias_text(fit, key, component)});
    };
    for (const std::string& key : vector_keys({&fit}))
      for (int i = 0; i < 3; ++i) add(key, i);
    for (const std::string& key : number_keys({&fit})) add(key, -1);
    table.add_row({"points used, of those within the gate", "", points_text(fit), ""});
    if (!fit.warning.empty()) table.add_row({fit.warning}, "fail");
  }
  return table.html();
}

/// Maps what became of the pixels of a camera.
std::string fates_figure(const MeasuredPage& page, const std::string& camera, const Image<PixelFate>& fates) {
  const bool code_alone = page.twin.fringes.steps == 0;
  ImageF map(fates.width, fates.height);
  for (std::size_t i = 0; i < fates.size(); ++i) map.data[i] = static_cast<float>(fates.data[i]);
  const report::MapStyle style{.limits = {0.0, static_cast<double>(kFates - 1)},
                               .title = code_alone ? "0 point, 1 decoded, 2 dark, 3 no word, 4 saturated"
                                                   : "0 point, 1 decoded, 2 dark, 3 no order, 4 saturated",
                               .max_width_px = 520};
  const std::string file = "pixels_" + camera + ".png";
  report::write_map_png(page.dir / file, map, style);
  return report::figure_html(
      "<div class=\"maps\">" + titled_map(report::escape_html(camera), report::map_html(map, style)) +
          "</div>",
      fmt::format("{}: what became of each pixel: 0 (violet) carries a point, 1 (blue) is decoded without "
                  "one, 2 (blue-green) shows too little modulation, 3 (green) has no {}, 4 (yellow) "
                  "is saturated. Full resolution: {}.",
                  camera, code_alone ? "certain word of the code" : "fringe order", file),
      "", page.command);
}

/// Tabulates how many pixels came to what, says why, and maps them.
std::string pixels_html(const MeasuredPage& page) {
  report::Table table;
  table.caption = "All pixels of each camera; one with several faults counts at the last of them.";
  table.columns = {text_column("camera"), text_column("pixels that"), {"n"}, {"share", "%"}};
  std::string figures;
  std::array<bool, kFates> there{};  // of which the reason is said
  for (std::size_t c = 0; c < page.measurement.cameras.size(); ++c) {
    const std::string& camera = page.measurement.cameras[c].camera;
    const Image<PixelFate> fates = pixel_fates(page.measurement, c);
    const auto first = static_cast<std::size_t>(c == 0 ? PixelFate::point : PixelFate::decoded);
    for (std::size_t k = first; k < kFates; ++k) {
      const auto fate = static_cast<PixelFate>(k);
      const auto n = std::ranges::count(fates.data, fate);
      table.add_row({k == first ? camera : "", fate_name(fate, c == 0, page.twin.fringes),
                     report::count(static_cast<unsigned long long>(n)),
                     report::fixed(100.0 * static_cast<double>(n) / static_cast<double>(fates.size()), 2)});
      there[k] = there[k] || (n > 0 && k > first);  // the first of a camera's fates is the good one
    }
    figures += fates_figure(page, camera, fates);
  }
  std::string reasons;
  for (std::size_t k = 0; k < kFates; ++k)
    if (there[k]) {
      const auto fate = static_cast<PixelFate>(k);
      reasons += "<p>Pixels that " + report::escape_html(fate_name(fate, true, page.twin.fringes)) + ": " +
                 report::escape_html(fate_reason(fate, page.twin, page.measurement)) + ".</p>\n";
    }
  return table.html() + reasons + figures;
}

/// Returns the image where the other is finite, else NaN.
ImageF where_finite(const ImageF& image, const ImageF& mask) {
  ImageF out = image;
  for (std::size_t i = 0; i < out.size(); ++i)
    if (!std::isfinite(mask.data[i])) out.data[i] = std::numeric_limits<float>::quiet_NaN();
  return out;
}

/// Phase, modulation and noise of one direction.
std::string direction_html(const MeasuredPage& page, const measure::CameraDecode& decode,
                           const DirectionDecode& d) {
  const std::string& camera = decode.camera;
  const std::string axis = axis_name(d.axis);
  const bool absolute = d.unwrapped && !d.coordinate_px.empty();
  if (d.pitches_px.empty() || d.amplitude_dn.empty() || (!absolute && d.wrapped_rad.empty())) return "";
  const std::size_t finest = d.wrapped_rad.empty() ? 0 : static_cast<std::size_t>(d.finest);
  const ImageF phase = absolute ? absolute_phase(page.twin, d) : d.wrapped_rad[finest];
  const Window window = data_window(finite_mask(phase));
  std::string maps, files;
  const auto add = [&](const ImageF& image, const std::string& title, const std::string& unit,
                       const std::string& name, const report::MapLimits& limits) {
    const report::MapStyle style{.limits = limits, .unit = unit, .title = title, .max_width_px = 520};
    const std::string file = fmt::format("{}_{}_{}.png", name, camera, axis);
    report::write_map_png(page.dir / file, image, style);
    maps += titled_map(title, report::map_html(crop(image, window), style));
    files += (files.empty() ? "" : ", ") + file;
  };
  add(phase, absolute ? "absolute phase" : "wrapped phase", "rad", "phase",
      report::robust_limits(crop(phase, window), 0.5, 99.5));
  const ImageF& modulation = d.amplitude_dn[finest];
  add(modulation, "modulation", decode.radiance ? "" : "DN", "modulation",
      {0.0, report::robust_limits(crop(modulation, window), 0.5, 99.5).high});
  if (!d.sigma_rad.empty()) {
    const ImageF sigma = where_finite(d.sigma_rad, phase);
    add(sigma, "standard deviation of the phase", "rad", "phase_sigma",
        report::robust_limits(crop(sigma, window), 0.5, 99.0));
  }
  return report::figure_html(
      "<div class=\"maps\">" + maps + "</div>",
      fmt::format(
          "{}, direction {}, {}: phase and its predicted standard deviation where they are known, and the "
          "modulation of all pixels, at the finest pitch ({:g} px). Full resolution: {}.",
          camera, axis, window.text(), d.pitches_px[finest], files),
      absolute ? "Φ = 2π (x_projector − phase_origin) / pitch" : "", page.command);
}

std::string cameras_html(const MeasuredPage& page) {
  std::string html;
  for (const measure::CameraDecode& camera : page.measurement.cameras) {
    throw_if_cancelled();
    html += camera_heading(camera.camera);
    for (const DirectionDecode& d : camera.directions) html += direction_html(page, camera, d);
  }
  return html;
}

std::string deviations_html(const MeasuredPage& page) {
  std::string html;
  for (const ObjectFit& fit : page.measurement.fits)
    html += deviation_html(page.dir, page.twin, page.command, fit.object,
                           {{&page.measurement, "measured", report::color::kReal}});
  return html;
}

std::string measured_footer_html(const Twin& twin, const Provenance& p) {
  return report::provenance_html({{"twin", twin.file.string()},
                                  {"command", report::shell_command(p.argv)},
                                  {"version", p.version}},
                                 p.inputs_sha256) +
         "<p>Every formula: docs/METRICS.md of the fringetwin source.</p>";
}

}  // namespace

void write_measurement_page(const std::filesystem::path& dir, const Twin& twin,
                            const Measurement& measurement, const std::filesystem::path& captures,
                            const Provenance& provenance, const std::map<std::string, double>& timing_s) {
  const MeasuredPage in{dir, twin, measurement, report::shell_command(provenance.argv)};
  report::Page page;
  page.title = twin.name.empty() ? twin.file.stem().string() : twin.name;
  page.answer = measured_answer(measurement);
  page.subtitle =
      fmt::format("Measurement of {} · {} {} · {} images each",
                  captures.empty() ? "a capture set" : captures.string(), twin.cameras.size(),
                  twin.cameras.size() == 1 ? "camera" : "cameras", expand_sequence(twin.fringes).size());
  page.summary_html = measured_next_html(in, captures);
  page.warnings = measurement.warnings;
  const auto add = [&](const char* id, const char* title, const std::string& body) {
    throw_if_cancelled();
    if (!body.empty()) page.sections.push_back({id, title, body});
  };
  add("fits", "Fitted geometry", measured_fits_html(measurement));
  add("pixels", "Which pixels were measured", pixels_html(in));
  add("phase", "Phase and modulation", cameras_html(in));
  add("deviation", "Deviation from the fitted surface", deviations_html(in));
  add("timing", "Timing", timing_html(timing_s));
  page.footer_html = measured_footer_html(twin, provenance);
  page.script = report::cloud_script();
  write_text_file(dir / "report.html", page.html());
}

}  // namespace fringetwin::compare
