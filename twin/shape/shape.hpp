// SPDX-License-Identifier: Apache-2.0
// The shape of an object: one of those in the other files of this folder.
#pragma once
#include <concepts>
#include <filesystem>
#include <utility>
#include <variant>
#include <vector>

#include "twin/shape/cylinder.hpp"
#include "twin/shape/measured.hpp"
#include "twin/shape/mesh_shape.hpp"
#include "twin/shape/plane.hpp"
#include "twin/shape/sphere.hpp"

namespace fringetwin {

// The shapes that formulas describe, in the order in which the renderer packs them: X(type).
#define FT_ANALYTIC_SHAPES(X) X(SphereShape) X(PlaneShape) X(CylinderShape)
#define FT_SHAPES(X) FT_ANALYTIC_SHAPES(X) X(MeshShape) X(MeasuredShape)

// Every shape S has, in its own file: S::kKind, its word in twin.toml and in results; S::kHasFiles, whether
// files are read for its form or its reflectivity; S::kLightsItself, whether light can go from one place of
// it to another; motions(S), place_keys(S) and make_units(S&) (motion.hpp); place_mm(S), a point that tells
// where it is, if anything does; shades_itself(S), whether it can keep the light from itself; and with files
// shape_files(S), has_albedo(S) and remove_albedo(S&). What other rooms do with a shape they overload in the
// same way and call through std::visit without a generic fallback, so that a shape somebody forgot does not
// compile or link.
#define FT_AND_NEXT(S) S,
using Shape = std::variant<FT_ANALYTIC_SHAPES(FT_AND_NEXT) MeshShape, MeasuredShape>;
#undef FT_AND_NEXT

/// A shape for which no file is read: its reflectivity is the same everywhere.
template <class S>
concept WithoutFiles = !S::kHasFiles;

/// Returns the files that the shape is read from (an empty name where it was made in memory).
template <WithoutFiles S>
std::vector<std::filesystem::path> shape_files(const S&) {
  return {};
}
/// Returns whether the reflectivity varies over the shape; remove_albedo() makes it the same everywhere.
template <WithoutFiles S>
bool has_albedo(const S&) {
  return false;
}
template <WithoutFiles S>
void remove_albedo(S&) {}

/// Returns the word for it in twin.toml and in results: "sphere", "plane", "cylinder", "mesh", "measured".
inline const char* shape_kind(const Shape& shape) {
  return std::visit([]<class S>(const S&) { return S::kKind; }, shape);
}

// Of any shape; templates, so that a shape without its own function does not turn into a Shape and come back
// here.
template <std::same_as<Shape> S>
bool shades_itself(const S& shape) {
  return std::visit([](const auto& s) { return shades_itself(s); }, shape);
}

template <std::same_as<Shape> S>
std::vector<std::filesystem::path> shape_files(const S& shape) {
  return std::visit([](const auto& s) { return shape_files(s); }, shape);
}

/// Calls `function` with a default-made shape of every type, in the order of the variant.
template <class Function>
void for_every_shape(const Function& function) {
  [&]<std::size_t... i>(std::index_sequence<i...>) {
    (function(std::variant_alternative_t<i, Shape>()), ...);
  }
  (std::make_index_sequence<std::variant_size_v<Shape>>());
}

}  // namespace fringetwin
