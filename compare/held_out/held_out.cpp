// SPDX-License-Identifier: Apache-2.0
#include "compare/held_out/held_out.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "compare/causes/sensitivity.hpp"
#include "compare/gray/interior_mask.hpp"
#include "compare/gray/own_light.hpp"
#include "compare/parameters/closed_columns.hpp"
#include "compare/refine/asked_parameters.hpp"
#include "compare/refine/refine.hpp"
#include "compare/verdict/explained.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::compare {
namespace {

constexpr std::size_t kFewestSteps = 3;
constexpr int kComplementaryBit = -1;
constexpr double kAlike = 1e-6;          ///< of a determinant: light and exposure are one
constexpr std::size_t kPixels = 40'000;  ///< per camera, as of refine()

bool has(const std::vector<int>& list, int n) { return std::ranges::find(list, n) != list.end(); }

/// Returns where the images that a fold holds out, or those that it fits, stand among those of the samples.
std::vector<std::size_t> images_of(const GridSamples& s, const std::vector<PatternSpec>& patterns,
                                   const Fold& fold, bool held_out) {
  const bool are_steps = fold.held_out_images.empty();
  std::vector<std::size_t> at;
  for (std::size_t k = 0; k < s.images.size(); ++k) {
    const PatternSpec& pattern = patterns[static_cast<std::size_t>(s.images[k])];
    const bool is_step = !pattern.is_gray() && !pattern.is_image();
    if (are_steps ? is_step && has(held_out ? fold.held_out : fold.fitted, pattern.step)
                  : has(held_out ? fold.held_out_images : fold.fitted_images, s.images[k]))
      at.push_back(k);
  }
  return at;
}

/// What one pixel has of its own, from its fitted values.
struct PixelOwn {
  OwnLight light;
  OwnLightSums sums;
};

/// The factors that are taken from a held-out image itself.
struct ImageOwn {
  double light = 1.0, exposure = 1.0;
};

/// Predicts the gray values of one camera.
class Prediction {
 public:
  Prediction(const HeldOutInput& in, const Refined& refined, GridSamples samples, std::vector<float> e)
      : in_(in), twin_(refined.twin), s_(std::move(samples)), e_(std::move(e)) {
    const std::vector<PatternSpec> patterns = expand_sequence(twin_.fringes);
    kinds_ = refined.report.own;
    for (const Parameter& p : refinable_parameters(in.twin, in.asked)) {
      takes_light_ = takes_light_ || p.group == "light";
      takes_exposure_ = takes_exposure_ || (p.group == "exposure" && p.camera == s_.camera);
    }
    fitted_ = images_of(s_, patterns, in.fold, false);
    held_out_ = images_of(s_, patterns, in.fold, true);
    const auto values = static_cast<double>(std::max<std::uint64_t>(refined.report.n, 1));
    const double unknowns = static_cast<double>(refined.report.rows.size()) + 2.0;
    common_ = unknowns / values * std::max(1.0, refined.report.chi2_after);
    for (std::size_t p = 0; p < s_.n_pixels(); ++p) own_.push_back(own_of_pixel(p));
  }

  /// Adds what is predicted of the images that are held out.
  void add_to(HeldOut& out) const {
    const std::vector<PatternSpec> patterns = expand_sequence(twin_.fringes);
    for (const std::size_t k : held_out_) {
      ImageF sigmas;
      HeldOutRow row = row_of(k, sigmas);
      row.camera = twin_.cameras[s_.camera].name;
      row.pattern = patterns[static_cast<std::size_t>(s_.images[k])].label(twin_.fringes);
      if (row.n > 0)
        keep_worst(out.worst, {{row.camera, row.pattern, row.ratio, s_.grid.first_x, s_.grid.first_y,
                                s_.grid.stride * s_.grid.keep, std::move(sigmas)}});
      out.rows.push_back(std::move(row));
    }
  }

 private:
  std::size_t at(std::size_t pixel, std::size_t k) const { return pixel * s_.images.size() + k; }
  double light_dn(std::size_t pixel, std::size_t k) const {
    return s_.gain_dn * static_cast<double>(e_[at(pixel, k)]);
  }
  double variance_dn2(double gray_dn) const {
    return s_.noise_dn2(std::max(0.0, gray_dn)) + s_.rendering_dn * s_.rendering_dn;
  }

  /// Returns the exposure of an image in the refined twin.
  double exposure_of(std::size_t k) const {
    return factor_of(twin_.cameras[s_.camera].exposure_factors, static_cast<std::size_t>(s_.images[k]));
  }

  /// Returns the line of apply_texture(), from the fitted images alone.
  PixelOwn own_of_pixel(std::size_t pixel) const {
    PixelOwn own;
    for (const std::size_t k : fitted_) {
      if (s_.weight[at(pixel, k)] == 0.0F) continue;
      const auto y = static_cast<double>(s_.real_dn[at(pixel, k)]);
      const double exposure = exposure_of(k);
      own.sums.add(light_dn(pixel, k) / exposure, (y - s_.black_level_dn) / exposure,
                   variance_dn2(y) / (exposure * exposure));
    }
    own.light = own.sums.line(kinds_);
    return own;
  }

  double room_dn(std::size_t pixel, std::size_t k) const {
    return s_.gain_dn * unprojected_light(twin_, s_, pixel, s_.images[k]);
  }
  /// Returns the light of the twin in an image with these factors.
  double light_with(std::size_t pixel, std::size_t k, const ImageOwn& image) const {
    const double room = room_dn(pixel, k);
    return image.exposure * (room + image.light * (light_dn(pixel, k) - room));
  }
  /// Returns what is predicted of a value over black.
  double shown_dn(std::size_t pixel, std::size_t k, const ImageOwn& image) const {
    const OwnLight& own = own_[pixel].light;
    return own.factor * light_with(pixel, k, image) + image.exposure * exposure_of(k) * own.offset_dn;
  }

  /// Returns the factors, of those asked for, by which the prediction of an image comes closest to it: light
  /// is that of the projector alone, exposure that of all there is.
  ImageOwn own_of_image(std::size_t k) const {
    const bool light = takes_light_, exposure = takes_exposure_;
    if (!light && !exposure) return {};
    Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();  // of the factors of the room and of the projector
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    for (std::size_t p = 0; p < s_.n_pixels(); ++p) {
      if (s_.weight[at(p, k)] == 0.0F) continue;
      const OwnLight& own = own_[p].light;
      const double room = own.factor * room_dn(p, k) + exposure_of(k) * own.offset_dn,
                   w2 = 1.0 / variance_dn2(shown_dn(p, k, {}) + s_.black_level_dn);
      const Eigen::Vector2d parts(room, own.factor * (light_dn(p, k) - room_dn(p, k)));
      normal += w2 * parts * parts.transpose();
      right += w2 * parts * (static_cast<double>(s_.real_dn[at(p, k)]) - s_.black_level_dn);
    }
    if (!exposure) return {.light = normal(1, 1) > 0.0 ? (right[1] - normal(1, 0)) / normal(1, 1) : 1.0};
    const bool told_apart = normal.determinant() > kAlike * normal(0, 0) * normal(1, 1);
    if (light && told_apart) {
      const Eigen::Vector2d factors = normal.inverse() * right;
      if (factors[0] > 0.0) return {.light = factors[1] / factors[0], .exposure = factors[0]};
    }
    return {.exposure = normal.sum() > 0.0 ? right.sum() / normal.sum() : 1.0};
  }

  /// Returns the row of an image, and what is left of each of its values.
  HeldOutRow row_of(std::size_t k, ImageF& sigmas) const {
    const GridView& grid = s_.grid;
    sigmas = ImageF((grid.width - 1) / grid.keep + 1, (grid.height - 1) / grid.keep + 1,
                    std::numeric_limits<float>::quiet_NaN());
    HeldOutRow row;
    double sum = 0.0, sum2 = 0.0, noise2 = 0.0, fitted2 = 0.0;
    const ImageOwn image = own_of_image(k);
    if (takes_light_) row.light_factor = image.light;
    if (takes_exposure_) row.exposure_factor = image.exposure;
    const double exposure = image.exposure * exposure_of(k);
    const double of_shape =
        in_.shape_leverage / static_cast<double>(std::max<std::size_t>(in_.fold.fitted.size(), 1));
    for (std::size_t p = 0; p < s_.n_pixels(); ++p) {
      if (s_.weight[at(p, k)] == 0.0F) continue;
      const double predicted = shown_dn(p, k, image) + s_.black_level_dn,
                   d = predicted - static_cast<double>(s_.real_dn[at(p, k)]),
                   variance = variance_dn2(predicted),
                   of_fit = exposure * exposure *
                                own_[p].sums.variance_at(kinds_, light_with(p, k, image) / exposure) +
                            (common_ + of_shape) * variance;
      sum += d;
      sum2 += d * d;
      noise2 += variance;
      fitted2 += of_fit;
      ++row.n;
      const auto cell = static_cast<int>(s_.cell[p]);
      sigmas(cell % grid.width / grid.keep, cell / grid.width / grid.keep) =
          static_cast<float>(d / std::sqrt(variance + of_fit));
    }
    if (row.n == 0) return row;
    const auto n = static_cast<double>(row.n);
    row.mean_dn = sum / n;
    row.rms_dn = std::sqrt(sum2 / n);
    row.noise_dn = std::sqrt(noise2 / n);
    row.fitted_dn = std::sqrt(fitted2 / n);
    row.predicted_dn = std::hypot(row.noise_dn, row.fitted_dn);
    row.ratio = row.rms_dn / row.predicted_dn;
    row.ratio_sigma = 0.5 * std::hypot(std::sqrt(2.0 / n), s_.known_to);
    return row;
  }

  const HeldOutInput& in_;
  const Twin& twin_;
  GridSamples s_;
  std::vector<float> e_;
  std::vector<std::size_t> fitted_, held_out_;
  double common_ = 0.0;  ///< share of a value's variance that the parameters common to all pixels add
  OwnKinds kinds_;       ///< what is fitted of each pixel
  bool takes_light_ = false, takes_exposure_ = false;  ///< of a held-out image, from itself
  std::vector<PixelOwn> own_;
};

/// Returns samples of all phase steps of one camera, on the pixels and with the noise that the fitted steps
/// tell; none where there is no line to compare along.
std::vector<GridSamples> samples_of(const HeldOutInput& in, const Side& real, const Refinement& report,
                                    const CompareOptions& of_fitted, const CompareOptions& of_all) {
  std::vector<std::string> warnings;  // those of the comparison say the same
  const std::vector<GrayPair> fitted = pair_gray(in.twin, real, in.simulated, of_fitted, warnings),
                              all = pair_gray(in.twin, real, in.simulated, of_all, warnings);
  std::vector<GridSamples> out;
  for (std::size_t c = 0; c < fitted.size(); ++c) {
    if (c >= report.lines.size() || !report.lines[c]) continue;
    const measure::CameraDecode *real_decode = decode_of(real, c), *sim_decode = decode_of(in.simulated, c);
    const GrayNoise noise(fitted[c], real_decode, in.fold.fitted);
    const GainFit fit = fit_gain(fitted[c], warnings, &noise);
    GridSamples s = grid_samples(
        all[c], c, fit, noise, interior_mask(fitted[c].mask, real_decode, sim_decode),
        rendering_error(*all[c].camera, of_all.rendered, fit.row.gain_dn).with_edges_dn, kPixels);
    s.gain_dn = report.lines[c]->gain_dn;
    s.black_level_dn = report.lines[c]->black_level_dn;
    if (s.n_pixels() > 0) out.push_back(std::move(s));
  }
  return out;
}

/// Returns what of a request can be fitted to these steps: what is a single image's own that is held out
/// cannot.
std::vector<std::string> without_images(const Twin& twin, const std::vector<std::string>& asked,
                                        const std::vector<int>& steps) {
  std::vector<std::string> out;
  const std::vector<Parameter> told = refinable_parameters(twin, {}, steps),
                               all = refinable_parameters(twin, {});
  for (const std::string& name : asked) {
    const auto is = [&](const Parameter& p) { return is_asked_by(name, p); };
    if (!std::ranges::any_of(all, is) || std::ranges::any_of(told, is)) out.push_back(name);
  }
  return out;
}

}  // namespace

std::vector<Fold> folds_of(int steps, int n_folds) {
  if (n_folds < 2 || n_folds > steps)
    throw UserError(ExitCode::usage, fmt::format("--hold-out {}", n_folds),
                    fmt::format("deals {} phase steps to {} folds", steps, n_folds),
                    "use 2 folds or more, and no more than there are steps");
  std::vector<Fold> folds(static_cast<std::size_t>(n_folds));
  for (int n = 0; n < steps; ++n)
    for (int f = 0; f < n_folds; ++f) {
      Fold& fold = folds[static_cast<std::size_t>(f)];
      (n % n_folds == f ? fold.held_out : fold.fitted).push_back(n);
    }
  for (const Fold& fold : folds)
    if (fold.fitted.size() < kFewestSteps)
      throw UserError(ExitCode::usage, fmt::format("--hold-out {}", n_folds),
                      fmt::format("leaves {} of the {} phase steps to fit, and a phase needs {}",
                                  fold.fitted.size(), steps, kFewestSteps),
                      "use more folds, or record more phase steps");
  return folds;
}

std::vector<Fold> folds_of(const Fringes& fringes, int n_folds, HeldOutBy by) {
  if (fringes.steps > 0 && by == HeldOutBy::steps) return folds_of(fringes.steps, n_folds);
  if (fringes.steps == 0 && by == HeldOutBy::pitches)
    throw UserError(ExitCode::usage, "--hold-out-by pitches", "a code alone has no pitches to hold out",
                    "hold out its bits: --hold-out-by steps");
  const bool are_pitches = by == HeldOutBy::pitches;
  const std::vector<PatternSpec> patterns = expand_sequence(fringes);
  std::vector<std::pair<int, int>> kept_together;  // direction, and bit or pitch
  std::vector<std::ptrdiff_t> place_of;            // -1: always fitted
  for (const PatternSpec& pattern : patterns) {
    place_of.push_back(-1);
    if (pattern.is_image() || pattern.is_gray() == are_pitches) continue;
    const std::pair own{pattern.direction, are_pitches                  ? pattern.pitch
                                           : pattern.is_complementary() ? kComplementaryBit
                                                                        : pattern.bit};
    const auto at = std::ranges::find(kept_together, own);
    place_of.back() = at - kept_together.begin();
    if (at == kept_together.end()) kept_together.push_back(own);
  }
  if (n_folds < 2 || static_cast<std::size_t>(n_folds) > kept_together.size()) {
    const char* what = are_pitches ? "pitches" : "bits";
    throw UserError(ExitCode::usage, fmt::format("--hold-out {}", n_folds),
                    fmt::format("deals {} {}{} to {} folds", kept_together.size(), what,
                                are_pitches ? "" : " of a code", n_folds),
                    fmt::format("use 2 folds or more, and no more than there are {}", what));
  }
  std::vector<Fold> folds(static_cast<std::size_t>(n_folds));
  for (std::size_t f = 0; f < folds.size(); ++f) {
    for (int n = 0; n < fringes.steps; ++n) folds[f].fitted.push_back(n);
    for (std::size_t i = 0; i < patterns.size(); ++i) {
      const bool is_held_out = place_of[i] >= 0 && static_cast<std::size_t>(place_of[i]) % folds.size() == f;
      (is_held_out ? folds[f].held_out_images : folds[f].fitted_images).push_back(static_cast<int>(i));
    }
  }
  return folds;
}

HeldOut predict_held_out(const HeldOutInput& in) {
  Side real;
  real.images = in.real;
  real.measurement = measure::measure(in.twin, in.real, in.fold.fitted);
  CompareOptions of_fitted = in.options, of_all = in.options;
  of_fitted.use_steps = in.fold.fitted;
  of_fitted.leave_out_images = in.fold.held_out_images;
  of_all.use_steps.clear();
  const bool by_light = in.options.refinement && in.options.refinement->by_light;
  const Refined refined =
      refine(in.twin, real, in.simulated, of_fitted, without_images(in.twin, in.asked, in.fold.fitted),
             WhatIsWorse::stays, by_light ? Evidence::fringes_and_light : Evidence::fringes);
  std::vector<GridSamples> samples = samples_of(in, real, refined.report, of_fitted, of_all);
  find_room_light(*in.options.renderer, refined.twin, samples);
  Sensitivity sensitivity(*in.options.renderer, std::move(samples));
  sensitivity.choose_points(refined.twin);
  sensitivity.leave_out_edges(refined.twin);
  const Sensitivity::Values e = sensitivity.irradiance(refined.twin, sensitivity.residual_samples());
  HeldOut out;
  for (std::size_t c = 0; c < e.size(); ++c)
    Prediction(in, refined, sensitivity.samples()[c], e[c]).add_to(out);
  return out;
}

void keep_worst(std::vector<HeldOutMap>& of_cameras, std::vector<HeldOutMap> others) {
  for (HeldOutMap& other : others) {
    const auto known = std::ranges::find(of_cameras, other.camera, &HeldOutMap::camera);
    if (known == of_cameras.end())
      of_cameras.push_back(std::move(other));
    else if (other.ratio > known->ratio)
      *known = std::move(other);
  }
}

double held_out_ratio(const std::vector<HeldOutRow>& rows, const std::string& camera) {
  double left = 0.0, predicted = 0.0;
  for (const HeldOutRow& row : rows) {
    if (row.camera != camera || row.n == 0) continue;
    left += static_cast<double>(row.n) * row.rms_dn * row.rms_dn;
    predicted += static_cast<double>(row.n) * row.predicted_dn * row.predicted_dn;
  }
  return predicted > 0.0 ? std::sqrt(left / predicted) : kNaN;
}

std::vector<std::string> held_out_sentences(const std::vector<HeldOutRow>& rows) {
  std::vector<std::string> cameras, sentences;
  for (const HeldOutRow& row : rows)
    if (std::ranges::find(cameras, row.camera) == cameras.end()) cameras.push_back(row.camera);
  for (const std::string& camera : cameras) {
    double least = kNaN, most = kNaN;
    std::size_t n = 0;
    for (const HeldOutRow& row : rows) {
      if (row.camera != camera || row.n == 0) continue;
      least = std::fmin(least, row.ratio), most = std::fmax(most, row.ratio);
      ++n;
    }
    if (n > 0)
      sentences.push_back(
          fmt::format("{}: {} held-out images ({} folds) are predicted to {:.3f} times their predicted noise "
                      "({:.3f} to {:.3f} per image)",
                      camera, n, rows.front().folds, held_out_ratio(rows, camera), least, most));
  }
  return sentences;
}

}  // namespace fringetwin::compare
