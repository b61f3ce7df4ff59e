// SPDX-License-Identifier: Apache-2.0
#include "compare/causes/sensitivity.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <utility>

#include "compare/causes/own_levels.hpp"
#include "compare/causes/scaled_eigen.hpp"
#include "compare/gray/texture_steps.hpp"
#include "compare/parameters/closed_columns.hpp"
#include "compare/parameters/parameters.hpp"
#include "compare/verdict/explained.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kWantedChange = 3e-3;  ///< of the images' size: 0.15 % of the derivative is curvature
constexpr double kExactChange = 2e-2;   ///< central: 0.01 %
constexpr int kMostAttempts = 4;
constexpr double kNoChange = 1e-7;         ///< of the images' size: rounding
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

/// What parameters do to the irradiance of a camera from their start to their values, where nothing is
/// rendered for it.
struct Effects {
  const Twin &rendered, &fitted;  ///< as EffectInput has them
  const std::vector<Parameter>& parameters;
  const Eigen::VectorXd& values;

  /// Does what is done to the light.
  void add_light(const GridSamples& s, const std::vector<float>& before, std::vector<float>& e) const {
    for (std::size_t k = 0; k < parameters.size(); ++k)
      if (!parameters[k].is_of_sensor && has_effect(k, s))
        parameters[k].effect({rendered, fitted, s, before, parameters[k].start, values[k]}, e);
  }
  /// Returns whether the sensors' curves bend light.
  bool bend(const GridSamples& s) const {
    for (std::size_t k = 0; k < parameters.size(); ++k)
      if (parameters[k].is_of_sensor && has_effect(k, s)) return true;
    return false;
  }
  /// Bends levels as the sensors' curves do, after all else.
  void see(const GridSamples& s, std::vector<float>& levels) const {
    for (std::size_t k = 0; k < parameters.size(); ++k)
      if (parameters[k].is_of_sensor && has_effect(k, s))
        parameters[k].effect({rendered, fitted, s, levels, parameters[k].start, values[k]}, levels);
  }
  /// Takes that back.
  void unsee(const GridSamples& s, std::vector<float>& levels) const {
    for (std::size_t k = parameters.size(); k-- > 0;)
      if (parameters[k].is_of_sensor && has_effect(k, s))
        parameters[k].effect({rendered, fitted, s, levels, values[k], parameters[k].start}, levels);
  }

 private:
  bool has_effect(std::size_t k, const GridSamples& s) const {
    const Parameter& p = parameters[k];
    return (!p.change || p.is_closed) && values[k] != p.start && (!p.camera || *p.camera == s.camera);
  }
};

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
  const Effects effects{changed, fitted, parameters, values};
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

double Sensitivity::relative_change(const Values& from, const Values& to,
                                    std::optional<std::size_t> camera) const {
  double change = 0.0, size = 0.0;
  for (std::size_t c = 0; c < samples_.size(); ++c) {
    if (camera && *camera != samples_[c].camera) continue;
    for (std::size_t i = 0; i < from[c].size(); ++i) {
      if (samples_[c].weight[i] == 0.0F) continue;
      const auto a = static_cast<double>(from[c][i]), b = static_cast<double>(to[c][i]);
      change += (b - a) * (b - a);
      size += a * a;
    }
  }
  return size > 0.0 ? std::sqrt(change / size) : 0.0;
}

namespace {
Sensitivity::Values zeros(const Sensitivity::Values& like) {
  Sensitivity::Values out;
  for (const std::vector<float>& values : like) out.emplace_back(values.size(), 0.0F);
  return out;
}
}  // namespace

int Sensitivity::derivative_samples(const Twin& twin, const std::vector<Parameter>& parameters) const {
  const bool is_fine = std::ranges::any_of(
      parameters, [](const Parameter& p) { return p.group == "harmonics_high" || p.group == "raster"; });
  return is_fine || holds_code(twin) ? residual_samples_ : kDerivativeSamples;
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

Sensitivity::Values Sensitivity::closed_column(const Twin& twin, const std::vector<Parameter>& parameters,
                                               const Eigen::VectorXd& values, std::size_t at,
                                               const Values& base) const {
  const Parameter& parameter = parameters[at];
  const bool bends = std::ranges::any_of(parameters, &Parameter::is_of_sensor);
  // harmonics are linear: of a long step less is rounded away
  const double step = parameter.harmonic > 0 && !bends ? 1.0 : parameter.step;
  const double up = std::min(values[at] + step, parameter.largest),
               down = std::max(values[at] - step, parameter.smallest);
  const Twin fitted = with_values(twin, parameters, values);
  const Effects sensors{twin, fitted, parameters, values};
  Values out = zeros(base);
  for (std::size_t c = 0; c < samples_.size(); ++c) {
    const GridSamples& s = samples_[c];
    if (parameter.camera && *parameter.camera != s.camera) continue;
    const bool bends_light = !parameter.is_of_sensor && sensors.bend(s);
    const OwnLevels own = parameter.is_of_sensor || bends_light
                              ? OwnLevels(s, base[c], light_for_own(s), own_, exposures_of(c))
                              : OwnLevels();
    std::vector<float> before = base[c];
    own.to_levels(before);
    if (bends_light) {
      sensors.unsee(s, before);
      own.to_irradiance(before);
    }
    std::vector<float> more = before, less = before;
    parameter.effect({fitted, fitted, s, before, values[at], up}, more);
    parameter.effect({fitted, fitted, s, before, values[at], down}, less);
    for (std::vector<float>* seen : {&more, &less}) {
      if (bends_light) {
        own.to_levels(*seen);
        sensors.see(s, *seen);
      }
      own.to_irradiance(*seen);
    }
    for (std::size_t i = 0; i < more.size(); ++i)
      out[c][i] =
          static_cast<float>((static_cast<double>(more[i]) - static_cast<double>(less[i])) / (up - down));
  }
  return out;
}

Sensitivity::Values Sensitivity::column(const Twin& twin, const std::vector<Parameter>& parameters,
                                        const Eigen::VectorXd& values, std::size_t at, const Values& base,
                                        Derivative derivative, double& found) const {
  const Parameter& parameter = parameters[at];
  if (tells_derivative(parameter)) return closed_column(twin, parameters, values, at, base);
  const double wanted = derivative == Derivative::exact ? kExactChange : kWantedChange,
               longer = wanted / kWantedChange;  // than a quick derivative's step
  // as far as a step may grow: a thousand times what suits a rig of usual size
  const double longest = 1e3 * parameter.step;
  const auto inside = [&](double value) { return value >= parameter.smallest && value <= parameter.largest; };
  const auto images_at = [&](double value) {
    Eigen::VectorXd changed = values;
    changed[at] = value;
    return predicted(twin, parameters, changed, derivative_samples(twin, parameters), parameter.camera,
                     &base);
  };
  const Values nothing = zeros(base);
  Values out, other;
  double step = parameter.is_switch ? (values[at] > 0.5 ? -1.0 : 1.0) : longer * found;
  try {
    bool is_all_room = false;
    for (int attempt = 0;; ++attempt) {
      if (!inside(values[at] + step)) step = -step;
      if (!inside(values[at] + step)) {  // as far as there is room
        const double up = parameter.largest - values[at], down = values[at] - parameter.smallest;
        step = up >= down ? up : -down;
        if (!(std::max(up, down) > 0.0)) return nothing;
        is_all_room = true;
      }
      out = images_at(values[at] + step);
      if (parameter.is_switch) break;
      const double change = relative_change(base, out, parameter.camera);
      if (change > wanted / 5.0 && change < wanted * 5.0) break;
      const bool cannot_grow = std::abs(step) >= longest || is_all_room;
      if (attempt == kMostAttempts || (change < kNoChange && cannot_grow) ||
          (change < wanted && is_all_room)) {
        if (change < kNoChange) return nothing;
        break;  // out belongs to this step, whatever its size
      }
      const double grown = step * std::clamp(wanted / std::max(change, 1e-12), 1e-3, 1e3);
      step = std::copysign(std::min(std::abs(grown), longest), step);
    }
    found = step / longer;
    if (derivative == Derivative::exact && !parameter.is_switch) {
      if (!inside(values[at] - step))  // one side only: a short step
        return column(twin, parameters, values, at, base, Derivative::quick, found);
      other = images_at(values[at] - step);
      step *= 2.0;
    }
  } catch (const UserError&) {
    return nothing;  // no lens can be made of it: the images say nothing about this parameter
  }
  const Values& from = other.empty() ? base : other;
  for (std::size_t c = 0; c < out.size(); ++c)
    for (std::size_t i = 0; i < out[c].size(); ++i)
      out[c][i] =
          static_cast<float>((static_cast<double>(out[c][i]) - static_cast<double>(from[c][i])) / step);
  return out;
}

bool Sensitivity::knows_places() const {
  return std::ranges::none_of(samples_, [](const GridSamples& s) { return s.projector_px.empty(); });
}

Sensitivity::Values Sensitivity::scaled_column(const Values& other, const Parameter& parameter) const {
  Values out = other;
  for (std::size_t c = 0; c < out.size(); ++c)
    for (std::size_t p = 0; p < samples_[c].n_pixels(); ++p) {
      const auto times = static_cast<float>(
          parameter.times ? parameter.times(samples_[c].projector_px[p].cast<double>()) : 1.0);
      const std::size_t n = samples_[c].images.size();
      for (std::size_t k = 0; k < n; ++k)
        out[c][p * n + k] *=
            parameter.only_image && *parameter.only_image != samples_[c].images[k] ? 0.0F : times;
    }
  return out;
}

void Sensitivity::find_unit_sums(const Twin& fitted, const std::vector<Parameter>& parameters) {
  const int points = derivative_samples(fitted, parameters);
  if (std::ranges::find(parameters, "raster", &Parameter::group) != parameters.end())
    find_waves(renderer_, fitted, points, samples_);
  int highest = 0;
  for (const Parameter& p : parameters)
    highest = std::max({highest, p.harmonic, p.does_as ? p.does_as->harmonic : 0});
  const bool are_late_or_move = std::ranges::any_of(
      parameters, [](const Parameter& p) { return p.group == "timing" || p.group == "motion"; });
  if (highest > 0 && harmonics_are_fringes(fitted) && !are_late_or_move)
    find_harmonics(renderer_, fitted, highest, points, samples_);
  else
    for (GridSamples& s : samples_) s.harmonics = nullptr, s.highest_harmonic = 1;
}

bool Sensitivity::tells_derivative(const Parameter& p) const {
  return p.effect && std::ranges::all_of(samples_, [&](const GridSamples& s) {
           return p.harmonic == 0 || p.harmonic <= s.highest_harmonic;
         });
}

/// Where exposures reach into other patterns an image changes with its neighbours, too. Seen through a curve,
/// a factor that is free in every pixel takes what is common to all images, and leaves the curve where it
/// was.
bool Sensitivity::renders_images_together(const Twin& fitted,
                                          const std::vector<Parameter>& parameters) const {
  return fitted.projector && fringes_have_overtones(fitted) && !sees_other_patterns(fitted) &&
         std::ranges::none_of(parameters, [this](const Parameter& p) {
           return p.group == "timing" || (p.is_of_sensor && own_ != FreePerPixel::nothing);
         });
}

const Sensitivity::Values& Sensitivity::column_beside(const Parameter& other, const Twin& twin,
                                                      const std::vector<Parameter>& parameters,
                                                      const Eigen::VectorXd& values, const Values& base,
                                                      Derivative derivative,
                                                      std::map<std::string, Values>& known) const {
  const auto [it, is_new] = known.try_emplace(other.name);
  if (!is_new) return it->second;
  std::vector<Parameter> with = parameters;
  with.push_back(other);
  Eigen::VectorXd at(values.size() + 1);
  at << values, other.start;
  double step = other.step;
  return it->second = column(twin, with, at, parameters.size(), base, derivative, step);
}

Sensitivity::Columns Sensitivity::columns(const Twin& twin, const std::vector<Parameter>& parameters,
                                          const Eigen::VectorXd& values, Derivative derivative,
                                          std::vector<double> steps) {
  const Twin fitted = with_values(twin, parameters, values);
  find_unit_sums(fitted, parameters);
  for (std::size_t k = steps.size(); k < parameters.size(); ++k) steps.push_back(parameters[k].step);
  Columns out{
      predicted(twin, parameters, values, derivative_samples(twin, parameters)), {}, std::move(steps)};
  std::map<std::string, Values> of_others;  // that are no parameters, or come later
  const auto column_of = [&](const Parameter& other) -> const Values& {
    const auto found = std::ranges::find(parameters, other.name, &Parameter::name) - parameters.begin();
    if (found < std::ssize(out.each)) return out.each[static_cast<std::size_t>(found)];
    return column_beside(other, twin, parameters, values, out.rough, derivative, of_others);
  };
  const bool are_rendered = renders_images_together(fitted, parameters);
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const Parameter& p = parameters[k];
    const bool is_closed = tells_derivative(p) && !(p.effect_of_sinusoids && are_rendered);
    out.each.push_back(p.does_as && !is_closed && (knows_places() || !p.times)
                           ? scaled_column(column_of(*p.does_as), p)
                           : column(twin, parameters, values, k, out.rough, derivative, out.steps[k]));
  }
  for (const Parameter& p : parameters) out.exposes.push_back(p.group == "exposure");
  return out;
}

void Sensitivity::take_pose_slopes(const Columns& columns, const std::vector<std::size_t>& pose) {
  for (std::size_t c = 0; c < samples_.size(); ++c) {
    std::vector<std::vector<float>> slopes;
    for (const std::size_t at : pose) slopes.push_back(columns.each[at][c]);
    samples_[c].pose_slopes = std::make_shared<const std::vector<std::vector<float>>>(std::move(slopes));
  }
}

Sensitivity::Columns Sensitivity::columns_of_all_groups(const Twin& twin,
                                                        const std::vector<Parameter>& parameters,
                                                        const Eigen::VectorXd& values,
                                                        const std::vector<std::size_t>& pose,
                                                        const std::function<void(std::size_t)>& after) {
  const Twin fitted = with_values(twin, parameters, values);
  find_unit_sums(fitted, parameters);
  Columns out{predicted(twin, parameters, values, derivative_samples(twin, parameters)), {}, {}};
  for (const Parameter& p : parameters) out.steps.push_back(p.step);
  out.each.resize(parameters.size());
  std::size_t done = 0;
  std::map<std::string, Values> of_all_images;
  const bool are_rendered = renders_images_together(fitted, parameters);
  const auto fill = [&](bool closed) {
    for (std::size_t k = 0; k < parameters.size(); ++k) {
      const Parameter& p = parameters[k];
      if (tells_derivative(p) != closed) continue;
      out.each[k] = p.effect_of_sinusoids && p.does_as && are_rendered
                        ? scaled_column(column_beside(*p.does_as, twin, parameters, values, out.rough,
                                                      Derivative::quick, of_all_images),
                                        p)
                        : column(twin, parameters, values, k, out.rough, Derivative::quick, out.steps[k]);
      after(++done);
    }
  };
  fill(false);
  take_pose_slopes(out, pose);
  fill(true);
  return out;
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
