// SPDX-License-Identifier: Apache-2.0
// make_freeform OUT.ply [SUBDIVISIONS [RADIUS_MM]]: writes the part of datasets/paper-freeform.
#include <cstdlib>
#include <exception>
#include <iostream>

#include "tests/support/freeform.hpp"
#include "tests/support/twin/save_mesh_ply.hpp"

int main(int argc, char** argv) {
  if (argc < 2 || argc > 4) {
    std::cerr << "usage: make_freeform OUT.ply [SUBDIVISIONS = 6 [RADIUS_MM = 35]]\n";
    return 2;
  }
  const int subdivisions = argc > 2 ? std::atoi(argv[2]) : 6;
  const double radius_mm = argc > 3 ? std::atof(argv[3]) : 35.0;
  if (subdivisions < 0 || subdivisions > 9 || !(radius_mm > 0.0)) {
    std::cerr << "make_freeform: subdivisions must be 0...9 and the radius positive\n";
    return 2;
  }
  try {
    const auto mesh = fringetwin::testing::make_bumpy_icosphere(subdivisions, radius_mm,
                                                                fringetwin::testing::default_bumps());
    fringetwin::testing::save_mesh_ply(argv[1], mesh);
    std::cerr << argv[1] << ": " << mesh.triangles.size() << " triangles\n";
  } catch (const std::exception& error) {
    std::cerr << "make_freeform: " << error.what() << "\n";
    return 3;
  }
}
