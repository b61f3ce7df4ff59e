// SPDX-License-Identifier: Apache-2.0
#include "compare/refine/refine.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "compare/gray/gray_pair.hpp"
#include "compare/gray/interior_mask.hpp"
#include "compare/parameters/closed_columns.hpp"
#include "compare/parameters/parameters.hpp"
#include "compare/refine/apply_texture.hpp"
#include "compare/refine/asked_parameters.hpp"
#include "compare/refine/refine_guard.hpp"
#include "compare/refine/refine_notes.hpp"
#include "compare/refine/refine_start.hpp"
#include "compare/refine/refined_budget.hpp"
#include "compare/refine/says_now_and_then.hpp"
#include "compare/refine/settled_harmonics.hpp"
#include "compare/verdict/explain_code.hpp"
#include "compare/verdict/explained.hpp"
#include "report/text.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::compare {
namespace {

constexpr std::size_t kPixels = 40'000;  ///< per camera

/// Returns whether this is a term of a field over the projector's image, which is fitted by its places.
bool is_of_field(const Parameter& p) { return p.group == "projector_field" || p.group == "harmonics_field"; }
/// Returns the order of a term of a field by its name: "projector.light_field.3_1",
/// "projector.harmonics_field.1_0.5.quadrature".
int order_of_term(const std::string& name) {
  const std::size_t between = name.rfind('_');
  return name[between - 1] - '0' + name[between + 1] - '0';
}

class Refiner {
 public:
  Refiner(const Twin& twin, const Side& real, const Side& simulated, const CompareOptions& options,
          const std::vector<std::string>& asked, Evidence evidence)
      : twin_(asks_for_halo(asked) ? with_empty_halo(twin) : twin),
        real_(real),
        simulated_(simulated),
        options_(options),
        sensitivity_(*options.renderer, collect(asked, false)),
        evidence_(evidence) {
    keeps_gain_ = is_asked(asked, "gain");
    keeps_black_ = is_asked(asked, "black");
    report_.asked = asked;
    for (Parameter& p : chosen_parameters(twin_, asked, options.use_steps)) {
      hold_gain_ = hold_gain_ || p.group == "albedo";
      (p.is_switch ? switches_ : parameters_).push_back(std::move(p));
    }
    report_.own = {.factor = is_asked(asked, "texture"), .offset = is_asked(asked, "offset")};
    hold_gain_ = hold_gain_ || report_.own.factor;
    sensitivity_.free_in_all(free_per_pixel(report_.own));
    for (std::size_t c = 0; c < sensitivity_.samples().size(); ++c) {
      const GridSamples& s = sensitivity_.samples()[c];
      const Sensor& sensor = twin.cameras[s.camera].sensor;
      sensitivity_.set_sensor(c, hold_gain_ ? sensor.gain_dn : s.gain_dn,
                              report_.own.offset ? sensor.black_level_dn : s.black_level_dn);
    }
    if (hold_gain_) sensitivity_.refer_curves_to_gain();  // curves are the camera's at its own gain
  }

  Refined run(WhatIsWorse worse) {
    const Twin as_written = twin_;
    const Eigen::VectorXd begin = values_to_begin_at();
    Twin scattering = twin_;
    for (const Parameter& p : switches_)
      if (p.start < 0.5) p.change(scattering, 1.0);
    sensitivity_.add_scatter_of(scattering);
    sensitivity_.choose_scale(twin_);
    const std::vector<double> scale = sensitivity_.scale();
    GroupFit start(sensitivity_, as_written, {}, {.hold_gain = hold_gain_});
    // fringes of the wrong phase make a line fitted to them flat or falling: the line from the amplitudes
    // stays
    if (!provisional_) start.settle_sensors();
    settle_switches(begin);
    GroupFitOptions how{.hold_gain = hold_gain_, .exact = true, .on_step = SaysNowAndThen{}};
    if (evidence_ == Evidence::fringes_and_light) how.free = FreePerPixel::nothing;
    report_.by_light = evidence_ == Evidence::fringes_and_light;
    GroupFit fit(sensitivity_, twin_, parameters_, how);
    fit.start_at(begin);
    hold_what_offsets_hold(fit);
    lower_the_field(fit);
    hold_what_changes_nothing(fit);
    refuse_what_cannot_be_told(fit);
    fit_what_is_told(fit);
    refuse_what_cannot_be_told(fit);
    settle_harmonics(fit);
    Refined out = finish(fit);
    if (worse == WhatIsWorse::stays) {
      out.report.n = parameters_.empty() ? fit.n_of_all() : fit.n();
      out.report.chi2_after = parameters_.empty() ? fit.chi2_of_all() : fit.chi2();
      return out;
    }
    out.one_error_away = places_one_error_away(fit, sensitivity_.samples(), out);
    std::vector<std::string> lights;
    for (const GridSamples& s : sensitivity_.samples()) note_light_of_code(s, twin_, lights);
    keep_what_is_better({start, scale}, {fit, sensitivity_.scale()}, as_written, out);
    if (!out.report.taken_back) std::ranges::move(lights, std::back_inserter(out.report.notes));
    return out;
  }

  /// How the twin of run() stands, taken back or not; nothing where what is worse `stays`.
  const Standing& reached() const { return reached_; }

 private:
  /// `of_harmonics`: as many pixels as settle_harmonics() looks at.
  std::vector<GridSamples> collect(const std::vector<std::string>& asked, bool of_harmonics) {
    std::vector<std::string> warnings;
    std::string reasons;
    std::vector<GridSamples> samples;
    const std::vector<GrayPair> pairs = pair_gray(twin_, real_, simulated_, options_, warnings);
    for (std::size_t c = 0; c < pairs.size(); ++c) {
      const measure::CameraDecode *real_decode = decode_of(real_, c), *sim_decode = decode_of(simulated_, c);
      const GrayNoise noise(pairs[c], real_decode, options_.use_steps);
      const GainFit fit = fit_gain(pairs[c], warnings, &noise);
      if (!fit.has_line() || pairs[c].real->radiance) {
        const std::string why = fit.has_line() ? "the real images are irradiance" : fit.row.why;
        reasons += fmt::format("{}{}: {}", reasons.empty() ? "" : "; ", pairs[c].camera->name, why);
        continue;
      }
      const std::vector<int> images =
          asks_for_halo(asked) ? pairs[c].gain_and_code_images() : pairs[c].gain_images;
      GridSamples grid = grid_samples(
          pairs[c], c, fit, noise, interior_mask(pairs[c].mask, real_decode, sim_decode),
          rendering_error(*pairs[c].camera, options_.rendered, fit.row.gain_dn).with_edges_dn,
          of_harmonics ? kMostSettledValues / std::max<std::size_t>(1, images.size()) : kPixels, images);
      if (grid.n_pixels() == 0) {
        reasons += fmt::format("{}{}: no pixel lies inside a surface that both sides share",
                               reasons.empty() ? "" : "; ", pairs[c].camera->name);
        continue;
      }
      provisional_ = provisional_ || !fit.row.usable;
      samples.push_back(std::move(grid));
    }
    if (samples.empty())
      throw UserError(
          ExitCode::input, "--refine",
          "no camera has gray values to refine by" + (reasons.empty() ? "" : " (" + reasons + ")"),
          "compare without --refine first and look at the report");
    if (!of_harmonics && std::ranges::any_of(chosen_parameters(twin_, asked), is_of_field))
      find_projector_places(*options_.renderer, twin_, samples);
    find_room_light(*options_.renderer, twin_, samples);
    return samples;
  }

  /// Returns the values of the twin, or of the places that the real points give, and leaves out what is
  /// sampled badly there.
  Eigen::VectorXd values_to_begin_at() {
    sensitivity_.choose_points(twin_);
    if (sensitivity_.holds_code(twin_))
      sensitivity_.settle_lights(sensitivity_.irradiance(twin_, sensitivity_.residual_samples()));
    sensitivity_.choose_scale(twin_);
    GroupFit start(sensitivity_, twin_, parameters_, {.hold_gain = hold_gain_});
    if (real_.measurement) start_at_fitted_places(start, twin_, real_.measurement->cloud);
    start_late_or_early(start);
    if (const Eigen::VectorXd lit = with_light_in_halo(parameters_, start.values()); lit != start.values())
      start.start_at(lit);
    if (const std::size_t n = sensitivity_.leave_out_edges(start.twin()))
      report_.notes.push_back(
          fmt::format("{} pixels on edges of facets and shadows, and beside them, are left out", n));
    return start.values();
  }

  /// Tries effects that are on or off both ways, with these values of the other parameters, and keeps what
  /// fits better.
  void settle_switches(const Eigen::VectorXd& values) {
    for (const Parameter& p : switches_) {
      Twin other = twin_;
      p.change(other, p.start > 0.5 ? -1.0 : 1.0);
      const auto chi2 = [&](const Twin& twin) {
        return GroupFit(sensitivity_, with_values(twin, parameters_, values), {}, {.hold_gain = hold_gain_})
            .chi2_of_all();
      };
      RefinedRow row{p.name, p.unit, p.start, p.start, 0.0};
      if (chi2(other) < chi2(twin_)) {
        twin_ = other;
        row.after = 1.0 - p.start;
      }
      report_.rows.push_back(row);
    }
  }

  /// Holds what changes nothing in these images: of a lens that nothing but columns is projected through, the
  /// row of its middle. Refuses a word of which nothing is left.
  void hold_what_changes_nothing(GroupFit& fit) {
    std::vector<std::size_t> idle;
    for (std::size_t k = 0; k < parameters_.size(); ++k)
      if (!parameters_[k].acts_beside_others && parameters_[k].expected == 0.0 &&
          std::ranges::find(held_, k) == held_.end() && fit.changes_nothing(k))
        idle.push_back(k);
    if (idle.empty()) return;
    for (const std::string& word : report_.asked) {
      const auto is_meant = [&](const Parameter& p) { return is_asked_by(word, p); };
      const auto n_idle =
          std::ranges::count_if(idle, [&](std::size_t k) { return is_meant(parameters_[k]); });
      if (n_idle > 0 && n_idle == std::ranges::count_if(parameters_, is_meant))
        throw UserError(ExitCode::usage, "--refine " + word, "changes nothing in these images",
                        "leave it out");
    }
    for (const std::size_t k : idle) {
      held_.push_back(k);
      report_.notes.push_back(parameters_[k].name +
                              " stays at the twin's value: it changes nothing in these images");
    }
    fit.hold(idle);
  }

  void refuse_what_cannot_be_told(GroupFit& fit) const {
    if (const std::string alike = fit.cannot_be_told(); !alike.empty())
      throw UserError(ExitCode::usage, "--refine", "the images cannot tell these apart: " + alike,
                      "refine fewer of them at a time");
  }

  /// Holds what an offset of each pixel does as well.
  void hold_what_offsets_hold(GroupFit& fit) {
    if (!report_.own.offset) return;
    const std::vector<std::size_t> same = alike_in_all_images(twin_, parameters_);
    for (const std::size_t k : same) {
      held_.push_back(k);
      report_.notes.push_back(
          parameters_[k].name +
          " stays at the twin's value: it is the same in all images of a pixel, as its offset");
    }
    if (!same.empty()) fit.hold(same);
  }

  /// Holds the highest orders of a field while the images cannot tell all apart: what is seen of the
  /// projector's image may be too little for them.
  void lower_the_field(GroupFit& fit) const {
    for (int order = 4; order > 1; --order) {
      std::vector<std::size_t> of_order;
      for (std::size_t k = 0; k < parameters_.size(); ++k)
        if (is_of_field(parameters_[k]) && order_of_term(parameters_[k].name) == order) of_order.push_back(k);
      if (of_order.empty()) continue;
      if (fit.cannot_be_told().empty()) return;
      fit.hold(of_order);
    }
  }

  /// Fits, and fits again without what these images hardly tell: a vignetting of 92 with a standard error of
  /// 166 is no finding. The highest order of a field goes first: beside it the lower ones and what it is a
  /// field of are hardly told, and may be told well without it.
  void fit_what_is_told(GroupFit& fit) {
    fit.run();
    if (const std::vector<std::size_t> on_time = exposures_on_time(fit); !on_time.empty()) {
      std::ranges::copy(on_time, std::back_inserter(held_));
      report_.notes.push_back(
          fmt::format("{} exposures are on time: what the fit gives for them is within three standard errors",
                      on_time.size()));
      hold(fit, on_time);
      fit.run();
    }
    for (int order = 2; order >= 0; --order) {
      std::vector<std::size_t> hardly;
      for (std::size_t k = 0; k < parameters_.size(); ++k) {
        const bool is_of_order =
            parameters_[k].group == "harmonics_field" && order_of_term(parameters_[k].name) == order;
        if (fit.known()[k].told && (order == 0 || is_of_order) && is_hardly_told(fit, k)) hardly.push_back(k);
      }
      if (hardly.empty()) continue;
      for (const std::size_t k : hardly) note_held(fit, k);
      hold(fit, hardly);
      fit.run();
    }
    for (std::size_t k = 0; k < parameters_.size(); ++k)
      if (!fit.known()[k].told && std::ranges::find(held_, k) == held_.end())
        report_.notes.push_back(parameters_[k].name +
                                " stays at the twin's value: these images do not tell it");
    report_.converged = fit.converged();
    report_.iterations = fit.steps();
    say(fmt::format("refine: {} steps, chi2 {:.5g}", report_.iterations, fit.chi2()));
    const std::string asked = fmt::format("--refine {}", fmt::join(report_.asked, ","));
    if (!report_.converged)
      report_.warnings.push_back(asked + " did not converge: its values are not to be trusted");
    if (!fit.unexplained().empty())
      report_.warnings.push_back(
          fmt::format("{}: what is left is not explained ({}): the values are not to be trusted", asked,
                      fit.unexplained()));
  }

  /// Settles the harmonics of all fringes at many more pixels than the fit looked at, where there are.
  void settle_harmonics(GroupFit& fit) {
    std::vector<bool> told;
    for (const GroupFit::Known& known : fit.known()) told.push_back(known.told);
    if (!can_settle_harmonics(twin_, parameters_, told)) return;
    std::vector<GridSamples> samples = collect(report_.asked, true);
    const auto n_pixels = [](const std::vector<GridSamples>& of) {
      std::size_t n = 0;
      for (const GridSamples& s : of) n += s.n_pixels();
      return n;
    };
    if (samples.size() != sensitivity_.samples().size() ||
        n_pixels(samples) < 2 * n_pixels(sensitivity_.samples()))
      return;
    Sensitivity all(*options_.renderer, std::move(samples));
    all.free_in_all(free_per_pixel(report_.own));
    all.take_sensors(sensitivity_.samples());
    if (hold_gain_) all.refer_curves_to_gain();
    fit.move_to(with_settled_harmonics(all, twin_, parameters_, told, fit.values(), hold_gain_));
  }

  /// Returns which exposures are late or early by what noise makes of those on time. Both ways they see less
  /// contrast: many of them would be taken for a gain and a black level.
  std::vector<std::size_t> exposures_on_time(const GroupFit& fit) const {
    constexpr double kSigmas = 3.0;
    std::vector<std::size_t> on_time;
    for (std::size_t k = 0; k < parameters_.size(); ++k)
      if (const Parameter& p = parameters_[k];
          p.group == "timing" && p.name.ends_with(".late") && p.start == 0.0 && fit.known()[k].told &&
          std::abs(fit.known()[k].value) < kSigmas * fit.known()[k].sigma)
        on_time.push_back(k);
    return on_time;
  }

  /// Returns whether a value is no better than its standard error, and that is no finding.
  bool is_hardly_told(const GroupFit& fit, std::size_t k) const {
    const Parameter& p = parameters_[k];
    const GroupFit::Known& known = fit.known()[k];
    const double sigma = p.shown_sigma(known.value, known.sigma), value = p.shown(known.value);
    // a place, and what an image has beside the others: nothing may be its finding
    const bool may_be_none = (is_geometric(p.group) && p.group != "lens") || p.group == "light" ||
                             p.group == "exposure" || p.group == "image_shift" || p.group == "timing" ||
                             p.group == "image_harmonics";
    return !may_be_none && sigma > std::max(std::abs(value), std::abs(value - p.shown(p.start)));
  }

  /// Holds these at the twin's values, with the bends of the cameras' curves where those left would make one
  /// that falls.
  void hold(GroupFit& fit, std::vector<std::size_t> which) const {
    try {
      fit.hold(which);
    } catch (const UserError&) {
      for (std::size_t k = 0; k < parameters_.size(); ++k)
        if (parameters_[k].group == "camera_response") which.push_back(k);
      fit.hold(which);
    }
  }

  void note_held(const GroupFit& fit, std::size_t k) {
    const Parameter& p = parameters_[k];
    const GroupFit::Known& known = fit.known()[k];
    held_.push_back(k);
    report_.notes.push_back(
        fmt::format("{} stays at the twin's value: the fit gives {}{}, no better than its standard error",
                    p.name, report::with_sigma(p.shown(known.value), p.shown_sigma(known.value, known.sigma)),
                    p.unit.empty() ? "" : " " + p.unit));
  }

  /// A fit, and the robust scale that it chose.
  struct Scaled {
    GroupFit& fit;
    std::vector<double> scale;
  };

  /// Takes the fit back where something got worse by it.
  void keep_what_is_better(Scaled start, Scaled fit, const Twin& as_written, Refined& out) {
    const bool moved_things =
        std::ranges::any_of(parameters_, [](const Parameter& p) { return is_geometric(p.group); });
    const auto standing = [&](const Scaled& scaled) {
      GroupFit& of = scaled.fit;
      // gain and black level may be the other twin's: Huber's weights are those of its own after some steps
      const auto settle_with = [&](const std::vector<double>& scale) {
        constexpr int kSteps = 4;
        sensitivity_.set_scale(scale);
        for (int step = 0; step < kSteps && !provisional_; ++step) of.settle_sensors();
      };
      settle_with(start.scale);
      // light with its own scale: the gain goes by what a wider one takes for noise, above all pixels on
      // edges
      settle_with(scaled.scale);
      Standing s{.light = of.light_in_regions()};
      settle_with(start.scale);  // or sums of squares would not compare
      s.chi2 = of.chi2_of_all();
      s.n = of.n_of_all();
      s.shift = of.shift_in_regions();
      s.fits_light = !moved_things;
      s.scatters = std::ranges::any_of(sensitivity_.samples(),
                                       [](const GridSamples& c) { return c.scatter_dn2.size() > 0; });
      if (moved_things) s.chi2_of_place = of.chi2_with(FreePerPixel::factor_and_offset);
      return s;
    };
    const Standing before = standing(start);
    reached_ = standing(fit);
    out.report.n = before.n;
    out.report.chi2_before = before.chi2;
    out.report.chi2_after = reached_.chi2;
    std::string worse = what_got_worse(before, reached_);
    if (worse.empty() && out.twin.projector && out.twin.projector->has_blur_field() &&
        !(out.twin.projector->least_blur_px() > 0.0))
      worse =
          "the blur's variance would be negative somewhere in the projector's image; where only a part of it "
          "is seen, refine blur with projector.blur_field_px2.u and projector.blur_field_px2.v alone";
    if (!worse.empty()) take_back(out, as_written, worse);
  }

  /// Reports values, standard errors, covariance and what is hardly told apart.
  Refined finish(GroupFit& fit) {
    fit.settle_sensors();
    const Eigen::VectorXd values = fit.shown_values();
    std::vector<std::size_t> told;
    for (std::size_t k = 0; k < parameters_.size(); ++k) {
      if (!fit.known()[k].told) continue;
      const Parameter& p = parameters_[k];
      told.push_back(k);
      report_.rows.push_back({p.name, p.unit, p.shown(p.start), p.shown(values[k]),
                              p.shown_sigma(values[k], fit.known()[k].sigma)});
    }
    note_correlations(fit, told, report_);
    Refined out{fit.twin(), {}};
    for (std::size_t c = 0; c < sensitivity_.samples().size(); ++c)
      keep_sensor(c, fit.sensor_sigma(c), out.twin);
    report_.lines.resize(twin_.cameras.size());
    for (const GridSamples& s : sensitivity_.samples())
      report_.lines[s.camera] = Refinement::Line{s.gain_dn, s.black_level_dn};
    if (report_.own.any()) note_texture(sensitivity_.samples(), report_, out.twin);
    out.report = std::move(report_);
    return out;
  }

  void keep_sensor(std::size_t index, const Eigen::Vector2d& sigma_dn, Twin& twin) {
    const GridSamples& s = sensitivity_.samples()[index];
    Sensor& sensor = twin.cameras[s.camera].sensor;
    const std::string& camera = twin.cameras[s.camera].name;
    if (keeps_gain_) {
      report_.rows.push_back({camera + ".gain_dn", "DN", sensor.gain_dn, s.gain_dn, sigma_dn[0]});
      sensor.gain_dn = s.gain_dn;
    }
    if (keeps_black_) {
      const double black = std::clamp(s.black_level_dn, 0.0, sensor.max_dn());
      report_.rows.push_back({camera + ".black_level_dn", "DN", sensor.black_level_dn, black, sigma_dn[1]});
      sensor.black_level_dn = black;
    }
  }

  Twin twin_;
  const Side &real_, &simulated_;
  const CompareOptions& options_;
  bool provisional_ = false;  ///< a camera's line comes from its amplitudes; collect() sets it
  Sensitivity sensitivity_;
  std::vector<Parameter> parameters_, switches_;
  std::vector<std::size_t> held_;  ///< parameters that stay at the twin's values, as a note says
  bool keeps_gain_ = false, keeps_black_ = false, hold_gain_ = false;
  Evidence evidence_;
  Standing reached_;
  Refinement report_;
};

}  // namespace

Refined refine(const Twin& twin, const Side& real, const Side& simulated, const CompareOptions& options,
               const std::vector<std::string>& asked, WhatIsWorse worse, Evidence evidence) {
  FT_CHECK(options.renderer != nullptr, "refinement renders");
  Standing by_fringes;
  Refined out = [&] {
    Refiner refiner(twin, real, simulated, options, asked, evidence);
    Refined refined = refiner.run(worse);
    by_fringes = refiner.reached();
    return refined;
  }();
  // A place that fringes tell poorly, as a projector's along its columns, may go where the light says no.
  if ((out.report.taken_back || leaves_light_alone(by_fringes)) && !out.report.own.any() &&
      evidence == Evidence::fringes && asks_for_places(twin, asked, options.use_steps)) {
    say("refine: once more, with the light as evidence of where things are");
    try {
      Refiner by_light(twin, real, simulated, options, asked, Evidence::fringes_and_light);
      Refined lit = by_light.run(worse);
      // what warns of itself is no better, unless the first one was not to be had
      const bool says_no_more = lit.report.warnings.size() <= out.report.warnings.size();
      if (!lit.report.taken_back &&
          (out.report.taken_back ||
           (says_no_more && is_better_lit(by_fringes, by_light.reached(), lit.report.rows.size())))) {
        lit.report.notes.push_back(
            "the light of the images is evidence of where things are: the fringes alone leave places at "
            "which more of it is left");
        out = std::move(lit);
      }
    } catch (const UserError&) {  // the light tells less: what the fringes told stays as it is
    }
  }
  if (asks_for_halo(asked) && twin.projector && twin.projector->halo.empty()) {
    drop_empty_halo(out.twin);
    for (Twin& changed : out.one_error_away) drop_empty_halo(changed);
  }
  return out;
}

}  // namespace fringetwin::compare
