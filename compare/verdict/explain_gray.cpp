// SPDX-License-Identifier: Apache-2.0
// Judges gray values.
#include <algorithm>
#include <cmath>

#include "compare/verdict/block_sums.hpp"
#include "twin/base/constants.hpp"

namespace fringetwin::compare {
namespace {

using measure::CameraDecode;
using measure::DirectionDecode;

class GrayExplanation {
 public:
  GrayExplanation(const GrayPair& pair, const GainFit& fit, const GrayNoise& noise, const ImageU8& interior,
                  const CameraDecode* simulated, const RenderingError& rendering, const RigVariance& rig,
                  const SeenPixels& seen, const OwnOfPixels& own, const ShapeInView& shape)
      : pair_(pair),
        fit_(fit),
        noise_(noise),
        interior_(interior),
        rendering_(rendering),
        rig_(rig),
        seen_(seen),
        own_(own),
        shape_(shape_in_budget(shape, own)) {
    for (const PatternSpec& p : pair.patterns) steps_ = std::max(steps_, p.step + 1);
    for (const int image : pair.gain_images) {
      const PatternSpec& p = pair.patterns[image];
      const bool has_phase = simulated && p.kind == PatternSpec::Kind::phase_step;
      phases_.push_back(has_phase ? wrapped_phase(*simulated, p) : nullptr);
      const double step_rad = kTwoPi * p.step / steps_;
      turns_.push_back({std::cos(step_rad), std::sin(step_rad)});
      moved_.push_back(moved_by_shape(p));
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
    row.lines = noise_lines(noise_, noise, rendering_, scatter_of_one_dn2_);
    row.lines.push_back(
        {"fit of gain and black level", 2.0 * noise / n * std::pow(fit_.row.sigma_inflation, 2)});
    if (shape_.noise) row.lines.push_back({kShapeLine, s.shape / n});
    if (s.smoothed > 0.0) row.lines.push_back({kSmoothedLine, s.smoothed / n});
    if (rig_.variance) row.lines.push_back({rig_.line, s.calibration / n});
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
        rig_.variance ? std::pow(fit_.row.gain_dn, 2) * static_cast<double>(rig_.variance->data[i]) : 0.0;
    out.n_inside += pair_.gain_images.size();
    double squares = 0.0, noises = 0.0, taken = 0.0, shaded = 0.0, smoothed = 0.0;
    const OwnLightSums line = own_light_sums(pair_, own_, noise_, i);
    const double shading = shape_.shading_at(i) * fit_.row.gain_dn;
    const SmoothedAt smoothed_shading = shape_.smoothed_shading_at(i);
    const RegionShares shares = shape_.noise ? shape_.shares_at(i) : RegionShares{};
    const double of_slopes = std::sqrt(shares.slope), of_depths = std::sqrt(shares.depth);
    int values = 0;
    const auto n_images = scatter_dn2_.rows();
    Eigen::MatrixX3d weights = Eigen::MatrixX3d::Zero(n_images, 3);  // of the images in each sum
    const ImageF* of = nullptr;  // the phase that `at` is of: one sine for all steps of a pitch
    Turn at{0.0, 0.0};
    MovedDn move;
    const CameraResponse& response = pair_.camera->sensor.response;  // which the values are straight without
    for (std::size_t k = 0; k < pair_.gain_images.size(); ++k) {
      const int image = pair_.gain_images[k];
      const double y = pair_.real_at(image, i);
      const double predicted = fit_.row.gain_dn * pair_.irradiance_at(image, i) + fit_.row.black_level_dn;
      if (!is_usable(u, y, pair_.source_at(image, i), predicted)) continue;
      const double r = y - predicted, noise = noise_.variance(predicted);
      squares += r * r, noises += noise, ++values;
      taken += noise * line.leverage_at(own_.kinds, pair_.irradiance_at(image, i));
      const double lit = pair_.irradiance_at(image, i) - shape_.ambient, off = shading * lit,
                   lit_dn = fit_.row.gain_dn * lit, smoothed_off = -smoothed_shading.value * lit_dn;
      shaded += off * off;
      smoothed += std::pow(smoothed_shading.size * lit_dn, 2);
      const OfShape by_light{.slopes = off * of_slopes, .smoothed_slopes = smoothed_off};
      level.add_shape(1.0, by_light);
      level.add(1.0, r, noise, calibration);
      if (n_images > 0) weights(static_cast<Eigen::Index>(k), 0) = 1.0;
      if (!phases_[k] || std::isnan(phases_[k]->data[i])) continue;
      if (of != phases_[k]) {
        of = phases_[k];
        const auto phase = static_cast<double>(of->data[i]);
        at = {std::cos(phase), std::sin(phase)};
        move = fringe_move_dn(moved_[k], i);
      }
      const Turn& step = turns_[k];
      const double cosine = at.c * step.c - at.s * step.s, sine = at.s * step.c + at.c * step.s;
      contrast.add(cosine, r, noise, calibration);
      shift.add(sine, r, noise, calibration);
      contrast.add_shape(cosine, by_light);
      shift.add_shape(sine, by_light);
      const double per_slope = sine / response.slope(predicted - fit_.row.black_level_dn),
                   moved = per_slope * move.by_noise, smoothed_moved = per_slope * move.smoothed;
      shaded += moved * moved;
      smoothed += std::pow(per_slope * move.by_smoothing, 2);
      const OfShape by_depths{.depths = moved * of_depths, .smoothed_depths = smoothed_moved};
      level.add_shape(1.0, by_depths);
      contrast.add_shape(cosine, by_depths);
      shift.add_shape(sine, by_depths);
      if (n_images > 0) weights.row(static_cast<Eigen::Index>(k)).tail<2>() << cosine, sine;
    }
    if (values == 0) return;
    out.add(squares, noises / values, noises / values + scatter_of_one_dn2_ + (shaded + smoothed) / values,
            shared, calibration, values);
    out.shape += shaded;
    out.smoothed += smoothed;
    out.taken += taken * values / noises;
    const auto scatter_of = [&](int sum) {
      return rendering_.scatters_alike * weights.col(sum).dot(scatter_dn2_ * weights.col(sum));
    };
    level.add_pixel(scatter_of(0)), contrast.add_pixel(scatter_of(1)), shift.add_pixel(scatter_of(2));
  }

  /// What the noise of a measured shape's depths moves in an image of fringes.
  struct MovedFringe {
    const ImageF* amplitude_dn = nullptr;  ///< of the real side; null: not known
    Axis axis = Axis::x;
    double rad_per_px = 0.0;
  };
  MovedFringe moved_by_shape(const PatternSpec& p) const {
    if (!shape_.noise || !shape_.real || p.kind != PatternSpec::Kind::phase_step) return {};
    const DirectionDecode& d = shape_.real->directions[static_cast<std::size_t>(p.direction)];
    const auto pitch = static_cast<std::size_t>(p.pitch);
    if (pitch >= d.amplitude_dn.size()) return {};
    return {&d.amplitude_dn[pitch], d.axis, kTwoPi / d.pitches_px[pitch]};
  }
  /// By how much what moves the place that lights a pixel changes its gray value, as it was taken, on the
  /// fringe's steepest slope; the sign is the same all over a direction.
  struct MovedDn {
    double by_noise = 0.0, by_smoothing = 0.0;  ///< their sizes
    double smoothed = 0.0;                      ///< what smoothing has, with its sign and noise
  };
  MovedDn fringe_move_dn(const MovedFringe& moved, std::size_t i) const {
    if (!moved.amplitude_dn) return {};
    const double dn_per_px = static_cast<double>(moved.amplitude_dn->data[i]) * moved.rad_per_px;
    if (!std::isfinite(dn_per_px)) return {};
    const SmoothedAt smoothed_px = shape_.smoothed_px_at(moved.axis, i);
    // of a fringe cos(phase): real - simulated of one that lies too far on is + sin(phase) times that
    return {dn_per_px * shape_.moved_px_at(moved.axis, i), dn_per_px * smoothed_px.size,
            dn_per_px * smoothed_px.value};
  }

  const GrayPair& pair_;
  const GainFit& fit_;
  const GrayNoise& noise_;
  const ImageU8& interior_;
  RenderingError rendering_;
  const RigVariance& rig_;
  SeenPixels seen_;
  const OwnOfPixels& own_;
  ShapeInView shape_;
  Eigen::MatrixXd scatter_dn2_;  ///< of pair.gain_images; empty where nothing scatters
  double scatter_of_one_dn2_ = 0.0;
  int steps_ = 1;
  struct Turn {
    double c, s;
  };
  std::vector<Turn> turns_;            ///< of pair.gain_images: cos and sin of the step
  std::vector<const ImageF*> phases_;  ///< of pair.gain_images; null for codes
  std::vector<MovedFringe> moved_;     ///< of pair.gain_images
};

}  // namespace

ExplainedRow explain_gray(const GrayPair& pair, const GainFit& fit, const GrayNoise& noise,
                          const ImageU8& interior, const CameraDecode* simulated,
                          const RenderingError& rendering, const RigVariance& rig, const SeenPixels& seen,
                          const OwnOfPixels& own, const ShapeInView& shape) {
  return GrayExplanation(pair, fit, noise, interior, simulated, rendering, rig, seen, own, shape).run();
}

}  // namespace fringetwin::compare
