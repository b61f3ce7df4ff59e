// SPDX-License-Identifier: Apache-2.0
#include "twin/file/twin_file.hpp"

#include <fmt/format.h>

#include "twin/base/errors.hpp"
#include "twin/base/paths.hpp"

namespace fringetwin {
namespace fs = std::filesystem;
namespace {
constexpr const char* kTwinSchema = "fringetwin-twin/1";
}

fs::path twin_file_of(const fs::path& file_or_folder) {
  std::error_code none;  // what cannot be looked at is read, and that says why not
  if (!fs::is_directory(file_or_folder, none)) return file_or_folder;
  const fs::path file = file_or_folder / "twin.toml";
  if (!fs::is_regular_file(file, none))
    throw UserError(ExitCode::usage, file_or_folder.string(), "is a folder without a twin.toml",
                    "give a twin.toml, or the folder that holds one");
  return file;
}

Twin load_twin(const fs::path& file) { return load_twin(file, {}); }

Twin load_twin(const fs::path& file_or_folder, const std::map<std::string, std::string>& settings) {
  const fs::path file = twin_file_of(file_or_folder);
  const TomlTable root = TomlTable::parse_file(file, ExitCode::usage, settings);
  const std::vector<std::string> keys = {
      "schema", "name",   "cameramodel_unit", "camera",  "projector", "fringes",     "object",
      "room",   "render", "measure",          "compare", "real",      "uncertainty", "limits"};
  if (!root.has("schema")) root.allow(keys);  // a misspelt "schema" is named as such
  if (root.required_string("schema") != kTwinSchema)
    root.fail("schema",
              fmt::format("must be \"{}\", is \"{}\"", kTwinSchema, root.required_string("schema")));
  root.allow(keys);
  Twin twin;
  twin.file = tidy_path(file);
  twin.input_files.push_back(twin.file);
  twin.name = root.string("name").value_or(twin.file.parent_path().filename().string());
  TwinFileContext context{.folder = twin.file.parent_path(), .files = &twin.input_files};
  if (root.choice("cameramodel_unit", {"m", "mm"}) == "mm") context.cameramodel_mm_per_unit = 1.0;

  twin.cameras = read_cameras(root, context);
  twin.projector = read_projector(root, context, twin.cameras[0].T_cam_world);
  twin.fringes = read_fringes(root);
  twin.fringes.images = read_pattern_images(root, twin.projector, context);
  read_image_harmonics(root, twin);
  twin.room = read_room(root, twin);
  read_light_factors(root, twin);
  twin.objects = read_objects(root, context);
  twin.render = read_render(root);
  twin.measure = read_measure(root, twin);
  twin.compare = read_comparison(root);
  twin.real = read_real(root, twin, context);
  twin.calibration_uncertainty = read_uncertainty(root, context);
  twin.limits = read_limits(root);
  return twin;
}

}  // namespace fringetwin
