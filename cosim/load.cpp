// SPDX-License-Identifier: Apache-2.0
#include "cosim/load.hpp"

#include "compare/verdict/limits.hpp"
#include "cosim/other_noise.hpp"
#include "cosim/shape/measured_shapes.hpp"
#include "measure/measurement.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::cosim {

Twin load_for_run(const std::filesystem::path& file, const std::map<std::string, std::string>& settings) {
  Twin twin = compare::load_checked_twin(file, settings);
  measure::check_fringes(twin);
  load_meshes(twin);
  return twin;
}

void check_renderable(const Twin& twin) {
  if (!twin.projector)
    throw UserError(ExitCode::usage, twin.file.string(),
                    "the twin has no [projector], so nothing can be rendered",
                    "add the projector, or use `fringetwin measure` on real captures");
  if (twin.objects.empty())
    throw UserError(ExitCode::usage, twin.file.string(),
                    "the twin has no [[object]], so nothing can be rendered",
                    "add one, e.g. shape = \"sphere\"");
}

Captures load_captures(const Twin& twin, const std::filesystem::path& dir) {
  const CaptureSet set = read_capture_set(dir, static_cast<int>(expand_sequence(twin.fringes).size()));
  Captures out;
  for (const Camera& camera : twin.cameras)
    out.cameras.push_back(load_camera_images(set, camera, twin.fringes));
  out.files = files_of(set);
  out.rendered_seed = seed_of_rendered(set.provenance);
  return out;
}

Twin load_renderable_twin(const std::filesystem::path& file,
                          const std::map<std::string, std::string>& settings) {
  Twin twin = load_for_run(file, settings);
  check_measured_shapes(twin);
  if (has_measured_shape(twin)) build_measured_shapes(twin, load_captures(twin, *twin.real.captures).cameras);
  return twin;
}

}  // namespace fringetwin::cosim
