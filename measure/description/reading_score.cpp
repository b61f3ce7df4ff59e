// SPDX-License-Identifier: Apache-2.0
#include "measure/description/reading_score.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "measure/decode/decode.hpp"
#include "measure/decode/decode_input.hpp"
#include "measure/decode/phase.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/statistics.hpp"
#include "twin/image/rows_of_images.hpp"

namespace fringetwin::measure {
namespace {

/// Residual of the steps over the amplitude from which a pixel contradicts the reading: a step in a wrong
/// place leaves about the amplitude itself, the harmonics of a projector without linear response a tenth to a
/// third of it.
constexpr float kLargestResidual = 0.4f;
constexpr std::size_t kFewestExpected = 200;  ///< pixels

std::vector<int> all_steps(const Fringes& fringes) {
  std::vector<int> steps(static_cast<std::size_t>(fringes.steps));
  std::iota(steps.begin(), steps.end(), 0);
  return steps;
}

/// Returns per pixel the largest residual of a pitch's steps over that pitch's amplitude; empty without N
/// > 3.
ImageF worst_residual(const CameraImages& images, const Fringes& fringes) {
  if (fringes.steps <= 3) return {};
  const int width = images.images.front().width, height = images.images.front().height;
  ImageF worst(width, height), phase(width, height), amplitude(width, height), residual(width, height);
  const std::vector<int> steps = all_steps(fringes);
  const StepSolver solver(steps, fringes.steps);
  std::vector<const float*> rows(steps.size());
  RowsOfImages of_images;
  for (std::size_t d = 0; d < fringes.directions.size(); ++d)
    for (const auto& pitch : collect_direction(images, fringes, static_cast<int>(d), steps).steps) {
      of_images.start();
      for (std::size_t n = 0; n < rows.size(); ++n) rows[n] = of_images.whole(*pitch[n]);
      PhaseRow out;
      out.phase_rad = phase.data.data(), out.amplitude = amplitude.data.data(),
      out.residual = residual.data.data();
      solve_row(solver, rows.data(), static_cast<int>(worst.size()), out);
      for (std::size_t i = 0; i < worst.size(); ++i)
        worst.data[i] = std::max(worst.data[i], residual.data[i] / std::max(amplitude.data[i], 1e-6f));
    }
  return worst;
}

double median_of(std::vector<double>& values) { return values.empty() ? kNaN : median(values); }

}  // namespace

ReadingScore score_reading(const CameraImages& images, const ImageU8& reached, const Reading& reading,
                           const DecodeOptions& options, const ExpectedCoordinates& expected) {
  ReadingScore score;
  CameraDecode decoded;
  const CameraImages read = read_as(images, reading);
  try {
    decoded = decode(read, reading.fringes, options);
  } catch (const UserError&) {
    return score;  // these fringes cannot be unwrapped over this projector
  }
  const ImageF residual = worst_residual(read, reading.fringes);
  std::vector<double> offsets, residuals;
  std::uint64_t valid = 0, good = 0, near = 0, jumps = 0;
  for (std::size_t i = 0; i < reached.size(); ++i) {
    if (reached.data[i] == 0) continue;
    ++score.n;
    const bool smooth = residual.empty() || residual.data[i] <= kLargestResidual;
    if (!residual.empty()) residuals.push_back(static_cast<double>(residual.data[i]));
    bool has_all = true, all_near = true;
    for (const DirectionDecode& d : decoded.directions) {
      const double at_px = d.unwrapped ? d.coordinate_px.data[i] : 0.0;
      has_all = has_all && std::isfinite(at_px) && (decoded.flags.data[i] & kLowModulation) == 0;
      const ImageD& where = expected.along(d.axis);
      if (!d.unwrapped || where.empty() || !std::isfinite(where.data[i]) || !std::isfinite(at_px)) continue;
      const double periods = (at_px - where.data[i]) / d.pitches_px[d.finest];
      offsets.push_back(periods);
      all_near = all_near && std::abs(periods) < 1.0;
      near += std::abs(periods) < 1.0 ? 1 : 0;
    }
    valid += has_all ? 1 : 0;
    good += has_all && all_near && smooth ? 1 : 0;
  }
  for (const DirectionDecode& d : decoded.directions) jumps += d.repair.n_left;
  if (score.n == 0) return score;
  const auto n = static_cast<double>(score.n);
  score.valid = static_cast<double>(valid) / n;
  score.jumps = static_cast<double>(jumps) / static_cast<double>(std::max<std::uint64_t>(valid, 1));
  score.residual = residuals.empty() ? 0.0 : median(residuals);
  score.good = static_cast<double>(good) / n * (1.0 - std::min(1.0, score.jumps));
  if (offsets.size() < kFewestExpected) {
    score.near = score.offset = score.scatter = kNaN;
    return score;
  }
  score.near = static_cast<double>(near) / static_cast<double>(offsets.size());
  score.offset = median_of(offsets);
  for (double& o : offsets) o = std::abs(o - score.offset);
  score.scatter = median_of(offsets);
  return score;
}

}  // namespace fringetwin::measure
