// SPDX-License-Identifier: Apache-2.0
// Takes two capture sets of one twin, real and simulated, up to their comparison: loads and measures both.
#pragma once
#include <filesystem>

#include "cosim/run.hpp"

namespace fringetwin::cosim {

struct CompareRequest {
  std::filesystem::path twin;             ///< the twin.toml
  std::filesystem::path real, simulated;  ///< capture folders
};

/// Loads and measures both sides; then compare_and_write() (cosim/write_results.hpp) does the rest. The
/// irradiance comes from the EXR images that `render --radiance` wrote, where they are there.
Run measure_both(const CompareRequest& request);

}  // namespace fringetwin::cosim
