// SPDX-License-Identifier: Apache-2.0
#include "study/volume_map/volume_map.hpp"

#include <fmt/format.h>

#include <cmath>

#include "twin/base/errors.hpp"

namespace fringetwin::study {
namespace {

using Eigen::Vector3d;

/// Holds what one trial measured of the sphere at one position.
struct Seen {
  Vector3d center_mm = Vector3d::Constant(kNan);
  double radius_mm = kNan, form_mm = kNan, form_95_mm = kNan;
  bool failed = true;
  std::string reason;
};

/// Sorts the outcomes by trial and position: out[trial][position].
std::vector<std::vector<Seen>> by_trial(const VolumeMapPlan& plan, std::size_t positions,
                                        const std::vector<PointOutcome>& outcomes) {
  std::vector<std::vector<Seen>> out(plan.trials, std::vector<Seen>(positions));
  for (const PointOutcome& o : outcomes) {
    const auto id = static_cast<std::size_t>(o.id);
    FT_CHECK(o.id >= 0 && id / positions < plan.trials, "a point of the map");
    Seen& seen = out[id / positions][id % positions];
    seen.failed = o.failed;
    seen.reason = o.reason;
    if (o.failed) continue;
    seen.center_mm = {o.number("x_mm"), o.number("y_mm"), o.number("z_mm")};
    seen.radius_mm = o.number("radius_mm");
    seen.form_mm = o.number("form_mm");
    seen.form_95_mm = o.number("form_95_mm");
  }
  return out;
}

MapNumber number_of(const std::vector<double>& values, double coverage) {
  const SampleSummary s = summarise(values, coverage);
  return {s.mean, s.sigma, s.symmetric, s.n};
}

/// Returns the statistics, over all trials, of the errors at one position.
MapPosition position(const VolumeMapPlan& plan, const Vector3d& center_mm,
                     const std::vector<const Seen*>& trials) {
  MapPosition out;
  out.center_mm = center_mm;
  std::map<std::string, std::vector<double>> values;
  for (const Seen* seen : trials) {
    out.failed += seen->failed ? 1 : 0;
    if (seen->failed && out.reason.empty()) out.reason = seen->reason;
    out.n += seen->center_mm.allFinite() ? 1 : 0;
    const Vector3d error = seen->center_mm - center_mm;
    values["x_mm"].push_back(error.x());
    values["y_mm"].push_back(error.y());
    values["z_mm"].push_back(error.z());
    values["size_mm"].push_back(2.0 * (seen->radius_mm - plan.radius_mm));
    values["form_mm"].push_back(seen->form_mm);
    values["form_95_mm"].push_back(seen->form_95_mm);
  }
  for (const auto& [name, sample] : values) out.numbers[name] = number_of(sample, plan.coverage);
  return out;
}

/// Returns the index i < n at which amount(i) is largest, NaN left out; nullopt when all are NaN.
template <class Amount>
std::optional<std::size_t> largest(std::size_t n, Amount amount) {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < n; ++i)
    if (const double v = amount(i); !std::isnan(v) && (!best || v > amount(*best))) best = i;
  return best;
}

/// Returns the indices i < n at which the mean, and the sigma, of number(i) are largest by amount; numbers
/// that some trial lacks do not count.
template <class Number>
std::optional<MapWorst> worst(std::size_t n, std::size_t trials, Number number) {
  const auto of_all = [&](std::size_t i, double MapNumber::*value) {
    const MapNumber& of = number(i);
    return of.n == trials ? std::abs(of.*value) : kNan;
  };
  const auto mean = largest(n, [&](std::size_t i) { return of_all(i, &MapNumber::mean); });
  const auto sigma = largest(n, [&](std::size_t i) { return of_all(i, &MapNumber::sigma); });
  if (!mean || !sigma) return std::nullopt;
  return MapWorst{*mean, *sigma};
}

}  // namespace

std::vector<Vector3d> VolumeMapPlan::positions() const {
  std::vector<Vector3d> out;
  const auto at = [&](int axis, int i) {
    const int n = counts[axis];
    return center_mm[axis] + (n == 1 ? 0.0 : size_mm[axis] * (static_cast<double>(i) / (n - 1) - 0.5));
  };
  for (int k = 0; k < counts[2]; ++k)
    for (int j = 0; j < counts[1]; ++j)
      for (int i = 0; i < counts[0]; ++i) out.emplace_back(at(0, i), at(1, j), at(2, k));
  return out;
}

PointSequence volume_map_points(const VolumeMapPlan& plan) {
  std::vector<Settings> nominal;
  std::vector<UncertainInputs> inputs;
  for (const Vector3d& p : plan.positions()) {
    nominal.push_back({{fmt::format("object.{}.center_mm", plan.object),
                        fmt::format("[{}, {}, {}]", p.x(), p.y(), p.z())}});
    inputs.push_back(about(plan.inputs, plan.twin, nominal.back()));
  }
  const std::size_t n = nominal.size() * plan.trials;
  return PointSequence(n, [all = plan.inputs, seed = plan.seed, nominal, inputs](std::size_t i) {
    const std::size_t trial = i / nominal.size(), p = i % nominal.size();
    InputDraw draw = draw_inputs(all, seed, DrawStream::trials, trial);
    draw.noise_seed = repeated_noise(all, seed, trial, static_cast<std::uint32_t>(p));
    return point_of(inputs[p], static_cast<std::int64_t>(i), draw, nominal[p]);
  });
}

std::vector<Record> volume_map_records(const std::string& object) {
  const std::string fit = "fits." + object + ".measured.", indicators = "indicators." + object + ".";
  return {{fit + "center_mm[0]", "x_mm"},          {fit + "center_mm[1]", "y_mm"},
          {fit + "center_mm[2]", "z_mm"},          {fit + "radius_mm", "radius_mm"},
          {indicators + "sphere_form", "form_mm"}, {indicators + "sphere_form_95", "form_95_mm"}};
}

VolumeMap volume_map(const VolumeMapPlan& plan, const std::vector<PointOutcome>& outcomes) {
  const std::vector<Vector3d> places = plan.positions();
  const auto seen = by_trial(plan, places.size(), outcomes);
  VolumeMap out;
  for (std::size_t p = 0; p < places.size(); ++p) {
    std::vector<const Seen*> trials;
    for (const auto& trial : seen) trials.push_back(&trial[p]);
    out.positions.push_back(position(plan, places[p], trials));
    out.measured += out.positions.back().n == plan.trials ? 1 : 0;
  }
  for (const auto& first : out.positions[0].numbers)
    if (const auto w = worst(places.size(), plan.trials, [&](std::size_t i) -> const MapNumber& {
          return out.positions[i].numbers.at(first.first);
        }))
      out.worst[first.first] = *w;

  std::vector<double> largest_mm(plan.trials, places.size() > 1 ? 0.0 : kNan);
  for (std::size_t a = 0; a < places.size(); ++a)
    for (std::size_t b = a + 1; b < places.size(); ++b) {
      MapSpacing spacing{a, b, (places[b] - places[a]).norm(), {}};
      std::vector<double> errors;
      for (std::size_t t = 0; t < plan.trials; ++t) {
        errors.push_back((seen[t][b].center_mm - seen[t][a].center_mm).norm() - spacing.length_mm);
        const double amount = std::abs(errors.back());
        if (std::isnan(amount) || amount > largest_mm[t]) largest_mm[t] = amount;  // once NaN it stays
      }
      spacing.error_mm = number_of(errors, plan.coverage);
      out.spacings.push_back(spacing);
    }
  out.worst_spacing = worst(out.spacings.size(), plan.trials,
                            [&](std::size_t i) -> const MapNumber& { return out.spacings[i].error_mm; });
  out.largest_mm = number_of(largest_mm, plan.coverage);
  return out;
}

}  // namespace fringetwin::study
