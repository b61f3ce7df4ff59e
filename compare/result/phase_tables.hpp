// SPDX-License-Identifier: Apache-2.0
// Holds the tables of a result that compare phase, differences at the finest pitch and their budget: their
// rows, and what each number of a row is. The formulas: docs/metrics/phase.md.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "compare/result/field_options.hpp"
#include "twin/base/constants.hpp"

namespace fringetwin::compare {

/// The phase differences of one camera and direction at the finest pitch.
struct PhaseRow {
  std::string camera = {}, direction = {};
  double mean_rad = 0, rms_rad = 0, p99_rad = 0, mean_relative = 0;
  std::uint64_t n = 0, n_order_disagree = 0;
  /// Of the pixels valid on both sides; NaN when there are none.
  double order_disagree_fraction() const {
    const auto all = static_cast<double>(n + n_order_disagree);
    return all > 0.0 ? static_cast<double>(n_order_disagree) / all : kNaN;
  }

  static void describe(auto& f) {
    using Row = PhaseRow;
    f.name("camera", "camera of the twin", &Row::camera).shown({"camera"});
    f.name("direction", "direction of the fringes", &Row::direction).one_of({"x", "y"}).shown({"direction"});
    f.add("mean_rad", "mean phase difference at the finest pitch", &Row::mean_rad)
        .shown({"mean", "rad", Column::signed_fixed, 5});
    f.positive("rms_rad", "rms of the phase difference at the finest pitch", &Row::rms_rad)
        .limited({"phase_rms_rad", "largest rms of the phase difference at the finest pitch, rad"})
        .shown({"rms", "rad", Column::fixed, 5});
    f.positive("p99_rad", "99th percentile of the phase difference's size", &Row::p99_rad)
        .shown({"P99 of |d|", "rad", Column::fixed, 5});
    f.positive("mean_relative", "mean size of the difference over the mean size of the real phase",
               &Row::mean_relative)
        .limited({"phase_mean_relative", "largest mean |phase difference| / mean |phase|"})
        .shown({"mean |ΔΦ| / mean |Φ|", "%", Column::significant, 3, 100.0});
    f.add("n", "pixels used", &Row::n).shown({"n"});
    f.add("n_order_disagree", "pixels left out because the fringe orders of the two sides differ",
          &Row::n_order_disagree)
        .not_required()
        .shown({"order disagrees", "pixels"});
    f.positive("order_disagree_fraction", "their share of the pixels valid on both sides",
               &Row::order_disagree_fraction)
        .not_required()
        .limited({"order_disagree_fraction",
                  "largest share of pixels whose fringe orders differ on the two sides"});
  }
};

/// Where the mean square of the phase difference comes from. All in rad²; the parts add up to total.
struct PhaseBudget {
  std::string camera, direction;
  int alias_order = 1;
  double total_rad2 = 0, offset_rad2 = 0, brightness_rad2 = 0, harmonic_rad2 = 0, noise_rad2 = 0,
         low_frequency_rad2 = 0, high_frequency_rad2 = 0;
  double harmonic_amplitude_rad = 0;
  double light_rad2 = kNaN;
  std::uint64_t n = 0;
  double explained() const {
    return (brightness_rad2 + harmonic_rad2 + noise_rad2) / (total_rad2 - offset_rad2);
  }

  static void describe(auto& f) {
    using Row = PhaseBudget;
    f.name("camera", "camera of the twin", &Row::camera);
    f.name("direction", "direction of the fringes", &Row::direction).one_of({"x", "y"});
    f.add("alias_order", "order of the ripple that projector harmonics leave in the steps used",
          &Row::alias_order);
    f.positive("total_rad2", "mean square of the phase difference", &Row::total_rad2);
    f.positive("offset_rad2", "square of the mean difference", &Row::offset_rad2);
    f.positive("brightness_rad2", "part of the ripple that brightness changes between the images leave",
               &Row::brightness_rad2)
        .not_required();
    f.positive("light_rad2",
               "what the factors of the real images' light, told by the steps, predict for brightness_rad2; "
               "known where its ripple fails",
               &Row::light_rad2)
        .not_required();
    f.positive("harmonic_rad2", "part of the ripple that projector harmonics leave", &Row::harmonic_rad2);
    f.positive("noise_rad2", "part that the phase sigmas of both sides predict", &Row::noise_rad2);
    f.add("low_frequency_rad2", "part of the means over blocks, less their noise", &Row::low_frequency_rad2);
    f.add("high_frequency_rad2", "part that none of the others explains", &Row::high_frequency_rad2);
    f.positive("harmonic_amplitude_rad", "amplitude of the ripple of the alias order at the finest pitch",
               &Row::harmonic_amplitude_rad)
        .not_required();
    f.add("explained_fraction",
          "share of the variance about the mean that brightness, harmonics and noise explain",
          &Row::explained)
        .not_required();
    f.add("n", "pixels used", &Row::n);
  }
};

struct PhaseTables {
  std::vector<PhaseRow> phase;
  std::vector<PhaseBudget> phase_budget;

  static void describe(auto& t) {
    t.rows("phase", &PhaseTables::phase).in_measurements();
    t.rows("phase_budget", &PhaseTables::phase_budget);
  }
};

}  // namespace fringetwin::compare
