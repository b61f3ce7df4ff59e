// SPDX-License-Identifier: Apache-2.0
// Parameters of the waves of the raster. One rendering of the waves by themselves tells the derivatives by
// all of them.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/parameters/closed_columns.hpp"
#include "compare/parameters/harmonic_parts.hpp"
#include "render/pattern/raster_waves.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kRasterMayBeOffPx = 1e-3;  ///< a turn or two of a wave over the projector's image

/// A part of the light of one wave.
struct WavePart {
  std::size_t direction, wave;
  double Harmonic::*part;
};

/// Returns the twin with no other wave than this, of a size of 1; all of them with `everything`.
Twin with_waves(const Twin& twin, const std::optional<WavePart>& only) {
  Twin out = twin;
  for (std::size_t d = 0; d < out.fringes.directions.size(); ++d)
    for (std::size_t k = 0; k < out.fringes.directions[d].raster.waves.size(); ++k) {
      Harmonic& wave = out.fringes.directions[d].raster.waves[k];
      wave = only ? Harmonic{} : Harmonic{1.0, 0.0};
      if (only && only->direction == d && only->wave == k) wave.*(only->part) = 1.0;
    }
  return out;
}

/// Returns where the sums of a wave stand in GridSamples::waves: by directions that have any, then pitches.
std::size_t place_of(const Fringes& fringes, const PatternSpec& spec, std::size_t wave) {
  std::size_t place = 0;
  for (std::size_t d = 0; d < static_cast<std::size_t>(spec.direction); ++d)
    place += fringes.directions[d].pitches_px.size() * fringes.directions[d].raster.waves.size();
  const Raster& raster = fringes.directions[static_cast<std::size_t>(spec.direction)].raster;
  return place + static_cast<std::size_t>(spec.pitch) * raster.waves.size() + wave;
}

void add_wave(const WavePart& of, const EffectInput& in, std::vector<float>& irradiance) {
  const GridSamples& s = in.samples;
  if (!s.waves) return;
  const Twin unit = with_waves(in.fitted, of);
  const std::vector<PatternSpec> sequence = expand_sequence(unit.fringes);
  const std::size_t n = s.images.size();
  for (std::size_t k = 0; k < n; ++k) {
    const auto image = static_cast<std::size_t>(s.images[k]);
    const PatternSpec& spec = sequence[image];
    if (spec.kind != PatternSpec::Kind::phase_step ||
        static_cast<std::size_t>(spec.direction) != of.direction)
      continue;
    const render::WaveTerm term = render::waves_of_image(unit, spec, image).front();
    const double times = (in.to - in.from) * factor_of(in.fitted.projector->light_factors, image) *
                         factor_of(in.fitted.cameras[s.camera].exposure_factors, image);
    const std::vector<float>& sums = s.waves->at(place_of(unit.fringes, spec, of.wave));
    const auto c = static_cast<float>(times * term.cosine), minus_s = static_cast<float>(-times * term.sine);
#pragma omp parallel for schedule(static)
    for (std::size_t p = 0; p < s.n_pixels(); ++p)
      irradiance[p * n + k] += c * sums[2 * p] + minus_s * sums[2 * p + 1];
  }
}

}  // namespace

std::vector<Parameter> raster_parameters(const Twin& twin) {
  std::vector<Parameter> all;
  if (!twin.projector || twin.projector->pixel_structure || twin.has_subsurface() || twin.fringes.steps == 0)
    return all;
  // what a neighbour's pattern brings is rendered
  const bool is_mixed =
      std::ranges::any_of(twin.cameras, [](const Camera& camera) { return camera.timing.has_value(); });
  for (std::size_t d = 0; d < twin.fringes.directions.size(); ++d) {
    const DirectionFringes& direction = twin.fringes.directions[d];
    const Raster& raster = direction.raster;
    const std::string name = fmt::format("projector.raster.{}.", axis_name(direction.axis));
    const int first = raster.first_order;
    for (std::size_t i = 0; i < raster.waves.size(); ++i)
      for (double Harmonic::*part : {&Harmonic::cosine, &Harmonic::sine}) {
        const int order = first + static_cast<int>(i);
        Parameter& p =
            all.emplace_back(Parameter{.group = "raster",
                                       .name = fmt::format("{}{}{}", name, order, name_of_part(part)),
                                       .unit = "",
                                       .start = raster.waves[i].*part,
                                       .step = 1e-3,
                                       .change = [d, i, part](Twin& t, double d_part) {
                                         t.fringes.directions[d].raster.waves[i].*part += d_part;
                                       }});
        if (!is_mixed)
          p.effect = [of = WavePart{d, i, part}](const EffectInput& in, std::vector<float>& irradiance) {
            add_wave(of, in, irradiance);
          };
        p.smallest = -1.0, p.largest = 1.0;  // as the file takes them
      }
    if (!raster.has_any()) continue;  // nothing tells the raster's pitch
    Parameter& p = all.emplace_back(Parameter{
        .group = "raster",
        .name = name + "pitch_px",
        .unit = "px",
        .start = raster.pitch_px,
        .step = 1e-6,
        .change = [d](Twin& t, double d_pitch) { t.fringes.directions[d].raster.pitch_px += d_pitch; }});
    p.smallest = raster.pitch_px - kRasterMayBeOffPx, p.largest = raster.pitch_px + kRasterMayBeOffPx;
  }
  return all;
}

void find_waves(render::Renderer& renderer, const Twin& twin, int points, std::vector<GridSamples>& samples) {
  const Twin all = with_waves(twin, {});
  if (!all.projector || !all.fringes.has_raster()) return;
  Twin view = render::showing_waves(all);
  for (Camera& camera : view.cameras) camera.exposure_factors.clear(), camera.timing.reset();
  for (Object& object : view.objects) object.motion = {};
  const double amplitude = view.fringes.amplitude;
  for (GridSamples& s : samples) {
    const std::vector<ImageF> images = render_grid(renderer, view, s.camera, s.grid, points);
    std::vector<std::vector<float>> waves(images.size() / 3, std::vector<float>(2 * s.n_pixels()));
    for (std::size_t w = 0; w < waves.size(); ++w)  // m + A (C cos(2 pi n/3) - S sin(2 pi n/3))
      for (std::size_t p = 0; p < s.n_pixels(); ++p) {
        const auto e = [&](std::size_t n) {
          return static_cast<double>(images[3 * w + n].data[s.cell[p]]) / amplitude;
        };
        waves[w][2 * p] = static_cast<float>((2.0 * e(0) - e(1) - e(2)) / 3.0);
        waves[w][2 * p + 1] = static_cast<float>((e(2) - e(1)) / std::sqrt(3.0));
      }
    s.waves = std::make_shared<const std::vector<std::vector<float>>>(std::move(waves));
  }
}

}  // namespace fringetwin::compare
