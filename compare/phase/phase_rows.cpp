// SPDX-License-Identifier: Apache-2.0
#include "compare/phase/phase_rows.hpp"

#include <cmath>
#include <numbers>

#include "compare/gray/gray_rows.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::compare {
namespace {

using measure::DirectionDecode;

double finest_pitch_px(const DirectionDecode& d) { return d.pitches_px.at(d.finest); }

/// Sums of one image row, added up in order: the same for any number of threads.
struct DifferenceSums {
  double difference = 0, difference2 = 0, magnitude = 0, absolute = 0;
  std::uint64_t disagree = 0;
  std::vector<float> values;
};

DifferenceSums sum_row(const DirectionDecode& real, const DirectionDecode& simulated, double origin_px,
                       int y) {
  const double per_px = kTwoPi / finest_pitch_px(real), farthest = farthest_rad(real);
  DifferenceSums s;
  for (int x = 0; x < real.coordinate_px.width; ++x) {
    const double r = real.coordinate_px(x, y);
    const double d = per_px * (simulated.coordinate_px(x, y) - r);
    if (std::isnan(d)) continue;
    if (std::abs(d) > farthest) {
      ++s.disagree;
      continue;
    }
    s.difference += d;
    s.difference2 += d * d;
    s.magnitude += std::abs(d);
    s.absolute += std::abs(per_px * (r - origin_px));
    s.values.push_back(static_cast<float>(d));
  }
  return s;
}

PhaseRow one_row(const DirectionDecode& real, const DirectionDecode& simulated, double origin_px) {
  const int height = real.coordinate_px.height;
  std::vector<DifferenceSums> rows(static_cast<std::size_t>(height));
#pragma omp parallel for schedule(static)
  for (int y = 0; y < height; ++y) rows[y] = sum_row(real, simulated, origin_px, y);
  DifferenceSums total;
  for (const DifferenceSums& row : rows) {
    total.difference += row.difference;
    total.difference2 += row.difference2;
    total.magnitude += row.magnitude;
    total.absolute += row.absolute;
    total.disagree += row.disagree;
    total.values.insert(total.values.end(), row.values.begin(), row.values.end());
  }
  PhaseRow out{.n = total.values.size(), .n_order_disagree = total.disagree};
  const double n = static_cast<double>(out.n);
  const bool any = out.n > 0;
  out.mean_rad = any ? total.difference / n : kNaN;
  out.rms_rad = any ? std::sqrt(total.difference2 / n) : kNaN;
  out.p99_rad = percentile_of_magnitude(total.values, out.rms_rad, 99.0);
  out.mean_relative = any && total.absolute > 0.0 ? total.magnitude / total.absolute : kNaN;
  return out;
}

bool has_coordinate(const DirectionDecode& d) { return !d.coordinate_px.empty() && !d.pitches_px.empty(); }

}  // namespace

double farthest_rad(const DirectionDecode& decode) {
  constexpr double kMostWords = 4.5;
  const bool code_only = decode.wrapped_rad.empty();
  return code_only ? kMostWords * kTwoPi : std::numbers::pi;
}

double phase_origin_px(const Twin& twin, const DirectionDecode& decode) {
  for (const DirectionFringes& d : twin.fringes.directions)
    if (d.axis == decode.axis) return d.phase_origin_px.at(d.finest());
  return 0.0;
}

std::vector<PhaseRow> phase_rows(const Twin& twin, const measure::Measurement& real,
                                 const measure::Measurement& simulated) {
  FT_CHECK(real.cameras.size() == simulated.cameras.size(), "both sides measure the same cameras");
  std::vector<PhaseRow> rows;
  for (std::size_t c = 0; c < real.cameras.size(); ++c)
    for (const DirectionDecode& r : real.cameras[c].directions) {
      const DirectionDecode* s = simulated.cameras[c].direction(r.axis);
      if (!s || !has_coordinate(r) || !has_coordinate(*s)) continue;
      FT_CHECK(r.coordinate_px.same_size(s->coordinate_px), "both sides have one image size");
      PhaseRow row = one_row(r, *s, phase_origin_px(twin, r));
      row.camera = real.cameras[c].camera;
      row.direction = std::string(axis_name(r.axis));
      rows.push_back(std::move(row));
    }
  return rows;
}

ImageF phase_difference(const DirectionDecode& real, const DirectionDecode& simulated) {
  const ImageD &r = real.coordinate_px, &s = simulated.coordinate_px;
  ImageF out(r.width, r.height);
  const double per_px = kTwoPi / finest_pitch_px(real), farthest = farthest_rad(real);
  for (std::size_t i = 0; i < r.size(); ++i) {
    const double d = per_px * (s.data[i] - r.data[i]);
    out.data[i] = std::abs(d) <= farthest ? static_cast<float>(d) : std::numeric_limits<float>::quiet_NaN();
  }
  return out;
}

ImageF absolute_phase(const Twin& twin, const DirectionDecode& decode) {
  ImageF out(decode.coordinate_px.width, decode.coordinate_px.height);
  const double per_px = kTwoPi / finest_pitch_px(decode), origin = phase_origin_px(twin, decode);
  for (std::size_t i = 0; i < out.size(); ++i)
    out.data[i] = static_cast<float>(per_px * (decode.coordinate_px.data[i] - origin));
  return out;
}

}  // namespace fringetwin::compare
