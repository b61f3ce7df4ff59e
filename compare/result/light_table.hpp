// SPDX-License-Identifier: Apache-2.0
// Holds the table `light` of a result: the factors of the images that `[measure] light = "corrected"` found
// and took out, and what each number of a row is. The formulas: docs/metrics/measure.md, "Light of the
// images".
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "compare/result/field_options.hpp"
#include "measure/measurement.hpp"

namespace fringetwin::compare {

/// What one camera's phase steps say of the light of its images.
struct LightRow {
  std::string side, camera;  ///< side: empty in a measurement, which has one
  bool corrected = false;
  std::vector<double> factor, factor_sigma;
  double phase_rms_rad = 0, residual_ratio = 0;
  std::uint64_t n_pixels = 0;

  static void describe(auto& f) {
    using Row = LightRow;
    f.name("side", "of a comparison: whose images", &Row::side).one_of({"real", "simulated"}).or_absent();
    f.name("camera", "camera of the twin", &Row::camera);
    f.add("corrected", "true: the factors were taken out; false: they differ by no more than chance",
          &Row::corrected);
    f.add("factor",
          "of each image of the sequence, geometric mean 1 over the phase steps; 1 of all other images",
          &Row::factor)
        .sigma = "factor_sigma";
    f.add("factor_sigma", "standard errors of the factors; 0 of what is no phase step, null: unknown",
          &Row::factor_sigma)
        .error();
    f.positive("phase_rms_rad",
               "what the factors move the phase by, rms over all phases, largest of the pitches",
               &Row::phase_rms_rad);
    f.positive("residual_ratio", "mean square of the N-step residuals with the factors over that without",
               &Row::residual_ratio);
    f.add("n_pixels", "pixels that told the factors, of all pitches", &Row::n_pixels);
  }
};

/// Appends the rows of a side's cameras; none where [measure] light is as it is, or the steps do not tell.
inline void add_light_rows(const measure::Measurement& measurement, const std::string& side,
                           std::vector<LightRow>& rows) {
  for (const measure::CameraDecode& camera : measurement.cameras)
    if (const auto& light = camera.light)
      rows.push_back({side, camera.camera, camera.light_taken_out, light->factor, light->sigma,
                      light->phase_rms_rad,
                      light->residual_before > 0.0 ? light->residual_after / light->residual_before : 1.0,
                      light->n_pixels});
}

struct LightTables {
  std::vector<LightRow> light;
};

}  // namespace fringetwin::compare
