// SPDX-License-Identifier: Apache-2.0
// example TWIN.toml: renders the twin, measures what its cameras see, and prints the radii of its spheres,
// mm.
#include <cstdio>
#include <exception>

#include "cosim/cosim.hpp"
#include "twin/base/errors.hpp"

int main(int argc, char** argv) {
  try {
    fringetwin::cosim::CosimRequest request;
    request.twin = argc > 1 ? argv[1] : "twin.toml";
    const fringetwin::cosim::Run run = fringetwin::cosim::run_cosim(request);
    for (const auto& fit : run.simulated.measurement.value().fits)
      if (fit.numbers.contains("radius_mm"))
        std::printf("%s %.17g\n", fit.object.c_str(), fit.numbers.at("radius_mm"));
    return 0;
  } catch (const fringetwin::UserError& fault) {
    std::fprintf(stderr, "%s\n", fault.what());
    return static_cast<int>(fault.code());
  }
}
