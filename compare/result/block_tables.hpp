// SPDX-License-Identifier: Apache-2.0
// Holds the tables of a result whose rows come with maps over blocks of pixels, noise and shift: their rows,
// and what each number of a row is. The formulas: docs/metrics/gray.md, "Noise"; docs/metrics/phase.md,
// "Shift field".
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "compare/result/field_options.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::compare {

inline constexpr int kNoiseBlock = 24;  ///< px
inline constexpr int kShiftBlock = 32;  ///< px

/// Gray noise of one interval of gray levels.
struct NoiseLevel {
  double level_dn = 0, measured_dn = 0, predicted_dn = 0;
  std::uint64_t n = 0;
};

/// One camera and direction. Ratios are measured / predicted standard deviations, each value against its own
/// prediction.
struct NoiseRow {
  std::string camera, direction;
  bool sensor_known = false;  ///< false: the twin's sensor has no noise, its rounding alone is the prediction
  int steps = 0;              ///< N: the residuals of one pixel have N - 3 degrees of freedom
  std::string source = "steps";  ///< what the gray noise is taken from
  double gray_measured_dn = 0, gray_predicted_dn = 0, gray_ratio = 0, gray_ratio_sigma = 0;
  std::uint64_t n = 0;
  double phase_measured_rad = 0, phase_predicted_rad = 0, phase_ratio = 0, phase_ratio_sigma = 0;
  std::uint64_t n_phase = 0;

  // for the page only
  std::vector<NoiseLevel> levels;
  ImageF ratio_map;  ///< gray ratio of blocks of kNoiseBlock px; NaN where too few values
  /// Quantiles of the residuals over their predicted sigma against those of the normal distribution.
  std::vector<double> normal_quantile, residual_quantile;

  static void describe(auto& f) {
    using Row = NoiseRow;
    const Limit as_predicted{"noise_ratio_error",
                             "largest |measured / predicted noise - 1| of gray values and phase",
                             Limit::Worst::farthest_from_one};
    f.name("camera", "camera of the twin", &Row::camera);
    f.name("direction", "direction of the fringes", &Row::direction).one_of({"x", "y"});
    f.add("prediction", "what the prediction holds: the twin's sensor model, or its rounding alone",
          [](const Row& r) { return std::string(r.sensor_known ? "sensor" : "quantisation"); })
        .one_of({"sensor", "quantisation"});
    f.add("source",
          "what the gray noise is taken from: redundancy of the steps, differences between the means of the "
          "pitches, or between neighbours",
          &Row::source)
        .one_of({"steps", "pitches", "neighbours"})
        .not_required();
    f.positive("gray_measured_dn", "gray noise of the real images", &Row::gray_measured_dn);
    f.positive("gray_predicted_dn", "gray noise that the twin predicts", &Row::gray_predicted_dn);
    f.positive("gray_ratio", "gray noise measured over predicted", &Row::gray_ratio).limited(as_predicted);
    f.sigma("gray_ratio_sigma", "standard error of that ratio", &Row::gray_ratio_sigma);
    f.add("n", "gray values used", &Row::n);
    f.positive("phase_measured_rad", "phase noise of the real images", &Row::phase_measured_rad);
    f.positive("phase_predicted_rad", "phase noise that the twin predicts", &Row::phase_predicted_rad);
    f.positive("phase_ratio", "phase noise measured over predicted", &Row::phase_ratio).limited(as_predicted);
    f.sigma("phase_ratio_sigma", "standard error of that ratio", &Row::phase_ratio_sigma);
    f.add("n_phase", "phase values used", &Row::n_phase);
  }
};

/// One component over the blocks that tell it; NaN when none does.
struct ShiftComponent {
  double mean_px = 0, mean_sigma_px = 0, rms_px = 0, largest_px = 0;
  std::uint64_t n_blocks = 0;
};

/// The simulated image moved by (dx, dy) lies on the real one.
struct ShiftRow {
  std::string camera;
  ShiftComponent dx, dy;
  double chi2_before = 0, chi2_after = 0;  ///< of blocks that tell a component
  std::uint64_t n = 0;
  ImageF dx_px, dy_px;  ///< one value per block; NaN where unknown

  static void describe(auto& f) {
    f.name("camera", "camera of the twin", &ShiftRow::camera);
    f.add("block_px", "side of the blocks", [](const ShiftRow&) { return kShiftBlock; });
    describe_component(f, "dx", &ShiftRow::dx);
    describe_component(f, "dy", &ShiftRow::dy);
    f.positive("chi2_before", "weighted square of the difference per degree of freedom",
               &ShiftRow::chi2_before);
    f.positive("chi2_after", "what of it the shift leaves", &ShiftRow::chi2_after);
    f.add("n", "degrees of freedom", &ShiftRow::n);
  }

 private:
  static void describe_component(auto& f, const std::string& name, ShiftComponent ShiftRow::*component) {
    const auto of = [component](auto ShiftComponent::*number) {
      return [component, number](const ShiftRow& r) { return r.*component.*number; };
    };
    f.add(name + "_px", "mean shift along this axis that moves the simulated image onto the real one",
          of(&ShiftComponent::mean_px));
    f.sigma(name + "_sigma_px", "standard error of the mean shift", of(&ShiftComponent::mean_sigma_px));
    f.positive(name + "_rms_px", "rms shift of the blocks", of(&ShiftComponent::rms_px)).not_required();
    f.positive(name + "_largest_px", "largest shift of a block", of(&ShiftComponent::largest_px))
        .not_required();
    f.add("n_blocks_" + name, "blocks that tell this component", of(&ShiftComponent::n_blocks))
        .not_required();
  }
};

struct BlockTables {
  std::vector<NoiseRow> noise;
  std::vector<ShiftRow> shift;

  static void describe(auto& t) {
    t.rows("noise", &BlockTables::noise);
    t.rows("shift", &BlockTables::shift);
  }
};

}  // namespace fringetwin::compare
