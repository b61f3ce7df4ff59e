// SPDX-License-Identifier: Apache-2.0
#include "render/base/kernels.hpp"

#include "kernels_spv.h"
#include "twin/base/errors.hpp"

namespace fringetwin::render {

std::span<const std::uint32_t> kernel_code(Kernel kernel, bool storage, bool precise) {
  using Code = std::span<const std::uint32_t>;
  const auto choose = [&](Code plain, Code in_storage, Code in_double, Code both) {
    return precise ? (storage ? both : in_double) : (storage ? in_storage : plain);
  };
  switch (kernel) {
    case Kernel::trace:
      return choose(trace_spv, trace_storage_spv, trace_precise_spv, trace_precise_storage_spv);
    case Kernel::probe:
      return choose(probe_spv, probe_storage_spv, probe_precise_spv, probe_precise_storage_spv);
    case Kernel::closed_form:
      return choose(closed_form_spv, closed_form_storage_spv, closed_form_precise_spv,
                    closed_form_precise_storage_spv);
    case Kernel::border:
      return choose(border_spv, border_storage_spv, border_precise_spv, border_precise_storage_spv);
    case Kernel::facets:
      return choose(facets_spv, facets_storage_spv, facets_precise_spv, facets_precise_storage_spv);
    case Kernel::lines:
      return choose(lines_spv, lines_storage_spv, lines_precise_spv, lines_precise_storage_spv);
    case Kernel::gather:
      return choose(gather_spv, gather_storage_spv, gather_precise_spv, gather_precise_storage_spv);
    case Kernel::mirror_ways:
      return choose(mirror_ways_spv, mirror_ways_storage_spv, mirror_ways_precise_spv,
                    mirror_ways_precise_storage_spv);
  }
  FT_CHECK(false, "unknown kernel");
  return {};
}

}  // namespace fringetwin::render
