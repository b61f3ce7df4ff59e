// SPDX-License-Identifier: Apache-2.0
#include "compare/verdict/explained.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "compare/phase/phase_rows.hpp"
#include "twin/base/constants.hpp"

namespace fringetwin::compare {
namespace {

using measure::CameraDecode;
using measure::DirectionDecode;

constexpr int kRegion = 16;             ///< px: side of a region
constexpr int kFewestInRegion = 64;     ///< pixels
constexpr double kNoiseKnownTo = 0.05;  ///< relative standard uncertainty of the stated noise variance
constexpr double kCoverage = 3.0;       ///< standard uncertainties
constexpr std::uint64_t kFewestJudged = 200;

double limit_for(double n) { return 1.0 + kCoverage * std::sqrt(2.0 / n + kNoiseKnownTo * kNoiseKnownTo); }

/// Sets the limits and the verdict of a row. The shares are those of the expected chi2 that the calibration
/// makes: its error is one draw for all of the image, not an average over many, so `kCoverage` standard
/// uncertainties of it must pass.
void judge(ExplainedRow& row, double calibration_share, double regional_share) {
  constexpr double kMore = kCoverage * kCoverage - 1.0;
  row.chi2_limit =
      limit_for(static_cast<double>(std::max<std::uint64_t>(row.n, 1))) + kMore * calibration_share;
  row.explained = row.chi2 <= row.chi2_limit;
  if (row.n_regions == 0) return;
  row.regional_limit = limit_for(static_cast<double>(row.n_regions)) + kMore * regional_share;
  row.explained = row.explained && row.regional_chi2 <= row.regional_limit;
}

/// A mean of a block: weighted sum of residuals, its variance if they are noise, and the sum of the weights'
/// sizes (an error that all share moves the sum by that). The calibration moves all values together, too, but
/// not alike (a shifted fringe changes sign): (sum w g)^2 <= sum w^2 sum g^2.
struct BlockSum {
  double sum = 0.0, variance = 0.0, weight = 0.0, weight2 = 0.0, calibration = 0.0;
  int pixels = 0;
  void add(double weight_of_one, double residual, double noise, double calibration_of_one) {
    sum += weight_of_one * residual;
    variance += weight_of_one * weight_of_one * noise;
    weight += std::abs(weight_of_one);
    weight2 += weight_of_one * weight_of_one;
    calibration += calibration_of_one;
  }
  bool usable() const { return pixels >= kFewestInRegion && variance > 0.0; }
  double expected(double shared) const { return variance + weight * weight * shared + weight2 * calibration; }
  double chi2(double shared) const { return sum * sum / expected(shared); }
  double calibration_share(double shared) const { return weight2 * calibration / expected(shared); }
};

/// Sums over all of an image, by blocks.
struct Sums {
  double r2 = 0.0, chi2 = 0.0, noise = 0.0, regional = 0.0;
  double calibration = 0.0, share = 0.0, regional_share = 0.0;  ///< shares: of the expected chi2
  std::uint64_t n = 0, n_regions = 0;
};

/// Calls `block(x0, y0, x1, y1)` -> Sums for every block, in parallel, added up in order.
template <class Block>
Sums sum_blocks(int width, int height, ImageF& regions, Block block) {
  const int across = (width + kRegion - 1) / kRegion, down = (height + kRegion - 1) / kRegion;
  std::vector<Sums> parts(static_cast<std::size_t>(across) * static_cast<std::size_t>(down));
#pragma omp parallel for schedule(dynamic)
  for (int b = 0; b < across * down; ++b) {
    const int x0 = b % across * kRegion, y0 = b / across * kRegion;
    parts[b] = block(x0, y0, std::min(x0 + kRegion, width), std::min(y0 + kRegion, height));
  }
  Sums total;
  regions = ImageF(across, down, std::numeric_limits<float>::quiet_NaN());
  for (std::size_t b = 0; b < parts.size(); ++b) {
    const Sums& part = parts[b];
    if (part.n_regions > 0)
      regions.data[b] = static_cast<float>(part.regional / static_cast<double>(part.n_regions));
    total.r2 += part.r2, total.chi2 += part.chi2, total.noise += part.noise, total.regional += part.regional;
    total.calibration += part.calibration, total.share += part.share;
    total.regional_share += part.regional_share;
    total.n += part.n, total.n_regions += part.n_regions;
  }
  return total;
}

void add_region(const BlockSum& block, double shared, Sums& out) {
  if (!block.usable()) return;
  out.regional += block.chi2(shared);
  out.regional_share += block.calibration_share(shared);
  ++out.n_regions;
}

/// Returns the mean share per region; 0 without regions.
double regional_share(const Sums& s) {
  return s.n_regions > 0 ? s.regional_share / static_cast<double>(s.n_regions) : 0.0;
}

/// Writes what single values and regions show into the row; `s.n` > 0.
void take_sums(const Sums& s, ExplainedRow& row) {
  const auto n = static_cast<double>(s.n);
  row.n = s.n;
  row.n_regions = s.n_regions;
  row.observed = s.r2 / n;
  row.chi2 = s.chi2 / n;
  row.regional_chi2 = s.n_regions > 0 ? s.regional / static_cast<double>(s.n_regions) : kNaN;
}

class GrayExplanation {
 public:
  GrayExplanation(const GrayPair& pair, const GainFit& fit, const GrayNoise& noise, const ImageU8& interior,
                  const CameraDecode* simulated, const RenderingError& rendering, const ImageF* calibration)
      : pair_(pair),
        fit_(fit),
        noise_(noise),
        interior_(interior),
        rendering_(rendering),
        calibration_(calibration) {
    for (const PatternSpec& p : pair.patterns) steps_ = std::max(steps_, p.step + 1);
    for (const int image : pair.gain_images) {
      const PatternSpec& p = pair.patterns[image];
      const ImageF* phase = nullptr;
      if (simulated && p.kind == PatternSpec::Kind::phase_step) {
        const DirectionDecode& d = simulated->directions.at(p.direction);
        if (static_cast<std::size_t>(p.pitch) < d.wrapped_rad.size()) phase = &d.wrapped_rad[p.pitch];
      }
      phases_.push_back(phase);
    }
    for (const int image : pair.gain_images) {
      const double step_rad = kTwoPi * pair.patterns[image].step / steps_;
      turns_.push_back({std::cos(step_rad), std::sin(step_rad)});
    }
  }

  std::optional<ExplainedRow> run() const {
    ExplainedRow row;
    const Sums s = sum_blocks(pair_.width(), pair_.height(), row.regions,
                              [this](int x0, int y0, int x1, int y1) { return block(x0, y0, x1, y1); });
    if (s.n < kFewestJudged) return std::nullopt;
    const auto n = static_cast<double>(s.n);
    row.quantity = "gray";
    row.region = pair_.camera->name;
    row.unit = "DN";
    take_sums(s, row);
    const double noise = s.noise / n, rounding = std::min(noise_.rounding_dn2(), noise);
    row.lines = {
        {"noise: " + noise_.source(), noise - rounding},
        {"quantisation", rounding},
        {rendering_.estimated ? "rendering, the renderer's own estimate" : "rendering (not estimated)",
         rendering_.gray_dn * rendering_.gray_dn},
        {"fit of gain and black level", 2.0 * noise / n * std::pow(fit_.row.sigma_inflation, 2)}};
    if (calibration_) row.lines.push_back({kCalibrationLine, s.calibration / n});
    judge(row, s.share / n, regional_share(s));
    return row;
  }

 private:
  Sums block(int x0, int y0, int x1, int y1) const {
    Sums out;
    BlockSum level, contrast, shift;
    const double shared = rendering_.gray_dn * rendering_.gray_dn;
    for (int y = y0; y < y1; y += row_step(pair_.width(), pair_.height()))
      for (int x = x0; x < x1; ++x)
        if (interior_(x, y) != 0) pixel(interior_.index(x, y), shared, out, level, contrast, shift);
    for (const BlockSum* b : {&level, &contrast, &shift}) add_region(*b, shared, out);
    return out;
  }

  void pixel(std::size_t i, double shared, Sums& out, BlockSum& level, BlockSum& contrast,
             BlockSum& shift) const {
    const UsableRange& u = fit_.usable;
    const double noise = noise_.variance(pair_.mean_real_dn(i));
    const double calibration =
        calibration_ ? std::pow(fit_.row.gain_dn, 2) * static_cast<double>(calibration_->data[i]) : 0.0;
    bool any = false;
    const ImageF* of = nullptr;  // the phase that `at` is of: one sine for all steps of a pitch
    Turn at{0.0, 0.0};
    for (std::size_t k = 0; k < pair_.gain_images.size(); ++k) {
      const int image = pair_.gain_images[k];
      const double y = pair_.real_at(image, i);
      const double predicted = fit_.row.gain_dn * pair_.irradiance_at(image, i) + fit_.row.black_level_dn;
      if (!is_usable(u, y, pair_.source_at(image, i), predicted)) continue;
      const double r = y - predicted;
      out.r2 += r * r;
      out.noise += noise;
      out.chi2 += r * r / (noise + shared + calibration);
      out.calibration += calibration;
      out.share += calibration / (noise + shared + calibration);
      ++out.n;
      any = true;
      level.add(1.0, r, noise, calibration);
      if (!phases_[k] || std::isnan(phases_[k]->data[i])) continue;
      if (of != phases_[k]) {
        of = phases_[k];
        const auto phase = static_cast<double>(of->data[i]);
        at = {std::cos(phase), std::sin(phase)};
      }
      const Turn& step = turns_[k];
      contrast.add(at.c * step.c - at.s * step.s, r, noise, calibration);
      shift.add(at.s * step.c + at.c * step.s, r, noise, calibration);
    }
    for (BlockSum* b : {&level, &contrast, &shift}) b->pixels += any ? 1 : 0;
  }

  const GrayPair& pair_;
  const GainFit& fit_;
  const GrayNoise& noise_;
  const ImageU8& interior_;
  RenderingError rendering_;
  const ImageF* calibration_;  ///< variance of the irradiance; may be null
  int steps_ = 1;
  struct Turn {
    double c, s;
  };
  std::vector<Turn> turns_;            ///< of pair.gain_images: cos and sin of the step
  std::vector<const ImageF*> phases_;  ///< of pair.gain_images; null for codes
};

}  // namespace

RenderingError rendering_error(const Camera& camera, const std::vector<RenderNote>& notes, double gain_dn) {
  for (const RenderNote& note : notes)
    if (note.camera == camera.name)
      return {note.gray_error.value_or(0.0) * camera.sensor.max_dn() * gain_dn / camera.sensor.gain_dn,
              note.phase_error_rad.value_or(0.0), note.gray_error.has_value()};
  return {};
}

std::optional<ExplainedRow> explain_gray(const GrayPair& pair, const GainFit& fit, const GrayNoise& noise,
                                         const ImageU8& interior, const CameraDecode* simulated,
                                         const RenderingError& rendering, const ImageF* calibration) {
  return GrayExplanation(pair, fit, noise, interior, simulated, rendering, calibration).run();
}

std::optional<ExplainedRow> explain_phase(const std::string& camera, const DirectionDecode& real,
                                          const DirectionDecode& simulated, const ImageU8& interior,
                                          const RenderingError& rendering, const ImageF* calibration) {
  const ImageF difference = phase_difference(real, simulated);
  const double per_px = kTwoPi / real.pitches_px[real.finest];
  const double shared = rendering.phase_rad * rendering.phase_rad;
  double real_noise = 0.0, simulated_noise = 0.0;
  const auto variance = [&](const DirectionDecode& d, std::size_t i) {
    const double s = per_px * static_cast<double>(d.coordinate_sigma_px.data[i]);
    return std::isfinite(s) ? s * s : 0.0;
  };
  ExplainedRow row;
  const Sums s =
      sum_blocks(difference.width, difference.height, row.regions, [&](int x0, int y0, int x1, int y1) {
        Sums out;
        BlockSum mean;
        for (int y = y0; y < y1; ++y)
          for (int x = x0; x < x1; ++x) {
            const auto d = static_cast<double>(difference(x, y));
            if (interior(x, y) == 0 || std::isnan(d)) continue;
            const std::size_t i = difference.index(x, y);
            const double noise = variance(real, i) + variance(simulated, i);
            if (!(noise > 0.0)) continue;
            out.r2 += d * d;
            out.noise += noise;
            const double moved = calibration ? static_cast<double>(calibration->data[i]) : 0.0;
            out.chi2 += d * d / (noise + shared + moved);
            out.calibration += moved;
            out.share += moved / (noise + shared + moved);
            ++out.n;
            mean.add(1.0, d, noise, moved);
            ++mean.pixels;
          }
        add_region(mean, shared, out);
        return out;
      });
  if (s.n < kFewestJudged) return std::nullopt;
  for (std::size_t i = 0; i < difference.size(); ++i)
    if (interior.data[i] != 0 && !std::isnan(difference.data[i])) {
      real_noise += variance(real, i);
      simulated_noise += variance(simulated, i);
    }
  const auto n = static_cast<double>(s.n);
  row.quantity = "phase";
  row.region = camera + " " + axis_name(real.axis);
  row.unit = "rad";
  take_sums(s, row);
  row.lines = {
      {"noise and quantisation of the real images", real_noise / n},
      {"noise and quantisation of the simulated images", simulated_noise / n},
      {rendering.estimated ? "rendering, the renderer's own estimate" : "rendering (not estimated)", shared}};
  if (calibration) row.lines.push_back({kCalibrationLine, s.calibration / n});
  judge(row, s.share / n, regional_share(s));
  return row;
}

}  // namespace fringetwin::compare
