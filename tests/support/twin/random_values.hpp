// SPDX-License-Identifier: Apache-2.0
// Property tests with a fixed seed, and generators of real numbers. For *_test.cpp only.
#pragma once
#include <rapidcheck/gtest.h>

#include <Eigen/Core>
#include <cstdint>
#include <cstdlib>

namespace fringetwin::testing {

/// rapidcheck draws its seed from the clock unless told; RC_PARAMS set outside wins.
inline const bool property_seed_fixed = setenv("RC_PARAMS", "seed=20230817 max_success=300", 0) == 0;

/// Uniform in [low, high], shrinking towards low; not scaled by rapidcheck's growing "size".
inline rc::Gen<double> uniform(double low, double high) {
  constexpr std::int64_t n = std::int64_t{1} << 40;
  return rc::gen::map(rc::gen::resize(100, rc::gen::inRange<std::int64_t>(0, n + 1)),
                      [low, high](std::int64_t i) {
                        return low + (high - low) * (static_cast<double>(i) / static_cast<double>(n));
                      });
}

inline Eigen::Vector3d any_vector(double limit) {
  const auto g = uniform(-limit, limit);
  return {*g, *g, *g};
}

}  // namespace fringetwin::testing
