// SPDX-License-Identifier: Apache-2.0
// The sampling schemes `pareto` compares, as one table.
#pragma once
#include <string>
#include <vector>

#include "render/renderer.hpp"
#include "twin/twin.hpp"

namespace fringetwin::study {

/// Schemes of one family differ in their number of samples only; time grows with it.
struct Scheme {
  std::string family;
  render::Sampling sampling;
  bool is_published = false;  ///< the published system's 1024 multi-jittered samples
  bool is_default = false;    ///< what `render` takes for this twin
};
/// By family, rising in samples; the default is flagged, and added where the table lacks it. `quick`: a
/// few of them, for tests.
std::vector<Scheme> scheme_table(const RenderOptions& options, bool quick);

/// Tracing in single or double precision as the renderer chooses it: by the phase target.
bool is_precise(const RenderOptions& options);
void set_precise(RenderOptions& options, bool precise);

}  // namespace fringetwin::study
