// SPDX-License-Identifier: Apache-2.0
// How a shape can be moved as a rigid body, and the keys of twin.toml that say where it is.
#pragma once
#include <functional>
#include <string>
#include <vector>

namespace fringetwin {

/// One degree of freedom of a shape of type S. Motions add up to first order; make_units() restores the unit
/// vectors of a shape after all of them.
template <class S>
struct Motion {
  std::string name;    ///< behind the object's name, as in "center_mm.x"
  std::string unit;    ///< "mm" or "rad"
  double start = 0.0;  ///< value before the motion; 0 where only the change has a meaning
  std::function<void(S&, double)> move_by;  ///< a distance or an angle in `unit`
};

/// A key of the object's table in twin.toml and its numbers.
struct PlaceKey {
  std::string key;
  std::vector<double> values;
};

}  // namespace fringetwin
