// SPDX-License-Identifier: Apache-2.0
// Lists the sampling schemes that `pareto` compares, as one table.
#pragma once
#include <string>
#include <vector>

#include "render/base/sampling.hpp"
#include "twin/twin.hpp"

namespace fringetwin::tradeoff {

/// Schemes of one family differ in their number of samples only, and time grows with it; the adaptive ones
/// in the error they aim at.
struct Scheme {
  std::string family;
  render::Sampling sampling;
  bool is_published = false;  ///< the published system's 1024 multi-jittered samples, single precision
  bool is_default = false;    ///< what `render` takes for this twin
  bool is_adaptive() const { return sampling.sampler == Sampler::adaptive; }
  std::string size() const;  ///< "16" samples, "1e-04" of error aimed at
};
/// Returns them in single precision, then double where the device has it; by family, rising in cost; the
/// default is flagged, and added where the table lacks it. `quick`: a few of them, for tests.
std::vector<Scheme> scheme_table(const Twin& twin, bool has_double, bool quick);

}  // namespace fringetwin::tradeoff
