// SPDX-License-Identifier: Apache-2.0
#include "tradeoff/pareto.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "cosim/fit_error.hpp"
#include "cosim/load.hpp"
#include "render/sensor/all_cameras.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"
#include "twin/base/stopwatch.hpp"
#include "twin/number/pareto_front.hpp"

namespace fringetwin::tradeoff {
namespace {

std::vector<ParetoPoint> list_points(const Twin& twin, bool has_double, bool quick) {
  std::vector<ParetoPoint> points;
  for (const Scheme& scheme : scheme_table(twin, has_double, quick)) {
    ParetoPoint p;
    p.scheme = scheme;
    points.push_back(p);
  }
  return points;
}

bool same_family(const ParetoPoint& a, const ParetoPoint& b) {
  return a.is_precise() == b.is_precise() && a.scheme.family == b.scheme.family;
}

/// Returns the measured member of the point's family with the most samples (time grows in proportion); null
/// before there is one.
const ParetoPoint* largest_measured(const std::vector<ParetoPoint>& points, const ParetoPoint& point) {
  const ParetoPoint* best = nullptr;
  for (const ParetoPoint& p : points)
    if (same_family(p, point) && std::isfinite(p.frame_ms) && p.extrapolated_from == 0 &&
        (!best || p.scheme.sampling.samples > best->scheme.sampling.samples))
      best = &p;
  return best;
}

/// Returns the larger of both, the second where the first is unknown.
double largest(double a, double b) { return std::isnan(a) ? b : std::max(a, b); }

/// Measures the points of one scene, one after the other, against one reference.
class SchemeSurvey {
 public:
  SchemeSurvey(const Twin& twin, render::Renderer& renderer, const ParetoOptions& options,
               ParetoResult& result)
      : twin_(twin), renderer_(renderer), options_(options), result_(result) {
    if (can_crop(twin)) windows_ = window_twin(twin, result.subset);
    reference_ = reference_values(twin, result.subset, options.reference);
    result.reference_uncertainty_dn = reference_.edge_uncertainty_dn;
  }

  void measure_point(ParetoPoint& point) {
    const auto predicted = predict_time(result_.points, point);
    const double n_cameras = static_cast<double>(twin_.cameras.size());
    const double expected_s = predicted ? 1e-3 * predicted->frame_ms * n_cameras : 0.0;
    if (expected_s > options_.longest_point_s)
      measure_windows(point, expected_s);
    else
      measure_frames(point);
  }
  /// Marks the point of the rule that stood in for the default; measures it where it is none of the schemes,
  /// which takes a place that the points have in reserve.
  void measure_default(std::vector<ParetoPoint>& points, const render::Sampling& rule) {
    for (ParetoPoint& p : points) p.scheme.is_default = false;
    const auto at = std::ranges::find_if(points, [&rule](const ParetoPoint& p) {
      const render::Sampling& s = p.scheme.sampling;
      return s.sampler == rule.sampler && s.samples == rule.samples && s.precise == rule.precise;
    });
    if (at != points.end()) {
      at->scheme.is_default = true;
      return;
    }
    FT_CHECK(points.size() < points.capacity(), "a place for the default: results are known by their places");
    ParetoPoint& added = points.emplace_back();
    added.scheme = {.family = render::sampler_name(rule.sampler), .sampling = rule, .is_default = true};
    measure_point(added);
  }
  void retime(ParetoPoint& point) {
    if (std::isnan(point.frame_ms) || !is_cheap(point)) return;
    const Elapsed t = timed_render(point.scheme.sampling).time;
    const double n = static_cast<double>(twin_.cameras.size());
    const double was_s = 1e-3 * point.frame_ms * n;
    point.frame_ms = std::min(point.frame_ms, 1e3 * t.wall_s / n);
    point.frame_cpu_ms = std::min(point.frame_cpu_ms, 1e3 * t.cpu_s / n);
    point.chain_s += 1e-3 * point.frame_ms * n - was_s;
  }

  /// True where the adaptive trace does not apply to the scene.
  bool not_adaptive() const { return not_adaptive_; }
  /// Where it is the default and does not apply: the fixed rule that stood in for it.
  const std::optional<render::Sampling>& stands_in() const { return stands_in_; }

  /// Once all points are measured.
  void compare_fits(std::vector<ParetoPoint>& points) const {
    ParetoPoint* reference = nullptr;
    for (ParetoPoint& p : points)
      if (fits_.contains(&p) && (!reference || p.error.gray_rms_dn < reference->error.gray_rms_dn))
        reference = &p;
    if (!reference) return;
    reference->is_fit_reference = true;
    for (ParetoPoint& p : points) {
      const auto own = fits_.find(&p);
      if (own == fits_.end()) continue;
      const auto& exact = fits_.at(reference);
      for (std::size_t k = 0; k < exact.size(); ++k)
        p.fit_shift_mm = largest(p.fit_shift_mm, cosim::fit_distance_mm(own->second[k], exact[k]));
    }
  }

 private:
  bool is_cheap(const ParetoPoint& point) const {
    return 1e-3 * point.frame_ms * static_cast<double>(twin_.cameras.size()) < options_.retime_below_s;
  }

  /// All cameras, and the time it took to render them.
  struct TimedRender {
    std::vector<render::RenderedCamera> cameras;
    Elapsed time;
  };
  TimedRender timed_render(const render::Sampling& sampling) const {
    const Stopwatch watch;
    TimedRender out{.cameras = render::render_all(renderer_, twin_, sampling, options_.seed),
                    .time = watch.elapsed()};
    return out;
  }

  void measure_frames(ParetoPoint& point) {
    const Twin& twin = twin_;
    // the first of a family builds the pipeline
    if (!largest_measured(result_.points, point)) timed_render(point.scheme.sampling);
    const TimedRender rendered = timed_render(point.scheme.sampling);
    const auto other = std::ranges::find_if(rendered.cameras, [&](const render::RenderedCamera& c) {
      return c.sampling.sampler != point.scheme.sampling.sampler;
    });
    if (other != rendered.cameras.end()) {
      // of the default alone: another target or precision has another rule
      if (point.scheme.is_default) stands_in_ = other->sampling;
      not_adaptive_ = true;
      return;
    }
    const double n = static_cast<double>(twin.cameras.size());
    point.frame_ms = 1e3 * rendered.time.wall_s / n;
    point.frame_cpu_ms = 1e3 * rendered.time.cpu_s / n;
    for (const render::RenderedCamera& c : rendered.cameras) point.rays += c.rays;
    point.error = error_against(reference_, twin, result_.subset,
                                dn_from_images(twin, result_.subset, rendered.cameras));
    if (result_.has_fits) measure_chain(twin, rendered, point);
  }

  void measure_chain(const Twin& twin, const TimedRender& rendered, ParetoPoint& point) {
    const Stopwatch sensor_watch;
    const auto captures = render::expose_all(rendered.cameras, twin, options_.seed);
    const double sensor_s = sensor_watch.elapsed().wall_s;
    const Stopwatch watch;
    const auto fits = cosim::fits_in_order(twin, measure::measure(twin, captures));
    point.measure_s = watch.elapsed().wall_s;
    point.chain_s = rendered.time.wall_s + sensor_s + point.measure_s;
    for (const measure::ObjectFit& fit : fits) {
      point.fit_error_mm = largest(point.fit_error_mm, cosim::fit_error_mm(twin, fit));
      if (fit.usable) point.fit_rms_mm = largest(point.fit_rms_mm, fit.numbers.at("rms_mm"));
    }
    fits_[&point] = fits;
  }

  void measure_windows(ParetoPoint& point, double expected_s) {
    if (!windows_) {
      result_.warnings.push_back(fmt::format(
          "{}: left out, it would take about {:.0f} s (--longest), and a lens of this model has no window",
          point.name(), expected_s));
      return;
    }
    const auto rendered = render::render_all(renderer_, *windows_, point.scheme.sampling, options_.seed);
    point.error =
        error_against(reference_, twin_, result_.subset, dn_from_windows(twin_, result_.subset, rendered));
  }

  const Twin& twin_;
  render::Renderer& renderer_;
  const ParetoOptions& options_;
  ParetoResult& result_;
  std::optional<Twin> windows_;
  std::optional<render::Sampling> stands_in_;
  bool not_adaptive_ = false;
  ReferenceValues reference_;
  std::map<const ParetoPoint*, std::vector<measure::ObjectFit>> fits_;
};

}  // namespace

std::string ParetoPoint::name() const {
  return fmt::format("{} {}, {}", scheme.family, scheme.size(), precision());
}

std::optional<PredictedTime> predict_time(const std::vector<ParetoPoint>& points, const ParetoPoint& point) {
  const ParetoPoint* from = largest_measured(points, point);
  if (!from) return std::nullopt;
  const int samples = from->scheme.sampling.samples;
  const double ratio =
      point.scheme.is_adaptive() ? 1.0 : static_cast<double>(point.scheme.sampling.samples) / samples;
  return PredictedTime{ratio * from->frame_ms, ratio * from->frame_cpu_ms, samples};
}

void extrapolate_times(std::vector<ParetoPoint>& points) {
  for (ParetoPoint& point : points) {
    if (std::isfinite(point.frame_ms)) continue;
    const auto predicted = predict_time(points, point);
    if (!predicted) continue;
    point.frame_ms = predicted->frame_ms;
    point.frame_cpu_ms = predicted->frame_cpu_ms;
    point.extrapolated_from = predicted->from_samples;
  }
}

void mark_fronts(std::vector<ParetoPoint>& points) {
  const auto mark = [&points](auto cost, auto error, bool ParetoPoint::*flag) {
    std::vector<CostAndError> all;
    for (const ParetoPoint& p : points) all.push_back({p.*cost, error(p)});
    for (const std::size_t i : pareto_front(all)) points[i].*flag = true;
  };
  mark(
      &ParetoPoint::frame_ms, [](const ParetoPoint& p) { return p.error.phase_interior_rms_rad; },
      &ParetoPoint::on_phase_front);
  mark(
      &ParetoPoint::frame_ms, [](const ParetoPoint& p) { return p.error.gray_rms_dn; },
      &ParetoPoint::on_gray_front);
  mark(
      &ParetoPoint::chain_s, [](const ParetoPoint& p) { return p.is_fit_reference ? kNaN : p.fit_shift_mm; },
      &ParetoPoint::on_fit_front);
}

ParetoResult run_pareto(const Twin& twin, render::Renderer& renderer, const ParetoOptions& options) {
  cosim::check_renderable(twin);
  ParetoResult result;
  result.device = renderer.device();
  result.has_fits = cosim::can_fit(twin);
  if (!result.device.has_double)
    result.warnings.push_back(result.device.name + " has no double precision: fp32 only");
  if (!result.has_fits)
    result.warnings.push_back(
        "the chain ends before a fit (no [[measure.fit]], or this rig cannot triangulate): images only");
  const Stopwatch reference_watch;
  result.subset = choose_subset(twin, renderer, options.subset);
  say("pixels: " + result.subset.text());
  result.points = list_points(twin, result.device.has_double, options.quick);
  result.points.reserve(result.points.size() + 1);
  SchemeSurvey survey(twin, renderer, options, result);
  result.timing_s["reference"] = reference_watch.elapsed().wall_s;

  const Stopwatch watch;
  {
    Progress progress("schemes", result.points.size());
    for (ParetoPoint& p : result.points) {
      survey.measure_point(p);
      progress.advance();
    }
  }
  if (survey.not_adaptive())
    result.warnings.push_back(
        "the adaptive trace does not apply to this scene (docs/PHYSICS.md): a fixed rule stands in");
  if (survey.stands_in()) survey.measure_default(result.points, *survey.stands_in());
  Progress progress("timing in turns", static_cast<std::size_t>(options.rounds) * result.points.size());
  for (int round = 0; round < options.rounds; ++round)
    for (ParetoPoint& p : result.points) {
      survey.retime(p);
      progress.advance();
    }
  survey.compare_fits(result.points);
  extrapolate_times(result.points);
  std::erase_if(result.points, [](const ParetoPoint& p) { return std::isnan(p.frame_ms); });
  mark_fronts(result.points);
  result.timing_s["schemes"] = watch.elapsed().wall_s;
  return result;
}

std::string pareto_table(const ParetoResult& result) {
  const auto cell = [](double v, double scale = 1.0) {
    return std::isfinite(v) ? fmt::format("{:.2g}", scale * v) : std::string("-");
  };
  std::string out =
      fmt::format("{:<26}{:>11}{:>11}{:>11}{:>10}{:>10}{:>10}{:>10}{:>10}{:>9}\n", "scheme", "frame ms",
                  "phase rad", "phase rad", "gray DN", "gray DN", "gray DN", "fit um", "fit um", "chain s");
  out += fmt::format("{:<26}{:>11}{:>11}{:>11}{:>10}{:>10}{:>10}{:>10}{:>10}\n", "", "", "interior", "all",
                     "interior", "all", "edges", "error", "shift");
  for (const ParetoPoint& p : result.points) {
    std::string notes;
    if (p.scheme.is_default) notes += " DEFAULT";
    if (p.scheme.is_published) notes += " PUBLISHED";
    if (p.on_phase_front) notes += " phase-front";
    if (p.on_gray_front) notes += " gray-front";
    if (p.on_fit_front) notes += " fit-front";
    if (p.is_fit_reference) notes += " reference-of-fit-shifts";
    if (p.extrapolated_from > 0) notes += fmt::format(" (time from {} samples)", p.extrapolated_from);
    out += fmt::format("{:<26}{:>11.1f}{:>11.1e}{:>11.1e}{:>10}{:>10}{:>10}{:>10}{:>10}{:>9} {}\n", p.name(),
                       p.frame_ms, p.error.phase_interior_rms_rad, p.error.phase_rms_rad,
                       cell(p.error.gray_interior_rms_dn), cell(p.error.gray_rms_dn),
                       cell(p.error.gray_edge_rms_dn), cell(p.fit_error_mm, 1e3), cell(p.fit_shift_mm, 1e3),
                       cell(p.chain_s), notes);
  }
  return out;
}

}  // namespace fringetwin::tradeoff
