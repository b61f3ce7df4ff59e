// SPDX-License-Identifier: Apache-2.0
// Parts of harmonics in lists, as parameters name, read and change them.
#pragma once
#include "twin/fringes.hpp"

namespace fringetwin::compare {

/// Of the group harmonics, and of what single images have of their own: fewer steps tell no orders, and the
/// highest one.
inline constexpr int kStepsForHarmonics = 6, kMostHarmonics = 7;

/// Returns what stands behind the order in a parameter's name.
inline const char* name_of_part(double Harmonic::*part) {
  return part == &Harmonic::sine ? ".quadrature" : "";
}

/// Returns a part of the harmonic of an order; 0 where the list ends before. `lowest`: order of its first.
inline double harmonic_part(const Harmonics& list, int order, double Harmonic::*part, int lowest = 2) {
  const auto i = static_cast<std::size_t>(order - lowest);
  return i < list.size() ? list[i].*part : 0.0;
}

/// Adds to it, in a list that grows to hold it.
inline void add_to_part(Harmonics& list, int order, double Harmonic::*part, double change, int lowest = 2) {
  const auto i = static_cast<std::size_t>(order - lowest);
  if (list.size() <= i) list.resize(i + 1);
  list[i].*part += change;
}

}  // namespace fringetwin::compare
