// SPDX-License-Identifier: Apache-2.0
// Binds capture sets: the images of each camera, as arrays over the program's own memory.
#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <cstring>

#include "cosim/load.hpp"
#include "python/arrays.hpp"
#include "python/long_call.hpp"
#include "python/types.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/captures/stored_images.hpp"

namespace fringetwin::python {
namespace {

using InArray = py::array_t<float, py::array::c_style | py::array::forcecast>;

/// The camera's images, which keep the whole set alive.
std::shared_ptr<CameraImages> images_of(const std::shared_ptr<std::vector<CameraImages>>& set,
                                        const std::string& camera) {
  for (CameraImages& images : *set)
    if (images.camera == camera) return {set, &images};
  throw py::key_error(camera);
}

/// (name, images) of all cameras.
py::list items_of(const PyCaptures& set) {
  py::list items;
  for (CameraImages& images : *set.cameras)
    items.append(py::make_tuple(images.camera, std::shared_ptr<CameraImages>(set.cameras, &images)));
  return items;
}

std::vector<std::string> names_of(const std::vector<CameraImages>& set) {
  std::vector<std::string> names;
  for (const CameraImages& images : set) names.push_back(images.camera);
  return names;
}

ImageF image_of(const InArray& array, const std::string& camera) {
  if (array.ndim() != 2)
    throw UserError(ExitCode::input, "camera \"" + camera + "\"",
                    "an image has " + std::to_string(array.ndim()) + " dimensions, not 2",
                    "give arrays of shape (height, width)");
  ImageF image(static_cast<int>(array.shape(1)), static_cast<int>(array.shape(0)));
  std::memcpy(image.data.data(), array.data(), image.size() * sizeof(float));
  return image;
}

/// Returns a copy of the arrays, checked as the images of a folder are.
PyCaptures captures_from(const PyTwin& twin, const std::map<std::string, std::vector<InArray>>& arrays) {
  auto cameras = std::make_shared<std::vector<CameraImages>>();
  const std::shared_ptr<const Twin> rig = twin.state().twin;
  const std::size_t n = expand_sequence(rig->fringes).size();
  for (const Camera& camera : rig->cameras) {
    const auto given = arrays.find(camera.name);
    if (given == arrays.end())
      throw UserError(ExitCode::input, twin.file.string(), "camera \"" + camera.name + "\" has no images",
                      "give a list of arrays for each camera of the twin");
    if (given->second.size() != n)
      throw UserError(ExitCode::input, "camera \"" + camera.name + "\"",
                      "has " + std::to_string(given->second.size()) + " images, the twin's sequence has " +
                          std::to_string(n));
    CameraImages& images = cameras->emplace_back();
    images.camera = camera.name;
    images.bit_depth = camera.sensor.bit_depth;
    for (const InArray& array : given->second) {
      images.images.push_back(image_of_camera(image_of(array, camera.name), camera));
      const GrayImage& image = images.images.back();
      if (image.width != camera.lens.width() || image.height != camera.lens.height())
        throw UserError(ExitCode::input, "camera \"" + camera.name + "\"",
                        "an image is " + std::to_string(image.width) + " x " + std::to_string(image.height) +
                            " pixels, the camera's imagersize " + std::to_string(camera.lens.width()) +
                            " x " + std::to_string(camera.lens.height()));
    }
  }
  return {cameras};
}

PyCaptures load(const PyTwin& twin, const std::filesystem::path& folder) {
  return long_call([&] {
    cosim::Captures loaded = cosim::load_captures(*twin.state().twin, folder);
    for (CameraImages& images : loaded.cameras) keep_as_floats(images);
    return PyCaptures{std::make_shared<std::vector<CameraImages>>(std::move(loaded.cameras)),
                      std::move(loaded.files)};
  });
}

/// By the cameras' names, in the order of the set.
py::dict read_captures(const std::filesystem::path& folder) {
  py::dict cameras;
  const auto load_all = [&] {
    std::vector<StoredImages> loaded = load_stored_images(read_capture_set(folder));
    for (StoredImages& images : loaded) keep_as_floats(images);
    return loaded;
  };
  for (StoredImages& images : long_call(load_all)) {
    const py::str name(images.camera);
    cameras[name] = std::make_shared<StoredImages>(std::move(images));
  }
  return cameras;
}

/// A getter of an image that may be there.
template <class Images>
auto optional_image(std::optional<GrayImage> Images::*member) {
  return [member](const py::object& self) -> py::object {
    std::optional<GrayImage>& image = self.cast<Images&>().*member;
    return image ? py::object(array_over(*image, self)) : py::none();
  };
}

/// A getter of the image of an index, which counts from the end where it is negative.
template <class Images>
auto image_at() {
  return [](const py::object& self, py::ssize_t i) {
    std::vector<GrayImage>& images = self.cast<Images&>().images;
    const auto n = static_cast<py::ssize_t>(images.size());
    if (i < 0) i += n;
    if (i < 0 || i >= n) throw py::index_error();
    return array_over(images[static_cast<std::size_t>(i)], self);
  };
}

/// A getter of a list of the images of a slice.
template <class Images>
auto images_of_slice() {
  return [](const py::object& self, const py::slice& slice) {
    std::vector<GrayImage>& images = self.cast<Images&>().images;
    std::size_t start = 0, stop = 0, step = 0, n = 0;
    if (!slice.compute(images.size(), &start, &stop, &step, &n)) throw py::error_already_set();
    py::list out;
    for (std::size_t k = 0; k < n; ++k, start += step) out.append(array_over(images[start], self));
    return out;
  };
}

/// Binds a sequence of the images of one camera, with all that such sequences have.
template <class Images>
py::class_<Images, std::shared_ptr<Images>> bind_images(py::module_& module, const char* name,
                                                        const char* what) {
  return py::class_<Images, std::shared_ptr<Images>>(module, name, what)
      .def_readonly("camera", &Images::camera, "Name of the camera.")
      .def_readonly("radiance", &Images::radiance, "True: values are irradiance, before the sensor.")
      .def_property_readonly("white", optional_image(&Images::white),
                             "The white reference (height, width), DN; None without.")
      .def_property_readonly("black", optional_image(&Images::black),
                             "The black reference (height, width), DN; None without.")
      .def("__len__", [](const Images& images) { return images.images.size(); })
      .def("__getitem__", image_at<Images>(), py::arg("index"),
           "Returns image `index`, float32 (height, width).")
      .def("__getitem__", images_of_slice<Images>(), py::arg("index"),
           "Returns a list of the images of a slice.");
}

void bind_images_of_cameras(py::module_& module) {
  bind_images<CameraImages>(
      module, "CameraImages",
      "The images of one camera in the order of the sequence: a sequence of float32 arrays (height, width), "
      "in DN (irradiance E where `radiance`). The arrays lie in the program's memory; nothing is copied.")
      .def_readonly("bit_depth", &CameraImages::bit_depth, "Bits of a gray value.");
  bind_images<StoredImages>(
      module, "StoredImages",
      "The images of one camera of a capture set as they are stored: a sequence of float32 arrays (height, "
      "width). The arrays lie in the program's memory; nothing is copied.")
      .def_readonly("file_bits", &StoredImages::file_bits,
                    "Bits of the files' values: 8, 16 (of any of them), 32 for EXR. The sensor may have "
                    "fewer.");
}

}  // namespace

void bind_captures(py::module_& module) {
  bind_images_of_cameras(module);
  py::class_<PyCaptures>(module, "Captures",
                         "The images of all cameras of a twin by the cameras' names: a mapping to "
                         "CameraImages. Real and simulated captures are the same.")
      .def(
          "keys", [](const PyCaptures& set) { return names_of(*set.cameras); },
          "Returns the names of the cameras.")
      .def("__len__", [](const PyCaptures& set) { return set.cameras->size(); })
      .def("__iter__", [](const PyCaptures& set) { return py::iter(py::cast(names_of(*set.cameras))); })
      .def(
          "__getitem__",
          [](const PyCaptures& set, const std::string& camera) { return images_of(set.cameras, camera); },
          py::arg("camera"), "Returns the CameraImages of a camera.")
      .def(
          "__contains__",
          [](const PyCaptures& set, const py::object& camera) {
            return py::dict(items_of(set)).contains(camera);
          },
          py::arg("camera"), "Returns whether there is a camera of this name.")
      .def(
          "get",
          [](const PyCaptures& set, const py::object& camera, const py::object& otherwise) -> py::object {
            return py::dict(items_of(set)).attr("get")(camera, otherwise);
          },
          py::arg("camera"), py::arg("default") = py::none(),
          "Returns the CameraImages of a camera, or `default` where there is none of this name.")
      .def(
          "values", [](const PyCaptures& set) { return py::list(py::dict(items_of(set)).attr("values")()); },
          "Returns the CameraImages of all cameras.")
      .def("items", &items_of, "Returns (name, CameraImages) of all cameras.")
      .def_readonly("files", &PyCaptures::files, "The files they were read from; empty where rendered.");
  py::class_<PyRendering, PyCaptures>(module, "Rendering",
                                      "What Twin.render() returns: Captures in DN, with how they came about.")
      .def_property_readonly(
          "irradiance", [](const PyRendering& r) { return PyCaptures{r.irradiance}; },
          "The same images before the sensor: Captures of irradiance E, float32.")
      .def_property_readonly(
          "device", [](const PyRendering& r) { return r.rendering.device; }, "The Vulkan device.")
      .def_property_readonly(
          "seed", [](const PyRendering& r) { return r.rendering.seed; }, "The seed of noise and sampling.")
      .def_property_readonly(
          "notes",
          [](const PyRendering& r) {
            std::map<std::string, std::string> notes;
            for (const compare::RenderNote& note : r.rendering.notes) notes[note.camera] = note.text();
            return notes;
          },
          "By camera: sampler, rays and estimated errors, in words.")
      .def(
          "write",
          [](const PyRendering& r, const std::filesystem::path& out, bool radiance) {
            long_call([&] {
              const FoldersOfCall folders;
              cosim::write_simulated(out, *r.twin, *r.cameras, radiance ? r.irradiance.get() : nullptr,
                                     r.rendering);
            });
          },
          py::arg("out"), py::arg("radiance") = false,
          "Writes the capture set as `fringetwin render --out` does (`radiance`: EXR images, too).");
}

void bind_capture_calls(py::module_& module) {
  module.def(
      "load_captures", &load, py::arg("twin"), py::arg("folder"),
      "Reads the capture set in a folder (capture.toml and its images): Captures of the twin's cameras, "
      "float32 arrays (height, width) in DN, in the order of the sequence.");
  module.def(
      "read_captures", &read_captures, py::arg("folder"),
      "Reads the capture set in a folder (capture.toml and its images) where no twin says what they are: the "
      "StoredImages of each camera by its name, values as they are stored. A pattern's images are those on "
      "disk, from number 0 without a gap. To measure or compare them, load_captures(twin, folder).");
  module.def("captures_from", &captures_from, py::arg("twin"), py::arg("images"),
             "Returns Captures with a copy of the arrays (height, width), DN, of each camera.");
}

}  // namespace fringetwin::python
