// SPDX-License-Identifier: Apache-2.0
#include "twin/effects.hpp"

#include <algorithm>
#include <memory>
#include <utility>

namespace fringetwin {
namespace {

/// Gives the sensor the same range in 16 bits: rounding shrinks to 2^-(16 - bits) of a gray level; noise
/// keeps its size.
void widen_sensor(Sensor& sensor) {
  const double scale = static_cast<double>(1 << (16 - sensor.bit_depth));
  sensor.bit_depth = 16;
  sensor.gain_dn *= scale;
  sensor.black_level_dn *= scale;
  if (sensor.electrons_per_dn) *sensor.electrons_per_dn /= scale;
  if (sensor.read_noise_dn) *sensor.read_noise_dn *= scale;
  sensor.response = sensor.response.scaled(scale);
  if (!sensor.dsnu.values) return;
  ImageF offsets_dn = *sensor.dsnu.values;
  for (float& offset_dn : offsets_dn.data) offset_dn *= static_cast<float>(scale);
  sensor.dsnu.values = std::make_shared<const ImageF>(std::move(offsets_dn));
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

bool has_map(const Object& o) {
  return std::visit([](const auto& shape) { return has_albedo(shape); }, o.shape);
}

void drop_map(Object& o) {
  if (has_map(o)) std::visit([](auto& shape) { remove_albedo(shape); }, o.shape);
}

Effect interreflection() {
  return {"interreflection",
          EffectStage::light,
          "no light from surface to surface",
          [](const Twin& t) { return t.render.bounces > 0; },
          [](Twin& t) { t.render.bounces = 0; },
          "[render] bounces = \"all\""};
}

Effect glossy_interreflection() {
  return {"glossy interreflection",
          EffectStage::light,
          "surfaces that light others by Lambert's law alone",
          [](const Twin& t) {
            const auto shines = [](const Object& o) { return o.material.specular > 0.0; };
            return t.render.bounces > 0 && t.render.glossy_bounces && std::ranges::any_of(t.objects, shines);
          },
          [](Twin& t) { t.render.glossy_bounces = false; },
          "[render] glossy_bounces = true, beside bounces"};
}

/// Makes an effect of every camera, or of every object: it is on where one has it.
template <class Part, class IsOn, class SwitchOff>
Effect of_each(std::vector<Part> Twin::*parts, EffectStage stage, const std::string& name,
               const std::string& without, IsOn is_on, SwitchOff switch_off, const std::string& switch_on) {
  return {name,
          stage,
          without,
          [=](const Twin& t) { return std::any_of((t.*parts).begin(), (t.*parts).end(), is_on); },
          [=](Twin& t) {
            for (Part& part : t.*parts) switch_off(part);
          },
          switch_on};
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

Effect light_per_image() {
  return {"light per image",
          EffectStage::light,
          "light and exposures that are the same in all images",
          [](const Twin& t) {
            const bool projector =
                t.projector && !(t.projector->light_factors.empty() && t.projector->ambient_factors.empty());
            return projector || std::ranges::any_of(
                                    t.cameras, [](const Camera& c) { return !c.exposure_factors.empty(); });
          },
          [](Twin& t) {
            for (Camera& camera : t.cameras) camera.exposure_factors.clear();
            if (!t.projector) return;
            t.projector->light_factors.clear();
            t.projector->ambient_factors.clear();
          },
          "[projector] light_factors, ambient_factors; [[camera]] exposure_factors"};
}

Effect shift_per_image() {
  return {"shift per image",
          EffectStage::light,
          "patterns that lie where they should in every image",
          [](const Twin& t) { return t.projector && t.projector->has_image_shifts(); },
          [](Twin& t) {
            if (t.projector) t.projector->image_shifts_px.clear();
          },
          "[projector] image_shifts_px"};
}

Effect waveform_per_image() {
  return {"waveform per image",
          EffectStage::light,
          "fringes of the same waveform in every image",
          [](const Twin& t) { return t.projector && t.fringes.steps > 0 && t.fringes.has_image_harmonics(); },
          [](Twin& t) { t.fringes.image_harmonics.clear(); },
          "[fringes] image_harmonics = [[[a1, b1], ...], ...], one list per image"};
}

Effect waves_of_raster() {
  return {"waves of the raster",
          EffectStage::light,
          "fringes without waves that their fine structure makes with the projector's pixels",
          [](const Twin& t) { return t.projector && t.fringes.steps > 0 && t.fringes.has_raster(); },
          [](Twin& t) {
            for (DirectionFringes& d : t.fringes.directions) d.raster.waves.clear();
          },
          "[fringes] raster = { pitch_px = 1, first = 41, waves = [[a41, b41], ...] }"};
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
      of_each(
          &Twin::cameras, EffectStage::light, "depth of field", "pinhole cameras",
          [](const Camera& c) { return c.optics.has_value(); }, [](Camera& c) { c.optics.reset(); },
          "[camera.optics] f_number, focal_length_mm, focus_distance_mm"),
      of_each(
          &Twin::cameras, EffectStage::light, "point spread", "lenses without blur",
          [](const Camera& c) { return c.psf_px > 0.0; }, [](Camera& c) { c.psf_px = 0.0; },
          "[camera.NAME] psf_px"),
      of_each(
          &Twin::cameras, EffectStage::light, "vignetting", "lenses as bright in the corners",
          [](const Camera& c) { return c.vignetting.kind != Vignetting::Kind::none; },
          [](Camera& c) { c.vignetting = {}; }, "[camera.NAME] vignetting"),
      of_each(
          &Twin::cameras, EffectStage::light, "texture of pixels",
          "pixels that all see the same of the light", [](const Camera& c) { return c.texture != nullptr; },
          [](Camera& c) { c.texture = nullptr; }, "[camera.NAME] texture = \"FILE.exr\""),
      of_each(
          &Twin::cameras, EffectStage::light, "texture within a pixel",
          "a texture whose changes move no fringes",
          [](const Camera& c) { return c.texture_spread_px > 0.0; },
          [](Camera& c) { c.texture_spread_px = 0.0; }, "[camera.NAME] texture_spread_px"),
      of_each(
          &Twin::objects, EffectStage::light, "specular lobe", "diffuse surfaces",
          [](const Object& o) { return o.material.specular > 0.0; },
          [](Object& o) { o.material.specular = 0.0; },
          "[object.material] specular, shininess; or specular_model = \"ggx\", roughness"),
      of_each(
          &Twin::objects, EffectStage::light, "subsurface light",
          "diffuse light that leaves where it came in",
          [](const Object& o) { return o.material.mean_free_path_mm > 0.0; },
          [](Object& o) { o.material.mean_free_path_mm = 0.0; }, "[object.material] mean_free_path_mm"),
      of_each(&Twin::objects, EffectStage::light, "albedo map", "one reflectivity per object", has_map,
              drop_map, "albedo_file of a plane; a measured shape has its own"),
      interreflection(),
      glossy_interreflection(),
      in_noise_theory(of_projector(
          "ambient light", "a dark room", [](const Projector& p) { return p.ambient > 0.0; },
          [](Projector& p) { p.ambient = 0.0; }, "[projector] ambient")),
      {"room lamp", EffectStage::light, "no lamp besides the projector",
       [](const Twin& t) { return t.room.has_lamp(); }, [](Twin& t) { t.room = {}; }, "[room] lamp"},
      light_per_image(),
      shift_per_image(),
      waveform_per_image(),
      waves_of_raster(),
      of_each(
          &Twin::cameras, EffectStage::light, "exposure timing", "exposures that see one pattern each",
          [](const Camera& c) { return c.timing.has_value(); }, [](Camera& c) { c.timing.reset(); },
          "[camera.timing] late, exposure, read_out"),
      in_noise_theory(of_projector(
          "projector falloff", "the same light at every distance",
          [](const Projector& p) { return p.inverse_square; }, [](Projector& p) { p.inverse_square = false; },
          "[projector] falloff = \"inverse-square\", reference_distance_mm")),
      in_noise_theory(of_projector(
          "projector blur", "a sharp projector, without a halo",
          [](const Projector& p) { return p.blur_px > 0.0; },
          [](Projector& p) { p.blur_px = 0.0, p.halo.clear(); }, "[projector] blur_px")),
      of_projector(
          "blur field", "the same blur all over the projector's image",
          [](const Projector& p) { return p.has_blur_field(); }, [](Projector& p) { p.blur_field_px2 = {}; },
          "[projector] blur_field_px2"),
      of_projector(
          "halo", "a projector whose light is spread by its blur alone",
          [](const Projector& p) { return p.has_halo(); }, [](Projector& p) { p.halo.clear(); },
          "[projector] halo = [[share, sigma_px], ...]"),
      of_projector(
          "light field", "the same light all over the projector's image",
          [](const Projector& p) { return p.has_light_field(); }, [](Projector& p) { p.light_field.clear(); },
          "[projector] light_field"),
      of_projector(
          "projector response", "a linear projector",
          [](const Projector& p) { return p.response.kind != ProjectorResponse::Kind::linear; },
          [](Projector& p) { p.response = {}; },
          "[projector] response = { gamma = 2.2 } or { table = [...] }"),
      {"fringe harmonics", EffectStage::light, "fringes without light besides what is shown",
       [](const Twin& t) {
         return t.projector && t.fringes.steps > 0 &&
                std::ranges::any_of(t.fringes.directions, &DirectionFringes::has_own_harmonics);
       },
       [](Twin& t) {
         for (DirectionFringes& d : t.fringes.directions) d.harmonics.clear();
       },
       "[fringes] harmonics = [[a2, b2], ...]"},
      {"harmonics field", EffectStage::light, "the same harmonics all over the projector's image",
       [](const Twin& t) { return t.projector && t.fringes.steps > 0 && t.fringes.has_harmonics_field(); },
       [](Twin& t) {
         for (DirectionFringes& d : t.fringes.directions) d.harmonics_field.clear();
       },
       "[fringes] harmonics_field = [[[a2, b2], ...], ...], one list per term"},
      {"fringe contrast", EffectStage::light, "fringes whose light swings as far as what is shown",
       [](const Twin& t) { return t.projector && t.fringes.steps > 0 && t.fringes.has_contrast(); },
       [](Twin& t) {
         for (DirectionFringes& d : t.fringes.directions) d.contrast.clear();
       },
       "[fringes] contrast = [c1, c2, ...], one per pitch"},
      {"fringe waveform", EffectStage::light, "sinusoidal fringes",
       [](const Twin& t) {
         return t.projector && t.fringes.steps > 0 && t.fringes.waveform.kind != Waveform::Kind::sine;
       },
       [](Twin& t) { t.fringes.waveform = {}; },
       "[fringes] waveform = \"binary\", { table = [...] } or { levels = [...] }"},
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
      of_each(
          &Twin::cameras, EffectStage::sensor, "camera response", "gray values straight over the light",
          [](const Camera& c) { return !c.sensor.response.straight(); },
          [](Camera& c) { c.sensor.response = {}; },
          "[camera.sensor] response = { knee_dn = 120.0, slope = 0.85 } or { table = [[...], ...] }"),
      of_each(
          &Twin::cameras, EffectStage::sensor, "gain of pixels", "pixels that all have the same gain",
          [](const Camera& c) { return c.sensor.prnu.given(); }, [](Camera& c) { c.sensor.prnu = {}; },
          "[camera.sensor] prnu = \"FILE.exr\""),
      of_each(
          &Twin::cameras, EffectStage::sensor, "offset of pixels",
          "pixels that all have the same black level", [](const Camera& c) { return c.sensor.dsnu.given(); },
          [](Camera& c) { c.sensor.dsnu = {}; }, "[camera.sensor] dsnu = \"FILE.exr\""),
      in_noise_theory(of_each(
          &Twin::cameras, EffectStage::sensor, "sensor noise", "a sensor without shot and read noise",
          [](const Camera& c) { return c.sensor.has_noise(); },
          [](Camera& c) {
            c.sensor.electrons_per_dn.reset();
            c.sensor.read_noise_dn.reset();
          },
          "[camera.sensor] electrons_per_dn, read_noise_dn")),
      in_noise_theory(of_each(
          &Twin::cameras, EffectStage::sensor, "sensor rounding", "16 bits over the same range",
          [](const Camera& c) { return c.sensor.bit_depth < 16; }, [](Camera& c) { widen_sensor(c.sensor); },
          "[camera.sensor] bit_depth below 16")),
  };
}

}  // namespace

const std::vector<Effect>& effects() {
  static const std::vector<Effect> table = make_effects();
  return table;
}

}  // namespace fringetwin
