// SPDX-License-Identifier: Apache-2.0
#include "tests/support/compare/synthetic_sides.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>

namespace fringetwin::testing {

double weight_at(const SidesTruth& t, int x, int y) {
  const double u = (x - 0.5 * t.width) / t.width, v = (y - 0.5 * t.height) / t.height;
  return t.weight * (1.0 - 1.2 * (u * u + v * v));
}

bool is_lit(const SidesTruth& t, int x, int y) {
  const double u = (x - 0.5 * t.width) / (0.46 * t.width), v = (y - 0.5 * t.height) / (0.46 * t.height);
  return u * u + v * v < 1.0;
}

namespace {

Twin make_twin(const SidesTruth& t) {
  Twin twin;
  twin.name = "synthetic";
  twin.file = "synthetic/twin.toml";
  for (int c = 0; c < t.cameras; ++c) {
    const double f = 2.0 * t.width;
    Camera camera{
        c == 0 ? "left" : "right",
        Lens("LENSMODEL_PINHOLE", {f, f, 0.5 * t.width, 0.5 * t.height}, {t.width, t.height}, "test"), Pose{},
        Sensor{}, std::nullopt};
    camera.sensor.bit_depth = t.bit_depth;
    camera.sensor.gain_dn = t.twin_gain_dn;
    camera.sensor.black_level_dn = t.twin_black_level_dn;
    twin.cameras.push_back(camera);
  }
  DirectionFringes x;
  x.pitches_px = t.pitches_px;
  x.phase_origin_px.assign(t.pitches_px.size(), 0.0);
  if (t.gray_bits > 0) {
    x.gray = GrayCode{};
    x.gray->bits = t.gray_bits;
    twin.fringes.unwrap = Unwrap::gray;
  }
  twin.fringes.directions = {x};
  twin.fringes.steps = t.steps;
  twin.fringes.amplitude = t.contrast;
  twin.objects.push_back({"ball", SphereShape{{0, 0, 250}, 5.0}, {}});
  twin.measure.fits.push_back({"ball", 2.0});
  return twin;
}

/// Projector coordinate of a pixel; a smooth slope so that all phases occur.
double projector_px(int x, int y) { return 40.0 + 0.83 * x + 0.11 * y + 2e-4 * x * y; }

measure::CameraDecode empty_decode(const SidesTruth& t, const std::string& camera) {
  measure::CameraDecode d;
  d.camera = camera;
  d.flags = ImageU8(t.width, t.height, measure::kLowModulation);
  measure::DirectionDecode direction;
  direction.pitches_px = t.pitches_px;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  direction.wrapped_rad.assign(t.pitches_px.size(), ImageF(t.width, t.height, nan));
  direction.amplitude_dn.assign(t.pitches_px.size(), ImageF(t.width, t.height, nan));
  direction.mean_dn = direction.sigma_rad = direction.coordinate_sigma_px = ImageF(t.width, t.height, nan);
  direction.coordinate_px = ImageD(t.width, t.height, std::nan(""));
  d.directions.push_back(std::move(direction));
  return d;
}

void set_pixel(measure::CameraDecode& d, const SidesTruth& t, int x, int y, double coordinate_px,
               double gain) {
  measure::DirectionDecode& m = d.directions[0];
  const double mean = 0.5 * gain * weight_at(t, x, y), amplitude = 2.0 * t.contrast * mean;
  d.flags(x, y) = measure::kValid;
  m.coordinate_px(x, y) = coordinate_px;
  for (std::size_t p = 0; p < t.pitches_px.size(); ++p) {
    m.wrapped_rad[p](x, y) = static_cast<float>(
        std::remainder(2.0 * std::numbers::pi * coordinate_px / t.pitches_px[p], 2.0 * std::numbers::pi));
    m.amplitude_dn[p](x, y) = static_cast<float>(amplitude);
  }
  m.mean_dn(x, y) = static_cast<float>(mean);
  const double gray_variance = t.noise_dn * t.noise_dn + (t.round_real ? 1.0 / 12.0 : 0.0);
  m.sigma_rad(x, y) = static_cast<float>(std::sqrt(2.0 * gray_variance / t.steps) / amplitude);
}

/// A sphere's points with Gaussian deviations, as if measured.
void add_sphere(measure::Measurement& m, const SidesTruth& t, double sigma_mm,
                const Eigen::Vector3d& center_mm, double radius_mm, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  measure::ObjectFit fit;
  fit.object = "ball";
  fit.kind = "sphere";
  fit.usable = true;
  for (int y = 0; y < t.height; ++y)
    for (int x = 0; x < t.width; ++x) {
      if (!is_lit(t, x, y)) continue;
      const double u = (x - 0.5 * t.width) / (0.5 * t.width), v = (y - 0.5 * t.height) / (0.5 * t.height);
      const double r2 = u * u + v * v;
      if (r2 > 0.9) continue;
      const double deviation = sigma_mm * normal(random);
      const Eigen::Vector3d direction(u, v, -std::sqrt(1.0 - r2));
      fit.index.push_back(m.cloud.size());
      fit.deviation_mm.push_back(static_cast<float>(deviation));
      m.cloud.p_world_mm.push_back(center_mm + (radius_mm + deviation) * direction);
      m.cloud.normal_world.push_back(direction.cast<float>());
      m.cloud.q_cam_px.emplace_back(static_cast<float>(x), static_cast<float>(y));
      m.cloud.sigma_mm.push_back(static_cast<float>(sigma_mm));
    }
  fit.n = fit.index.size();
  fit.numbers = {{"radius_mm", radius_mm}, {"radius_sigma_mm", 0.0004}, {"rms_mm", sigma_mm}};
  fit.vectors = {{"center_mm", center_mm}, {"center_sigma_mm", Eigen::Vector3d(0.0003, 0.0003, 0.0007)}};
  m.triangulation.n_candidates = m.triangulation.n_points = fit.n;
  m.fits.push_back(std::move(fit));
}

}  // namespace

SyntheticSides make_sides(const SidesTruth& t) {
  SyntheticSides s{make_twin(t), {}, {}};
  std::mt19937_64 random(t.seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  const std::vector<PatternSpec> patterns = expand_sequence(s.twin.fringes);
  const double max_dn = s.twin.cameras[0].sensor.max_dn();
  const double finest = t.pitches_px[static_cast<std::size_t>(s.twin.fringes.directions[0].finest())];
  s.real.measurement.emplace();
  s.simulated.measurement.emplace();
  for (int c = 0; c < t.cameras; ++c) {
    const std::string name = s.twin.cameras[static_cast<std::size_t>(c)].name;
    CameraImages blank;
    blank.camera = name;
    blank.bit_depth = t.bit_depth;
    blank.images.assign(patterns.size(), ImageF(t.width, t.height, 0.0f));
    CameraImages real = blank, dn = blank, irradiance = blank;
    irradiance.radiance = true;
    measure::CameraDecode real_decode = empty_decode(t, name), sim_decode = real_decode;
    for (int y = 0; y < t.height; ++y)
      for (int x = 0; x < t.width; ++x) {
        const bool lit = is_lit(t, x, y);
        const double w = lit ? weight_at(t, x, y) : 0.0;
        const double albedo = 1.0 + t.albedo_sigma * normal(random);
        const double xp = projector_px(x, y);
        const double xp_real = xp + t.geometry_rad * normal(random) * finest / (2.0 * std::numbers::pi);
        if (lit) {
          set_pixel(sim_decode, t, x, y, xp, t.twin_gain_dn);
          set_pixel(real_decode, t, x, y, xp_real, t.gain_dn);
        }
        for (std::size_t k = 0; k < patterns.size(); ++k) {
          const PatternSpec& p = patterns[k];
          const double e = w * pattern_value(s.twin.fringes, p, xp);
          double e_real = w * pattern_value(s.twin.fringes, p, xp_real);
          if (!p.is_gray()) {
            const double theta = 2.0 * std::numbers::pi *
                                 (xp_real / t.pitches_px[static_cast<std::size_t>(p.pitch)] +
                                  static_cast<double>(p.step) / t.steps);
            e_real += 0.5 * w * t.second_harmonic * std::cos(2.0 * theta);
          }
          const double light_dn = t.gain_dn * albedo * e_real;
          const double shot_dn2 = t.electrons_per_dn > 0.0 ? light_dn / t.electrons_per_dn : 0.0;
          double y_real = light_dn + t.black_level_dn +
                          std::sqrt(t.noise_dn * t.noise_dn + std::max(shot_dn2, 0.0)) * normal(random);
          if (t.outlier_fraction > 0.0 && uniform(random) < t.outlier_fraction) y_real += t.outlier_dn;
          if (t.round_real) y_real = std::clamp(std::round(y_real), 0.0, max_dn);
          real.images[k].writable(x, y) = static_cast<float>(y_real);
          irradiance.images[k].writable(x, y) = static_cast<float>(e);
          dn.images[k].writable(x, y) = static_cast<float>(
              std::clamp(std::round(t.twin_gain_dn * e + t.twin_black_level_dn), 0.0, max_dn));
        }
      }
    s.real.images.push_back(std::move(real));
    s.simulated.images.push_back(std::move(dn));
    s.simulated.irradiance.push_back(std::move(irradiance));
    s.real.measurement->cameras.push_back(std::move(real_decode));
    s.simulated.measurement->cameras.push_back(std::move(sim_decode));
  }
  add_sphere(*s.real.measurement, t, 0.013, {6.567, -5.497, 270.634}, 19.065, random);
  add_sphere(*s.simulated.measurement, t, 0.004, {6.5665, -5.4972, 270.6338}, 19.0651, random);
  if (t.published_only) s.real = {};
  return s;
}

}  // namespace fringetwin::testing
