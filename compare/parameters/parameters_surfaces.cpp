// SPDX-License-Identifier: Apache-2.0
#include "compare/parameters/parameters_surfaces.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "compare/parameters/closed_columns.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kSmoothest = 0.05;  ///< roughness: a lobe of 0.3 degrees
constexpr double kLeastShininess = 0.5, kMostShininess = 1e4;
constexpr double kDarkest = 0.01;  ///< factor on all reflectivities

/// Returns whether light below surfaces can be rendered.
bool can_have_subsurface(const Twin& twin) {
  const Projector& p = *twin.projector;
  return !p.pixel_structure && !p.optics && twin.fringes.images.empty() && !twin.fringes.has_raster();
}

class SurfaceParameters : private GroupList {
 public:
  SurfaceParameters(const Twin& twin, std::string group) : GroupList(std::move(group)), twin_(twin) {}

  std::vector<Parameter> run() {
    if (group_ == "albedo") add_albedo();
    if (group_ == "specular") add_specular();
    if (group_ == "roughness") add_roughness();
    if (group_ == "subsurface") add_subsurface();
    if (group_ == "bounce") add_bounce();
    if (group_ == "gloss") add_gloss();
    if (group_ == "bounce_albedo") add_bounce_albedo();
    return std::move(list_);
  }

 private:
  void add_albedo() {
    for (std::size_t k = 0; k < twin_.objects.size(); ++k) {
      Parameter& p = add(twin_.objects[k].name + ".diffuse", "", twin_.objects[k].material.diffuse, 0.01,
                         [k](Twin& t, double d) { t.objects[k].material.diffuse += d; });
      p.smallest = 1e-6;
      if (all_light_is_diffuse()) p.effect = factor_effect();
    }
  }

  /// Returns whether all light of the images is in proportion to the reflectivity of the only object.
  bool all_light_is_diffuse() const {
    return twin_.objects.size() == 1 && twin_.objects[0].material.specular == 0.0 &&
           twin_.objects[0].material.diffuse > 0.0 && twin_.render.bounces == 0 && twin_.projector &&
           twin_.projector->ambient == 0.0 &&
           std::ranges::none_of(twin_.cameras, [](const Camera& c) { return c.texture != nullptr; });
  }

  /// The shininess is held: of a weak gloss it cannot be told.
  void add_specular() {
    for (std::size_t k = 0; k < twin_.objects.size(); ++k) {
      Parameter& p = add(twin_.objects[k].name + ".specular", "", twin_.objects[k].material.specular, 0.01,
                         [k](Twin& t, double d) { t.objects[k].material.specular += d; });
      p.smallest = 0.0;
    }
  }

  /// How wide the lobe of a glossy object is.
  void add_roughness() {
    for (std::size_t k = 0; k < twin_.objects.size(); ++k) {
      const Material& material = twin_.objects[k].material;
      if (material.specular == 0.0) continue;
      if (material.specular_model == Material::Specular::ggx) {
        Parameter& p = add(twin_.objects[k].name + ".roughness", "", material.roughness, 0.02,
                           [k](Twin& t, double d) { t.objects[k].material.roughness += d; });
        p.smallest = std::min(kSmoothest, p.start);
        p.largest = 1.0;
      } else {
        Parameter& p =
            add(twin_.objects[k].name + ".shininess", "", material.shininess, 0.05 * material.shininess,
                [k](Twin& t, double d) { t.objects[k].material.shininess += d; });
        p.smallest = std::min(kLeastShininess, p.start);
        p.largest = std::max(kMostShininess, p.start);
      }
    }
  }

  /// From none at all the contrast falls with the square of the path, and the fringes move with it.
  void add_subsurface() {
    if (!twin_.projector || !can_have_subsurface(twin_)) return;
    for (std::size_t k = 0; k < twin_.objects.size(); ++k) {
      if (twin_.objects[k].material.diffuse == 0.0) continue;
      Parameter& p =
          add(twin_.objects[k].name + ".mean_free_path_mm", "mm", twin_.objects[k].material.mean_free_path_mm,
              0.05, [k](Twin& t, double d) { t.objects[k].material.mean_free_path_mm += d; });
      p.smallest = 0.0;
      p.largest = kLongestFreePathMm;
    }
  }

  /// Two convex bodies, or one mesh, can light each other; one sphere, plane or cylinder cannot.
  bool surfaces_light_each_other() const {
    const bool alone =
        twin_.objects.size() == 1 &&
        !std::visit([]<class S>(const S&) { return S::kLightsItself; }, twin_.objects[0].shape);
    return twin_.projector && !alone && !twin_.objects.empty() && !twin_.fringes.has_harmonics_field();
  }

  /// The logarithm of a factor on all reflectivities, with as much less light: what comes straight stays as
  /// it is, and the gain does not know of it.
  void add_bounce_albedo() {
    if (!surfaces_light_each_other()) return;
    double most = 0.0;
    for (const Object& object : twin_.objects) most = std::max(most, object.material.diffuse);
    if (most == 0.0) return;
    Parameter& p = add("bounces.log_albedo", "", 0.0, 0.05, [](Twin& t, double d) {
      const double factor = std::exp(d);
      for (Object& object : t.objects) {
        object.material.diffuse *= factor;
        object.material.specular *= factor;
      }
      t.projector->intensity /= factor;
      t.room.lamp_world /= factor;
    });
    p.smallest = std::log(kDarkest);
    p.largest = -std::log(most);
  }

  void add_bounce() {
    if (!surfaces_light_each_other()) return;
    Parameter& p = add("bounces", "", twin_.render.bounces > 0 ? 1.0 : 0.0, 1.0, [](Twin& t, double d) {
      if (d >= 0.5 && t.render.bounces == 0) t.render.bounces = kAllBounces;  // as surfaces do
      if (d <= -0.5) t.render.bounces = 0;
    });
    p.is_switch = true;
    p.smallest = 0.0;
    p.largest = 1.0;
  }

  /// Surfaces that shine send light to others by their lobes, too; with it goes all light between surfaces.
  void add_gloss() {
    const bool shiny =
        std::ranges::any_of(twin_.objects, [](const Object& o) { return o.material.specular > 0.0; });
    if (!shiny || !surfaces_light_each_other()) return;
    Parameter& p =
        add("bounces.glossy", "", twin_.render.glossy_bounces ? 1.0 : 0.0, 1.0, [](Twin& t, double d) {
          if (d >= 0.5 && t.render.bounces == 0) t.render.bounces = kAllBounces;
          if (d >= 0.5) t.render.glossy_bounces = true;
          if (d <= -0.5) t.render.glossy_bounces = false;
        });
    p.is_switch = true;
    p.smallest = 0.0;
    p.largest = 1.0;
  }

  const Twin& twin_;
};

}  // namespace

std::vector<Parameter> surface_parameters(const Twin& twin, const std::string& group) {
  return SurfaceParameters(twin, group).run();
}

}  // namespace fringetwin::compare
