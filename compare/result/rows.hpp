// SPDX-License-Identifier: Apache-2.0
// Holds what one comparison of a real with a simulated side found, table by table and row by row, as plain
// values before they become JSON or a page. docs/METRICS.md leads to every formula. A number that is unknown
// is NaN; differences are simulated - real.
#pragma once
#include <string>
#include <vector>

#include "compare/result/block_tables.hpp"
#include "compare/result/coverage_tables.hpp"
#include "compare/result/geometry_tables.hpp"
#include "compare/result/gray_tables.hpp"
#include "compare/result/held_out_table.hpp"
#include "compare/result/light_table.hpp"
#include "compare/result/other_surface_table.hpp"
#include "compare/result/phase_tables.hpp"
#include "compare/result/verdict_tables.hpp"

namespace fringetwin::compare {

/// All tables, the verdict on the limits, and the warnings.
struct Comparison : GeometryTables,
                    GrayTables,
                    PhaseTables,
                    BlockTables,
                    CoverageTables,
                    VerdictTables,
                    LightTables,
                    HeldOutTables,
                    OtherSurfaceTables {
  bool pass = true;
  std::vector<std::string> warnings;
  /// The real images show other fringes than the twin, or show them elsewhere, so that no fit says anything
  /// (warnings tell how); not written.
  bool shows_other_fringes = false;
  /// The windows of a measured shape smooth away what the gray values show, and nothing else fails.
  bool smooths_a_form_away = false;
};

}  // namespace fringetwin::compare
