// SPDX-License-Identifier: Apache-2.0
// [[object]] of twin.toml.
#include <fmt/format.h>

#include <cmath>
#include <map>
#include <set>

#include "twin/file/plain_keys.hpp"
#include "twin/file/twin_file.hpp"
#include "twin/moving.hpp"

namespace fringetwin {
namespace {

// A sequence takes seconds: what goes a metre meanwhile is no object of a measurement.
const NumberRange kMotionRange = NumberRange::between(-1e3, 1e3);
constexpr std::size_t kMostObjects = 1000;  // each pixel asks each of them; every fit looks for its name

Eigen::Vector3d read_unit_vector(const TomlTable& table, const std::string& key) {
  const auto v = table.vector(key, 3, NumberRange::any_size());
  if (!v) table.fail(key, "is missing", "it must be an array of 3 numbers");
  if (v->isZero(0.0)) table.fail(key, "must not be [0, 0, 0]");
  return v->stableNormalized();  // of any length, also 1e200
}

/// Any fixed direction across the normal, for a plane whose first side has no direction given:
/// the world's x axis, or y where the normal is along x.
Eigen::Vector3d default_u_axis(const Eigen::Vector3d& normal) {
  const Eigen::Vector3d axis =
      std::abs(normal.x()) < 0.9 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  return (axis - axis.dot(normal) * normal).normalized();
}

// Per shape: the keys that it has besides those of every object, and how they are read.

std::vector<std::string> keys_of(const SphereShape&) { return {"center_mm", "radius_mm"}; }

void read_keys(const TomlTable& table, const TwinFileContext&, SphereShape& sphere) {
  sphere.center_mm = table.required_vector3("center_mm");
  sphere.radius_mm = table.required_number("radius_mm", NumberRange::positive());
}

std::vector<std::string> keys_of(const PlaneShape&) {
  return {"point_mm", "normal", "size_mm", "u_axis", "albedo_map"};
}

void read_keys(const TomlTable& table, const TwinFileContext& context, PlaneShape& plane) {
  plane.point_mm = table.required_vector3("point_mm");
  plane.normal = read_unit_vector(table, "normal");
  plane.u_axis = default_u_axis(plane.normal);
  if (const auto size = table.vector("size_mm", 2, NumberRange::positive()))
    plane.size_mm = Eigen::Vector2d(*size);
  if (table.has("u_axis")) {
    if (!plane.size_mm) table.fail("u_axis", "has no effect without size_mm");
    const Eigen::Vector3d u = read_unit_vector(table, "u_axis");
    const Eigen::Vector3d across = u - u.dot(plane.normal) * plane.normal;
    if (across.norm() < 1e-6) table.fail("u_axis", "must not be parallel to the normal");
    plane.u_axis = across.normalized();
  }
  if (table.has("albedo_map")) {
    if (!plane.size_mm) table.fail("albedo_map", "needs size_mm", "the image covers the rectangle");
    plane.albedo_file = context.resolve(table, "albedo_map");
  }
}

std::vector<std::string> keys_of(const CylinderShape&) {
  return {"point_mm", "axis", "radius_mm", "length_mm"};
}

void read_keys(const TomlTable& table, const TwinFileContext&, CylinderShape& cylinder) {
  cylinder.point_mm = table.required_vector3("point_mm");
  cylinder.axis = read_unit_vector(table, "axis");
  cylinder.radius_mm = table.required_number("radius_mm", NumberRange::positive());
  cylinder.length_mm = table.number("length_mm", NumberRange::positive());
}

std::vector<std::string> keys_of(const MeshShape&) { return {"file", "unit", "rt_world_object", "shading"}; }

void read_keys(const TomlTable& table, const TwinFileContext& context, MeshShape& mesh) {
  mesh.file = context.resolve(table, "file");
  mesh.unit = table.choice("unit", {"mm", "m"}).value_or(mesh.unit);
  if (const auto rt = table.vector("rt_world_object", 6)) mesh.T_world_object = pose_from_rt(RotTrans(*rt));
  mesh.smooth = table.choice("shading", {"facet", "smooth"}) == "smooth";
}

std::vector<std::string> keys_of(const MeasuredShape&) {
  return {"steps", "smoothing_px", "most_smoothing_px", "correct_fringes"};
}

void read_keys(const TomlTable& table, const TwinFileContext&, MeasuredShape& measured) {
  measured.steps = table.choice("steps", {"even", "odd", "all"}).value_or(measured.steps);
  measured.smoothing_px =
      table.number_or("smoothing_px", measured.smoothing_px, NumberRange::between(0.0, 100.0));
  measured.most_smoothing_px =
      table.number_or("most_smoothing_px", measured.most_smoothing_px, NumberRange::between(0.0, 50.0));
  measured.correct_fringes = table.boolean("correct_fringes").value_or(measured.correct_fringes);
}

/// Keys of the shape (of every shape while it is not known) and those every object has.
void allow_keys(const TomlTable& table, const std::string& shape) {
  std::map<std::string, std::vector<std::string>> of_kind;
  for_every_shape([&](const auto& s) { of_kind[s.kKind] = keys_of(s); });
  std::vector<std::string> keys = {"name", "shape", "material", "motion"};
  for (const auto& [kind, own] : of_kind)
    if (shape.empty() || kind == shape) keys.insert(keys.end(), own.begin(), own.end());
  table.allow(keys);
}

Shape read_shape(const TomlTable& table, const TwinFileContext& context) {
  if (!table.has("shape")) allow_keys(table, "");  // a misspelt "shape" is named as such
  std::vector<std::string> kinds;
  for_every_shape([&](const auto& s) { kinds.emplace_back(s.kKind); });
  const std::string kind = table.required_choice("shape", kinds);
  allow_keys(table, kind);
  Shape shape;
  for_every_shape([&](auto s) {
    if (kind != s.kKind) return;
    read_keys(table, context, s);
    shape = s;
  });
  return shape;
}

Material read_material(const TomlTable& table) {
  table.allow(names_of_keys<Material>());
  Material material;
  read_plain_keys(table, material);
  const bool ggx = table.choice("specular_model", {"phong", "ggx"}) == "ggx";
  const char* other = ggx ? "shininess" : "roughness";
  if (table.has(other))
    table.fail(other, fmt::format("has no effect with specular_model = \"{}\"", ggx ? "ggx" : "phong"),
               ggx ? "use roughness" : "use shininess, or specular_model = \"ggx\"");
  if (ggx) {
    material.specular_model = Material::Specular::ggx;
    material.roughness = table.number_or("roughness", material.roughness,
                                         {.min = 0.0, .max = 1.0, .min_excluded = true, .smallest = 0.01});
    table.number("specular", NumberRange::between(0.0, 1.0));  // a reflectance
  }
  return material;
}

std::vector<double> read_motion(const TomlTable& table, const Shape& shape) {
  const auto motion = table.table("motion");
  if (!motion) return {};
  const std::vector<MotionKey> keys = motion_keys(shape);
  if (keys.empty())
    table.fail("motion", fmt::format("is not possible for a {} shape", shape_kind(shape)),
               "its place is that of the capture");
  std::vector<std::string> names;
  std::size_t n_ways = 0;
  for (const MotionKey& key : keys) {
    names.push_back(key.key);
    n_ways += key.at.size();
  }
  motion->allow(names);
  std::vector<double> ways(n_ways, 0.0);
  for (const MotionKey& key : keys) {
    if (!motion->has(key.key)) continue;
    if (key.at.size() == 1) {
      ways[key.at[0]] = motion->required_number(key.key, kMotionRange);
      continue;
    }
    const auto given = motion->vector(key.key, static_cast<int>(key.at.size()), kMotionRange);
    for (std::size_t i = 0; i < key.at.size(); ++i) ways[key.at[i]] = (*given)[static_cast<Eigen::Index>(i)];
  }
  return ways;
}

}  // namespace

std::vector<Object> read_objects(const TomlTable& root, const TwinFileContext& context) {
  std::vector<Object> objects;
  std::set<std::string> names;
  const std::vector<TomlTable> tables = root.tables("object");
  if (tables.size() > kMostObjects)
    root.fail("object",
              fmt::format("is given {} times, at most {} are possible", tables.size(), kMostObjects),
              "make one mesh of them");
  for (const TomlTable& table : tables) {
    Object object;
    object.shape = read_shape(table, context);
    object.name = table.required_name();
    if (!names.insert(object.name).second)
      table.fail("name", fmt::format("\"{}\" is the name of an earlier object, too", object.name));
    if (const auto material = table.table("material")) object.material = read_material(*material);
    object.motion = read_motion(table, object.shape);
    objects.push_back(object);
  }
  return objects;
}

}  // namespace fringetwin
