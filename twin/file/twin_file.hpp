// SPDX-License-Identifier: Apache-2.0
// The parts of load_twin(): one function per top-level key of twin.toml reads and checks it.
#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "twin/file/toml_reader.hpp"
#include "twin/twin.hpp"

namespace fringetwin {

/// What reading a camera or projector needs to know of the file around it.
struct TwinFileContext {
  std::filesystem::path folder;                         ///< relative paths start here
  double cameramodel_mm_per_unit = 1000.0;              ///< cameramodel_unit
  std::vector<std::filesystem::path>* files = nullptr;  ///< every file read is appended
  std::filesystem::path resolve(const TomlTable& table, const std::string& key) const {
    return resolve_path(table.required_string(key), folder, table.where(key), ExitCode::usage);
  }
};

std::vector<Camera> read_cameras(const TomlTable& root, const TwinFileContext& context);
/// `T_first_world`: pose of the first camera.
std::optional<Projector> read_projector(const TomlTable& root, const TwinFileContext& context,
                                        const Pose& T_first_world);
Fringes read_fringes(const TomlTable& root);
/// [fringes] images: read and checked against the projector.
std::vector<PatternImage> read_pattern_images(const TomlTable& root,
                                              const std::optional<Projector>& projector,
                                              const TwinFileContext& context);
/// [fringes] image_harmonics: `twin` has its whole sequence and its projector already.
void read_image_harmonics(const TomlTable& root, Twin& twin);
/// `twin`: its projector is there already.
Room read_room(const TomlTable& root, const Twin& twin);
/// The factors, shifts and exposures of each image of the sequence, of cameras and projector: `twin` has its
/// fringes already.
void read_light_factors(const TomlTable& root, Twin& twin);
std::vector<Object> read_objects(const TomlTable& root, const TwinFileContext& context);
RenderOptions read_render(const TomlTable& root);
/// `twin`: cameras, projector and objects are already there and are checked against.
MeasureOptions read_measure(const TomlTable& root, const Twin& twin);
ComparisonOptions read_comparison(const TomlTable& root);
RealSource read_real(const TomlTable& root, const Twin& twin, const TwinFileContext& context);
/// [uncertainty]: a file that is there; compare/ reads it.
std::optional<std::filesystem::path> read_uncertainty(const TomlTable& root, const TwinFileContext& context);
std::map<std::string, double> read_limits(const TomlTable& root);

}  // namespace fringetwin
