// SPDX-License-Identifier: Apache-2.0
// Lenses for tests: those of datasets/paper-sphere (Table 3 of its paper) and random plausible ones. For
// *_test.cpp only.
#pragma once
#include <string>
#include <vector>

#include "tests/support/twin/random_values.hpp"
#include "twin/base/errors.hpp"
#include "twin/lens/lens.hpp"

namespace fringetwin::testing {

inline Lens paper_left() {
  return {"LENSMODEL_OPENCV4",
          {2359.53, 2359.09, 734.47, 578.34, -0.1251, 0.1620, 0.0003, -0.0004},
          {1440, 1080},
          "left"};
}
inline Lens paper_right() {
  return {"LENSMODEL_OPENCV4",
          {2360.53, 2359.81, 736.99, 580.87, -0.1170, 0.1249, 0.0, -0.0002},
          {1440, 1080},
          "right"};
}
inline Lens paper_projector() {
  return {"LENSMODEL_OPENCV4",
          {1700.15, 1701.22, 627.73, 406.54, 0.1328, -0.3361, -0.0006, -0.0001},
          {1280, 720},
          "projector"};
}

/// Strong but plausible: up to 40 degrees off axis at the corners, distortion up to 20 % there,
/// decentred optics. Lenses that are not invertible over their image are drawn again.
inline Lens any_lens() {
  struct Model {
    const char* name;
    std::size_t count;
  };
  const auto model = *rc::gen::elementOf(std::vector<Model>{{"LENSMODEL_PINHOLE", 0},
                                                            {"LENSMODEL_OPENCV4", 4},
                                                            {"LENSMODEL_OPENCV5", 5},
                                                            {"LENSMODEL_OPENCV8", 8},
                                                            {"LENSMODEL_OPENCV12", 12}});
  const double limits[12] = {0.4, 0.3, 0.005, 0.005, 0.1, 0.2, 0.1, 0.05, 0.01, 0.01, 0.01, 0.01};
  const int width = *rc::gen::resize(100, rc::gen::inRange(320, 4096));
  const int height = *rc::gen::resize(100, rc::gen::inRange(240, 3000));
  const double diagonal = std::hypot(width, height);
  const double f = 0.5 * diagonal / *uniform(0.1, 0.8);
  std::vector<double> intrinsics{f, f * *uniform(0.98, 1.02), width * *uniform(0.42, 0.58),
                                 height * *uniform(0.42, 0.58)};
  for (std::size_t i = 0; i < model.count; ++i) intrinsics.push_back(*uniform(-limits[i], limits[i]));
  try {
    return {model.name, intrinsics, {width, height}, "random lens"};
  } catch (const UserError&) {
    RC_DISCARD("not invertible over its image");
  }
}

inline Eigen::Vector2d any_pixel(const Lens& lens) {
  return {*uniform(-0.5, lens.width() - 0.5), *uniform(-0.5, lens.height() - 0.5)};
}

}  // namespace fringetwin::testing
