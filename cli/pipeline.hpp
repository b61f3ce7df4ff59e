// SPDX-License-Identifier: Apache-2.0
// The steps that several subcommands share: load, simulate, measure, keep time.
#pragma once
#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "compare/result/provenance.hpp"
#include "measure/measurement.hpp"
#include "render/renderer.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/twin.hpp"

namespace fringetwin::cli {

/// Options of everything that renders.
struct RenderFlags {
  std::optional<int> samples;
  std::optional<std::string> sampler;  ///< adaptive | gauss | multi-jittered | sobol
  std::optional<double> phase_error_rad, gray_error;
  bool radiance = false;
  std::uint64_t seed = 0;
  std::string device;
};

/// The images of one simulated camera, before and after the sensor.
struct Simulated {
  std::vector<CameraImages> captures;      ///< DN
  std::vector<CameraImages> irradiance;    ///< E
  std::vector<compare::RenderNote> notes;  ///< one per camera
  std::string device;
};

/// Wall time per named stage, s.
class StageTimer {
 public:
  void start(const std::string& stage);
  void stop();
  std::map<std::string, double> seconds;

 private:
  std::string stage_;
  std::chrono::steady_clock::time_point begin_;
};

/// Applies command-line sampling over the twin's own [render] (CLI > file > default).
void apply_flags(const RenderFlags& flags, RenderOptions& options);

/// load_twin() and its meshes; also refuses fringes that `measure` could not unwrap over the projector's
/// image, before anything is rendered.
Twin load_for_run(const std::filesystem::path& file);

/// All cameras' images of a capture folder, order of twin.cameras.
std::vector<CameraImages> load_captures(const Twin& twin, const std::filesystem::path& dir);

/// True when an object's shape is to be built from the real capture.
bool has_measured_shape(const Twin& twin);
/// Replaces every MeasuredShape by the surface measured from `real`. The steps a comparison may use then:
/// left_over_steps() (twin/captures/measured_steps.hpp), to be asked before.
void build_measured_shapes(Twin& twin, const std::vector<CameraImages>& real);

/// The twin with everything a renderer needs: meshes read, measured shapes built from [real] captures.
Twin load_renderable_twin(const std::filesystem::path& file);

/// Renders and exposes all cameras. Throws UserError(usage) when no camera sees any object; warns
/// for an object that no camera sees.
Simulated simulate(const Twin& twin, const RenderFlags& flags, render::Renderer& renderer);
/// What simulate() needs, checked before a device is opened.
void check_renderable(const Twin& twin);

/// Writes the simulated capture set; with `radiance` the EXR images too, described by
/// DIR/radiance/capture.toml. The capture.toml go first and come back last, so that a broken-off run leaves
/// no mix of old and new images that looks complete.
void write_simulated(const std::filesystem::path& dir, const Simulated& simulated, bool radiance,
                     std::uint64_t seed, const Twin& twin);

}  // namespace fringetwin::cli
