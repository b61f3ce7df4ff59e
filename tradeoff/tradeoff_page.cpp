// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <sched.h>

#include <cmath>
#include <fstream>

#include "report/json.hpp"
#include "report/provenance.hpp"
#include "report/text.hpp"
#include "tradeoff/tradeoff_json.hpp"

namespace fringetwin::tradeoff {

using report::Json, report::json_number;

Json json_change(const ImageChange& c) {
  return {{"phase_rms_rad", json_number(c.phase_rms_rad)},
          {"phase_interior_rms_rad", json_number(c.phase_interior_rms_rad)},
          {"gray_rms_dn", json_number(c.gray_rms_dn)},
          {"gray_interior_rms_dn", json_number(c.gray_interior_rms_dn)},
          {"gray_edge_rms_dn", json_number(c.gray_edge_rms_dn)},
          {"n_phase", c.n_phase},
          {"n_gray", c.n_gray},
          {"n_interior", c.n_interior}};
}

std::string json_text(const Json& json) {
  return json.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

std::string machine_name() {
  std::ifstream in("/proc/cpuinfo");
  std::string line, model = "unknown CPU";
  while (std::getline(in, line))
    if (line.starts_with("model name")) {
      const auto colon = line.find(": ");
      if (colon != std::string::npos) model = line.substr(colon + 2);
      break;
    }
  cpu_set_t set;
  CPU_ZERO(&set);
  const int n = sched_getaffinity(0, sizeof(set), &set) == 0 ? CPU_COUNT(&set) : 1;
  return fmt::format("{} x {}", n, model);
}

Json json_head(const std::string& schema, const Twin& twin, const compare::Provenance& provenance,
               const render::DeviceInfo& device, const PixelSubset& subset,
               const std::map<std::string, double>& timing_s) {
  Json out;
  out["schema"] = schema;
  out["twin"] = twin.name;
  out["provenance"] = {
      {"argv", provenance.argv}, {"version", provenance.version}, {"inputs_sha256", provenance.inputs_sha256},
      {"device", device.name},   {"driver", device.driver},       {"machine", machine_name()},
      {"seed", provenance.seed}};
  out["timing_s"] = Json::object();
  for (const auto& [stage, seconds] : timing_s) out["timing_s"][stage] = json_number(seconds);
  std::size_t n_image = 0, n_edge_image = 0, n_windows = 0;
  for (const CameraSubset& c : subset.cameras) {
    n_image += c.n_interior_image + c.n_edge_image;
    n_edge_image += c.n_edge_image;
    n_windows += c.windows.size();
  }
  out["subset"] = {{"text", subset.text()},       {"n_pixels", subset.n_pixels()},
                   {"n_windows", n_windows},      {"window_px", subset.options.window_px},
                   {"seed", subset.options.seed}, {"n_pixels_image", n_image},
                   {"n_edge_image", n_edge_image}};
  return out;
}

std::string provenance_html(const Twin& twin, const compare::Provenance& p,
                            const render::DeviceInfo& device) {
  return report::provenance_html(
             {{"twin", twin.file.string()},
              {"command", report::shell_command(p.argv)},
              {"version", p.version},
              {"device", fmt::format("{} ({}, Vulkan {})", device.name, device.driver, device.api_version)},
              {"machine", machine_name()},
              {"seed", std::to_string(p.seed)}},
             p.inputs_sha256) +
         "<p>Every formula: docs/METRICS.md of the fringetwin source.</p>";
}

std::string scientific(double value) {
  return std::isfinite(value) ? fmt::format("{:.1e}", value) : std::isnan(value) ? "–" : "∞";
}

}  // namespace fringetwin::tradeoff
