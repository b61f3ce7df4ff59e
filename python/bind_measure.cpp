// SPDX-License-Identifier: Apache-2.0
// Binds measuring: whole measurements, decoding and triangulation alone, the fit of a sphere.
#include <pybind11/eigen.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "compare/result/result_json.hpp"
#include "cosim/measure_captures.hpp"
#include "measure/decode/phase_exr.hpp"
#include "measure/fit/fits.hpp"
#include "python/arrays.hpp"
#include "python/long_call.hpp"
#include "python/types.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"

namespace fringetwin::python {
namespace {

using measure::CameraDecode;
using measure::PointCloud;

std::shared_ptr<PyMeasurement> measure_set(const PyTwin& twin, const PyCaptures& captures, bool method_bias) {
  return long_call([&] {
    auto out = std::make_shared<PyMeasurement>();
    const PyTwin::State state = twin.state();
    out->twin = state.twin;
    out->origin =
        origin_of("fringetwin.measure", twin.file, state.settings,
                  method_bias ? std::vector<std::string>{"method_bias=True"} : std::vector<std::string>{});
    out->capture_files = captures.files;
    cosim::measuring_renders(*out->twin, method_bias);  // may be refused, before the work
    out->measurement = cosim::measure_captures(*out->twin, *captures.cameras, method_bias, out->timer);
    return out;
  });
}

void write(PyMeasurement& self, const std::filesystem::path& out, bool npz, bool figures) {
  long_call([&] {
    const FoldersOfCall folders;
    const cosim::ExtraFiles extra{.npz = npz, .figures = figures};
    cosim::write_measured(out, *self.twin, self.measurement, self.capture_files, self.origin, self.timer,
                          extra);
    cosim::check_figures(out, extra);
  });
}

CameraDecode decode(const PyTwin& twin, const CameraImages& images) {
  return long_call([&] {
    const std::shared_ptr<const Twin> rig = twin.state().twin;
    for (const Camera& camera : rig->cameras)
      if (camera.name == images.camera)
        return measure::decode(images, rig->fringes, measure::decode_options(*rig, camera, images));
    throw UserError(ExitCode::usage, twin.file.string(), "has no camera \"" + images.camera + "\"");
  });
}

std::shared_ptr<PointCloud> triangulate(const PyTwin& twin, const std::vector<CameraDecode>& decodes) {
  return long_call([&] {
    const std::shared_ptr<const Twin> rig = twin.state().twin;
    if (decodes.size() != rig->cameras.size())
      throw UserError(ExitCode::usage, twin.file.string(),
                      "the twin has " + std::to_string(rig->cameras.size()) + " cameras, " +
                          std::to_string(decodes.size()) + " were decoded");
    return std::make_shared<PointCloud>(std::move(measure::measure_decoded(*rig, decodes).cloud));
  });
}

using InPoints = py::array_t<double, py::array::c_style | py::array::forcecast>;

py::dict fit_sphere(const InPoints& p_mm, const Eigen::Vector3d& start_center_mm, double start_radius_mm) {
  if (p_mm.ndim() != 2 || p_mm.shape(1) != 3)
    throw UserError(ExitCode::usage, "fit_sphere", "the points are no array of shape (n, 3)");
  const auto* first = reinterpret_cast<const Eigen::Vector3d*>(p_mm.data());
  const std::vector<Eigen::Vector3d> points(first, first + p_mm.shape(0));
  const measure::SphereFit fit = long_call([&] {
    return measure::fit_sphere(points, {start_center_mm, start_radius_mm}, {});
  });
  using namespace py::literals;
  return py::dict("usable"_a = fit.usable, "message"_a = fit.message, "n"_a = fit.n,
                  "center_mm"_a = fit.center_mm, "radius_mm"_a = fit.radius_mm, "rms_mm"_a = fit.rms_mm,
                  "covariance_mm2"_a = fit.covariance);
}

void bind_points(py::module_& module) {
  const auto column = [](auto PointCloud::*member) {
    return [member](const py::object& self) { return array_over(self.cast<PointCloud&>().*member, self); };
  };
  py::class_<PointCloud, std::shared_ptr<PointCloud>>(
      module, "Points", "Triangulated points: arrays of n rows over the program's own memory.")
      .def("__len__", &PointCloud::size)
      .def_property_readonly("p_world_mm", column(&PointCloud::p_world_mm),
                             "float64 (n, 3): points in the world frame, mm.")
      .def_property_readonly("normal_world", column(&PointCloud::normal_world),
                             "float32 (n, 3): unit normals in the world frame; NaN where unknown.")
      .def_property_readonly("q_cam_px", column(&PointCloud::q_cam_px),
                             "float32 (n, 2): x, y of the source pixel in the first camera, px.")
      .def_property_readonly("sigma_mm", column(&PointCloud::sigma_mm),
                             "float32 (n): standard deviation along the viewing ray, mm.");
}

void bind_decode(py::module_& module) {
  py::class_<CameraDecode, std::shared_ptr<CameraDecode>>(module, "Decode", "The decoded images of a camera.")
      .def_readonly("camera", &CameraDecode::camera, "Name of the camera.")
      .def_property_readonly(
          "flags", [](const py::object& self) { return array_over(self.cast<CameraDecode&>().flags, self); },
          "uint8 (height, width): 0 valid, 1 saturated, 2 low modulation, 4 order invalid, or-ed.")
      .def(
          "coordinate_px",
          [](const py::object& self, const std::string& direction) {
            for (measure::DirectionDecode& d : self.cast<CameraDecode&>().directions)
              if (direction == axis_name(d.axis)) return array_over(d.coordinate_px, self);
            throw py::key_error(direction);
          },
          py::arg("direction") = "x",
          "Returns float64 (height, width): projector coordinate along \"x\" or \"y\", px; NaN where "
          "invalid.")
      .def(
          "channels",
          [](const CameraDecode& self) {
            py::dict out;
            for (auto& [name, image] : measure::phase_channels(self))
              out[name.c_str()] = array_of(std::move(image));
            return out;
          },
          "Returns the channels of phase_CAM.exr by name, float32 (height, width) "
          "(docs/formats/results.md): wrapped_x_13 (rad), column_px, amplitude_dn, mean_dn, sigma_rad ...");
}

}  // namespace

void bind_measure(py::module_& module) {
  bind_points(module);
  bind_decode(module);
  py::class_<PyMeasurement, std::shared_ptr<PyMeasurement>>(
      module, "Measurement", "What one capture set gave: phases, points, fits.")
      .def_property_readonly(
          "points",
          [](const std::shared_ptr<PyMeasurement>& self) {
            return std::shared_ptr<PointCloud>(self, &self->measurement.cloud);
          },
          "The triangulated Points.")
      .def_property_readonly(
          "decodes",
          [](const std::shared_ptr<PyMeasurement>& self) {
            std::map<std::string, std::shared_ptr<CameraDecode>> out;
            for (CameraDecode& decode : self->measurement.cameras)
              out[decode.camera] = std::shared_ptr<CameraDecode>(self, &decode);
            return out;
          },
          "Decode of each camera, by name.")
      .def_property_readonly(
          "warnings", [](const PyMeasurement& self) { return self.measurement.warnings; }, "Sentences.")
      .def_property_readonly(
          "timing_s", [](const PyMeasurement& self) { return self.timer.seconds; }, "Wall time by stage, s.")
      .def(
          "_result_json",
          [](const PyMeasurement& self) {
            return compare::measurement_json(*self.twin, self.measurement, {}, self.timer.seconds);
          },
          "Returns result.json without its provenance.")
      .def("_write", &write, py::arg("out"), py::arg("npz") = false, py::arg("figures") = false,
           "Writes what `fringetwin measure --out` writes.");
  module.def("measure", &measure_set, py::arg("twin"), py::arg("captures"), py::arg("method_bias") = false,
             "Measures Captures; see fringetwin.measure.");
  module.def("decode", &decode, py::arg("twin"), py::arg("images"),
             "Decodes the CameraImages of one camera as `fringetwin measure` does: Decode.");
  module.def("triangulate", &triangulate, py::arg("twin"), py::arg("decodes"),
             "Triangulates the Decodes of all cameras, in the twin's order, as `fringetwin measure` does: "
             "Points.");
  module.def("fit_sphere", &fit_sphere, py::arg("p_mm"), py::arg("start_center_mm"),
             py::arg("start_radius_mm"),
             "Fits a sphere to points (n, 3), mm, by least squares of orthogonal distances from a start. "
             "Returns a dict: usable, message, n, center_mm (3), radius_mm, rms_mm, covariance_mm2 (4, 4) of "
             "centre and radius.");
}

}  // namespace fringetwin::python
