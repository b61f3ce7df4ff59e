// SPDX-License-Identifier: Apache-2.0
#include "study/noise/theory_scope.hpp"

#include <fmt/format.h>

#include <variant>

#include "twin/effects.hpp"

namespace fringetwin::study {
namespace {

std::string outside_of_object(const Object& object) {
  const auto* plane = std::get_if<PlaneShape>(&object.shape);
  if (plane == nullptr && !std::holds_alternative<SphereShape>(object.shape))
    return std::string("objects of shape ") + shape_kind(object.shape);
  if (object.material.specular > 0.0)
    return fmt::format("object.{}.material.specular = {}", object.name, object.material.specular);
  if (plane != nullptr && !plane->albedo_file.empty())
    return fmt::format("object.{}.albedo_file = \"{}\"", object.name, plane->albedo_file.string());
  return "";
}

std::string outside_of_fringes(const Fringes& fringes) {
  if (fringes.directions.size() != 1)
    return fmt::format("fringes in {} directions (fringes.directions)", fringes.directions.size());
  if (fringes.directions[0].gray) return "Gray code (fringes.gray)";
  return fringes.steps < 4 ? fmt::format("fringes.steps = {}", fringes.steps) : "";
}

std::string outside_of_projector(const Projector& projector) {
  if (projector.response.kind != ProjectorResponse::Kind::linear) return "projector.response, not linear";
  if (projector.optics) return fmt::format("projector.optics.f_number = {}", projector.optics->f_number);
  return projector.pixel_structure ? "projector.pixel_structure = true" : "";
}

std::string outside_of_camera(const Camera& camera) {
  if (camera.optics)
    return fmt::format("camera.{}.optics.f_number = {}", camera.name, camera.optics->f_number);
  if (camera.psf_px > 0.0) return fmt::format("camera.{}.psf_px = {}", camera.name, camera.psf_px);
  const bool dark_corners = camera.vignetting.kind != Vignetting::Kind::none;
  return dark_corners ? fmt::format("camera.{}.vignetting", camera.name) : "";
}

std::string outside_of_options(const Twin& twin) {
  const int bounces = twin.render.bounces;
  if (bounces > 0)
    return "render.bounces = " + (bounces == kAllBounces ? "\"all\"" : std::to_string(bounces));
  return twin.measure.smoothing_px > 0.0 ? fmt::format("measure.smoothing_px = {}", twin.measure.smoothing_px)
                                         : "";
}

std::string outside_of_effects(const Twin& twin) {
  for (const Effect& effect : effects())
    if (effect.is_on(twin) && !effect.in_noise_theory)
      return fmt::format("{} ({})", effect.name, effect.switch_on);
  return "";
}

}  // namespace

std::string outside_noise_theory(const Twin& twin, const std::string& name) {
  const Object* object = twin.find_object(name);
  if (object == nullptr) return "the object \"" + name + "\"";
  if (twin.objects.size() != 1) return fmt::format("{} objects in a scene", twin.objects.size());
  if (!twin.projector) return "a rig without projector";
  std::string outside = outside_of_object(*object);
  if (outside.empty()) outside = outside_of_fringes(twin.fringes);
  if (outside.empty()) outside = outside_of_projector(*twin.projector);
  if (outside.empty()) outside = outside_of_options(twin);
  for (const Camera& camera : twin.cameras)
    if (outside.empty()) outside = outside_of_camera(camera);
  return outside.empty() ? outside_of_effects(twin) : outside;
}

}  // namespace fringetwin::study
