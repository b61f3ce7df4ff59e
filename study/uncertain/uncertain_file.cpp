// SPDX-License-Identifier: Apache-2.0
#include "study/uncertain/uncertain_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numbers>
#include <optional>
#include <set>

#include "study/plan/study_tables.hpp"
#include "twin/base/errors.hpp"
#include "twin/file/toml_reader.hpp"
#include "twin/lens/baseline.hpp"
#include "twin/twin.hpp"

namespace fringetwin::study {
namespace {

/// Returns the names of the spheres in the twin's file.
std::set<std::string> sphere_names(const TomlTable& twin) {
  std::set<std::string> names;
  for (const TomlTable& object : twin.tables("object"))
    if (object.string("shape") == "sphere") names.insert(object.string("name").value_or(""));
  return names;
}

UncertainForm read_form(const TomlTable& table, const std::set<std::string>& spheres,
                        std::set<std::string>* taken) {
  table.allow({"form", "name", "rms_mm", "degrees"});
  UncertainForm out;
  out.object = table.required_string("form");
  if (!spheres.contains(out.object))
    table.fail("form", fmt::format("\"{}\" is no sphere of the twin", out.object));
  if (!taken->insert("form of " + out.object).second)
    table.fail("form", fmt::format("names \"{}\" a second time", out.object));
  out.name = table.string("name").value_or("form of " + out.object);
  out.spread.rms_mm = table.required_number("rms_mm", NumberRange::positive(1e-6));
  if (table.has("degrees")) {
    const Eigen::VectorXd degrees =
        *table.vector("degrees", 2, NumberRange::between(FormSpread::kLeastDegree, FormSpread::kMostDegree));
    if (degrees != degrees.array().round().matrix() || degrees[0] > degrees[1])
      table.fail("degrees", "must be two whole numbers, the second not below the first");
    out.spread.low = static_cast<int>(degrees[0]);
    out.spread.high = static_cast<int>(degrees[1]);
  }
  return out;
}

// Returns the number of a key of the twin: as its file has it, or, where the file states the pose otherwise,
// the baseline or the angle that it makes.
std::optional<double> nominal_number(const TomlTable& twin, const std::filesystem::path& twin_file,
                                     const std::string& key) {
  if (const auto written = twin.number_at(key)) return written;
  if (!key.ends_with(".baseline_mm") && !key.ends_with(".angle_deg")) return std::nullopt;
  const Twin loaded = load_twin(twin_file);
  const Pose& T_first_world = loaded.cameras[0].T_cam_world;
  std::map<std::string, Pose> devices;
  if (loaded.projector) devices["projector"] = loaded.projector->T_proj_world;
  for (std::size_t i = 1; i < loaded.cameras.size(); ++i)
    for (const std::string& path : {"camera." + loaded.cameras[i].name, fmt::format("camera[{}]", i)})
      devices[path] = loaded.cameras[i].T_cam_world;
  const auto device = devices.find(key.substr(0, key.rfind('.')));
  if (device == devices.end()) return std::nullopt;
  if (key.ends_with(".baseline_mm")) return baseline_mm(T_first_world, device->second);
  const auto angle_rad = triangulation_rad(T_first_world, device->second);
  return angle_rad ? std::optional(*angle_rad * 180.0 / std::numbers::pi) : std::nullopt;
}

UncertainKey read_uncertain(const TomlTable& table, const TomlTable& twin,
                            const std::filesystem::path& twin_file, std::set<std::string>* taken) {
  table.allow({"key", "keys", "form", "name", "value", "distribution", "sigma", "half_width"});
  UncertainKey out;
  out.keys = read_study_keys(table, taken);
  out.name = table.string("name").value_or(out.keys[0]);
  if (table.has("sigma") == table.has("half_width")) table.fail("", "needs either sigma or half_width");
  const bool uniform = table.has("half_width");
  const auto stated = table.choice("distribution", {"normal", "uniform"});
  if (stated && (*stated == "uniform") != uniform)
    table.fail("distribution",
               fmt::format("is \"{}\", which takes {}", *stated, uniform ? "sigma" : "half_width"));
  out.distribution = uniform ? Distribution::uniform : Distribution::normal;
  const char* spread = uniform ? "half_width" : "sigma";
  out.spread = table.required_number(spread, NumberRange::positive(1e-12));
  out.stated = table.has("value");
  for (const std::string& key : out.keys) {
    const auto value = out.stated ? table.number("value") : nominal_number(twin, twin_file, key);
    if (!value)
      table.fail(table.has("key") ? "key" : "keys",
                 fmt::format("\"{}\" has no number in the twin's file", key),
                 "give the middle of the distribution: value = ...");
    out.values.push_back(*value);
  }
  return out;
}

}  // namespace

std::vector<std::string> with_uncertain_keys(const std::vector<std::string>& keys) {
  std::vector<std::string> all = {"calibration", "noise", "uncertain"};
  all.insert(all.end(), keys.begin(), keys.end());
  return all;
}

double read_coverage(const TomlTable& root) {
  const double coverage = root.number("coverage").value_or(0.95);
  if (!(coverage > 0.0 && coverage < 1.0)) root.fail("coverage", "must lie between 0 and 1");
  return coverage;
}

UncertainSettings read_uncertain_settings(const TomlTable& root, const std::filesystem::path& twin_file) {
  UncertainSettings out;
  out.inputs.noise = root.boolean("noise").value_or(true);
  out.calibration = root.boolean("calibration").value_or(false);
  const TomlTable twin = TomlTable::parse_file(twin_file, ExitCode::usage);
  const std::set<std::string> spheres = sphere_names(twin);
  std::set<std::string> taken, names = {"calibration", "noise"};
  for (const TomlTable& table : root.tables("uncertain")) {
    const bool form = table.has("form");
    if (form)
      out.inputs.forms.push_back(read_form(table, spheres, &taken));
    else
      out.inputs.keys.push_back(read_uncertain(table, twin, twin_file, &taken));
    const std::string& name = form ? out.inputs.forms.back().name : out.inputs.keys.back().name;
    if (!names.insert(name).second)
      table.fail(table.has("name") ? "name" : "",
                 fmt::format("\"{}\" is the name of another input, too", name));
  }
  if (out.inputs.keys.empty() && out.inputs.forms.empty() && !out.calibration && !out.inputs.noise)
    root.fail("uncertain", "is missing: nothing is uncertain",
              "give an [[uncertain]], or calibration = true");
  return out;
}

UncertainInputs complete_inputs(const UncertainSettings& settings, const std::filesystem::path& twin) {
  UncertainInputs out = settings.inputs;
  if (settings.calibration) out.calibration = VirtualRig(twin, true).calibration_directions();
  return out;
}

}  // namespace fringetwin::study
