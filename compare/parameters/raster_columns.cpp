// SPDX-License-Identifier: Apache-2.0
// Parameters of the waves of the raster. One rendering of the waves by themselves tells the derivatives by
// all of them.
#include <fmt/format.h>

#include "compare/parameters/closed_columns.hpp"
#include "compare/parameters/harmonic_parts.hpp"
#include "compare/parameters/unit_sums.hpp"
#include "render/pattern/raster_waves.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kRasterMayBeOffPx = 1e-3;  ///< a turn or two of a wave over the projector's image

/// A part of the light of one wave.
struct WavePart {
  std::size_t direction, wave;
  double Harmonic::*part;
};

/// Returns the twin with no other wave than this, of a size of 1; without it with all of them.
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
  for (std::size_t k = 0; k < s.images.size(); ++k) {
    const auto image = static_cast<std::size_t>(s.images[k]);
    const PatternSpec& spec = sequence[image];
    if (spec.kind != PatternSpec::Kind::phase_step ||
        static_cast<std::size_t>(spec.direction) != of.direction)
      continue;
    const render::WaveTerm term = render::waves_of_image(unit, spec, image).front();
    const double times = (in.to - in.from) * factor_of(in.fitted.projector->light_factors, image) *
                         factor_of(in.fitted.cameras[s.camera].exposure_factors, image);
    const std::vector<float>& sums = s.waves->at(place_of(unit.fringes, spec, of.wave));
    add_sums(s, sums, k, times * term.cosine, -times * term.sine, irradiance);
  }
}

/// Lists the parameters of the group.
class RasterList : private GroupList {
 public:
  explicit RasterList(const Twin& twin) : GroupList("raster"), twin_(twin) {}

  std::vector<Parameter> run() {
    for (std::size_t d = 0; d < twin_.fringes.directions.size(); ++d) {
      const Raster& raster = twin_.fringes.directions[d].raster;
      for (std::size_t wave = 0; wave < raster.waves.size(); ++wave)
        for (double Harmonic::*part : {&Harmonic::cosine, &Harmonic::sine}) add_part({d, wave, part});
      if (raster.has_any()) add_pitch(d);  // nothing else tells it
    }
    return std::move(list_);
  }

 private:
  const Raster& raster_of(std::size_t direction) const { return twin_.fringes.directions[direction].raster; }
  std::string name_of(std::size_t direction) const {
    return fmt::format("projector.raster.{}.", axis_name(twin_.fringes.directions[direction].axis));
  }

  void add_part(const WavePart& of) {
    const Raster& raster = raster_of(of.direction);
    const int order = raster.first_order + static_cast<int>(of.wave);
    Parameter& p = add(fmt::format("{}{}{}", name_of(of.direction), order, name_of_part(of.part)), "",
                       raster.waves[of.wave].*(of.part), 1e-3, [of](Twin& t, double change) {
                         t.fringes.directions[of.direction].raster.waves[of.wave].*(of.part) += change;
                       });
    if (!sees_other_patterns(twin_))  // what those bring is rendered
      p.effect = [of](const EffectInput& in, std::vector<float>& irradiance) {
        add_wave(of, in, irradiance);
      };
    p.smallest = -1.0, p.largest = 1.0;  // as the file takes them
  }

  void add_pitch(std::size_t d) {
    const double pitch_px = raster_of(d).pitch_px;
    Parameter& p = add(name_of(d) + "pitch_px", "px", pitch_px, 1e-6,
                       [d](Twin& t, double change) { t.fringes.directions[d].raster.pitch_px += change; });
    p.smallest = pitch_px - kRasterMayBeOffPx, p.largest = pitch_px + kRasterMayBeOffPx;
  }

  const Twin& twin_;
};

}  // namespace

std::vector<Parameter> raster_parameters(const Twin& twin) {
  if (!twin.projector || twin.projector->pixel_structure || twin.has_subsurface() || twin.fringes.steps == 0)
    return {};
  return RasterList(twin).run();
}

void find_waves(render::Renderer& renderer, const Twin& twin, int points, std::vector<GridSamples>& samples) {
  const Twin all = with_waves(twin, {});
  if (!all.projector || !all.fringes.has_raster()) return;
  const Twin view = render::showing_waves(all);
  for (GridSamples& s : samples) s.waves = render_unit_sums(renderer, view, s, points);
}

}  // namespace fringetwin::compare
