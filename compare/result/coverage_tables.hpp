// SPDX-License-Identifier: Apache-2.0
// Holds the table of a result that says which pixels were measured on both sides, on one, on none, and why:
// its rows, and what each number of a row is. The formulas: docs/metrics/verdict.md, "Coverage".
#pragma once
#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "compare/result/field_options.hpp"
#include "twin/base/constants.hpp"

namespace fringetwin::compare {

/// The pixels that one side measures and the other does not, and what they are on the other side.
struct OneSided {
  std::uint64_t n = 0, border = 0, interior = 0, thick = 0;
  std::uint64_t lost_dark = 0, lost_low_modulation = 0, lost_saturated = 0, lost_order = 0;
};

/// What one camera measures of all it sees, or of one object.
struct CoverageRow {
  std::string camera;
  std::string object;  ///< empty: of everything
  std::uint64_t n_both = 0, n_seen = 0, n_neither_saturated = 0, outline_px = 0;
  OneSided real_only, simulated_only;
  double allowed_thick = kNaN, allowed_interior = kNaN, allowed_border = kNaN;  ///< NaN: not judged
  bool explained = false;
  std::string why;  ///< what is beyond the allowance; empty when explained
  /// The largest area inside that is measured on one side only, where the row is not explained.
  std::vector<double> place_box_px, place_mm;
  std::string place_object;

  std::uint64_t n_one_sided() const { return real_only.n + simulated_only.n; }
  std::uint64_t n_union() const { return n_both + n_one_sided(); }
  std::uint64_t n_interior() const { return real_only.interior + simulated_only.interior; }
  std::uint64_t n_border() const { return real_only.border + simulated_only.border; }
  std::uint64_t n_thick() const { return real_only.thick + simulated_only.thick; }
  std::uint64_t n_neither() const { return n_seen - n_union(); }
  /// NaN where no side sees anything.
  double covered_fraction() const { return ratio(n_both, n_seen); }
  /// NaN where no side measures anything.
  double one_sided_fraction() const { return ratio(n_one_sided(), n_union()); }
  /// Returns how many times its allowance the furthest of the three counts is; one that is not judged is 0.
  double excess() const {
    const auto over = [](std::uint64_t n, double allowed) {
      return allowed > 0.0 ? static_cast<double>(n) / allowed : 0.0;
    };
    return std::max({over(n_thick(), allowed_thick), over(n_interior(), allowed_interior),
                     over(n_border(), allowed_border)});
  }
  static double ratio(std::uint64_t part, std::uint64_t all) {
    return all > 0 ? static_cast<double>(part) / static_cast<double>(all) : kNaN;
  }

  static void describe(auto& f) {
    using Row = CoverageRow;
    f.name("camera", "camera of the twin", &Row::camera).shown({"camera"});
    f.name("object", "object of the twin; null for everything that the camera sees", &Row::object)
        .or_null()
        .shown({"object"});
    f.add("n_both", "pixels measured on both sides", &Row::n_both).shown({"on both sides", "pixels"});
    describe_side(f, "real_only", "real", &Row::real_only);
    describe_lost(f, "simulated", "real", &Row::real_only);
    describe_side(f, "simulated_only", "simulated", &Row::simulated_only);
    describe_lost(f, "real", "simulated", &Row::simulated_only);
    f.add("n_seen", "pixels in which one side or both have fringes, or are saturated", &Row::n_seen)
        .shown({"seen", "pixels"});
    f.add("n_neither", "of these, measured on neither side", &Row::n_neither)
        .shown({"on neither side", "pixels"});
    f.add("n_neither_saturated", "of these, saturated on one side or both", &Row::n_neither_saturated);
    f.add("outline_px", "length of the outline of what is measured, without gaps", &Row::outline_px);
    f.positive("covered_fraction", "share of the pixels seen that is measured on both sides",
               &Row::covered_fraction)
        .limited({"covered_fraction",
                  "smallest share of the pixels seen that is measured on both sides (at least)",
                  Limit::Worst::smallest, 1.0})
        .shown({"covered", "% of the seen", Column::fixed, 1, 100.0});
    f.positive("one_sided_fraction", "share of the measured pixels that only one side measures",
               &Row::one_sided_fraction)
        .limited({"one_sided_fraction", "largest share of the measured pixels that only one side measures"})
        .shown({"one-sided", "% of the measured", Column::significant, 3, 100.0});
    f.positive("allowed_thick", "thick one-sided pixels that count as explained", &Row::allowed_thick);
    f.positive("allowed_interior", "interior one-sided pixels that count as explained",
               &Row::allowed_interior);
    f.positive("allowed_border", "one-sided pixels at outlines that count as explained",
               &Row::allowed_border);
    f.add("explained", "whether all three are within their allowance and half of the seen is covered",
          &Row::explained);
    f.add("why", "what is not explained, in words", &Row::why).or_null();
    f.add("place_box_px", "largest area inside that one side alone measures: left, top, right, bottom pixel",
          &Row::place_box_px);
    f.add("place_mm", "mean of the points in that area, in the world frame", &Row::place_mm);
    f.add("place_object", "object of the twin that these points are on", &Row::place_object).or_null();
  }

 private:
  /// Adds where the pixels lie that one side alone measures.
  static void describe_side(auto& f, const std::string& key, const std::string& side,
                            OneSided CoverageRow::*pixels) {
    const auto add = [&](const std::string& end, const std::string& meaning, std::uint64_t OneSided::*part) {
      return &f.add("n_" + key + end, meaning,
                    [pixels, part](const CoverageRow& row) { return row.*pixels.*part; });
    };
    add("", "pixels measured on the " + side + " side only", &OneSided::n)->shown({side + " only", "pixels"});
    add("_border", "of these, at the outline of what either side measures", &OneSided::border);
    add("_interior", "of these, away from outlines", &OneSided::interior)
        ->shown({"of these inside", "pixels"});
    add("_thick", "of these, more than 2 px inside an area that one side alone measures", &OneSided::thick)
        ->shown({"of these thick", "pixels"});
  }

  /// Adds why the one side lacks the pixels that the other side alone measures.
  static void describe_lost(auto& f, const std::string& side, const std::string& other,
                            OneSided CoverageRow::*pixels) {
    const auto add = [&](const std::string& key, const std::string& what, std::uint64_t OneSided::*part) {
      f.add(side + "_lacks_" + key,
            "pixels measured on the " + other + " side only; the " + side + " side " + what,
            [pixels, part](const CoverageRow& row) { return row.*pixels.*part; });
    };
    add("dark", "is dark there: nothing is there, or it lies in shadow", &OneSided::lost_dark);
    add("low_modulation", "has light there, but too weak fringes", &OneSided::lost_low_modulation);
    add("saturated", "is saturated there", &OneSided::lost_saturated);
    add("order", "has fringes there, but no fringe order", &OneSided::lost_order);
  }
};

struct CoverageTables {
  std::vector<CoverageRow> coverage;

  static void describe(auto& t) { t.rows("coverage", &CoverageTables::coverage); }
};

}  // namespace fringetwin::compare
