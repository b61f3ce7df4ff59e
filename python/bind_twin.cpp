// SPDX-License-Identifier: Apache-2.0
// Binds the twin: its file with settings, and what its cameras would record.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "cli/version.hpp"
#include "cosim/load.hpp"
#include "cosim/shape/measured_shapes.hpp"
#include "python/long_call.hpp"
#include "python/types.hpp"

namespace fringetwin::python {
namespace {

PyRendering render(PyTwin& self, std::optional<int> samples, std::optional<std::string> sampler,
                   std::optional<double> phase_error_rad, std::optional<double> gray_error,
                   std::uint64_t seed, const std::string& device) {
  return long_call([&] {
    const std::lock_guard lock(self.busy);
    const std::shared_ptr<const Twin> twin = self.renderable();
    cosim::Simulated simulated = cosim::simulate(
        *twin, {std::move(samples), std::move(sampler), phase_error_rad, gray_error, seed, device},
        self.renderer(device));
    PyRendering out;
    for (CameraImages& images : simulated.captures) keep_as_floats(images);
    out.cameras = std::make_shared<std::vector<CameraImages>>(std::move(simulated.captures));
    out.irradiance = std::make_shared<std::vector<CameraImages>>(std::move(simulated.irradiance));
    out.twin = twin;
    out.rendering = std::move(simulated.rendering);
    return out;
  });
}

template <class Named>
std::vector<std::string> names_of(const std::vector<Named>& all) {
  std::vector<std::string> names;
  for (const Named& one : all) names.push_back(one.name);
  return names;
}

}  // namespace

PyTwin::PyTwin(std::filesystem::path of_file)
    : file(twin_file_of(of_file)), state_{{}, std::make_shared<const Twin>(cosim::load_for_run(file))} {}

PyTwin::State PyTwin::state() const {
  const std::lock_guard lock(state_mutex_);
  return state_;
}

void PyTwin::set(const Settings& values) {
  const std::lock_guard lock(busy);
  State changed = state();
  for (const auto& [key, value] : values) changed.settings[key] = value;
  changed.twin = std::make_shared<const Twin>(cosim::load_for_run(file, changed.settings));
  renderable_.reset();
  const std::lock_guard state_lock(state_mutex_);
  std::swap(state_, changed);
}

std::shared_ptr<const Twin> PyTwin::renderable() {
  if (!renderable_) {
    const State now = state();
    cosim::check_renderable(*now.twin);
    renderable_ = cosim::has_measured_shape(*now.twin)
                      ? std::make_shared<const Twin>(cosim::load_renderable_twin(file, now.settings))
                      : now.twin;
  }
  return renderable_;
}

render::Renderer& PyTwin::renderer(const std::string& device) {
  if (!renderer_ || device_ != device) {
    renderer_.reset();
    renderer_ = std::make_unique<render::Renderer>(device);
    device_ = device;
  }
  return *renderer_;
}

cosim::Origin origin_of(const std::string& call, const std::filesystem::path& file, const Settings& settings,
                        const std::vector<std::string>& options) {
  std::vector<std::string> argv = {call, file.string()};
  for (const auto& [key, value] : settings) argv.push_back(key + "=" + value);
  argv.insert(argv.end(), options.begin(), options.end());
  return {argv, cli::version_string()};
}

void bind_twin(py::module_& module) {
  py::class_<PyTwin>(module, "Twin", "A twin.toml with settings; see fringetwin.Twin.")
      .def(py::init([](const std::filesystem::path& file) {
             return long_call([&] { return std::make_unique<PyTwin>(file); });
           }),
           py::arg("file"))
      .def(
          "_set", [](PyTwin& self, const Settings& values) { long_call([&] { self.set(values); }); },
          py::arg("values"), "Puts TOML texts at the paths of their keys.")
      .def("render", &render, py::kw_only(), py::arg("samples") = py::none(), py::arg("sampler") = py::none(),
           py::arg("phase_error_rad") = py::none(), py::arg("gray_error") = py::none(), py::arg("seed") = 0,
           py::arg("device") = "",
           "Renders every image of the sequence as each camera would record it: Rendering, a mapping from "
           "camera to images, float32 (height, width) in DN. Options as of `fringetwin render`: `samples` "
           "per pixel (a square number for the sampler \"gauss\"), `sampler`, `phase_error_rad` (rad), "
           "`gray_error` (of full scale), `seed`, `device` (a part of its name).")
      .def_readonly("file", &PyTwin::file, "The twin.toml.")
      .def_property_readonly(
          "name", [](const PyTwin& self) { return self.state().twin->name; }, "Its name.")
      .def_property_readonly(
          "settings", [](const PyTwin& self) { return self.state().settings; },
          "What was set: TOML text by the path of its key.")
      .def_property_readonly(
          "cameras", [](const PyTwin& self) { return names_of(self.state().twin->cameras); },
          "Names, in order.")
      .def_property_readonly(
          "objects", [](const PyTwin& self) { return names_of(self.state().twin->objects); },
          "Names, in order.")
      .def_property_readonly(
          "n_images", [](const PyTwin& self) { return expand_sequence(self.state().twin->fringes).size(); },
          "Images of each camera: the length of the fringe sequence.");
}

}  // namespace fringetwin::python
