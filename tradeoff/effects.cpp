// SPDX-License-Identifier: Apache-2.0
#include "tradeoff/effects.hpp"

#include <algorithm>

namespace fringetwin::tradeoff {
namespace {

bool any_camera(const Twin& twin, const std::function<bool(const Camera&)>& has) {
  return std::any_of(twin.cameras.begin(), twin.cameras.end(), has);
}

/// Gives the sensor the same range in 16 bits: rounding shrinks to 2^-(16 - bits) of a gray level; noise
/// keeps its size.
void widen_sensor(Sensor& sensor) {
  const double scale = static_cast<double>(1 << (16 - sensor.bit_depth));
  sensor.bit_depth = 16;
  sensor.gain_dn *= scale;
  sensor.black_level_dn *= scale;
  if (sensor.electrons_per_dn) *sensor.electrons_per_dn /= scale;
  if (sensor.read_noise_dn) *sensor.read_noise_dn *= scale;
}

/// True for one analytic object that cannot shade itself: the renderer leaves the shadow rays off by itself.
bool hides_nothing(const Twin& twin) {
  return twin.objects.size() == 1 && !shades_itself(twin.objects[0].shape);
}

Effect pixel_area() {
  return {"pixel area",
          EffectStage::light,
          "one ray through the pixel's centre",
          [](const Twin& t) { return t.render.samples != 1; },
          [](Twin& t) {
            t.render.samples = 1;
            t.render.sampler = Sampler::gauss;
          },
          "[render] pixel_fill (1: the whole pixel); always on unless samples = 1"};
}

Effect shadow() {
  return {"shadow",
          EffectStage::light,
          "nothing hides a point from the projector",
          [](const Twin& t) { return t.render.shadow && !t.objects.empty() && !hides_nothing(t); },
          [](Twin& t) { t.render.shadow = false; },
          "[render] shadow = true; needs a second object or a shape that can shade itself"};
}

Effect depth_of_field() {
  return {"depth of field",
          EffectStage::light,
          "pinhole cameras",
          [](const Twin& t) { return any_camera(t, [](const Camera& c) { return c.optics.has_value(); }); },
          [](Twin& t) {
            for (Camera& c : t.cameras) c.optics.reset();
          },
          "[camera.optics] f_number, focal_length_mm, focus_distance_mm"};
}

Effect specular() {
  return {"specular lobe",
          EffectStage::light,
          "diffuse surfaces",
          [](const Twin& t) {
            return std::any_of(t.objects.begin(), t.objects.end(),
                               [](const Object& o) { return o.material.specular > 0.0; });
          },
          [](Twin& t) {
            for (Object& o : t.objects) o.material.specular = 0.0;
          },
          "[object.material] specular, shininess; or specular_model = \"ggx\", roughness"};
}

bool has_map(const Object& o) {
  return std::visit([](const auto& shape) { return has_albedo(shape); }, o.shape);
}

Effect albedo() {
  return {"albedo map",
          EffectStage::light,
          "one reflectivity per object",
          [](const Twin& t) { return std::any_of(t.objects.begin(), t.objects.end(), has_map); },
          [](Twin& t) {
            for (Object& o : t.objects)
              if (has_map(o)) std::visit([](auto& shape) { remove_albedo(shape); }, o.shape);
          },
          "albedo_file of a plane; a measured shape has its own"};
}

Effect interreflection() {
  return {"interreflection",
          EffectStage::light,
          "no light from surface to surface",
          [](const Twin& t) { return t.render.bounces > 0; },
          [](Twin& t) { t.render.bounces = 0; },
          "[render] bounces = 1"};
}

/// Makes an effect of every camera.
Effect of_cameras(const std::string& name, const std::string& without,
                  const std::function<bool(const Camera&)>& is_on,
                  const std::function<void(Camera&)>& switch_off, const std::string& switch_on) {
  return {name,
          EffectStage::light,
          without,
          [is_on](const Twin& t) { return any_camera(t, is_on); },
          [switch_off](Twin& t) {
            for (Camera& c : t.cameras) switch_off(c);
          },
          switch_on};
}

Effect noise() {
  return {"sensor noise",
          EffectStage::sensor,
          "a sensor without shot and read noise",
          [](const Twin& t) { return any_camera(t, [](const Camera& c) { return c.sensor.has_noise(); }); },
          [](Twin& t) {
            for (Camera& c : t.cameras) {
              c.sensor.electrons_per_dn.reset();
              c.sensor.read_noise_dn.reset();
            }
          },
          "[camera.sensor] electrons_per_dn, read_noise_dn"};
}

Effect quantisation() {
  return {
      "sensor rounding",
      EffectStage::sensor,
      "16 bits over the same range",
      [](const Twin& t) { return any_camera(t, [](const Camera& c) { return c.sensor.bit_depth < 16; }); },
      [](Twin& t) {
        for (Camera& c : t.cameras) widen_sensor(c.sensor);
      },
      "[camera.sensor] bit_depth below 16"};
}

/// Makes an effect of the projector, which a twin may lack.
Effect of_projector(const std::string& name, const std::string& without,
                    const std::function<bool(const Projector&)>& is_on,
                    const std::function<void(Projector&)>& switch_off, const std::string& switch_on) {
  return {name,
          EffectStage::light,
          without,
          [is_on](const Twin& t) { return t.projector && is_on(*t.projector); },
          [switch_off](Twin& t) {
            if (t.projector) switch_off(*t.projector);
          },
          switch_on};
}

/// Says of an effect that the closed form of the noise counts with it.
Effect in_noise_theory(Effect effect) {
  effect.in_noise_theory = true;
  return effect;
}

std::vector<Effect> make_effects() {
  return {
      in_noise_theory(pixel_area()),
      shadow(),
      depth_of_field(),
      of_cameras(
          "point spread", "lenses without blur", [](const Camera& c) { return c.psf_px > 0.0; },
          [](Camera& c) { c.psf_px = 0.0; }, "[camera.NAME] psf_px"),
      of_cameras(
          "vignetting", "lenses as bright in the corners",
          [](const Camera& c) { return c.vignetting.kind != Vignetting::Kind::none; },
          [](Camera& c) { c.vignetting = {}; }, "[camera.NAME] vignetting"),
      specular(),
      albedo(),
      interreflection(),
      in_noise_theory(of_projector(
          "ambient light", "a dark room", [](const Projector& p) { return p.ambient > 0.0; },
          [](Projector& p) { p.ambient = 0.0; }, "[projector] ambient")),
      in_noise_theory(of_projector(
          "projector falloff", "the same light at every distance",
          [](const Projector& p) { return p.inverse_square; }, [](Projector& p) { p.inverse_square = false; },
          "[projector] falloff = \"inverse-square\", reference_distance_mm")),
      in_noise_theory(of_projector(
          "projector blur", "a sharp projector", [](const Projector& p) { return p.blur_px > 0.0; },
          [](Projector& p) { p.blur_px = 0.0; }, "[projector] blur_px")),
      of_projector(
          "projector response", "a linear projector",
          [](const Projector& p) { return p.response.kind != ProjectorResponse::Kind::linear; },
          [](Projector& p) { p.response = {}; },
          "[projector] response = { gamma = 2.2 } or { table = [...] }"),
      of_projector(
          "projector defocus", "the projector's lens without depth of field",
          [](const Projector& p) { return p.optics.has_value(); }, [](Projector& p) { p.optics.reset(); },
          "[projector.optics] f_number, focal_length_mm, focus_distance_mm"),
      of_projector(
          "projector pixels", "patterns continuous between the projector's pixels",
          [](const Projector& p) { return p.pixel_structure; },
          [](Projector& p) { p.pixel_structure = false; }, "[projector] pixel_structure = true"),
      of_projector(
          "pattern rounding", "patterns of any gray value",
          [](const Projector& p) { return p.quantise_bits.has_value(); },
          [](Projector& p) { p.quantise_bits.reset(); }, "[projector] quantise_bits = 8"),
      in_noise_theory(noise()),
      in_noise_theory(quantisation()),
  };
}

}  // namespace

const std::vector<Effect>& effects() {
  static const std::vector<Effect> table = make_effects();
  return table;
}

}  // namespace fringetwin::tradeoff
