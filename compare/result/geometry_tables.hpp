// SPDX-License-Identifier: Apache-2.0
// Holds the tables of a result that compare geometry, fits and indicators: their rows, and what each number
// of a row is. The formulas: docs/metrics/geometry.md.
#pragma once
#include <Eigen/Core>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "measure/fit/fit_types.hpp"
#include "twin/base/constants.hpp"

namespace fringetwin::compare {

/// The fits of one object on both sides, and how far they differ.
struct FitRow {
  std::string object, kind;
  std::optional<measure::ObjectFit> simulated, real;  ///< real may hold published numbers (n = 0)
  std::map<std::string, double> difference, z;        ///< simulated - real; z absent where a sigma is unknown
  std::map<std::string, Eigen::Vector3d> difference_vectors, z_vectors;
  /// Where a published real side gives an rms but no sigma: its sigmas, by their own keys, estimated from
  /// that rms, and the z they make (published_sigma.hpp).
  std::map<std::string, double> real_sigma_estimated, z_estimated;
  std::map<std::string, Eigen::Vector3d> real_sigma_estimated_vectors, z_estimated_vectors;
};

/// One geometry indicator in mm: form, size, flatness or spacing (docs/metrics/geometry.md, "Indicators").
struct Indicator {
  std::string name;
  std::vector<std::string> objects;  ///< two for a spacing
  struct Value {
    double mm = kNaN, sigma_mm = kNaN;
  };
  Value simulated, real;

  double difference_mm() const { return simulated.mm - real.mm; }
  /// NaN where a sigma is unknown.
  double z() const {
    const double sigma = std::hypot(simulated.sigma_mm, real.sigma_mm);
    return sigma > 0.0 ? difference_mm() / sigma : kNaN;
  }

  static void describe(auto& f) {
    f.name("name", "which indicator it is", &Indicator::name)
        .one_of({"sphere_form", "sphere_form_95", "sphere_size", "plane_flatness", "plane_flatness_95",
                 "sphere_spacing"});
    f.name("objects", "objects it is taken from", &Indicator::objects).items(1, 2);
    f.add("unit", "unit of the values", [](const Indicator&) { return std::string("mm"); }).one_of({"mm"});
    f.add("simulated", "value of the simulated side", [](const Indicator& i) { return i.simulated.mm; })
        .in("mm")
        .without_images();
    f.sigma("simulated_sigma_mm", "its standard error",
            [](const Indicator& i) { return i.simulated.sigma_mm; });
    f.add("real", "value of the real side", [](const Indicator& i) { return i.real.mm; }).in("mm");
    f.sigma("real_sigma_mm", "its standard error", [](const Indicator& i) { return i.real.sigma_mm; });
    f.add("difference", "simulated less real", &Indicator::difference_mm).in("mm");
    f.add("z", "the difference over its standard error", &Indicator::z);
  }
};

struct GeometryTables {
  std::vector<FitRow> fits;  ///< written by fit_json.hpp: its numbers stand in maps
  std::vector<Indicator> indicators;

  static void describe(auto& t) { t.rows("indicators", &GeometryTables::indicators); }
};

}  // namespace fringetwin::compare
