// SPDX-License-Identifier: Apache-2.0
#include "compare/verdict/explained.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "compare/gray/own_light.hpp"
#include "compare/phase/phase_rows.hpp"
#include "compare/phase/texture_shift.hpp"
#include "twin/base/constants.hpp"

namespace fringetwin::compare {
namespace {

using measure::CameraDecode;
using measure::DirectionDecode;

constexpr int kRegion = 16;          ///< px: side of a region
constexpr int kFewestInRegion = 64;  ///< pixels
constexpr double kCoverage = 3.0;    ///< standard uncertainties
constexpr std::uint64_t kFewestJudged = 200;
constexpr double kNoisy = 2.0;       ///< times the rounding's variance: less noise than that is none
constexpr double kLeastShare = 0.5;  ///< of what could have been compared
/// Times the rounding's variance: noise that smooths the ripple that rounding alone leaves to 1e-4 of it.
constexpr double kSmoothRounding = 4.0;
/// Standard deviations of chi2 over its degrees of freedom: its tail is longer than a normal one (12: 3e-4).
constexpr double kRippleCoverage = 5.0;
/// Of the regional chi2 beyond noise: fringes that lie elsewhere from place to place, as those of an object
/// that was moved, look like ripples by as much (0.5 % for a ball moved by 0.1 mm).
constexpr double kRippleOfShifts = 0.01;
/// A sensor is refuted by a noise this much below 1 and below by `kCoverage` standard errors.
constexpr double kLeastExcess = 0.1;
constexpr const char* kOfPixels = "the pixels that a side sees with modulation";

/// A mean of a block: weighted sum of residuals, its variance if they are noise, and the sum of the weights'
/// sizes (an error that all share moves the sum by that). The calibration moves all values together, too, but
/// not alike (a shifted fringe changes sign): (sum w g)^2 <= sum w^2 sum g^2.
struct BlockSum {
  double sum = 0.0, variance = 0.0, weight = 0.0, weight2 = 0.0, calibration = 0.0;
  double together = 0.0;  ///< what a known effect adds to the sum
  double shape = 0.0;     ///< what the shape's noise would add to the sum if all shared one standard error
  double shape_share = 0.0;
  int pixels = 0;
  void add(double weight_of_one, double residual, double noise, double calibration_of_one) {
    sum += weight_of_one * residual;
    variance += weight_of_one * weight_of_one * noise;
    weight += std::abs(weight_of_one);
    weight2 += weight_of_one * weight_of_one;
    calibration += calibration_of_one;
  }
  void add_pixel(double variance_of_its_sum) { variance += variance_of_its_sum, ++pixels; }
  bool usable() const { return pixels >= kFewestInRegion && variance > 0.0; }
  double expected(double shared) const {
    return variance + weight * weight * shared + weight2 * calibration + together * together +
           shape_share * shape * shape;
  }
  double chi2(double shared) const { return sum * sum / expected(shared); }
  double calibration_share(double shared) const { return weight2 * calibration / expected(shared); }
};

/// Sums over all of an image, by blocks.
struct Sums {
  double r2 = 0.0, chi2 = 0.0, noise = 0.0, regional = 0.0;
  double noise_chi2 = 0.0;  ///< against noise and quantisation alone
  double texture = 0.0;     ///< of the phase: moved by texture within a pixel
  double shape = 0.0;       ///< variance that the noise of a measured shape makes
  double taken = 0.0;  ///< of the noise chi2 of gray values: what a fit of each pixel's own numbers takes
  double calibration = 0.0, share = 0.0, regional_share = 0.0;  ///< shares: of the expected chi2
  std::uint64_t n = 0, n_regions = 0;
  std::uint64_t n_inside = 0;  ///< values that interior pixels have, usable or not
  /// Adds `values` values by the sum of their squares and by what one of them has on average. `own`: its
  /// noise and what else is its own; `shared`: variance that neighbours share; `moved`: that of the
  /// calibration.
  void add(double squares, double noise_of_one, double own, double shared, double moved, int values = 1) {
    r2 += squares;
    noise += values * noise_of_one;
    chi2 += squares / (own + shared + moved);
    noise_chi2 += squares / noise_of_one;
    calibration += values * moved;
    share += values * moved / (own + shared + moved);
    n += static_cast<std::uint64_t>(values);
  }
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
    total.noise_chi2 += part.noise_chi2, total.texture += part.texture, total.taken += part.taken;
    total.shape += part.shape;
    total.n += part.n, total.n_regions += part.n_regions, total.n_inside += part.n_inside;
  }
  return total;
}

void add_region(const BlockSum& block, double shared, Sums& out) {
  if (!block.usable()) return;
  out.regional += block.chi2(shared);
  out.regional_share += block.calibration_share(shared);
  ++out.n_regions;
}

/// Writes what single values and regions show into the row. Returns false where the values are too few.
bool take_sums(const Sums& s, ExplainedRow& row) {
  const auto n = static_cast<double>(s.n);
  row.n = s.n;
  if (s.n < kFewestJudged) return row.regions = {}, false;
  row.n_regions = s.n_regions;
  row.observed = s.r2 / n;
  row.chi2 = s.chi2 / n;
  row.regional_chi2 = s.n_regions > 0 ? s.regional / static_cast<double>(s.n_regions) : kNaN;
  row.noise_chi2 = s.noise_chi2 / n;
  return true;
}

/// Judges a row whose sums are in it by its upper limits. The shares are those of the expected chi2 that the
/// calibration makes: its error is one draw for all of the image, not an average over many, so `kCoverage`
/// standard uncertainties of it must pass. `kept`: share of the noise that fits to these values have left in
/// them.
void judge(const Sums& s, double known_to, double kept, ExplainedRow& row) {
  constexpr double kMore = kCoverage * kCoverage - 1.0;
  const auto n = static_cast<double>(s.n);
  row.state = kExplained;
  row.chi2_limit = kept * (1.0 + allowed_for(n, known_to)) + kMore * s.share / n;
  if (!(row.chi2 <= row.chi2_limit)) row.worsen(kNotExplained);
  if (row.n_regions == 0) return;
  const auto n_regions = static_cast<double>(s.n_regions);
  row.regional_limit = 1.0 + allowed_for(n_regions, known_to) + kMore * (s.regional_share / n_regions);
  if (!(row.regional_chi2 <= row.regional_limit)) row.worsen(kNotExplained);
}

/// Calls the budget too wide where the values scatter less than its noise alone, calibration and rendering
/// left out, says. `kept`: share of the noise that fits to these values have left in them. Rounding is not
/// held against a budget: two sides without noise may well round alike.
void judge_least(const Sums& s, double noise, double rounding, double kept, double known_to,
                 ExplainedRow& row) {
  if (!(noise > kNoisy * rounding)) return;
  row.chi2_least = kept * (1.0 - allowed_for(static_cast<double>(s.n), known_to));
  if (row.noise_chi2 >= row.chi2_least) return;
  row.worsen(kTooWide, fmt::format("single values scatter by {:.2f} of what the noise in the budget says",
                                   std::sqrt(row.noise_chi2 / kept)));
}

/// Takes back "explained" where less than half was compared.
void judge_share(double fraction, const char* of, ExplainedRow& row) {
  row.compared_fraction = std::min(1.0, fraction);
  if (fraction >= kLeastShare) return;
  row.worsen(kNotCompared, fmt::format("only {:.3g} % of {} could be compared", 100.0 * fraction, of));
}

double share_of(std::uint64_t part, std::uint64_t whole) {
  return static_cast<double>(part) / static_cast<double>(whole);
}

/// Returns why a row has nothing to judge.
std::string too_few(std::uint64_t n, const SeenPixels& seen, std::uint64_t both) {
  std::string why =
      fmt::format("{} values inside surfaces that both sides decoded, {} are needed", n, kFewestJudged);
  if (seen.either > 0)
    why += fmt::format(" ({} of the {} pixels that a side sees with modulation agree in their fringe order)",
                       both, seen.either);
  return why;
}

class GrayExplanation {
 public:
  GrayExplanation(const GrayPair& pair, const GainFit& fit, const GrayNoise& noise, const ImageU8& interior,
                  const CameraDecode* simulated, const RenderingError& rendering, const ImageF* calibration,
                  const SeenPixels& seen, const OwnOfPixels& own, const ShapeInView& shape)
      : pair_(pair),
        fit_(fit),
        noise_(noise),
        interior_(interior),
        rendering_(rendering),
        calibration_(calibration),
        seen_(seen),
        own_(own),
        shape_(shape) {
    if (own.kinds.factor) shape_.noise = nullptr;  // a factor has what its pixel's normal is off by
    if (shape_.noise) {
      shading_share_ = region_shares(shape_.noise->surface.radius_px, kRegion).slope;
    }
    for (const PatternSpec& p : pair.patterns) steps_ = std::max(steps_, p.step + 1);
    for (const int image : pair.gain_images) {
      const PatternSpec& p = pair.patterns[image];
      const bool has_phase = simulated && p.kind == PatternSpec::Kind::phase_step;
      phases_.push_back(has_phase ? wrapped_phase(*simulated, p) : nullptr);
      const double step_rad = kTwoPi * p.step / steps_;
      turns_.push_back({std::cos(step_rad), std::sin(step_rad)});
    }
    if (rendering_.scatter_dn2.size() == 0) return;
    scatter_dn2_ = rendering_.scatter_dn2(pair.gain_images, pair.gain_images);
    scatter_of_one_dn2_ = scatter_dn2_.diagonal().mean();
  }

  ExplainedRow run() const {
    ExplainedRow row;
    const Sums s = sum_blocks(pair_.width(), pair_.height(), row.regions,
                              [this](int x0, int y0, int x1, int y1) { return block(x0, y0, x1, y1); });
    row.quantity = "gray";
    row.region = pair_.camera->name;
    row.unit = "DN";
    row.states_noise = noise_.stated();
    if (!take_sums(s, row)) {
      row.worsen(kNotCompared, too_few(s.n, seen_, seen_.both));
      return row;
    }
    const auto n = static_cast<double>(s.n);
    const double noise = s.noise / n, rounding = std::min(noise_.rounding_dn2(), noise);
    row.lines = {
        {"noise: " + noise_.source(), noise - rounding},
        {"quantisation", rounding},
        {rendering_.estimated ? "rendering, the renderer's own estimate" : "rendering (not estimated)",
         rendering_.gray_dn * rendering_.gray_dn + scatter_of_one_dn2_},
        {"fit of gain and black level", 2.0 * noise / n * std::pow(fit_.row.sigma_inflation, 2)}};
    if (shape_.noise) row.lines.push_back({kShapeLine, s.shape / n});
    if (calibration_) row.lines.push_back({kCalibrationLine, s.calibration / n});
    const double kept = 1.0 - s.taken / n;
    judge(s, noise_.known_to(), own_.from_here ? kept : 1.0, row);
    judge_least(s, noise, rounding, kept, noise_.known_to(), row);
    if (row.noise_chi2 < row.chi2_least) row.too_wide_factor = std::sqrt(kept / row.noise_chi2);
    const double usable = share_of(s.n, s.n_inside),
                 pixels = seen_.either > 0 ? share_of(seen_.both, seen_.either) : 1.0;
    if (pixels < usable)
      judge_share(pixels, kOfPixels, row);
    else
      judge_share(usable, "the gray values inside surfaces", row);
    return row;
  }

 private:
  Sums block(int x0, int y0, int x1, int y1) const {
    Sums out;
    BlockSum level, contrast, shift;
    for (BlockSum* b : {&level, &contrast, &shift}) b->shape_share = shading_share_;
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
    const double calibration =
        calibration_ ? std::pow(fit_.row.gain_dn, 2) * static_cast<double>(calibration_->data[i]) : 0.0;
    out.n_inside += pair_.gain_images.size();
    double squares = 0.0, noises = 0.0, taken = 0.0, shaded = 0.0;
    const OwnLightSums line = line_of(i);
    const double shading = shape_.noise ? shape_.noise->shading_at(shape_.camera, i) * fit_.row.gain_dn : 0.0;
    int values = 0;
    const auto n_images = scatter_dn2_.rows();
    Eigen::MatrixX3d weights = Eigen::MatrixX3d::Zero(n_images, 3);  // of the images in each sum
    const ImageF* of = nullptr;  // the phase that `at` is of: one sine for all steps of a pitch
    Turn at{0.0, 0.0};
    for (std::size_t k = 0; k < pair_.gain_images.size(); ++k) {
      const int image = pair_.gain_images[k];
      const double y = pair_.real_at(image, i);
      const double predicted = fit_.row.gain_dn * pair_.irradiance_at(image, i) + fit_.row.black_level_dn;
      if (!is_usable(u, y, pair_.source_at(image, i), predicted)) continue;
      const double r = y - predicted, noise = noise_.variance(predicted);
      squares += r * r, noises += noise, ++values;
      taken += noise * line.leverage_at(own_.kinds, pair_.irradiance_at(image, i));
      const double off = shading * (pair_.irradiance_at(image, i) - shape_.ambient);
      shaded += off * off;
      level.shape += off;
      level.add(1.0, r, noise, calibration);
      if (n_images > 0) weights(static_cast<Eigen::Index>(k), 0) = 1.0;
      if (!phases_[k] || std::isnan(phases_[k]->data[i])) continue;
      if (of != phases_[k]) {
        of = phases_[k];
        const auto phase = static_cast<double>(of->data[i]);
        at = {std::cos(phase), std::sin(phase)};
      }
      const Turn& step = turns_[k];
      const double cosine = at.c * step.c - at.s * step.s, sine = at.s * step.c + at.c * step.s;
      contrast.add(cosine, r, noise, calibration);
      shift.add(sine, r, noise, calibration);
      contrast.shape += cosine * off;
      shift.shape += sine * off;
      if (n_images > 0) weights.row(static_cast<Eigen::Index>(k)).tail<2>() << cosine, sine;
    }
    if (values == 0) return;
    out.add(squares, noises / values, noises / values + scatter_of_one_dn2_ + shaded / values, shared,
            calibration, values);
    out.shape += shaded;
    out.taken += taken * values / noises;
    const auto scatter_of = [&](int sum) { return weights.col(sum).dot(scatter_dn2_ * weights.col(sum)); };
    level.add_pixel(scatter_of(0)), contrast.add_pixel(scatter_of(1)), shift.add_pixel(scatter_of(2));
  }

  /// Returns the sums of the fit of what the pixel has of its own. What it has already shifts and scales its
  /// light, which changes no leverage.
  OwnLightSums line_of(std::size_t i) const {
    OwnLightSums line;
    if (own_.kinds.any())
      for (const int image : own_.images)
        if (const double y = pair_.real_at(image, i); y < pair_.real->saturation_dn())
          line.add(pair_.irradiance_at(image, i), y);
    return line;
  }

  const GrayPair& pair_;
  const GainFit& fit_;
  const GrayNoise& noise_;
  const ImageU8& interior_;
  RenderingError rendering_;
  const ImageF* calibration_;  ///< variance of the irradiance; may be null
  SeenPixels seen_;
  const OwnOfPixels& own_;
  ShapeInView shape_;
  double shading_share_ = 0.0;   ///< region_shares()
  Eigen::MatrixXd scatter_dn2_;  ///< of pair.gain_images; empty where nothing scatters
  double scatter_of_one_dn2_ = 0.0;
  int steps_ = 1;
  struct Turn {
    double c, s;
  };
  std::vector<Turn> turns_;            ///< of pair.gain_images: cos and sin of the step
  std::vector<const ImageF*> phases_;  ///< of pair.gain_images; null for codes
};

/// Returns how well the noise of this side's phases is known: relative, of its variance. `is_drawn`: the side
/// is simulated, and its noise was drawn from what the twin states.
double noise_known_to(const DirectionDecode& side, bool is_drawn) {
  if (side.noise_source == measure::NoiseSource::residuals)
    return std::hypot(kMeasuredKnownTo, side.noise_known_to);
  return is_drawn && side.noise_source == measure::NoiseSource::known ? 0.0 : kStatedKnownTo;
}

/// Returns whether a pixel has fringes to compare: neither saturated nor weak, and more than noise, which may
/// pass a low min_modulation_dn by chance. Coverage asks for less: a saturated pixel is seen, and should have
/// been measured. Doubts of the description ask the gray values, as no decode can be believed then.
bool has_fringes(const CameraDecode& decode, std::size_t i) {
  constexpr double kSigmas = 4.0;
  if ((decode.flags.data[i] & measure::kUnseen) != 0) return false;
  return std::ranges::all_of(decode.directions, [i](const DirectionDecode& d) {
    const auto pitch = std::min(static_cast<std::size_t>(d.finest), d.amplitude_dn.size() - 1);
    return d.amplitude_dn.empty() ||
           static_cast<double>(d.amplitude_dn[pitch].data[i]) >= kSigmas * d.noise_dn;
  });
}

}  // namespace

double allowed_for(double n, double known_to) { return kCoverage * std::sqrt(2.0 / n + known_to * known_to); }

RenderingError rendering_error(const Camera& camera, const std::vector<RenderNote>& notes, double gain_dn) {
  for (const RenderNote& note : notes)
    if (note.camera == camera.name) {
      const double of_full_scale = camera.sensor.max_dn() * gain_dn / camera.sensor.gain_dn;
      const double with_edges = note.gray_error.value_or(0.0);
      return {note.gray_inside_error.value_or(with_edges) * of_full_scale, note.phase_error_rad.value_or(0.0),
              note.gray_error.has_value(), with_edges * of_full_scale};
    }
  return {};
}

SeenPixels seen_pixels(const CameraDecode* real, const CameraDecode* simulated) {
  SeenPixels out;
  if (!real || !simulated) return out;
  for (std::size_t i = 0; i < real->flags.size(); ++i) {
    if (real->flags.data[i] == measure::kValid && simulated->flags.data[i] == measure::kValid) ++out.both;
    if (has_fringes(*real, i) || has_fringes(*simulated, i)) ++out.either;
  }
  return out;
}

ExplainedRow not_compared(const std::string& quantity, const std::string& region, const std::string& why) {
  ExplainedRow row;
  row.quantity = quantity;
  row.region = region;
  row.worsen(kNotCompared, why);
  return row;
}

ExplainedRow explain_gray(const GrayPair& pair, const GainFit& fit, const GrayNoise& noise,
                          const ImageU8& interior, const CameraDecode* simulated,
                          const RenderingError& rendering, const ImageF* calibration, const SeenPixels& seen,
                          const OwnOfPixels& own, const ShapeInView& shape) {
  return GrayExplanation(pair, fit, noise, interior, simulated, rendering, calibration, seen, own, shape)
      .run();
}

ExplainedRow explain_phase(const std::string& camera, const DirectionDecode& real,
                           const DirectionDecode& simulated, const ImageU8& interior,
                           const TextureShift& texture, const RenderingError& rendering,
                           const ImageF* calibration, const SeenPixels& seen, const ShapeInView& shape) {
  const double shape_share = shape.noise ? region_shares(shape.noise->surface.radius_px, kRegion).depth : 0.0;
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
        mean.shape_share = shape_share;
        for (int y = y0; y < y1; ++y)
          for (int x = x0; x < x1; ++x) {
            const auto d = static_cast<double>(difference(x, y));
            if (interior(x, y) == 0 || std::isnan(d)) continue;
            const std::size_t i = difference.index(x, y);
            const double noise = variance(real, i) + variance(simulated, i);
            if (!(noise > 0.0)) continue;
            const double moved = calibration ? static_cast<double>(calibration->data[i]) : 0.0;
            const double textured = std::pow(static_cast<double>(texture.largest_rad.data[i]), 2);
            const double of_shape = shape.noise ? shape.noise->leverage_at(shape.camera, i) *
                                                      shape.noise->of_phase * variance(real, i)
                                                : 0.0;
            const double own = noise + textured;
            out.texture += textured;
            out.shape += of_shape;
            mean.shape += std::sqrt(of_shape);
            out.add(d * d, noise, own + of_shape, shared, moved);
            mean.add(1.0, d, own, moved);
            mean.together += static_cast<double>(texture.signed_rad.data[i]);
            ++mean.pixels;
          }
        add_region(mean, shared, out);
        return out;
      });
  row.quantity = "phase";
  row.region = camera + " " + axis_name(real.axis);
  row.unit = "rad";
  row.states_noise = real.noise_source == measure::NoiseSource::known;
  std::uint64_t agree = 0;
  for (const float d : difference.data) agree += std::isnan(d) ? 0 : 1;
  if (!take_sums(s, row)) {
    row.worsen(kNotCompared, real.unwrapped && simulated.unwrapped
                                 ? too_few(s.n, seen, agree)
                                 : "the phases are not unwrapped, so they have no fringe order");
    return row;
  }
  for (std::size_t i = 0; i < difference.size(); ++i)
    if (interior.data[i] != 0 && !std::isnan(difference.data[i])) {
      real_noise += variance(real, i);
      simulated_noise += variance(simulated, i);
    }
  const auto n = static_cast<double>(s.n);
  row.lines = {
      {"noise and quantisation of the real images", real_noise / n},
      {"noise and quantisation of the simulated images", simulated_noise / n},
      {rendering.estimated ? "rendering, the renderer's own estimate" : "rendering (not estimated)", shared}};
  if (s.texture > 0.0) row.lines.push_back({"texture within a pixel", s.texture / n});
  if (shape.noise) row.lines.push_back({kShapeLine, s.shape / n});
  if (calibration) row.lines.push_back({kCalibrationLine, s.calibration / n});
  const double known_to = std::hypot(real_noise * noise_known_to(real, false),
                                     simulated_noise * noise_known_to(simulated, true)) /
                          (real_noise + simulated_noise);
  judge(s, known_to, 1.0, row);
  judge_least(s, std::min(real.noise_dn * real.noise_dn, simulated.noise_dn * simulated.noise_dn),
              kRoundingVariance, 1.0, known_to, row);
  // the simulated side has the noise that is stated: only the real one's can be too small
  if (row.noise_chi2 < row.chi2_least) {
    const double seen_noise = row.noise_chi2 * (real_noise + simulated_noise) - simulated_noise;
    if (seen_noise > kLeastExcess * real_noise) row.too_wide_factor = std::sqrt(real_noise / seen_noise);
  }
  if (seen.either > 0) judge_share(share_of(agree, seen.either), kOfPixels, row);
  return row;
}

void judge_ripple(const RippleTest& ripple, const RenderingError& rendering, const DirectionDecode& real,
                  const DirectionDecode& simulated, ExplainedRow& row) {
  if (!std::isfinite(row.chi2) || row.lines.back().name == kCalibrationLine) return;
  const double noise_dn = std::min(real.noise_dn, simulated.noise_dn);
  if (!(noise_dn * noise_dn > kSmoothRounding * kRoundingVariance)) return;
  const auto p = static_cast<double>(ripple.functions);
  row.brightness_chi2 = ripple.brightness_chi2;
  row.harmonic_chi2 = ripple.harmonic_chi2;
  const double beyond_noise = row.n_regions > 0 ? std::max(0.0, row.regional_chi2 - 1.0) : 0.0;
  row.ripple_limit = 1.0 + kRippleCoverage * std::sqrt(2.0 / p) +
                     rendering.phase_rad * rendering.phase_rad * ripple.information / p +
                     kRippleOfShifts * beyond_noise;
  if (row.brightness_chi2 > row.ripple_limit)
    row.worsen(kNotExplained,
               fmt::format("the phase ripples with the fringes ({:.3g} times what noise does): "
                           "the brightness varies from image to image",
                           row.brightness_chi2));
  if (row.harmonic_chi2 > row.ripple_limit)
    row.worsen(kNotExplained, fmt::format("the phase ripples {} times per fringe ({:.3g} times what noise "
                                          "does): the real fringes are not the waveform of the twin",
                                          ripple.order, row.harmonic_chi2));
}

void hold_against_noise(const std::vector<NoiseRow>& noise, std::vector<ExplainedRow>& rows) {
  for (ExplainedRow& row : rows) {
    if (!row.states_noise) continue;
    const NoiseRow* refuting = nullptr;
    for (const NoiseRow& n : noise) {
      if (row.region != n.camera && row.region != n.camera + " " + n.direction) continue;
      if (!(std::pow(n.gray_predicted_dn, 2) > kNoisy * kRoundingVariance)) continue;
      const double least = 1.0 - std::max(kCoverage * n.gray_ratio_sigma, kLeastExcess);
      if (n.sensor_known && n.gray_ratio < least && (!refuting || n.gray_ratio < refuting->gray_ratio))
        refuting = &n;
    }
    if (!refuting) continue;
    row.too_wide_factor = 1.0 / refuting->gray_ratio;
    row.worsen(
        kTooWide,
        fmt::format("the twin states {:.3g} times the noise that the images have ({:.3g} DN, not {:.3g})",
                    row.too_wide_factor, refuting->gray_measured_dn, refuting->gray_predicted_dn));
  }
}

}  // namespace fringetwin::compare
