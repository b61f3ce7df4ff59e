// SPDX-License-Identifier: Apache-2.0
// vivid_setup N: instances 0...N-1 show on their capture what their output plays, at the rate of the tests.
#include <cstdio>
#include <cstdlib>

#include "tests/vm/vivid.hpp"

int main(int argc, char** argv) {
  try {
    const int n = argc > 1 ? std::atoi(argv[1]) : 1;
    for (int i = 0; i < n; ++i) fringetwin::test::Vivid{i};
  } catch (const std::exception& error) {
    std::fprintf(stderr, "vivid_setup: %s\n", error.what());
    return 1;
  }
}
