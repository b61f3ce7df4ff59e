// SPDX-License-Identifier: Apache-2.0
// Holds the table of the areas in which the real images show another surface than the twin: its rows, and
// what each number of a row is. How they are found: docs/metrics/verdict.md, "Other surfaces".
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "compare/result/field_options.hpp"
#include "twin/base/constants.hpp"

namespace fringetwin::compare {

/// A connected area of one camera.
struct OtherSurfaceRow {
  std::string camera;
  std::string object;  ///< of the twin, that it shows there; empty: none, or not known
  std::string seen;    ///< object of the twin that the real points are on; empty: none, or not known
  std::uint64_t n = 0, n_other_order = 0;
  std::vector<double> middle_px, place_mm;
  double before_mm = kNaN;
  std::string why;

  static void describe(auto& f) {
    using Row = OtherSurfaceRow;
    f.name("camera", "camera of the twin", &Row::camera).shown({"camera"});
    f.add("n", "pixels of the area", &Row::n).shown({"pixels"});
    f.add("n_other_order", "of these, measured on both sides, with phases more than half a fringe apart",
          &Row::n_other_order)
        .shown({"of other order"});
    f.add("middle_px", "mean pixel of the area: x, y", &Row::middle_px);
    f.add("object", "object that the twin shows there; null where none is known", &Row::object)
        .or_null()
        .shown({"the twin shows"});
    f.add("seen", "object of the twin whose surface the real points are on; null: of none, or no point tells",
          &Row::seen)
        .or_null()
        .shown({"the rig shows"});
    f.add("before_mm",
          "median distance by which the real points are nearer to the camera than the twin's; null where one "
          "side has no points there",
          &Row::before_mm)
        .shown({"nearer than the twin's", "mm", Column::signed_fixed, 2});
    f.add("place_mm", "mean of the real points, in the world frame", &Row::place_mm);
    f.add("why", "the finding in words", &Row::why).shown({"in words"});
  }
};

struct OtherSurfaceTables {
  std::vector<OtherSurfaceRow> other_surfaces;  ///< the largest of each camera first
};

}  // namespace fringetwin::compare
