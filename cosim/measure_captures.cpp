// SPDX-License-Identifier: Apache-2.0
#include "cosim/measure_captures.hpp"

#include "compare/geometry/deviation_cloud.hpp"
#include "compare/page/measurement_page.hpp"
#include "compare/result/result_json.hpp"
#include "cosim/load.hpp"
#include "cosim/simulate.hpp"
#include "measure/description_warnings.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::cosim {
namespace {

/// Returns the folder whose capture.toml is among the files; empty without one.
std::filesystem::path captures_among(const std::vector<std::filesystem::path>& files) {
  for (const std::filesystem::path& file : files)
    if (file.filename() == "capture.toml") return file.parent_path();
  return {};
}

}  // namespace

bool measuring_renders(const Twin& twin, bool method_bias) {
  const bool renders = method_bias || twin.measure.correct_pixel_area;
  if (renders) check_renderable(twin);
  return renders;
}

measure::Measurement measure_captures(const Twin& twin, const std::vector<CameraImages>& images,
                                      bool method_bias, StageTimer& timer) {
  timer.start("measure");
  measure::Measurement measurement = measure::measure(twin, images);
  if (measuring_renders(twin, method_bias)) {
    timer.start("method_bias");
    render::Renderer renderer;
    const Simulated simulated = simulate(twin, {}, renderer);
    measure::state_method_bias(twin, simulated.irradiance, measurement);
  }
  measure::put_first(measure::description_warnings(twin, images, measurement, nullptr), measurement.warnings);
  timer.stop();
  return measurement;
}

void write_measured(const std::filesystem::path& dir, const Twin& twin,
                    const measure::Measurement& measurement,
                    const std::vector<std::filesystem::path>& capture_files, const Origin& origin,
                    StageTimer& timer, const ExtraFiles& extra) {
  timer.start("write");
  std::vector<std::string> earlier = files_of_some_runs(twin);
  earlier.insert(earlier.begin(), {"result.json", "report.html"});
  begin_output(dir, earlier);
  measure::write_measurement(dir, measurement);
  compare::write_deviation_clouds(dir, measurement, {&measurement});
  write_npz_if_asked(dir, measurement, extra);
  timer.start("report");
  timer.seconds.insert(measurement.timing_s.begin(), measurement.timing_s.end());
  const compare::Provenance provenance = make_provenance(origin, twin, capture_files);
  compare::write_measurement_page(dir, twin, measurement, captures_among(capture_files), provenance,
                                  timer.seconds);
  write_figures_if_asked(dir, extra);
  timer.stop();
  write_text_file(dir / "result.json",
                  compare::measurement_json(twin, measurement, provenance, timer.seconds));
}

}  // namespace fringetwin::cosim
