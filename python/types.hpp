// SPDX-License-Identifier: Apache-2.0
// The objects that Python holds: a twin with its settings, capture sets, measurements; and what binds them.
#pragma once
#include <pybind11/pybind11.h>

#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "cosim/simulate.hpp"
#include "cosim/write_results.hpp"
#include "measure/measurement.hpp"
#include "render/renderer.hpp"
#include "twin/base/stopwatch.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/twin.hpp"

namespace fringetwin::python {
namespace py = pybind11;

using Settings = std::map<std::string, std::string>;  ///< values (TOML text) by the paths of their keys

/// A twin.toml with settings. It is read again when they change; what was made of it before stays as it was.
/// Its functions may be called on several threads.
class PyTwin {
 public:
  /// What a call works with; it stays as it is when another thread sets something.
  struct State {
    Settings settings;
    std::shared_ptr<const Twin> twin;  ///< as cosim::load_for_run() reads it with these settings
  };

  explicit PyTwin(std::filesystem::path file);

  /// Returns the settings and the twin that belong together now.
  State state() const;

  /// Puts values at their keys; where they are refused all settings stay as they were.
  void set(const Settings& values);
  /// Returns the twin with what a renderer needs, made when it is first asked for; `busy` must be held.
  std::shared_ptr<const Twin> renderable();
  /// Returns the renderer on a device, which is opened when it is first asked for; `busy` must be held.
  render::Renderer& renderer(const std::string& device);

  const std::filesystem::path file;
  std::mutex busy;  ///< one thread renders, or sets something, at a time

 private:
  mutable std::mutex state_mutex_;  ///< held for moments only, so that nobody waits for it with Python's lock
  State state_;
  std::shared_ptr<const Twin> renderable_;
  std::unique_ptr<render::Renderer> renderer_;
  std::string device_;
};

/// Keeps the images of a camera (CameraImages, StoredImages) as floats: arrays lie over them, and other
/// threads read them while Python does.
template <class Images>
void keep_as_floats(Images& images) {
  for (GrayImage& image : images.images) image.as_floats();
  if (images.white) images.white->as_floats();
  if (images.black) images.black->as_floats();
}

/// The images of all cameras, in the twin's order, as floats.
struct PyCaptures {
  std::shared_ptr<std::vector<CameraImages>> cameras;
  std::vector<std::filesystem::path> files = {};  ///< they were read from
};

/// What was rendered: gray values, and the irradiance before the sensor.
struct PyRendering : PyCaptures {
  std::shared_ptr<const Twin> twin;
  std::shared_ptr<std::vector<CameraImages>> irradiance;
  cosim::Rendering rendering;
};

struct PyMeasurement {
  std::shared_ptr<const Twin> twin;
  measure::Measurement measurement;
  std::vector<std::filesystem::path> capture_files;
  cosim::Origin origin;  ///< the call and the settings that it was measured with
  StageTimer timer;
};

/// Returns what a result says of a call from Python: its name, the twin's file, the settings and the options
/// ("samples=4") that are not the defaults.
cosim::Origin origin_of(const std::string& call, const std::filesystem::path& file, const Settings& settings,
                        const std::vector<std::string>& options);

/// A signature shows the names of Python for classes that are bound before it, and those of C++ for the
/// others: so the calls that take a twin come after it.
void bind_captures(py::module_& module);
void bind_twin(py::module_& module);
void bind_capture_calls(py::module_& module);
void bind_measure(py::module_& module);
void bind_cosim(py::module_& module);

}  // namespace fringetwin::python
