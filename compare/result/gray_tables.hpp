// SPDX-License-Identifier: Apache-2.0
// Holds the tables of a result that compare gray values, gain, differences and their budget: their rows, and
// what each number of a row is. The formulas: docs/metrics/gray.md.
#pragma once
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "compare/result/field_options.hpp"
#include "twin/base/constants.hpp"

namespace fringetwin::compare {

/// The line between simulated irradiance and the real gray values of one camera.
struct GainRow {
  std::string camera;
  bool usable = false;  ///< false: no gain could be fitted, the numbers are NaN
  double gain_dn = 0, gain_sigma_dn = 0, black_level_dn = 0, black_level_sigma_dn = 0;
  double rms_before_dn = 0, rms_after_dn = 0, r2 = 0;
  std::uint64_t n = 0;      ///< gray values (pixel x image)
  std::string black_state;  ///< "fitted", or why the black level was held at the twin's
  /// Standard error ratio: cluster-robust / as if all residuals were independent. Far above 1 =
  /// spatially correlated residuals (albedo, shading, geometry), which the sigmas here allow for.
  double sigma_inflation = 1.0;
  double robust_scale_dn = 0, outlier_fraction = 0;  ///< 1.4826 MAD; share beyond the Huber threshold
  /// Range of predicted gray values used (values near a clip are left out).
  double low_dn = 0, high_dn = 0;
  /// Where the real values stop below full scale; NaN where they do not.
  double clip_dn = kNaN;
  /// The line that gray values are judged along where no gain is fitted; NaN where one is.
  double provisional_gain_dn = kNaN, provisional_black_level_dn = kNaN;
  std::string state = "not fitted";  ///< what the two numbers are worth (gain_trust.hpp)
  std::string why;                   ///< what speaks against them; may be empty
  double gain_bias_dn = kNaN, black_level_bias_dn = kNaN;  ///< NaN: nothing was checked
  /// Share of the sound gray values that the fit's margin at the clips left out; NaN: none was looked at.
  double dropped_fraction = kNaN;
  /// Returns the standard error of the gain, widened by its bias where that is known.
  double gain_total_sigma_dn() const { return widened(gain_sigma_dn, gain_bias_dn); }
  /// Returns the same of the black level.
  double black_level_total_sigma_dn() const { return widened(black_level_sigma_dn, black_level_bias_dn); }
  /// Returns root of the sum of both squares; a bias that is not known widens nothing.
  static double widened(double sigma, double bias) {
    return std::isnan(bias) ? sigma : std::hypot(sigma, bias);
  }

  static void describe(auto& f) {
    f.name("camera", "camera of the twin", &GainRow::camera).shown({"camera"});
    f.add("gain_dn", "gray values per unit of simulated irradiance", &GainRow::gain_dn)
        .shown({.header = "gain",
                .unit = "DN per unit E",
                .style = Column::with_sigma,
                .sigma = "gain_total_sigma_dn"});
    f.sigma("gain_sigma_dn", "standard error of the gain", &GainRow::gain_sigma_dn);
    f.add("black_level_dn", "gray value without light", &GainRow::black_level_dn)
        .shown({.header = "black level",
                .unit = "DN",
                .style = Column::with_sigma,
                .sigma = "black_level_total_sigma_dn"});
    f.sigma("black_level_sigma_dn", "standard error of the black level", &GainRow::black_level_sigma_dn)
        .not_required();
    f.add("state", "what gain and black level are worth", &GainRow::state)
        .one_of({"sensor value", "biased", "not offered", "not fitted"})
        .not_required()
        .shown({.header = "worth"});
    f.add("why", "why they are no sensor values, or what their parts disagree in", &GainRow::why).or_absent();
    f.positive("gain_bias_dn", "what parts of the gray values disagree with the gain by",
               &GainRow::gain_bias_dn)
        .not_required();
    f.positive("black_level_bias_dn", "what parts of the gray values disagree with the black level by",
               &GainRow::black_level_bias_dn)
        .not_required();
    f.positive("gain_total_sigma_dn", "standard error of the gain, widened by that bias",
               &GainRow::gain_total_sigma_dn)
        .error()
        .not_required();
    f.positive("black_level_total_sigma_dn", "standard error of the black level, widened by that bias",
               &GainRow::black_level_total_sigma_dn)
        .error()
        .not_required();
    f.positive("rms_before_dn", "rms of the difference with the twin's own sensor values",
               &GainRow::rms_before_dn)
        .shown({"rms before", "DN", Column::significant, 4});
    f.positive("rms_after_dn", "rms of the difference after the gain fit", &GainRow::rms_after_dn)
        .limited({"gray_rms_dn", "largest gray residual after the gain fit, DN"})
        .shown({"rms after", "DN", Column::significant, 4});
    f.add("r2", "share of the variance of the gray values that the line explains", &GainRow::r2)
        .limited({"gain_r2", "smallest R² of the gain fit (at least)", Limit::Worst::smallest, 1.0})
        .shown({"R²", "", Column::fixed, 6});
    f.add("n", "gray values used", &GainRow::n).shown({.header = "n", .place = 2});
    f.add("clip_dn", "gray value below full scale at which the real values stop", &GainRow::clip_dn)
        .not_required();
    f.add("provisional_gain_dn",
          "where no gain is fitted: slope of the line that gray values are judged along",
          &GainRow::provisional_gain_dn)
        .not_required();
    f.add("provisional_black_level_dn", "black level of that line", &GainRow::provisional_black_level_dn)
        .not_required();
    f.positive("sigma_inflation", "standard error of the gain over that of independent gray values",
               &GainRow::sigma_inflation)
        .error()
        .not_required()
        .shown({.header = "σ inflation", .style = Column::significant, .digits = 3, .place = 1});
    f.positive("outlier_fraction", "share of the residuals beyond the Huber threshold",
               &GainRow::outlier_fraction)
        .not_required()
        .shown({"beyond Huber", "%", Column::fixed, 2, 100.0});
    f.positive("dropped_fraction", "share of the sound gray values that the margin at the clips left out",
               &GainRow::dropped_fraction)
        .not_required();
  }
};

/// Gain and black level of one camera as a part of its gray values says them (gain_checks.hpp).
struct GainCheck {
  std::string camera, part;
  double gain_dn = kNaN, gain_sigma_dn = kNaN, gain_z = kNaN;
  double black_level_dn = kNaN, black_level_sigma_dn = kNaN, black_level_z = kNaN;
  double sigma_inflation = kNaN;
  std::uint64_t n = 0;

  static void describe(auto& f) {
    using Row = GainCheck;
    f.name("camera", "camera of the twin", &Row::camera).shown({"camera"});
    f.name("part", "which gray values", &Row::part).shown({"gray values"});
    f.add("gain_dn", "gain of these gray values alone", &Row::gain_dn)
        .shown({"gain", "DN per unit E", Column::with_sigma});
    f.sigma("gain_sigma_dn", "standard error of that gain", &Row::gain_sigma_dn);
    f.add("gain_z", "its distance from the gain of all over the standard error", &Row::gain_z)
        .shown({"z", "", Column::signed_fixed, 1});
    f.add("black_level_dn", "black level of these gray values alone", &Row::black_level_dn)
        .shown({"black level", "DN", Column::with_sigma});
    f.sigma("black_level_sigma_dn", "standard error of that black level", &Row::black_level_sigma_dn);
    f.add("black_level_z", "its distance from the black level of all over the standard error",
          &Row::black_level_z)
        .shown({"z", "", Column::signed_fixed, 1});
    f.positive("sigma_inflation", "standard error of the gain over that of the predicted noise alone",
               &Row::sigma_inflation)
        .error();
    f.add("n", "gray values used", &Row::n).shown({"n"});
  }
};

/// The gray-value differences of one camera in one image after the gain fit.
struct GrayRow {
  std::string camera;
  std::string pattern;  ///< PatternSpec::label
  double mean_dn = 0, rms_dn = 0, p99_dn = 0;
  std::uint64_t n = 0;

  static void describe(auto& f) {
    f.name("camera", "camera of the twin", &GrayRow::camera).shown({"camera"});
    f.name("pattern", "image of the sequence", &GrayRow::pattern).shown({"image"});
    f.add("mean_dn", "mean difference after the gain fit", &GrayRow::mean_dn)
        .shown({"mean", "DN", Column::signed_fixed, 3});
    f.positive("rms_dn", "rms of the difference after the gain fit", &GrayRow::rms_dn)
        .shown({"rms", "DN", Column::fixed, 3});
    f.positive("p99_dn", "99th percentile of the difference's size", &GrayRow::p99_dn)
        .shown({"P99 of |d|", "DN", Column::fixed, 2});
    f.add("n", "gray values used", &GrayRow::n).shown({"n"});
  }
};

/// Where the residual variance after the gain fit comes from. All in DN²; the parts add up to total.
struct GrayBudget {
  std::string camera;
  std::string noise_source;
  double total_dn2 = 0, noise_dn2 = 0, albedo_dn2 = 0, harmonics_dn2 = 0, geometry_dn2 = 0, rest_dn2 = 0;
  double shading_dn2 = 0, contrast_dn2 = 0, higher_orders_dn2 = 0;
  double noise_offset_dn2 = 0, noise_per_dn = 0;
  double albedo_sigma = 0;
  std::vector<double> harmonic_amplitude;  ///< of order 0...6
  std::string waveform;                    ///< sentence on a harmonic that the twin lacks; empty without
  std::uint64_t n_pixels = 0, n = 0;

  static void describe(auto& f) {
    using Row = GrayBudget;
    f.name("camera", "camera of the twin", &Row::camera);
    f.add("noise_source", "the estimate that the noise is taken from", &Row::noise_source);
    f.positive("total_dn2", "mean square of the residual after the gain fit", &Row::total_dn2);
    f.positive("noise_dn2", "part that is predicted as noise", &Row::noise_dn2);
    f.add("albedo_dn2", "part that one factor per pixel removes", &Row::albedo_dn2);
    f.add("harmonics_dn2", "part that one periodic function of the phase removes", &Row::harmonics_dn2);
    f.add("geometry_dn2", "part that one shift of the projector coordinate per pixel removes",
          &Row::geometry_dn2);
    f.add("rest_dn2", "part that none of the others explains", &Row::rest_dn2);
    f.positive("shading_dn2",
               "of that part: what the noise of a measured shape's normals predicts, no reflectivity of the "
               "part; 0 without such a shape",
               &Row::shading_dn2)
        .not_required();
    f.add("contrast_dn2", "of the harmonics: orders 0 and 1, contrast and offset of the fringe",
          &Row::contrast_dn2)
        .not_required();
    f.add("higher_orders_dn2", "of the harmonics: orders 2 to 6", &Row::higher_orders_dn2).not_required();
    f.add("noise_offset_dn2", "noise variance at gray value 0, of a straight line", &Row::noise_offset_dn2)
        .not_required();
    f.add("noise_per_dn", "slope of that line: noise variance per gray value", &Row::noise_per_dn)
        .not_required();
    f.positive("albedo_spread", "robust relative scatter of the factors per pixel", &Row::albedo_sigma)
        .not_required();
    f.add("harmonic_amplitude", "amplitudes of orders 0 to 6, relative to the gray level above black",
          &Row::harmonic_amplitude)
        .not_required();
    f.add("waveform", "the harmonic that the real fringes have beyond the twin's", &Row::waveform)
        .or_absent();
    f.add("n_pixels", "pixels used", &Row::n_pixels).not_required();
    f.add("n", "gray values used", &Row::n);
  }
};

struct GrayTables {
  std::vector<GainRow> gain;
  std::vector<GainCheck> gain_checks;
  std::vector<GrayRow> gray;
  std::vector<GrayBudget> gray_budget;

  static void describe(auto& t) {
    t.rows("gain", &GrayTables::gain).in_measurements();
    t.rows("gain_checks", &GrayTables::gain_checks);
    t.rows("gray", &GrayTables::gray)
        .in_measurements()
        .shown("Gray differences per image", "(gain · E + black level) − real gray value, per image.");
    t.rows("gray_budget", &GrayTables::gray_budget);
  }
};

}  // namespace fringetwin::compare
