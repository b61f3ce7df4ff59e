// SPDX-License-Identifier: Apache-2.0
// The shape of an object: one of those in the other files of this folder.
#pragma once
#include <utility>
#include <variant>
#include <vector>

#include "twin/shape/cylinder.hpp"
#include "twin/shape/measured.hpp"
#include "twin/shape/mesh_shape.hpp"
#include "twin/shape/plane.hpp"
#include "twin/shape/sphere.hpp"

namespace fringetwin {

// Every shape S has, next to it, motions(S), place_keys(S), make_units(S&), place_mm(S), a point that tells
// where it is, if anything does, and shades_itself(S), whether light can be kept from it by itself. What
// other rooms do with a shape they overload in the same way and call through std::visit without a generic
// fallback, so that a shape somebody forgot does not compile.
using Shape = std::variant<SphereShape, PlaneShape, CylinderShape, MeshShape, MeasuredShape>;

/// Returns the word for it in twin.toml and in results: "sphere", "plane", "cylinder", "mesh", "measured".
inline const char* shape_kind(const Shape& shape) {
  return std::visit([]<class S>(const S&) { return S::kKind; }, shape);
}

inline bool shades_itself(const Shape& shape) {
  return std::visit([](const auto& s) { return shades_itself(s); }, shape);
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
