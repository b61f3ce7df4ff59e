// SPDX-License-Identifier: Apache-2.0
#include "compare/causes/sensitivity.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>

#include "compare/causes/own_levels.hpp"
#include "compare/causes/parameter_effects.hpp"
#include "compare/causes/scaled_eigen.hpp"
#include "compare/gray/texture_steps.hpp"
#include "compare/parameters/parameters.hpp"
#include "compare/verdict/explained.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kSampledWell = 0.2;       ///< standard deviations
constexpr double kPointsMayDiffer = 0.05;  ///< standard deviations, rms
constexpr double kNoSpread = 1e-6;         ///< of a sum of squares: the values are all alike

/// What a pixel's real values are of those predicted, both without black level.
struct PixelLine {
  double factor = 1.0, offset_dn = 0.0;
};

/// Returns what `free` leaves open of the line through the used values of a pixel by least squares without
/// weights; its factor is at least 0, and 1 where the predicted values are all alike.
PixelLine line_of(const GridSamples& s, std::size_t pixel, const std::vector<float>& predicted,
                  FreePerPixel free) {
  double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
  const std::size_t k = s.images.size();
  for (std::size_t i = pixel * k; i < (pixel + 1) * k; ++i) {
    if (s.weight[i] == 0.0F) continue;
    const double light_dn = s.gain_of(i - pixel * k) * static_cast<double>(predicted[i]),
                 real_dn = static_cast<double>(s.real_dn[i]) - s.black_level_dn;
    n += 1.0, x += light_dn, y += real_dn, xx += light_dn * light_dn, xy += light_dn * real_dn;
  }
  PixelLine line;
  if (free == FreePerPixel::factor && x > 0.0) line.factor = std::max(0.0, y / x);
  if (free == FreePerPixel::factor_and_offset && xx - x * x / n > kNoSpread * xx)
    line.factor = std::max(0.0, (xy - x * y / n) / (xx - x * x / n));
  if (frees_offset(free) && n > 0.0) line.offset_dn = (y - line.factor * x) / n;
  return line;
}

/// Takes the noise of a pixel's values at what is predicted of them with a factor and an offset.
void weigh_pixel(GridSamples& s, std::size_t pixel, const std::vector<float>& predicted, PixelLine line) {
  const std::size_t n = s.images.size();
  for (std::size_t k = 0; s.noise_dn2 && k < n; ++k) {
    const std::size_t i = pixel * n + k;
    const double light_dn = line.factor * s.gain_of(k) * static_cast<double>(predicted[i]) + line.offset_dn,
                 variance = s.noise_dn2(std::max(0.0, light_dn) + s.black_level_dn) +
                            s.rendering_dn * s.rendering_dn + s.scatter_of(k);
    if (s.weight[i] > 0.0F && variance > 0.0) s.weight[i] = static_cast<float>(1.0 / std::sqrt(variance));
  }
}

/// Leaves out these pixels, unless they are more than half of all. Returns how many it left out.
std::size_t leave_out(GridSamples& s, const std::vector<std::size_t>& pixels) {
  if (2 * pixels.size() > s.n_pixels()) return 0;
  const std::size_t n = s.images.size();
  for (const std::size_t p : pixels) std::fill_n(s.weight.data() + p * n, n, 0.0F);
  return pixels.size();
}

/// Returns the limit of a mean of n squares with the noise of the camera whose `known_to` is the largest.
double limit_of(const std::vector<GridSamples>& samples, double GridSamples::*known_to, double n) {
  double most = 0.0;
  for (const GridSamples& s : samples) most = std::max(most, s.*known_to);
  return 1.0 + allowed_above(n, most);
}

}  // namespace

GridSamples grid_samples(const GrayPair& pair, std::size_t camera_index, const GainFit& fit,
                         const GrayNoise& noise, const ImageU8& interior, double rendering_dn,
                         std::size_t most, std::vector<int> images) {
  GridSamples out;
  out.camera = camera_index;
  out.images = images.empty() ? pair.gain_images : std::move(images);
  out.gain_dn = out.reference_gain_dn = fit.row.gain_dn;
  out.black_level_dn = fit.row.black_level_dn;
  out.rendering_dn = rendering_dn;
  out.noise_dn2 = [noise](double gray_dn) { return noise.variance(gray_dn); };
  if (!pair.from_dn && pair.e_scale == 1.0) out.frame = pair.irradiance;
  const auto n_valid =
      static_cast<std::size_t>(std::ranges::count_if(interior.data, [](unsigned char m) { return m != 0; }));
  out.grid = cut_to(choose_grid(*pair.camera, n_valid, most), *pair.camera, interior);
  for (std::size_t k = 0; k < out.images.size(); ++k)
    if (std::ranges::find(pair.gain_images, out.images[k]) == pair.gain_images.end())
      out.lit_apart.push_back(k);
  out.light.assign(out.lit_apart.empty() ? 0 : out.images.size(), 1.0);
  const UsableRange& u = fit.usable;
  std::vector<float> levels;
  for (int gy = 0; gy < out.grid.height; gy += out.grid.keep)
    for (int gx = 0; gx < out.grid.width; gx += out.grid.keep) {
      const std::size_t i = out.grid.pixel_of(gx, gy, pair.width());
      if (interior.data[i] == 0) continue;
      out.cell.push_back(static_cast<std::size_t>(gy) * static_cast<std::size_t>(out.grid.width) +
                         static_cast<std::size_t>(gx));
      for (const int image : out.images) {
        const double y = pair.real_at(image, i);
        const double predicted = u.gain_dn * pair.irradiance_at(image, i) + u.black_level_dn;
        const bool usable = is_usable(u, y, pair.source_at(image, i), predicted);
        // the noise of the value itself: with that of the pixel's mean, a factor per pixel takes 1.5 chi2
        const double sigma_dn = std::sqrt(noise.variance(predicted) + rendering_dn * rendering_dn);
        out.real_dn.push_back(static_cast<float>(y));
        out.weight.push_back(usable && sigma_dn > 0.0 ? static_cast<float>(1.0 / sigma_dn) : 0.0F);
        if (out.weight.back() > 0.0F) levels.push_back(static_cast<float>(predicted));
      }
    }
  if (!levels.empty()) out.known_to = noise.known_to(levels);
  out.mean_known_to = noise.known_to();
  return out;
}

void find_texture_edges(const GrayPair& pair, const UsableRange& usable, const GrayNoise& noise,
                        GridSamples& samples) {
  const TextureSteps texture(pair, usable, noise);
  samples.at_texture_edge.clear();
  for (const std::size_t cell : samples.cell) {
    const int x = static_cast<int>(cell) % samples.grid.width,
              y = static_cast<int>(cell) / samples.grid.width;
    samples.at_texture_edge.push_back(texture.is_steep(samples.grid.pixel_of(x, y, pair.width())));
  }
}

Eigen::MatrixXd NormalEquations::normal_of(const std::vector<std::size_t>& unknowns) const {
  const auto m = static_cast<Eigen::Index>(unknowns.size());
  Eigen::MatrixXd part(m, m);
  for (Eigen::Index i = 0; i < m; ++i)
    for (Eigen::Index j = 0; j < m; ++j) part(i, j) = normal(unknowns[i], unknowns[j]);
  return part;
}

Step solve_step(const NormalEquations& e, const std::vector<std::size_t>& unknowns) {
  const auto m = static_cast<Eigen::Index>(unknowns.size());
  Step step{Eigen::VectorXd::Zero(e.right.size()), Eigen::VectorXd::Zero(e.right.size()), e.chi2, 0};
  if (m == 0) return step;
  Eigen::VectorXd right(m);
  for (Eigen::Index i = 0; i < m; ++i) right[i] = e.right[unknowns[i]];
  const ScaledEigen scaled(e.normal_of(unknowns));
  step.n_determined = scaled.rank(ScaledEigen::kNull);
  const Eigen::MatrixXd covariance = scaled.inverse(ScaledEigen::kNull);
  const Eigen::VectorXd change = covariance * right;
  for (Eigen::Index i = 0; i < m; ++i) {
    step.change[unknowns[i]] = change[i];
    step.sigma[unknowns[i]] = std::sqrt(std::max(0.0, covariance(i, i)));
  }
  step.chi2 = e.chi2 - change.dot(right);
  return step;
}

Sensitivity::Sensitivity(render::Renderer& renderer, std::vector<GridSamples> samples)
    : renderer_(renderer), samples_(std::move(samples)), threshold_(samples_.size(), kHuberSigmas) {}

void Sensitivity::set_sensor(std::size_t index, double gain_dn, double black_level_dn) {
  samples_.at(index).gain_dn = gain_dn;
  samples_.at(index).black_level_dn = black_level_dn;
}

void Sensitivity::take_sensors(const std::vector<GridSamples>& from) {
  for (std::size_t c = 0; c < from.size(); ++c) {
    set_sensor(c, from[c].gain_dn, from[c].black_level_dn);
    samples_[c].light = from[c].light;
  }
}

std::vector<std::size_t> Sensitivity::lights_at(std::size_t camera, std::size_t n_parameters) const {
  std::size_t first = n_parameters + 2 * samples_.size();
  for (std::size_t c = 0; c < camera; ++c) first += samples_[c].lit_apart.size();
  std::vector<std::size_t> places(samples_[camera].lit_apart.size());
  std::iota(places.begin(), places.end(), first);
  return places;
}

void Sensitivity::move_sensors(const Eigen::VectorXd& change) {
  for (std::size_t c = 0; c < samples_.size(); ++c) {
    GridSamples& s = samples_[c];
    const std::vector<std::size_t> at = lights_at(c, 0);
    std::vector<double> gains_dn;  // the equations are linear in these, not in their ratios
    for (std::size_t j = 0; j < at.size(); ++j) gains_dn.push_back(s.gain_of(s.lit_apart[j]) + change[at[j]]);
    set_sensor(c, s.gain_dn + change[2 * c], s.black_level_dn + change[2 * c + 1]);
    for (std::size_t j = 0; j < at.size(); ++j) s.light[s.lit_apart[j]] = gains_dn[j] / s.gain_dn;
  }
}

void Sensitivity::settle_lights(const Values& predicted) {
  std::vector<std::size_t> lights;
  for (std::size_t c = 0; c < samples_.size(); ++c)
    std::ranges::copy(lights_at(c, 0), std::back_inserter(lights));
  if (lights.empty()) return;
  const NormalEquations e = equations_at(predicted, {predicted, {}}, FreePerPixel::nothing);
  move_sensors(solve_step(e, lights).change);
}

void Sensitivity::refer_curves_to_gain() {
  for (GridSamples& s : samples_) s.reference_gain_dn = s.gain_dn;
}

void Sensitivity::take_exposures(const Twin& twin) {
  exposures_.clear();
  for (const GridSamples& s : samples_) {
    exposures_.emplace_back();
    for (const int image : s.images)
      exposures_.back().push_back(
          factor_of(twin.cameras[s.camera].exposure_factors, static_cast<std::size_t>(image)));
  }
}

std::vector<double> Sensitivity::standing() const {
  std::vector<double> all = threshold_;
  all.push_back(static_cast<double>(weighings_));
  all.push_back(static_cast<double>(own_));
  for (const GridSamples& s : samples_) {
    all.push_back(s.gain_dn);
    all.push_back(s.black_level_dn);
    all.insert(all.end(), s.light.begin(), s.light.end());
  }
  for (const std::vector<double>& of_camera : exposures_)
    all.insert(all.end(), of_camera.begin(), of_camera.end());
  return all;
}

void Sensitivity::add_scatter_of(const Twin& twin) {
  ++weighings_;
  for (GridSamples& s : samples_) {
    const Eigen::MatrixXd scatter = bounce_scatter(renderer_, twin, s.camera);
    if (scatter.size() == 0) continue;
    s.scatter_dn2 = s.gain_dn * s.gain_dn * scatter(s.images, s.images);
    const double apart_px = s.grid.stride * s.grid.keep;
    s.scatters_alike = std::max(1.0, kPixelsOfOneGathering / (apart_px * apart_px));
    for (std::size_t i = 0; i < s.weight.size(); ++i)
      if (float& w = s.weight[i]; w > 0.0F)
        w = static_cast<float>(
            1.0 / std::sqrt(1.0 / std::pow(static_cast<double>(w), 2) + s.scatter_of(i % s.images.size())));
  }
}

double Sensitivity::chi2_limit(double n) const { return limit_of(samples_, &GridSamples::known_to, n); }

double Sensitivity::regional_limit(double n) const {
  return limit_of(samples_, &GridSamples::mean_known_to, n);
}

void Sensitivity::weigh_at(const Values& predicted) {
  ++weighings_;
  for (std::size_t c = 0; c < samples_.size(); ++c)
    for (std::size_t p = 0; p < samples_[c].n_pixels(); ++p) weigh_pixel(samples_[c], p, predicted[c], {});
}

void Sensitivity::weigh_with_field_at(const Values& predicted, FreePerPixel free) {
  ++weighings_;
  for (std::size_t c = 0; c < samples_.size(); ++c)
    for (std::size_t p = 0; p < samples_[c].n_pixels(); ++p)
      weigh_pixel(samples_[c], p, predicted[c], line_of(samples_[c], p, predicted[c], free));
}

std::vector<float> Sensitivity::irradiance_of(const Twin& twin, const GridSamples& s, int points) const {
  throw_if_cancelled();
  const std::vector<ImageF> images = render_grid(renderer_, twin, s.camera, s.grid, points);
  std::vector<float> values(s.real_dn.size());
  for (std::size_t p = 0; p < s.n_pixels(); ++p)
    for (std::size_t k = 0; k < s.images.size(); ++k)
      values[p * s.images.size() + k] = images[s.images[k]].data[s.cell[p]];
  return values;
}

Sensitivity::Values Sensitivity::irradiance(const Twin& twin, int samples) const {
  Values out;
  for (const GridSamples& s : samples_) out.push_back(irradiance_of(twin, s, samples));
  return out;
}

std::vector<float> Sensitivity::light_for_own(const GridSamples& s) const {
  return own_ == FreePerPixel::nothing ? std::vector<float>{} : real_light(s);
}

Sensitivity::Values Sensitivity::predicted(const Twin& twin, const std::vector<Parameter>& parameters,
                                           const Eigen::VectorXd& values, int samples,
                                           std::optional<std::size_t> camera, const Values* others) const {
  Eigen::VectorXd rendered = values;
  for (std::size_t k = 0; k < parameters.size(); ++k)
    if (parameters[k].is_closed) rendered[k] = parameters[k].start;
  const Twin changed = with_values(twin, parameters, rendered);
  const auto is_other = [&](std::size_t c) { return camera && *camera != samples_[c].camera; };
  Values before;
  for (std::size_t c = 0; c < samples_.size(); ++c)
    before.push_back(is_other(c) ? (*others)[c] : irradiance_of(changed, samples_[c], samples));
  const Twin fitted = with_values(twin, parameters, values);
  const ParameterEffects effects{changed, fitted, parameters, values};
  Values out = before;
  for (std::size_t c = 0; c < samples_.size(); ++c) {
    if (is_other(c)) continue;
    effects.add_light(samples_[c], before[c], out[c]);
    if (!effects.bend(samples_[c])) continue;
    std::vector<float> real = light_for_own(samples_[c]);
    effects.unsee(samples_[c], real);
    const OwnLevels own(samples_[c], out[c], real, own_, exposures_of(c));
    own.to_levels(out[c]);
    effects.see(samples_[c], out[c]);
    own.to_irradiance(out[c]);
  }
  return out;
}

std::size_t Sensitivity::leave_out_edges(const Twin& twin) {
  ++weighings_;
  const Values coarse = irradiance(twin, residual_samples_), fine = irradiance(twin, kFineSamples);
  std::size_t n_left_out = 0;
  for (std::size_t c = 0; c < samples_.size(); ++c) {
    GridSamples& s = samples_[c];
    const std::size_t k = s.images.size();
    ImageU8 near_edge(s.grid.width, s.grid.height, 0);
    for (std::size_t i = 0; i < s.weight.size(); ++i) {
      const auto apart = static_cast<double>(s.weight[i] * (coarse[c][i] - fine[c][i]));
      if (!(s.gain_dn * std::abs(apart) > kSampledWell)) continue;
      const int x = static_cast<int>(s.cell[i / k]) % s.grid.width,
                y = static_cast<int>(s.cell[i / k]) / s.grid.width, d = s.grid.keep;
      for (int v = std::max(0, y - d); v <= std::min(s.grid.height - 1, y + d); ++v)
        for (int u = std::max(0, x - d); u <= std::min(s.grid.width - 1, x + d); ++u) near_edge(u, v) = 1;
    }
    std::vector<std::size_t> pixels;
    for (std::size_t p = 0; p < s.n_pixels(); ++p)
      if (near_edge.data[s.cell[p]] != 0) pixels.push_back(p);
    n_left_out += leave_out(s, pixels);
  }
  return n_left_out;
}

void Sensitivity::leave_out_texture_edges() {
  ++weighings_;
  for (GridSamples& s : samples_) {
    std::vector<std::size_t> pixels;
    for (std::size_t p = 0; p < s.at_texture_edge.size(); ++p)
      if (s.at_texture_edge[p]) pixels.push_back(p);
    leave_out(s, pixels);
  }
}

double Sensitivity::residual(const GridSamples& s, const std::vector<float>& irradiance, std::size_t i) {
  const double gain_dn = s.light.empty() ? s.gain_dn : s.gain_of(i % s.images.size());
  return static_cast<double>(s.real_dn[i]) - gain_dn * static_cast<double>(irradiance[i]) - s.black_level_dn;
}

bool Sensitivity::holds_code(const Twin& twin) const {
  const std::vector<PatternSpec> sequence = expand_sequence(twin.fringes);
  return std::ranges::any_of(samples_, [&](const GridSamples& s) {
    return std::ranges::any_of(
        s.images, [&](int image) { return sequence[static_cast<std::size_t>(image)].is_gray(); });
  });
}

void Sensitivity::choose_points(const Twin& twin) {
  if (!twin.projector || !twin.projector->has_halo() || !holds_code(twin)) return;
  const Values few = irradiance(twin, kResidualSamples), many = irradiance(twin, kCodeSamples);
  double squares = 0.0, n = 0.0;
  for (std::size_t c = 0; c < samples_.size(); ++c)
    for (std::size_t i = 0; i < few[c].size(); ++i) {
      if (samples_[c].weight[i] == 0.0F) continue;
      const auto apart = static_cast<double>(samples_[c].weight[i] * (few[c][i] - many[c][i]));
      squares += std::pow(samples_[c].gain_dn * apart, 2);
      n += 1.0;
    }
  if (squares > kPointsMayDiffer * kPointsMayDiffer * n) residual_samples_ = kCodeSamples;
}

NormalEquations Sensitivity::equations(const Twin& twin, const std::vector<Parameter>& parameters,
                                       const Eigen::VectorXd& values, bool keep_scale,
                                       Derivative derivative) {
  const Values base = predicted(twin, parameters, values);
  if (!keep_scale) choose_scale(base, FreePerPixel::nothing);
  const Columns all = parameters.empty() ? Columns{base, {}} : columns(twin, parameters, values, derivative);
  return equations_at(base, all, FreePerPixel::nothing);
}

NormalEquations Sensitivity::equations_without_parameters(const Twin& twin,
                                                          const std::vector<Parameter>& parameters,
                                                          const Eigen::VectorXd& values) const {
  const Values base = predicted(twin, parameters, values);
  return equations_at(base, {base, {}}, FreePerPixel::nothing);
}

}  // namespace fringetwin::compare
