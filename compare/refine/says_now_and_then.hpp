// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <fmt/format.h>

#include <chrono>

#include "twin/base/progress.hpp"

namespace fringetwin::compare {

/// Says how far a fit is that takes long.
class SaysNowAndThen {
 public:
  void operator()(int step, double chi2) {
    constexpr std::chrono::seconds kSilence{3};
    if (const auto now = std::chrono::steady_clock::now(); now - last_ >= kSilence) {
      last_ = now;
      say(fmt::format("refine: step {}, chi2 {:.5g} so far", step + 1, chi2));
    }
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace fringetwin::compare
