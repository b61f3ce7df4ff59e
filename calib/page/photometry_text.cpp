// SPDX-License-Identifier: Apache-2.0
// Photometry as blocks for twin.toml and as JSON.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "calib/page/photometry_page.hpp"
#include "report/json.hpp"

namespace fringetwin::calib {
namespace {

using report::Json, report::json_number, report::json_numbers;

/// Prints as many digits as the sigma leaves, two of the sigma itself: "40.53 ± 0.08" and so that TOML reads
/// a number.
std::string digits(double value, double sigma) {
  if (!std::isfinite(sigma) || !(sigma > 0.0)) return fmt::format("{:.6g}", value);
  const int decimals = std::clamp(1 - static_cast<int>(std::floor(std::log10(sigma))), 0, 9);
  return fmt::format("{:.{}f}", value, decimals);
}
std::string digits(const Estimate& e) { return digits(e.value, e.sigma); }

/// A line of a block: what was measured may take the place of what a twin says, what was taken over from the
/// twin stands there for reading only.
struct BlockLine {
  TomlKey key;
  bool is_measured = true;
  std::string above = {};  ///< a comment on the line before, where the value is long
};
using BlockLines = std::vector<BlockLine>;

std::string text_of(const BlockLines& lines) {
  std::string out;
  for (const BlockLine& line : lines) {
    if (!line.above.empty()) out += "# " + line.above + "\n";
    if (line.key.name.empty()) continue;
    const std::string left = line.key.name + " = " + line.key.value;
    out += line.key.comment.empty() ? left + "\n" : fmt::format("{:<32}# {}\n", left, line.key.comment);
  }
  return out;
}

/// Leaves out what was not measured.
std::vector<TomlKey> measured(const BlockLines& lines) {
  std::vector<TomlKey> keys;
  for (const BlockLine& line : lines)
    if (line.is_measured) keys.push_back(line.key);
  return keys;
}

std::string plus_minus(const Estimate& e) {
  return std::isfinite(e.sigma) ? fmt::format("± {:.2g}", e.sigma) : "sigma unknown";
}

/// The camera's response as a key of [camera.sensor].
BlockLine camera_response_line(const ResponseFit& fit) {
  std::string points;
  for (const CameraResponse::Corner& c : fit.response.corners)
    points += fmt::format("{}[{:.3f}, {:.3f}]", points.empty() ? "" : ", ", c.in_dn, c.out_dn);
  return {.key = {"response", "{ table = [" + points + "] }"},
          .above = fmt::format("predicts every second exposure to {:.2g} DN rms from the others",
                               fit.held_out_rms_dn)};
}

/// The file of a map as a key of [camera.sensor], beside photometry.toml; nothing where noise outweighs it.
/// `black_known`: without the black level the factors of the pixels are no measured ones.
void add_map_line(BlockLines& lines, const std::string& name, const std::optional<PixelMapEstimate>& map,
                  double scale, const std::string& unit, const std::string& camera, bool black_known = true) {
  if (!map || !map->is_told()) return;
  lines.push_back(
      {{name, fmt::format("\"{}\"", pixel_map_file(name, camera)),
        fmt::format(
            "pixels differ by {:.3g} {} rms, each known to ± {:.2g} (noise of the means of {} images)",
            scale * map->rms, unit, scale * map->noise, map->n_images)},
       black_known});
}

BlockLines sensor_lines(const CameraPhotometry& c) {
  const Sensor& s = c.sensor;
  BlockLines out;
  out.push_back({{"bit_depth", fmt::format("{}", s.bit_depth)}, false});
  if (s.exposure_ms) out.push_back({{"exposure_ms", fmt::format("{}", *s.exposure_ms)}, false});
  out.push_back({{"gain_dn", fmt::format("{}", s.gain_dn), "the twin's: `fringetwin cosim` fits it"}, false});
  if (c.black_measured)
    out.push_back({{"black_level_dn", digits(c.black_level_dn),
                    plus_minus(c.black_level_dn) + ", mean of the dark images"}});
  else
    out.push_back({{"black_level_dn", fmt::format("{}", s.black_level_dn),
                    c.black_known ? "the twin's: not measured without dark images"
                                  : "neither measured, without dark images, nor stated in the twin"},
                   false});
  if (c.transfer) {
    const PhotonTransfer& t = *c.transfer;
    out.push_back({{"electrons_per_dn", digits(t.electrons_per_dn),
                    fmt::format("{}; {:.5g} ± {:.2g} DN per electron, from {} over {:.0f}...{:.0f} DN",
                                plus_minus(t.electrons_per_dn), t.dn_per_electron.value,
                                t.dn_per_electron.sigma, c.noise_from, t.low_dn, t.high_dn)}});
    if (c.black_known)
      out.push_back({{"read_noise_dn", digits(t.read_noise_dn),
                      fmt::format("{}, without rounding; {:.2g} electrons{}", plus_minus(t.read_noise_dn),
                                  t.read_noise_electrons.value,
                                  std::isfinite(c.dark_noise_dn.value) ? ", from the dark images" : "")}});
    else
      out.push_back(
          {.key = {},
           .is_measured = false,
           .above = "read_noise_dn is not told: it is the noise at the black level, which nothing says"});
  } else if (std::isfinite(c.dark_noise_dn.value)) {
    out.push_back(
        {{"read_noise_dn", digits(c.dark_noise_dn), plus_minus(c.dark_noise_dn) + ", from the dark images"}});
  }
  if (c.response) out.push_back(camera_response_line(*c.response));
  add_map_line(out, "prnu", c.factors, 100.0, "%", c.camera, c.black_known);
  add_map_line(out, "dsnu", c.offsets, 1.0, "DN", c.camera);
  return out;
}

TomlKey factors_key(const std::string& name, const std::vector<double>& factors) {
  return {name, fmt::format("[{:.6f}]", fmt::join(factors, ", "))};
}

/// `exposure_factors`: empty where the camera has none of its own.
BlockLines camera_lines(const CameraPhotometry& c, const std::vector<double>& exposure_factors) {
  BlockLines out;
  if (!exposure_factors.empty()) out.push_back({factors_key("exposure_factors", exposure_factors)});
  if (c.flat) {
    const auto& a = c.flat->a;
    out.push_back(
        {{"vignetting", fmt::format("[{}, {}, {}]", digits(a[0]), digits(a[1]), digits(a[2])),
          fmt::format("± {:.2g}, {:.2g}, {:.2g}; {:.3f} at the corners{}", a[0].sigma, a[1].sigma, a[2].sigma,
                      c.flat->corner, c.black_known ? "" : ", with a black level of 0")},
         c.black_known});
  }
  return out;
}

BlockLine response_line(const ProjectorPhotometry& p) {
  const std::string gamma = fmt::format("gamma {} {}, which leaves {:.2g} of the range", digits(p.gamma),
                                        plus_minus(p.gamma), p.gamma_misfit);
  switch (p.response.kind) {
    case ProjectorResponse::Kind::linear:
      return {{"response", "\"linear\"", gamma}};
    case ProjectorResponse::Kind::gamma:
      return {{"response", fmt::format("{{ gamma = {} }}", digits(p.gamma)), gamma}};
    case ProjectorResponse::Kind::table:
      break;
  }
  double sigma = 0.0;
  for (const double s : p.curve_sigma) sigma = std::max(sigma, s);
  return {.key = {"response", fmt::format("{{ table = [{:.5g}] }}", fmt::join(p.response.table, ", "))},
          .above = fmt::format("± {:.2g} (largest); nearest gamma: {}", sigma, gamma)};
}

BlockLines projector_lines(const Photometry& photometry) {
  BlockLines out;
  if (const std::optional<LightOfImages> light = light_of_images(photometry))
    out.push_back({.key = factors_key("light_factors", light->light_factors),
                   .above = fmt::format(
                       "± {:.2g} (largest), one for each image of the first capture; another has others",
                       measure::largest_told(light->sigma))});
  const ProjectorPhotometry* p = photometry.projector();
  if (p == nullptr) return out;
  if (p->response_known) out.push_back(response_line(*p));
  if (std::isfinite(p->blur_px.value) && !p->tells_blur())
    out.push_back({.key = {},
                   .is_measured = false,
                   .above = fmt::format(
                       "blur_px stays as it is: {} {} is told neither from none nor from the twin's {:g}",
                       digits(p->blur_px), plus_minus(p->blur_px), p->blur_of_twin_px)});
  else if (std::isfinite(p->blur_px.value))
    out.push_back({{"blur_px", digits(p->blur_px),
                    fmt::format("{}; the contrasts are {:.1f} % off a Gaussian's", plus_minus(p->blur_px),
                                100.0 * p->blur_misfit)}});
  return out;
}

std::string projector_toml(const Photometry& photometry) {
  const BlockLines lines = projector_lines(photometry);
  if (lines.empty()) return "";
  const ProjectorPhotometry* p = photometry.projector();
  const bool has_keys = p != nullptr && (p->response_known || std::isfinite(p->blur_px.value));
  const std::string from = has_keys ? fmt::format("# Keys of [projector], from camera \"{}\", direction {}\n",
                                                  photometry.cameras[photometry.projector_camera].camera,
                                                  axis_name(p->harmonics.axis))
                                    : "";
  return "\n" + from + "[projector]\n" + text_of(lines);
}

/// The factors of each camera's images, where its light differs; empty lists where it does not.
std::vector<std::vector<double>> exposures(const Photometry& photometry) {
  const std::optional<LightOfImages> light = light_of_images(photometry);
  if (light && !light->exposure_factors.empty()) return light->exposure_factors;
  return std::vector<std::vector<double>>(photometry.cameras.size());
}

void put(Json& out, const std::string& name, const std::string& unit, const Estimate& e) {
  const std::string tail = unit.empty() ? "" : "_" + unit;
  out[name + tail] = json_number(e.value);
  out[name + "_sigma" + tail] = json_number(e.sigma);
}

Json transfer_json(const CameraPhotometry& c) {
  if (!c.transfer) return nullptr;
  const PhotonTransfer& t = *c.transfer;
  Json out = {{"noise_from", c.noise_from}};
  put(out, "dn_per_electron", "", t.dn_per_electron);
  put(out, "electrons_per_dn", "", t.electrons_per_dn);
  put(out, "offset", "dn2", t.offset_dn2);
  put(out, "read_variance", "dn2", t.read_variance_dn2);
  put(out, "read_noise", "dn", t.read_noise_dn);
  put(out, "read_noise", "electrons", t.read_noise_electrons);
  put(out, "slope_change", "", t.slope_change);
  out["residual_rms"] = json_number(t.residual_rms);
  out["residual_worst"] = json_number(t.residual_worst);
  out["chi2_per_dof"] = json_number(t.chi2_per_dof);
  out["low_dn"] = json_number(t.low_dn);
  out["high_dn"] = json_number(t.high_dn);
  out["flicker"] = c.noise_from == "repeats" ? json_number(c.flicker) : Json(nullptr);
  out["n"] = t.n;
  out["bins"] = Json::array();
  for (const TransferBin& b : t.bins)
    out["bins"].push_back({{"level_dn", json_number(b.level_dn)},
                           {"variance_dn2", json_number(b.variance_dn2)},
                           {"variance_sigma_dn2", json_number(b.sigma_dn2)},
                           {"line_dn2", json_number(b.line_dn2)},
                           {"n", b.n}});
  return out;
}

Json saturation_json(const CameraPhotometry& c) {
  Json out = {{"level_dn", c.saturation.level_dn},
              {"reached", c.saturation.reached},
              {"fraction", c.saturation.fraction}};
  Estimate full_well;
  if (c.saturation.reached && c.transfer && c.black_known) {
    const double span = c.saturation.level_dn - c.sensor.black_level_dn;
    full_well = {span * c.transfer->electrons_per_dn.value, span * c.transfer->electrons_per_dn.sigma};
  }
  put(out, "capacity", "electrons", full_well);
  return out;
}

Json linearity_json(const CameraPhotometry& c) {
  if (!c.linearity) return nullptr;
  const ExposureLinearity& l = *c.linearity;
  Json out;
  put(out, "slope", "dn_per_ms", l.slope_dn_per_ms);
  put(out, "offset", "dn", l.offset_dn);
  out["worst_percent"] = json_number(l.worst_percent);
  out["points"] = Json::array();
  for (std::size_t i = 0; i < l.exposure_ms.size(); ++i)
    out["points"].push_back({{"exposure_ms", l.exposure_ms[i]},
                             {"level_dn", json_number(l.level_dn[i])},
                             {"residual_percent", json_number(l.residual_percent[i])}});
  return out;
}

Json camera_response_json(const CameraPhotometry& c) {
  if (!c.response) return nullptr;
  const ResponseFit& r = *c.response;
  Json out = {{"has_knee", r.has_knee}};
  put(out, "slope_at_origin", "dn_per_ms", r.dn_per_ms);
  put(out, "delay", "ms", r.delay_ms);
  put(out, "knee", "dn", r.knee_dn);
  put(out, "knee_slope_ratio", "", r.knee_slope_ratio);
  out["held_out_rms_dn"] = json_number(r.held_out_rms_dn);
  out["held_out_rms_own_light_dn"] = json_number(r.held_out_rms_own_light_dn);
  out["table"] = Json::array();
  for (std::size_t i = 0; i < r.response.corners.size(); ++i)
    out["table"].push_back({{"in_dn", json_number(r.response.corners[i].in_dn)},
                            {"out_dn", json_number(r.response.corners[i].out_dn)},
                            {"out_sigma_dn", json_number(r.corner_sigma_dn[i])}});
  out["held_out"] = Json::array();
  for (std::size_t i = 0; i < r.held_out_ms.size(); ++i)
    out["held_out"].push_back({{"exposure_ms", json_number(r.held_out_ms[i])},
                               {"rms_dn", json_number(r.held_out_image_dn[i])},
                               {"own_light", json_number(r.own_light[i])}});
  return out;
}

Json flat_json(const CameraPhotometry& c) {
  if (!c.flat) return nullptr;
  const FlatField& f = *c.flat;
  Json out = {{"vignetting", Json::array()}, {"vignetting_sigma", Json::array()}};
  for (const Estimate& a : f.a) {
    out["vignetting"].push_back(json_number(a.value));
    out["vignetting_sigma"].push_back(json_number(a.sigma));
  }
  out["corner"] = json_number(f.corner);
  put(out, "level", "dn", f.level_dn);
  put(out, "gradient_x", "", f.gradient_x);
  put(out, "gradient_y", "", f.gradient_y);
  out["residual_rms"] = json_number(f.residual_rms);
  out["n"] = f.n;
  return out;
}

Json map_json(const std::optional<PixelMapEstimate>& map, const std::string& unit) {
  if (!map) return nullptr;
  const std::string tail = unit.empty() ? "" : "_" + unit;
  return {{"rms" + tail, json_number(map->rms)},
          {"noise" + tail, json_number(map->noise)},
          {"n_images", map->n_images},
          {"n_unknown", map->n_unknown},
          {"written", map->is_told()}};
}

Json light_json(const CameraPhotometry& c) {
  if (!c.light) return nullptr;
  const measure::LightFactors& l = *c.light;
  return {{"differ", l.differ()},
          {"factor", json_numbers(l.factor)},
          {"factor_sigma", json_numbers(l.sigma)},
          {"phase_rms_rad", json_number(l.phase_rms_rad)},
          {"residual_ratio",
           l.residual_before > 0.0 ? json_number(l.residual_after / l.residual_before) : Json(nullptr)},
          {"n", l.n_pixels}};
}

Json values(const std::vector<Estimate>& estimates, double Estimate::*part) {
  Json out = Json::array();
  for (const Estimate& e : estimates) out.push_back(json_number(e.*part));
  return out;
}

Json pitch_json(const PitchHarmonics& h) {
  return {{"pitch_px", h.pitch_px},
          {"median_dn", json_numbers(h.median_dn)},
          {"amplitude", values(h.amplitude, &Estimate::value)},
          {"amplitude_sigma", values(h.amplitude, &Estimate::sigma)},
          {"quadrature", values(h.quadrature, &Estimate::value)},
          {"quadrature_sigma", values(h.quadrature, &Estimate::sigma)},
          {"camera_factor", json_numbers(h.camera_factor)}};
}

Json response_json(const ProjectorPhotometry& p) {
  if (!p.response_known) return nullptr;
  Json out = {{"kind", p.response.kind == ProjectorResponse::Kind::linear  ? "linear"
                       : p.response.kind == ProjectorResponse::Kind::gamma ? "gamma"
                                                                           : "table"}};
  put(out, "gamma", "", p.gamma);
  out["gamma_misfit"] = json_number(p.gamma_misfit);
  out["harmonics"] = values(p.response_harmonics, &Estimate::value);
  out["harmonics_sigma"] = values(p.response_harmonics, &Estimate::sigma);
  out["level"] = json_numbers(p.curve_level);
  out["light"] = json_numbers(p.curve_light);
  out["light_sigma"] = json_numbers(p.curve_sigma);
  return out;
}

Json direction_json(const ProjectorPhotometry& p) {
  Json out = {{"direction", axis_name(p.harmonics.axis)},
              {"steps", p.harmonics.steps},
              {"n", p.harmonics.n},
              {"mean_dn", json_number(p.harmonics.mean_dn)},
              {"pitches", Json::array()}};
  for (const PitchHarmonics& h : p.harmonics.pitches) out["pitches"].push_back(pitch_json(h));
  out["response"] = response_json(p);
  put(out, "blur", "px", p.blur_px);
  out["blur_misfit"] = json_number(p.blur_misfit);
  out["mtf"] = Json::array();
  for (const MtfPoint& m : p.mtf) {
    Json row = {{"pitch_px", m.pitch_px}, {"order", m.order}, {"period_px", m.period_px}};
    put(row, "contrast", "", m.contrast);
    row["camera_factor"] = json_number(m.camera_factor);
    row["gaussian"] = json_number(m.gaussian);
    out["mtf"].push_back(row);
  }
  return out;
}

}  // namespace

std::string photometry_toml(const Photometry& photometry) {
  std::string out =
      "# Measured by fringetwin photometry: put these keys into the tables of the same name in twin.toml\n"
      "# (`--into twin.toml` puts what was measured there). ± is one standard error.\n";
  const std::vector<std::vector<double>> exposure_factors = exposures(photometry);
  for (std::size_t c = 0; c < photometry.cameras.size(); ++c) {
    const CameraPhotometry& camera = photometry.cameras[c];
    out += fmt::format("\n[[camera]]\nname = \"{}\"\n", camera.camera) +
           text_of(camera_lines(camera, exposure_factors[c])) + "[camera.sensor]\n" +
           text_of(sensor_lines(camera));
  }
  return out + projector_toml(photometry);
}

std::vector<TomlBlock> photometry_blocks(const Photometry& photometry) {
  std::vector<TomlBlock> out;
  const std::vector<std::vector<double>> exposure_factors = exposures(photometry);
  for (std::size_t c = 0; c < photometry.cameras.size(); ++c) {
    const CameraPhotometry& camera = photometry.cameras[c];
    out.push_back({.table = {"camera"},
                   .entry = camera.camera,
                   .keys = measured(camera_lines(camera, exposure_factors[c]))});
    out.push_back(
        {.table = {"camera", "sensor"}, .entry = camera.camera, .keys = measured(sensor_lines(camera))});
  }
  if (const BlockLines lines = projector_lines(photometry); !lines.empty())
    out.push_back({.table = {"projector"}, .keys = measured(lines)});
  return out;
}

std::string photometry_json(const Photometry& photometry, const Origin& origin) {
  Json out;
  out["schema"] = "fringetwin-photometry/1";
  out["provenance"] = {
      {"argv", origin.argv}, {"version", origin.version}, {"inputs_sha256", origin.inputs_sha256}};
  out["cameras"] = Json::array();
  for (const CameraPhotometry& c : photometry.cameras) {
    Json camera = {{"camera", c.camera}};
    put(camera, "black_level", "dn", c.black_level_dn);
    put(camera, "dark_noise", "dn", c.dark_noise_dn);
    camera["photon_transfer"] = transfer_json(c);
    camera["saturation"] = saturation_json(c);
    camera["exposure_linearity"] = linearity_json(c);
    camera["camera_response"] = camera_response_json(c);
    camera["flat_field"] = flat_json(c);
    camera["prnu"] = map_json(c.factors, "");
    camera["dsnu"] = map_json(c.offsets, "dn");
    camera["light"] = light_json(c);
    camera["projector"] = Json::array();
    for (const ProjectorPhotometry& p : c.directions) camera["projector"].push_back(direction_json(p));
    out["cameras"].push_back(camera);
  }
  out["projector_from"] = nullptr;
  if (const ProjectorPhotometry* p = photometry.projector())
    out["projector_from"] = {{"camera", photometry.cameras[photometry.projector_camera].camera},
                             {"direction", axis_name(p->harmonics.axis)}};
  out["warnings"] = photometry.warnings;
  return out.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace fringetwin::calib
