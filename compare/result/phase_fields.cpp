// SPDX-License-Identifier: Apache-2.0
// The fields of the rows that speak of phase: differences at the finest pitch and their budget.
#include "compare/result/fields.hpp"
#include "compare/result/rows.hpp"

namespace fringetwin::compare {

namespace {
using Style = Column::Style;
}

std::vector<Field> describe(const PhaseRow*) {
  using Row = PhaseRow;
  Fields<Row> f;
  f.add("camera", "", "camera of the twin", &Row::camera).named().shown({"camera", ""});
  f.add("direction", "", "direction of the fringes", &Row::direction)
      .named()
      .one_of({"x", "y"})
      .shown({"direction", ""});
  f.add("mean_rad", "rad", "mean phase difference at the finest pitch", &Row::mean_rad)
      .shown({"mean", "rad", Style::signed_fixed, 5});
  f.add_positive("rms_rad", "rad", "rms of the phase difference at the finest pitch", &Row::rms_rad)
      .limited({"phase_rms_rad", "largest rms of the phase difference at the finest pitch, rad"})
      .shown({"rms", "rad", Style::fixed, 5});
  f.add_positive("p99_rad", "rad", "99th percentile of the phase difference's size", &Row::p99_rad)
      .shown({"P99 of |d|", "rad", Style::fixed, 5});
  f.add_positive("mean_relative", "", "mean size of the difference over the mean size of the real phase",
                 &Row::mean_relative)
      .limited({"phase_mean_relative", "largest mean |phase difference| / mean |phase|"})
      .shown({"mean |ΔΦ| / mean |Φ|", "%", Style::significant, 3, 100.0});
  f.add("n", "", "pixels used", &Row::n).shown({"n", ""});
  f.add("n_order_disagree", "", "pixels left out because the fringe orders of the two sides differ",
        &Row::n_order_disagree)
      .not_required()
      .shown({"order disagrees", "pixels"});
  f.add_positive("order_disagree_fraction", "", "their share of the pixels valid on both sides",
                 &Row::order_disagree_fraction)
      .not_required()
      .limited(
          {"order_disagree_fraction", "largest share of pixels whose fringe orders differ on the two sides"});
  return f.take();
}

std::vector<Field> describe(const PhaseBudget*) {
  using Row = PhaseBudget;
  Fields<Row> f;
  f.add("camera", "", "camera of the twin", &Row::camera).named();
  f.add("direction", "", "direction of the fringes", &Row::direction).named().one_of({"x", "y"});
  f.add("alias_order", "", "order of the ripple that projector harmonics leave in the steps used",
        &Row::alias_order);
  f.add_positive("total_rad2", "rad²", "mean square of the phase difference", &Row::total_rad2);
  f.add_positive("offset_rad2", "rad²", "square of the mean difference", &Row::offset_rad2);
  f.add_positive("brightness_rad2", "rad²",
                 "part of the ripple that brightness changes between the images leave", &Row::brightness_rad2)
      .not_required();
  f.add_positive("harmonic_rad2", "rad²", "part of the ripple that projector harmonics leave",
                 &Row::harmonic_rad2);
  f.add_positive("noise_rad2", "rad²", "part that the phase sigmas of both sides predict", &Row::noise_rad2);
  f.add("low_frequency_rad2", "rad²", "part of the means over blocks, less their noise",
        &Row::low_frequency_rad2);
  f.add("high_frequency_rad2", "rad²", "part that none of the others explains", &Row::high_frequency_rad2);
  f.add_positive("harmonic_amplitude_rad", "rad",
                 "amplitude of the ripple of the alias order at the finest pitch",
                 &Row::harmonic_amplitude_rad)
      .not_required();
  f.add("explained_fraction", "",
        "share of the variance about the mean that brightness, harmonics and noise explain", &Row::explained)
      .not_required();
  f.add("n", "", "pixels used", &Row::n);
  return f.take();
}

}  // namespace fringetwin::compare
