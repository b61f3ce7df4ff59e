// SPDX-License-Identifier: Apache-2.0
#include "cosim/measured_shapes.hpp"

#include <algorithm>

#include "cosim/load.hpp"
#include "measure/measurement.hpp"
#include "measure/surface.hpp"
#include "twin/base/errors.hpp"
#include "twin/captures/measured_steps.hpp"

namespace fringetwin::cosim {

bool has_measured_shape(const Twin& twin) {
  return std::ranges::any_of(
      twin.objects, [](const Object& object) { return std::holds_alternative<MeasuredShape>(object.shape); });
}

void check_measured_shapes(const Twin& twin) {
  if (has_measured_shape(twin) && !twin.real.captures)
    throw UserError(ExitCode::usage, twin.file.string(),
                    "an object has shape = \"measured\" but [real] names no captures",
                    "add [real] captures = \"FOLDER\"");
}

void build_measured_shapes(Twin& twin, const std::vector<CameraImages>& real) {
  build_measured_shapes(twin, real, {});
}

double measured_shape_leverage(const Twin& twin) {
  double leverage = 0.0;
  for (const Object& object : twin.objects)
    if (const auto* shape = std::get_if<MeasuredShape>(&object.shape))
      leverage = std::max(leverage, measure::smoothing_leverage(shape->smoothing_px));
  return leverage;
}

void build_measured_shapes(Twin& twin, const std::vector<CameraImages>& real, const std::vector<int>& steps) {
  for (Object& object : twin.objects) {
    const auto* measured = std::get_if<MeasuredShape>(&object.shape);
    if (!measured) continue;
    const measure::Measurement m =
        measure::measure(twin, real, steps.empty() ? built_from_steps(twin, object, *measured) : steps);
    MeshShape mesh{.smooth = true, .mesh = measure::build_surface(twin, 0, m.cloud, measured->smoothing_px)};
    object.shape = mesh;
  }
}

Twin load_renderable_twin(const std::filesystem::path& file,
                          const std::map<std::string, std::string>& settings) {
  Twin twin = load_for_run(file, settings);
  check_measured_shapes(twin);
  if (has_measured_shape(twin)) build_measured_shapes(twin, load_captures(twin, *twin.real.captures).cameras);
  return twin;
}

}  // namespace fringetwin::cosim
