// SPDX-License-Identifier: Apache-2.0
// No tolerances: switches. That each switch acts on its own effect only is in
// tests/accuracy/effects_test.cpp.
#include "twin/effects.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace fringetwin::effects_test {
namespace {

/// One way in which an effect may be on.
struct Way {
  const char *effect, *what;
  std::function<void(Twin&)> switch_on;
};

Camera& second(Twin& twin) { return twin.cameras.at(1); }

std::vector<Way> all_ways() {
  return {
      {"vignetting", "cos4 of the second camera alone",
       [](Twin& t) { second(t).vignetting.kind = Vignetting::Kind::cos4; }},
      {"vignetting", "a polynomial",
       [](Twin& t) { second(t).vignetting.kind = Vignetting::Kind::polynomial; }},
      {"point spread", "of the second camera alone", [](Twin& t) { second(t).psf_px = 0.25; }},
      {"texture within a pixel", "of the second camera alone",
       [](Twin& t) { second(t).texture_spread_px = 0.5; }},
      {"exposure timing", "of the second camera alone", [](Twin& t) { second(t).timing.emplace(); }},
      {"depth of field", "of the second camera alone",
       [](Twin& t) {
         second(t).optics = Optics{8.0, 10.0, 270.0};
       }},
      {"camera response", "of the second camera alone",
       [](Twin& t) { second(t).sensor.response = knee_response(90.0, 0.8); }},
      {"gain of pixels", "of the second camera alone",
       [](Twin& t) { second(t).sensor.prnu.values = std::make_shared<const ImageF>(40, 30, 1.0F); }},
      {"offset of pixels", "of the second camera alone",
       [](Twin& t) { second(t).sensor.dsnu.values = std::make_shared<const ImageF>(40, 30, 1.0F); }},
      {"gain of pixels", "a file that is not read yet",
       [](Twin& t) { second(t).sensor.prnu.file = "prnu.exr"; }},
      {"sensor noise", "electrons alone", [](Twin& t) { second(t).sensor.electrons_per_dn = 40.0; }},
      {"sensor noise", "read noise alone", [](Twin& t) { second(t).sensor.read_noise_dn = 0.5; }},
      {"sensor rounding", "of the second camera alone", [](Twin& t) { second(t).sensor.bit_depth = 12; }},
      {"specular lobe", "of the second object alone",
       [](Twin& t) { t.objects.at(1).material.specular = 0.125; }},
      {"subsurface light", "of the second object alone",
       [](Twin& t) { t.objects.at(1).material.mean_free_path_mm = 0.5; }},
      {"glossy interreflection", "of the second object alone",
       [](Twin& t) {
         t.objects.at(1).material.specular = 0.125;
         t.render.bounces = 1;
         t.render.glossy_bounces = true;
       }},
      {"projector response", "gamma",
       [](Twin& t) {
         t.projector->response = {ProjectorResponse::Kind::gamma, 2.25, {}};
       }},
      {"projector response", "a table",
       [](Twin& t) {
         t.projector->response = {ProjectorResponse::Kind::table, 1.0, {0.0, 0.25, 1.0}};
       }},
  };
}

/// Two cameras of 16 bit, two objects, a projector, and no effect of all_ways().
Twin plain() {
  const Lens lens("LENSMODEL_PINHOLE", {100.0, 100.0, 20.0, 15.0}, {40, 30}, "test");
  Twin twin;
  twin.cameras.resize(2, Camera{"left", lens, Pose{}, Sensor{}, std::nullopt});
  for (Camera& camera : twin.cameras) camera.sensor.bit_depth = 16;
  twin.projector = Projector{.lens = lens, .T_proj_world = Pose{}, .response = {}};
  twin.objects.resize(2);
  return twin;
}

TEST(EffectSwitches, EveryWayToHaveAnEffectIsSeenAndSwitchedOff) {
  for (const Way& way : all_ways()) {
    const auto effect = std::ranges::find(effects(), way.effect, &Effect::name);
    ASSERT_NE(effect, effects().end()) << way.effect;
    Twin twin = plain();
    EXPECT_FALSE(effect->is_on(twin)) << way.effect;
    way.switch_on(twin);
    EXPECT_TRUE(effect->is_on(twin)) << way.effect << ": " << way.what;
    effect->switch_off(twin);
    EXPECT_FALSE(effect->is_on(twin)) << way.effect << ": " << way.what;
  }
}

}  // namespace
}  // namespace fringetwin::effects_test
