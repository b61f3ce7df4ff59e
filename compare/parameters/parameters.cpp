// SPDX-License-Identifier: Apache-2.0
#include "compare/parameters/parameters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

#include "compare/parameters/camera_curves.hpp"
#include "compare/parameters/closed_columns.hpp"
#include "compare/parameters/harmonic_parts.hpp"
#include "compare/parameters/parameters_geometry.hpp"
#include "compare/parameters/parameters_surfaces.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::compare {
namespace {

using Change = std::function<void(Twin&, double)>;

/// Of the group harmonics_high: the orders that twin.toml holds, with steps that tell all lower ones.
constexpr int kStepsForHigh = kMostHarmonics + 2, kMostHigh = 16;
constexpr double kSmallestContrast = 1e-3;
constexpr double kLeastBlurOfHaloPx2 = 0.01;
constexpr double kLeastBlurPx2 = 1e-6;  ///< where the field of a blur is narrowest

/// Adds to what a harmonic has more per term of the field, of the fringes of every direction.
void add_to_field(Twin& twin, std::size_t term, int order, double Harmonic::*part, double change) {
  for (DirectionFringes& d : twin.fringes.directions) {
    d.harmonics_field.resize(kHarmonicsFieldTerms);
    add_to_part(d.harmonics_field[term], order, part, change);
  }
}

constexpr double kMostLightInHalo = 0.9;  ///< in all of its parts
constexpr double kMostHaloGrowth = 8.0;   ///< of a part's width in one refinement
/// Widths that a halo begins with where the twin has none: beside the blur, and of light that lenses scatter.
constexpr double kNearPerBlur = 4.0, kFarPx = 30.0;
constexpr double kSharper = 0.5;       ///< times its width: a blur that is fitted beside a halo from none
constexpr double kLittleLight = 0.05;  ///< in a part of a halo that a fit begins with

bool has_code(const Twin& twin) {
  return std::ranges::any_of(expand_sequence(twin.fringes), &PatternSpec::is_gray);
}

/// Returns whether a halo of the projector can be rendered.
bool can_have_halo(const Twin& twin) {
  const Projector& p = *twin.projector;
  const bool gaps = p.pixel_structure && p.pixel_fill < 1.0;
  return p.blur_px > 0.0 && !gaps && twin.fringes.images.empty() && !(p.has_blur_field() && has_code(twin));
}

constexpr std::array kTermsOfBlurField{"u", "v", "u2", "uv", "v2"};  ///< order of blur_field_px2

/// Returns whether a blur that varies over the projector's image can be rendered.
bool can_have_blur_field(const Twin& twin) {
  const Projector& p = *twin.projector;
  return p.blur_px > 0.0 && !p.pixel_structure && !p.optics && twin.fringes.images.empty() && !has_code(twin);
}

/// Returns whether several pitches tell how light is spread: by what they lose of their contrast.
bool has_pitches(const Twin& twin) {
  return std::ranges::any_of(twin.fringes.directions,
                             [](const DirectionFringes& d) { return d.pitches_px.size() > 1; });
}

/// Lists what light does.
class ParameterList : private GroupList {
 public:
  ParameterList(const Twin& twin, std::string group) : GroupList(std::move(group)), twin_(twin) {}

  std::vector<Parameter> run() {
    if (group_ == "response") add_response();
    if (group_ == "harmonics") add_harmonics();
    if (group_ == "harmonics_high" && twin_.projector && twin_.fringes.steps >= kStepsForHigh)
      add_orders(kMostHarmonics + 1, kMostHigh);
    if (group_ == "harmonics_field") add_harmonics_field();
    if (group_ == "contrast") add_contrast();
    if (group_ == "fringe_contrast") add_contrast_of_all();
    if (group_ == "blur") add_blur();
    if (group_ == "blur_field") add_blur_field();
    if (group_ == "halo") add_halo();
    if (group_ == "vignetting") add_vignetting();
    if (group_ == "lamp") add_lamp();
    return std::move(list_);
  }

 private:
  void add_response() {
    if (!twin_.projector || twin_.projector->response.kind == ProjectorResponse::Kind::table) return;
    const ProjectorResponse& r = twin_.projector->response;
    Parameter& p = add("projector.gamma", "", r.kind == ProjectorResponse::Kind::gamma ? r.gamma : 1.0, 0.01,
                       [](Twin& t, double d) {
                         ProjectorResponse& response = t.projector->response;
                         response.gamma =
                             (response.kind == ProjectorResponse::Kind::gamma ? response.gamma : 1.0) + d;
                         response.kind = ProjectorResponse::Kind::gamma;
                       });
    p.smallest = 0.2;
    p.largest = 5.0;
  }

  /// The light a_k cos(kt) + b_k sin(kt), k = 2 ..., that the fringes have besides what is shown, the same of
  /// all pitches (they are told together; those of a twin that differ stay as far apart). With few steps
  /// their orders cannot be told from the fundamental.
  void add_harmonics() {
    if (!twin_.projector || twin_.fringes.steps < kStepsForHarmonics) return;
    add_orders(2, std::min(kMostHarmonics, twin_.fringes.steps - 2));
  }

  /// Adds both parts of the harmonics of these orders. An order above the number of steps is told from the
  /// lower one that it looks like in a pixel by how both go on from pixel to pixel.
  void add_orders(int first, int last) {
    for (int k = first; k <= last; ++k)
      for (double Harmonic::*part : {&Harmonic::cosine, &Harmonic::sine})
        list_.push_back(harmonic_parameter(twin_, k, part)), list_.back().group = group_;
  }

  /// What these have more away from the middle of the projector's image: of each order five terms.
  void add_harmonics_field() {
    const int most = std::min(kMostHarmonics, twin_.fringes.steps - 2);
    if (!twin_.projector || twin_.fringes.steps < kStepsForHarmonics || twin_.render.bounces > 0 ||
        twin_.projector->pixel_structure)
      return;
    const std::vector<Harmonics>& field = twin_.fringes.directions.front().harmonics_field;
    for (std::size_t t = 0; t < kHarmonicsFieldTerms; ++t)
      for (int k = 2; k <= most; ++k)
        for (double Harmonic::*part : {&Harmonic::cosine, &Harmonic::sine}) {
          const double start = t < field.size() ? harmonic_part(field[t], k, part) : 0.0;
          const LegendreOrders& orders = kLightFieldTerms[t];
          Parameter& p =
              add(fmt::format("projector.harmonics_field.{}_{}.{}{}", orders[0], orders[1], k,
                              name_of_part(part)),
                  "", start, 1e-3, [t, k, part](Twin& twin, double d) { add_to_field(twin, t, k, part, d); });
          p.smallest = -1.0, p.largest = 1.0;  // as the file takes them
          p.does_as = std::make_shared<Parameter>(harmonic_parameter(twin_, k, part));
          p.times = [projector = *twin_.projector, t](const Eigen::Vector2d& px) {
            return projector.field_terms(px)[t];
          };
        }
  }

  /// What all fringes keep of their contrast, shown as that of the widest pitch of the first direction. On an
  /// even surface a gain and a black level do the same.
  void add_contrast_of_all() {
    if (!twin_.projector || twin_.fringes.steps == 0) return;
    const DirectionFringes& first = twin_.fringes.directions.front();
    const auto widest =
        static_cast<std::size_t>(std::ranges::max_element(first.pitches_px) - first.pitches_px.begin());
    const double start = first.contrast_of(widest);
    std::vector<std::vector<double>> shares;  // of each pitch, of what the widest one changes by
    double most = 1.0;
    for (const DirectionFringes& direction : twin_.fringes.directions) {
      std::vector<double>& of_direction = shares.emplace_back();
      for (std::size_t p = 0; p < direction.pitches_px.size(); ++p)
        of_direction.push_back(direction.contrast_of(p) / start);
      most = std::max(most, std::ranges::max(of_direction));
    }
    Parameter& parameter =
        add("projector.fringe_contrast", "", start, 0.01, [shares](Twin& t, double change) {
          for (std::size_t d = 0; d < shares.size(); ++d) {
            std::vector<double>& contrast = t.fringes.directions[d].contrast;
            contrast.resize(shares[d].size(), 1.0);
            for (std::size_t p = 0; p < contrast.size(); ++p) contrast[p] += change * shares[d][p];
          }
        });
    parameter.smallest = kSmallestContrast;
    parameter.largest = kLargestContrast / most;
  }

  /// Of every pitch but the widest one of the first direction: what all pitches share is fringe_contrast's.
  void add_contrast() {
    if (!twin_.projector || twin_.fringes.steps == 0) return;
    for (std::size_t d = 0; d < twin_.fringes.directions.size(); ++d) {
      const DirectionFringes& direction = twin_.fringes.directions[d];
      const auto widest = std::ranges::max_element(direction.pitches_px) - direction.pitches_px.begin();
      for (std::size_t p = 0; p < direction.pitches_px.size(); ++p) {
        if (d == 0 && static_cast<std::ptrdiff_t>(p) == widest) continue;
        Parameter& parameter =
            add(fmt::format("projector.contrast.{}.{}", axis_name(direction.axis), direction.pitches_px[p]),
                "", direction.contrast_of(p), 0.01, [d, p](Twin& t, double change) {
                  DirectionFringes& changed = t.fringes.directions[d];
                  changed.contrast.resize(changed.pitches_px.size(), 1.0);
                  changed.contrast[p] += change;
                });
        parameter.smallest = kSmallestContrast;
        parameter.largest = kLargestContrast;
      }
    }
  }

  /// Contrast falls with the square of the width, so that is what is fitted.
  void add_blur() {
    if (!twin_.projector) return;
    const double sigma_px = twin_.projector->blur_px;
    Parameter& p = add("projector.blur_px", "px", sigma_px * sigma_px, 0.05, [](Twin& t, double d) {
      double& blur_px = t.projector->blur_px;
      blur_px = std::sqrt(std::max(0.0, blur_px * blur_px + d));
    });
    p.is_variance = true;
    // with a field, the narrowest place must keep a blur
    const double least_px = twin_.projector->least_blur_px();
    p.smallest = twin_.projector->has_blur_field() ? sigma_px * sigma_px - least_px * least_px + kLeastBlurPx2
                 : twin_.projector->has_halo()
                     ? std::min(kLeastBlurOfHaloPx2, p.start)  // tables' samples grow with 1/blur
                     : 0.0;
  }

  /// The terms of the quadratic that the blur's variance varies by over the projector's image.
  void add_blur_field() {
    if (!twin_.projector || !can_have_blur_field(twin_)) return;
    for (std::size_t k = 0; k < kTermsOfBlurField.size(); ++k)
      add(fmt::format("projector.blur_field_px2.{}", kTermsOfBlurField[k]), "px2",
          twin_.projector->blur_field_px2[k], 0.05,
          [k](Twin& t, double d) { t.projector->blur_field_px2[k] += d; });
  }

  /// Share and width of each part of the halo that the twin has, be they without light (with_empty_halo()).
  void add_halo() {
    if (!twin_.projector || !can_have_halo(twin_) || !(has_code(twin_) || has_pitches(twin_))) return;
    const std::vector<Halo>& parts = twin_.projector->halo;
    double in_all = 0.0;
    for (const Halo& part : parts) in_all += part.share;
    for (std::size_t k = 0; k < parts.size(); ++k) {
      if (parts[k].sigma_px == 0.0) continue;
      Parameter& share = add(fmt::format("projector.halo.{}.share", k + 1), "", parts[k].share, 0.01,
                             [k](Twin& t, double d) { t.projector->halo.at(k).share += d; });
      share.smallest = 0.0;
      share.largest =
          share.start + std::max(0.0, kMostLightInHalo - in_all) / static_cast<double>(parts.size());
      const double sigma_px = parts[k].sigma_px;
      Parameter& width =
          add(fmt::format("projector.halo.{}.sigma_px", k + 1), "px", sigma_px, 0.05 * sigma_px,
              [k](Twin& t, double d) { t.projector->halo.at(k).sigma_px += d; });
      width.acts_beside_others = parts[k].share == 0.0;  // no light, no width
      width.smallest = sigma_px / kMostHaloGrowth;
      width.largest = std::min(sigma_px * kMostHaloGrowth, kWidestHaloPx);
    }
  }

  void add_vignetting() {
    for (std::size_t c = 0; c < twin_.cameras.size(); ++c) {
      const Vignetting& v = twin_.cameras[c].vignetting;
      if (v.kind == Vignetting::Kind::cos4) continue;
      const auto add_factor = [&](const std::string& name, double start, Change change) {
        Parameter& p = add(twin_.cameras[c].name + name, "", start, 0.01, std::move(change));
        p.camera = c;
        p.effect = vignetting_effect(c, p.change);
      };
      for (int i = 0; i < 2; ++i)
        add_factor(fmt::format(".vignetting_tilt.{}", "xy"[i]), v.tilt[i], [c, i](Twin& t, double d) {
          Vignetting& changed = t.cameras[c].vignetting;
          changed.kind = Vignetting::Kind::polynomial;
          changed.tilt[i] += d;
        });
      add_factor(".vignetting.a1", v.a[0], [c](Twin& t, double d) {
        t.cameras[c].vignetting.kind = Vignetting::Kind::polynomial;
        t.cameras[c].vignetting.a[0] += d;
      });
    }
  }

  /// From no lamp at all there is no way to one: what it would light is not known.
  void add_lamp() {
    if (!twin_.projector || !twin_.room.has_lamp()) return;
    const double step = 0.01 * twin_.room.lamp_world.norm();
    for (int i = 0; i < 3; ++i)
      add(fmt::format("room.lamp.{}", "xyz"[i]), "", twin_.room.lamp_world[i], step,
          [i](Twin& t, double d) { t.room.lamp_world[i] += d; });
  }

  const Twin& twin_;
};

/// Returns r^4 and r^6 of each camera's vignetting. The search for causes goes without, and so does the group
/// where the twin has none: over images that are lit unevenly they do much of what r^2 does.
std::vector<Parameter> vignetting_beyond_r2(const Twin& twin) {
  std::vector<Parameter> all;
  for (std::size_t c = 0; c < twin.cameras.size(); ++c) {
    const Vignetting& v = twin.cameras[c].vignetting;
    if (v.kind == Vignetting::Kind::cos4) continue;
    for (std::size_t i = 1; i < v.a.size(); ++i) {
      Parameter& p = all.emplace_back();
      p.group = "vignetting";
      p.name = fmt::format("{}.vignetting.a{}", twin.cameras[c].name, i + 1);
      p.start = v.a[i];
      p.step = 0.01;
      p.change = [c, i](Twin& t, double d) {
        t.cameras[c].vignetting.kind = Vignetting::Kind::polynomial;
        t.cameras[c].vignetting.a[i] += d;
      };
      p.camera = c;
      p.effect = vignetting_effect(c, p.change);
      p.only_by_name = v.a[i] == 0.0;
    }
  }
  return all;
}

}  // namespace

std::vector<Parameter> parameters_of(const Twin& twin, const std::string& group,
                                     const std::vector<int>& use_steps) {
  // pitches alone tell a halo from the blur where nothing else differs, and that is for `--refine`
  if (group == "halo" && !has_code(twin)) return {};
  std::vector<Parameter> all = geometry_parameters(twin, group);
  for (Parameter& p : surface_parameters(twin, group)) all.push_back(std::move(p));
  for (Parameter& p : ParameterList(twin, group).run()) all.push_back(std::move(p));
  for (Parameter& p : closed_parameters(twin, group, use_steps)) {
    if (p.instead.empty()) p.instead = parameter_group(group).instead;
    all.push_back(std::move(p));
  }
  return all;
}

std::vector<Parameter> refinable_parameters_of(const Twin& twin, const std::string& group,
                                               const std::vector<int>& use_steps) {
  if (group == "motion") return motion_parameters(twin);
  if (group == "halo") return ParameterList(twin, group).run();
  if (group == "camera_response") {
    std::vector<Parameter> all;
    for (std::size_t c = 0; c < twin.cameras.size(); ++c)
      std::ranges::move(bend_parameters(twin, c), std::back_inserter(all));
    return all;
  }
  std::vector<Parameter> all = parameters_of(twin, group, use_steps);
  if (group == "vignetting") std::ranges::move(vignetting_beyond_r2(twin), std::back_inserter(all));
  return all;
}

Twin with_empty_halo(const Twin& twin) {
  if (!twin.projector || twin.projector->has_halo() || !can_have_halo(twin)) return twin;
  Twin out = twin;
  const double near_px = kNearPerBlur * twin.projector->blur_px;
  out.projector->halo = {{.share = 0.0, .sigma_px = near_px},
                         {.share = 0.0, .sigma_px = std::max(kFarPx, kNearPerBlur * near_px)}};
  return out;
}

Eigen::VectorXd with_light_in_halo(const std::vector<Parameter>& parameters, Eigen::VectorXd values) {
  std::size_t n_parts = 0, n_empty = 0;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    if (parameters[k].group != "halo" || !parameters[k].name.ends_with(".share")) continue;
    double& share = values[static_cast<Eigen::Index>(k)];
    ++n_parts;
    if (share == 0.0) share = kLittleLight, ++n_empty;
  }
  const auto blur = std::ranges::find(parameters, "projector.blur_px", &Parameter::name),
             near = std::ranges::find(parameters, "projector.halo.1.sigma_px", &Parameter::name);
  const bool is_from_none = n_empty > 0 && n_empty == n_parts;
  if (!is_from_none || blur == parameters.end() || near == parameters.end()) return values;
  // A blur without a halo was made to stand for both: from it the fit ends in a wrong minimum.
  double& variance_px2 = values[blur - parameters.begin()];
  variance_px2 = std::max(blur->smallest, kSharper * kSharper * variance_px2);
  values[near - parameters.begin()] *= kSharper;
  return values;
}

void drop_empty_halo(Twin& twin) {
  if (twin.projector) std::erase_if(twin.projector->halo, [](const Halo& h) { return h.share == 0.0; });
}

Twin with_values(const Twin& twin, const std::vector<Parameter>& parameters, const Eigen::VectorXd& values) {
  Twin out = twin;
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (const double d = values[i] - parameters[i].start; d != 0.0 && parameters[i].change)
      parameters[i].change(out, d);
  for (Object& object : out.objects) std::visit([](auto& shape) { make_units(shape); }, object.shape);
  return out;
}

Eigen::VectorXd start_values(const std::vector<Parameter>& parameters) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t i = 0; i < parameters.size(); ++i) values[i] = parameters[i].start;
  return values;
}

}  // namespace fringetwin::compare
