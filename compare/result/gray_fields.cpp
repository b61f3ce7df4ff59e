// SPDX-License-Identifier: Apache-2.0
// The fields of the rows that speak of gray values: gain, gray differences and their budget, noise, shift.
#include "compare/result/fields.hpp"
#include "compare/result/rows.hpp"

namespace fringetwin::compare {

namespace {
using Style = Column::Style;
}

std::vector<Field> describe(const GainRow*) {
  Fields<GainRow> f;
  f.add("camera", "", "camera of the twin", &GainRow::camera).named().shown({"camera", ""});
  f.add("gain_dn", "DN", "gray values per unit of simulated irradiance", &GainRow::gain_dn)
      .with_sigma("gain_sigma_dn")
      .shown({"gain", "DN per unit E", Style::with_sigma});
  f.add_positive("gain_sigma_dn", "DN", "standard error of the gain", &GainRow::gain_sigma_dn).error();
  f.add("black_level_dn", "DN", "gray value without light", &GainRow::black_level_dn)
      .with_sigma("black_level_sigma_dn")
      .shown({"black level", "DN", Style::with_sigma});
  f.add_positive("black_level_sigma_dn", "DN", "standard error of the black level",
                 &GainRow::black_level_sigma_dn)
      .error()
      .not_required();
  f.add_positive("rms_before_dn", "DN", "rms of the difference with the twin's own sensor values",
                 &GainRow::rms_before_dn)
      .shown({"rms before", "DN", Style::significant, 4});
  f.add_positive("rms_after_dn", "DN", "rms of the difference after the gain fit", &GainRow::rms_after_dn)
      .limited({"gray_rms_dn", "largest gray residual after the gain fit, DN"})
      .shown({"rms after", "DN", Style::significant, 4});
  f.add("r2", "", "share of the variance of the gray values that the line explains", &GainRow::r2)
      .limited({"gain_r2", "smallest R² of the gain fit (at least)", Limit::Worst::smallest, 1.0})
      .shown({"R²", "", Style::fixed, 6});
  f.add("n", "", "gray values used", &GainRow::n).shown({.header = "n", .place = 2});
  f.add_positive("sigma_inflation", "", "standard error of the gain over that of independent gray values",
                 &GainRow::sigma_inflation)
      .error()
      .not_required()
      .shown({.header = "σ inflation", .style = Style::significant, .digits = 3, .place = 1});
  f.add_positive("outlier_fraction", "", "share of the residuals beyond the Huber threshold",
                 &GainRow::outlier_fraction)
      .not_required()
      .shown({"beyond Huber", "%", Style::fixed, 2, 100.0});
  return f.take();
}

std::vector<Field> describe(const GrayRow*) {
  Fields<GrayRow> f;
  f.add("camera", "", "camera of the twin", &GrayRow::camera).named().shown({"camera", ""});
  f.add("pattern", "", "image of the sequence", &GrayRow::pattern).named().shown({"image", ""});
  f.add("mean_dn", "DN", "mean difference after the gain fit", &GrayRow::mean_dn)
      .shown({"mean", "DN", Style::signed_fixed, 3});
  f.add_positive("rms_dn", "DN", "rms of the difference after the gain fit", &GrayRow::rms_dn)
      .shown({"rms", "DN", Style::fixed, 3});
  f.add_positive("p99_dn", "DN", "99th percentile of the difference's size", &GrayRow::p99_dn)
      .shown({"P99 of |d|", "DN", Style::fixed, 2});
  f.add("n", "", "gray values used", &GrayRow::n).shown({"n", ""});
  return f.take();
}

std::vector<Field> describe(const GrayBudget*) {
  using Row = GrayBudget;
  Fields<Row> f;
  f.add("camera", "", "camera of the twin", &Row::camera).named();
  f.add("noise_source", "", "the estimate that the noise is taken from", &Row::noise_source);
  f.add_positive("total_dn2", "DN²", "mean square of the residual after the gain fit", &Row::total_dn2);
  f.add_positive("noise_dn2", "DN²", "part that is predicted as noise", &Row::noise_dn2);
  f.add("albedo_dn2", "DN²", "part that one factor per pixel removes", &Row::albedo_dn2);
  f.add("harmonics_dn2", "DN²", "part that one periodic function of the phase removes", &Row::harmonics_dn2);
  f.add("geometry_dn2", "DN²", "part that one shift of the projector coordinate per pixel removes",
        &Row::geometry_dn2);
  f.add("rest_dn2", "DN²", "part that none of the others explains", &Row::rest_dn2);
  f.add("contrast_dn2", "DN²", "of the harmonics: orders 0 and 1, contrast and offset of the fringe",
        &Row::contrast_dn2)
      .not_required();
  f.add("higher_orders_dn2", "DN²", "of the harmonics: orders 2 to 6", &Row::higher_orders_dn2)
      .not_required();
  f.add("noise_offset_dn2", "DN²", "noise variance at gray value 0, of a straight line",
        &Row::noise_offset_dn2)
      .not_required();
  f.add("noise_per_dn", "DN", "slope of that line: noise variance per gray value", &Row::noise_per_dn)
      .not_required();
  f.add_positive("albedo_spread", "", "robust relative scatter of the factors per pixel", &Row::albedo_sigma)
      .not_required();
  f.add("harmonic_amplitude", "", "amplitudes of orders 0 to 6, relative to the gray level above black",
        &Row::harmonic_amplitude)
      .not_required();
  f.add("n_pixels", "", "pixels used", &Row::n_pixels).not_required();
  f.add("n", "", "gray values used", &Row::n);
  return f.take();
}

std::vector<Field> describe(const NoiseRow*) {
  using Row = NoiseRow;
  const Limit as_predicted{"noise_ratio_error",
                           "largest |measured / predicted noise - 1| of gray values and phase",
                           Limit::Worst::farthest_from_one};
  Fields<Row> f;
  f.add("camera", "", "camera of the twin", &Row::camera).named();
  f.add("direction", "", "direction of the fringes", &Row::direction).named().one_of({"x", "y"});
  f.add("prediction", "", "what the prediction holds: the twin's sensor model, or its rounding alone",
        [](const Row& r) { return std::string(r.sensor_known ? "sensor" : "quantisation"); })
      .one_of({"sensor", "quantisation"});
  f.add_positive("gray_measured_dn", "DN", "gray noise of the real images", &Row::gray_measured_dn);
  f.add_positive("gray_predicted_dn", "DN", "gray noise that the twin predicts", &Row::gray_predicted_dn);
  f.add_positive("gray_ratio", "", "gray noise measured over predicted", &Row::gray_ratio)
      .with_sigma("gray_ratio_sigma")
      .limited(as_predicted);
  f.add_positive("gray_ratio_sigma", "", "standard error of that ratio", &Row::gray_ratio_sigma).error();
  f.add("n", "", "gray values used", &Row::n);
  f.add_positive("phase_measured_rad", "rad", "phase noise of the real images", &Row::phase_measured_rad);
  f.add_positive("phase_predicted_rad", "rad", "phase noise that the twin predicts",
                 &Row::phase_predicted_rad);
  f.add_positive("phase_ratio", "", "phase noise measured over predicted", &Row::phase_ratio)
      .with_sigma("phase_ratio_sigma")
      .limited(as_predicted);
  f.add_positive("phase_ratio_sigma", "", "standard error of that ratio", &Row::phase_ratio_sigma).error();
  f.add("n_phase", "", "phase values used", &Row::n_phase);
  return f.take();
}

namespace {
/// Adds the numbers of one component; `name`: "dx" or "dy".
void add_shift_component(const std::string& name, ShiftComponent ShiftRow::*component, Fields<ShiftRow>& f) {
  const auto of = [component](double ShiftComponent::*number) {
    return [component, number](const ShiftRow& r) { return r.*component.*number; };
  };
  f.add(name + "_px", "px", "mean shift along this axis that moves the simulated image onto the real one",
        of(&ShiftComponent::mean_px))
      .with_sigma(name + "_sigma_px");
  f.add_positive(name + "_sigma_px", "px", "standard error of the mean shift",
                 of(&ShiftComponent::mean_sigma_px))
      .error();
  f.add_positive(name + "_rms_px", "px", "rms shift of the blocks", of(&ShiftComponent::rms_px))
      .not_required();
  f.add_positive(name + "_largest_px", "px", "largest shift of a block", of(&ShiftComponent::largest_px))
      .not_required();
  f.add("n_blocks_" + name, "", "blocks that tell this component", [component](const ShiftRow& r) {
     return (r.*component).n_blocks;
   }).not_required();
}
}  // namespace

std::vector<Field> describe(const ShiftRow*) {
  Fields<ShiftRow> f;
  f.add("camera", "", "camera of the twin", &ShiftRow::camera).named();
  f.add("block_px", "px", "side of the blocks", [](const ShiftRow&) { return kShiftBlock; });
  add_shift_component("dx", &ShiftRow::dx, f);
  add_shift_component("dy", &ShiftRow::dy, f);
  f.add_positive("chi2_before", "", "weighted square of the difference per degree of freedom",
                 &ShiftRow::chi2_before);
  f.add_positive("chi2_after", "", "what of it the shift leaves", &ShiftRow::chi2_after);
  f.add("n", "", "degrees of freedom", &ShiftRow::n);
  return f.take();
}

}  // namespace fringetwin::compare
