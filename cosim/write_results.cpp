// SPDX-License-Identifier: Apache-2.0
#include "cosim/write_results.hpp"

#include <fmt/format.h>

#include <map>

#include "compare/comparison.hpp"
#include "compare/geometry/deviation_cloud.hpp"
#include "compare/page/report_page.hpp"
#include "compare/result/result_json.hpp"
#include "cosim/other_noise.hpp"
#include "measure/measurement.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/base/progress.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::cosim {
namespace {

std::map<std::string, std::string> capture_provenance(const Twin& twin, const Rendering& rendering) {
  std::map<std::string, std::string> provenance = {
      {"device", kRenderedBy + rendering.device},
      {"twin", twin.name},
      {"seed", std::to_string(rendering.seed)},
  };
  for (const compare::RenderNote& note : rendering.notes) provenance["rendered " + note.camera] = note.text();
  for (const Camera& camera : twin.cameras)
    if (camera.sensor.exposure_ms)
      provenance["exposure_ms " + camera.name] = fmt::format("{}", *camera.sensor.exposure_ms);
  return provenance;
}

std::vector<const CameraImages*> pointers_to(const std::vector<CameraImages>& cameras) {
  std::vector<const CameraImages*> out;
  for (const CameraImages& images : cameras) out.push_back(&images);
  return out;
}

/// Throws UserError(usage) where a texture would be written over a file that the run has read.
void check_textures(const std::filesystem::path& dir, const Twin& twin,
                    const compare::Refinement& refinement) {
  for (std::size_t c = 0; c < refinement.texture.size(); ++c) {
    if (!refinement.texture[c]) continue;
    const std::filesystem::path file = dir / twin.cameras[c].texture_file;
    for (const std::filesystem::path& input : twin.input_files) {
      std::error_code error;
      if (std::filesystem::equivalent(input, file, error))
        throw UserError(
            ExitCode::usage, fmt::format("--out {}", dir.string()),
            fmt::format("{} is an input of this run, and the refined texture would take its place",
                        twin.cameras[c].texture_file.string()),
            "choose another folder");
    }
  }
}

/// Writes the textures that a refinement gave the cameras, under the names that refined.toml has.
void write_textures(const std::filesystem::path& dir, const Twin& twin,
                    const compare::Refinement& refinement) {
  for (std::size_t c = 0; c < refinement.texture.size(); ++c) {
    const Camera& camera = twin.cameras[c];
    if (!refinement.texture[c] || !camera.texture) continue;
    std::vector<NamedChannel> channels{{"factor", &camera.texture->factor}};
    if (!camera.texture->offset.empty()) channels.emplace_back("offset", &camera.texture->offset);
    write_exr(dir / camera.texture_file, channels);
  }
}

/// Writes what was measured on each side, both coloured alike.
void write_measured_sides(const std::filesystem::path& dir, const Run& run, const ExtraFiles& extra) {
  std::vector<std::pair<const char*, const measure::Measurement*>> sides;
  if (run.simulated.measurement) sides.emplace_back("measured_simulated", &*run.simulated.measurement);
  if (run.real.measurement) sides.emplace_back("measured_real", &*run.real.measurement);
  std::vector<const measure::Measurement*> all;
  for (const auto& side : sides) all.push_back(side.second);
  for (const auto& [name, measurement] : sides) {
    begin_output(dir / name, files_of_some_runs(run.twin), Writers::several);
    measure::write_measurement(dir / name, *measurement);
    compare::write_deviation_clouds(dir / name, *measurement, all);
    write_npz_if_asked(dir / name, *measurement, extra);
  }
}

}  // namespace

compare::Provenance make_provenance(const Origin& origin, const Twin& twin,
                                    const std::vector<std::filesystem::path>& capture_files,
                                    const Rendering& rendering) {
  compare::Provenance provenance;
  provenance.argv = origin.argv;
  provenance.version = origin.version;
  std::vector<std::filesystem::path> inputs = twin.input_files;
  inputs.insert(inputs.end(), capture_files.begin(), capture_files.end());
  provenance.inputs_sha256 = compare::sha256_of_files(inputs);
  provenance.device = rendering.device;
  provenance.rendered = rendering.notes;
  provenance.seed = rendering.seed;
  return provenance;
}

void write_simulated(const std::filesystem::path& dir, const Twin& twin,
                     const std::vector<CameraImages>& captures, const std::vector<CameraImages>* irradiance,
                     const Rendering& rendering) {
  const std::map<std::string, std::string> provenance = capture_provenance(twin, rendering);
  begin_output(dir, {"capture.toml", "radiance/capture.toml"});
  for (const CameraImages& images : captures) write_camera_images(dir, images);
  if (irradiance) {
    for (const CameraImages& images : *irradiance) write_camera_radiance(dir, images);
    write_capture_toml(dir / "radiance", pointers_to(*irradiance), provenance, "exr", "..");
  }
  write_capture_toml(dir, pointers_to(captures), provenance, "png");
}

void write_simulated_side(const std::filesystem::path& dir, Run& run, bool radiance) {
  run.timer.start("write");
  if (run.options.textured()) check_textures(dir, run.twin, *run.options.refinement);
  begin_output(dir, {"result.json", "refined.toml", "report.html"});
  write_simulated(dir / "simulated", run.twin, run.simulated.images,
                  radiance ? &run.simulated.irradiance : nullptr, run.rendering);
  if (run.options.textured()) write_textures(dir, run.twin, *run.options.refinement);
  if (run.options.refinement) write_text_file(dir / "refined.toml", run.refined_toml);
  run.timer.stop();
}

compare::Comparison compare_and_write(const std::filesystem::path& dir, Run& run, const Origin& origin,
                                      const ExtraFiles& extra) {
  run.timer.start("compare");
  throw_if_cancelled();
  compare::Comparison comparison = compare::compare(run.twin, run.real, run.simulated, run.options);
  run.timer.start("write");
  throw_if_cancelled();
  begin_output(dir, {"result.json", "report.html"});
  write_measured_sides(dir, run, extra);
  run.timer.start("report");
  throw_if_cancelled();
  const compare::Provenance provenance = make_provenance(origin, run.twin, run.capture_files, run.rendering);
  compare::write_report(dir, run.twin, run.real, run.simulated, comparison, run.options, provenance,
                        run.timer.seconds);
  write_figures_if_asked(dir, extra);
  run.timer.stop();
  throw_if_cancelled();
  write_text_file(dir / "result.json",
                  compare::comparison_json(run.twin, comparison, provenance, run.timer.seconds));
  return comparison;
}

}  // namespace fringetwin::cosim
