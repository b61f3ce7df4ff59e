// SPDX-License-Identifier: Apache-2.0
// Parameters of the harmonics that all fringes have. Each is a fringe of its own, of a part of the pitch: one
// rendering of those tells the derivatives by all of them.
#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "compare/parameters/closed_columns.hpp"
#include "compare/parameters/harmonic_parts.hpp"
#include "compare/parameters/parameters.hpp"
#include "compare/parameters/unit_sums.hpp"
#include "render/pattern/unit_fringes.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"
#include "twin/moving.hpp"

namespace fringetwin::compare {
namespace {

/// Adds to a part of a harmonic of the fringes of every pitch.
void add_to_harmonic(Twin& twin, int order, double Harmonic::*part, double change) {
  for (DirectionFringes& d : twin.fringes.directions) {
    d.harmonics.resize(d.pitches_px.size());
    for (Harmonics& list : d.harmonics) add_to_part(list, order, part, change);
  }
}

/// Returns the fringes of the orders 2 ... `highest` of every pitch.
std::vector<DirectionFringes> fringes_of_orders(const Fringes& fringes, int highest) {
  std::vector<DirectionFringes> out;
  for (const DirectionFringes& d : fringes.directions) {
    DirectionFringes& orders = out.emplace_back(DirectionFringes{d.axis, {}, {}, {}});
    for (std::size_t p = 0; p < d.pitches_px.size(); ++p)
      for (int k = 2; k <= highest; ++k) {
        orders.pitches_px.push_back(d.pitches_px[p] / k);
        orders.phase_origin_px.push_back(d.phase_origin_px[p]);
      }
  }
  return out;
}

/// Adds what a part of a harmonic brings: in the phase t + d of the step a cos(k t + k d) + b sin(k t + k d).
void add_harmonic(int order, double Harmonic::*part, const EffectInput& in, std::vector<float>& irradiance) {
  const GridSamples& s = in.samples;
  FT_CHECK(s.harmonics && order <= s.highest_harmonic, "samples that know the harmonics' fringes");
  const Fringes& fringes = in.fitted.fringes;
  const auto per_pitch = static_cast<std::size_t>(s.highest_harmonic - 1);
  std::vector<std::size_t> first_of_direction{0};
  for (const DirectionFringes& d : fringes.directions)
    first_of_direction.push_back(first_of_direction.back() + d.pitches_px.size() * per_pitch);
  const std::vector<PatternSpec> sequence = expand_sequence(fringes);
  for (std::size_t k = 0; k < s.images.size(); ++k) {
    const auto image = static_cast<std::size_t>(s.images[k]);
    const PatternSpec& spec = sequence[image];
    if (spec.kind != PatternSpec::Kind::phase_step) continue;
    const auto d = static_cast<std::size_t>(spec.direction), p = static_cast<std::size_t>(spec.pitch);
    const double angle = kTwoPi * order *
                         (static_cast<double>(spec.step) / fringes.steps -
                          in.fitted.projector->image_shift_px(image) / fringes.directions[d].pitches_px[p]);
    const double times = (in.to - in.from) * fringes.directions[d].contrast_of(p) *
                         factor_of(in.fitted.projector->light_factors, image) *
                         factor_of(in.fitted.cameras[s.camera].exposure_factors, image);
    const double c = times * std::cos(angle), sine = times * std::sin(angle);
    const std::vector<float>& sums =
        s.harmonics->at(first_of_direction[d] + p * per_pitch + static_cast<std::size_t>(order - 2));
    if (part == &Harmonic::cosine)
      add_sums(s, sums, k, c, -sine, irradiance);
    else
      add_sums(s, sums, k, sine, c, irradiance);
  }
}

}  // namespace

bool harmonics_are_fringes(const Twin& twin) {
  return twin.projector && !twin.projector->pixel_structure && !twin.has_subsurface() && !has_motion(twin) &&
         !sees_other_patterns(twin);
}

Parameter harmonic_parameter(const Twin& twin, int order, double Harmonic::*part) {
  Parameter p{.group = "harmonics",
              .name = fmt::format("projector.harmonic.{}{}", order, name_of_part(part)),
              .unit = "",
              .start = harmonic_part(twin.fringes.directions.front().harmonics_of(0), order, part),
              .step = 1e-3,
              .change = [order, part](Twin& t, double d) { add_to_harmonic(t, order, part, d); }};
  if (harmonics_are_fringes(twin)) {
    p.effect = [order, part](const EffectInput& in, std::vector<float>& irradiance) {
      add_harmonic(order, part, in, irradiance);
    };
    p.harmonic = order;
  }
  return p;
}

void find_harmonics(render::Renderer& renderer, const Twin& twin, int highest, int points,
                    std::vector<GridSamples>& samples) {
  const Twin view = render::showing_fringes(twin, fringes_of_orders(twin.fringes, highest));
  for (GridSamples& s : samples) {
    s.harmonics = render_unit_sums(renderer, view, s, points);
    s.highest_harmonic = highest;
  }
}

}  // namespace fringetwin::compare
