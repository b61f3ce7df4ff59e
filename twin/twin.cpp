// SPDX-License-Identifier: Apache-2.0
// The small methods of twin.hpp. Reading the file: twin_file.cpp.
#include "twin/twin.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "twin/base/errors.hpp"
#include "twin/base/module_loader.hpp"
#include "twin/base/paths.hpp"
#include "twin/base/plain_text.hpp"
#include "twin/image/image_io.hpp"

#ifndef FRINGETWIN_SOURCE_FROM_BUILD
#error "FRINGETWIN_SOURCE_FROM_BUILD: the checkout as seen from the build tree, set in twin/CMakeLists.txt"
#endif

namespace fringetwin {
namespace fs = std::filesystem;

namespace {

constexpr float kLargestTexture = 1e9F;  ///< beyond that it is no factor and no irradiance

// Reads the files of the shapes that have some, each once. A shape with files and without a load() does not
// compile.
class Loader {
 public:
  std::vector<fs::path> mesh_files, map_files;  ///< what was read

  void load(MeshShape& shape) {
    if (shape.mesh) return;
    auto& mesh = meshes_[{shape.file, shape.unit}];
    if (!mesh) {
      mesh = load_mesh(shape.file, shape.unit);
      mesh_files.push_back(shape.file);
    }
    shape.mesh = mesh;
  }

  void load(PlaneShape& plane) {
    if (plane.albedo_file.empty() || plane.albedo_map) return;
    auto& map = maps_[plane.albedo_file];
    if (!map) {
      LoadedGray gray = read_gray(plane.albedo_file);
      const float white = std::ldexp(1.0F, gray.file_bits) - 1.0F;
      for (float& value : gray.image.data) value /= white;
      map = std::make_shared<const ImageF>(std::move(gray.image));
      map_files.push_back(plane.albedo_file);
    }
    plane.albedo_map = map;
  }

  template <WithoutFiles S>
  void load(S&) {}

  void load_texture(Camera& camera) {
    if (camera.texture_file.empty() || camera.texture) return;
    if (const auto known = textures_.find(camera.texture_file);
        known != textures_.end() && is_of(*known->second, camera)) {
      camera.texture = known->second;
      return;
    }
    const auto fail = [&](const std::string& what) {
      throw UserError(
          ExitCode::input, camera.texture_file.string(), what,
          "a texture is an EXR of camera \"" + camera.name +
              "\"'s size with the channels factor, offset or both, as `cosim --refine texture` writes it");
    };
    PixelTexture texture;
    for (auto& [name, image] : read_exr(camera.texture_file)) {
      if (name != "factor" && name != "offset") fail("has a channel \"" + plain_text(name) + "\"");
      if (image.width != camera.lens.width() || image.height != camera.lens.height())
        fail(fmt::format("has {} x {} px, the camera {} x {}", image.width, image.height, camera.lens.width(),
                         camera.lens.height()));
      const float least = name == "factor" ? 0.0F : -kLargestTexture;
      if (!std::ranges::all_of(image.data, [&](float v) { return v >= least && v <= kLargestTexture; }))
        fail("has a value in its channel \"" + name + "\" that is none");
      (name == "factor" ? texture.factor : texture.offset) = std::move(image);
    }
    map_files.push_back(camera.texture_file);
    camera.texture = std::make_shared<const PixelTexture>(std::move(texture));
  }

  /// Loads what the sensor's pixels have of their own.
  void load_maps(Camera& camera) {
    const MappedCamera mapped{camera.name, camera.lens.width(), camera.lens.height()};
    Sensor& sensor = camera.sensor;
    load_map(sensor.prnu, factors_, mapped, [&] { return read_pixel_factors(sensor.prnu.file, mapped); });
    load_map(sensor.dsnu, offsets_, mapped,
             [&] { return read_pixel_offsets(sensor.dsnu.file, mapped, sensor.max_dn()); });
  }

  /// Takes over what is read already.
  void know(const MeshShape& shape) { meshes_[{shape.file, shape.unit}] = shape.mesh; }
  void know(const Camera& camera) {
    if (camera.texture && !camera.texture_file.empty()) textures_[camera.texture_file] = camera.texture;
    if (camera.sensor.prnu.values) factors_[camera.sensor.prnu.file] = camera.sensor.prnu.values;
    if (camera.sensor.dsnu.values) offsets_[camera.sensor.dsnu.file] = camera.sensor.dsnu.values;
  }

 private:
  std::map<std::pair<fs::path, std::string>, std::shared_ptr<const Mesh>> meshes_;
  std::map<fs::path, std::shared_ptr<const ImageF>> maps_;
  std::map<fs::path, std::shared_ptr<const PixelTexture>> textures_;
  std::map<fs::path, std::shared_ptr<const ImageF>> factors_, offsets_;  ///< of sensors

  /// A map of another size is read again, to be refused as the file of this camera.
  template <class Read>
  void load_map(PixelMap& map, std::map<fs::path, std::shared_ptr<const ImageF>>& known,
                const MappedCamera& camera, Read read) {
    if (map.file.empty() || map.values) return;
    std::shared_ptr<const ImageF>& values = known[map.file];
    if (!values || values->width != camera.width || values->height != camera.height) {
      values = read();
      map_files.push_back(map.file);
    }
    map.values = values;
  }

  /// Returns whether a texture has the size of the camera.
  static bool is_of(const PixelTexture& texture, const Camera& camera) {
    return std::ranges::all_of(std::array{&texture.factor, &texture.offset}, [&](const ImageF* image) {
      return image->empty() || (image->width == camera.lens.width() && image->height == camera.lens.height());
    });
  }
};

/// Returns a place from -1 to 1 across an image, from border to border.
std::array<double, 2> across_image(const Lens& lens, const Eigen::Vector2d& q_px) {
  return {(2.0 * q_px.x() + 1.0) / lens.width() - 1.0, (2.0 * q_px.y() + 1.0) / lens.height() - 1.0};
}

}  // namespace

std::array<double, kHarmonicsFieldTerms> Projector::field_terms(const Eigen::Vector2d& q_px) const {
  const auto [u, v] = across_image(lens, q_px);
  return {u, v, 1.5 * u * u - 0.5, u * v, 1.5 * v * v - 0.5};
}

double Projector::blur_variance_px2(const Eigen::Vector2d& q_px) const {
  const auto [u, v] = across_image(lens, q_px);
  const auto& b = blur_field_px2;
  const double more = b[0] * u + b[1] * v + b[2] * u * u + b[3] * u * v + b[4] * v * v;
  return std::max(0.0, blur_px * blur_px + more);
}

double Projector::halo_attenuation(double cycles_per_px) const {
  double lost = 0.0;
  for (const Halo& h : halo) {
    const double turn_rad = 2.0 * std::numbers::pi * cycles_per_px * h.sigma_px;
    lost -= h.share * std::expm1(-0.5 * turn_rad * turn_rad);
  }
  return 1.0 - lost;
}

double Projector::least_blur_px() const {
  if (!has_blur_field()) return blur_px;
  constexpr int kNodes = 65;  // along each side: a quadratic is no lower between them than 1/4000 of its bend
  double least = std::numeric_limits<double>::infinity();
  for (int j = 0; j < kNodes; ++j)
    for (int i = 0; i < kNodes; ++i) {
      const Eigen::Vector2d q_px(lens.width() * i / (kNodes - 1.0) - 0.5,
                                 lens.height() * j / (kNodes - 1.0) - 0.5);
      least = std::min(least, blur_variance_px2(q_px));
    }
  return std::sqrt(least);
}

double ProjectorResponse::operator()(double value) const {
  switch (kind) {
    case Kind::linear:
      return value;
    case Kind::gamma:
      return std::pow(value, gamma);
    case Kind::table: {
      const double position = std::clamp(value, 0.0, 1.0) * static_cast<double>(table.size() - 1);
      const auto i = std::min(static_cast<std::size_t>(position), table.size() - 2);
      const double part = position - static_cast<double>(i);
      return table[i] * (1.0 - part) + table[i + 1] * part;
    }
  }
  return value;
}

const Object* Twin::find_object(const std::string& object) const {
  const auto it = std::ranges::find(objects, object, &Object::name);
  return it == objects.end() ? nullptr : &*it;
}

bool Twin::has_subsurface() const {
  return std::ranges::any_of(objects, [](const Object& o) { return o.material.mean_free_path_mm > 0.0; });
}

Triangulate Twin::triangulate() const {
  return measure.triangulate.value_or(cameras.size() >= 2 ? Triangulate::stereo : Triangulate::projector);
}

void load_meshes(Twin& twin, const Twin* known) {
  Loader loader;
  if (known)
    for (const Object& object : known->objects)
      if (const auto* shape = std::get_if<MeshShape>(&object.shape)) loader.know(*shape);
  if (known)
    for (const Camera& camera : known->cameras) loader.know(camera);
  for (Object& object : twin.objects) std::visit([&](auto& shape) { loader.load(shape); }, object.shape);
  for (Camera& camera : twin.cameras) loader.load_texture(camera), loader.load_maps(camera);
  for (const auto& files : {loader.mesh_files, loader.map_files})
    twin.input_files.insert(twin.input_files.end(), files.begin(), files.end());
}

fs::path captures_root() {
  if (const char* variable = std::getenv("FRINGETWIN_CAPTURES"); variable != nullptr && *variable != '\0')
    return tidy_path(variable);
  const fs::path checkout = own_checkout(), captures = "../shared/captures";
  std::error_code error;
  if (!checkout.empty() && fs::is_directory(checkout / captures, error))
    return tidy_path(checkout / captures);
  return tidy_path(captures);
}

fs::path own_checkout() {
  const fs::path build_tree = own_build_tree();
  return build_tree.empty() ? build_tree : tidy_path(build_tree / FRINGETWIN_SOURCE_FROM_BUILD);
}

fs::path datasets_root() {
  const fs::path checkout = own_checkout(), prefix = prefix_of(own_program());
  if (!checkout.empty()) return checkout / "datasets";
  return prefix.empty() ? fs::path{} : prefix / "share" / "fringetwin" / "datasets";
}

}  // namespace fringetwin
