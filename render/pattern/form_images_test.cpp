// SPDX-License-Identifier: Apache-2.0
// | tolerance | unit | origin                              |
// |-----------|------|-------------------------------------|
// | 1e-6      | E    | single precision of sums below 10   |
#include "render/pattern/form_images.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "render/pattern/response_series.hpp"

namespace fringetwin::render::form_images_test {
namespace {

/// A rig without fringes, whose projector gives some light at level 0 and not all at level 1.
Twin rig() {
  const Lens lens("LENSMODEL_PINHOLE", {100.0, 100.0, 1.0, 0.5}, {3, 2}, "test");
  Twin twin;
  twin.cameras = {Camera{"left", lens, Pose{}, Sensor{}, std::nullopt}};
  twin.projector = Projector{.lens = lens, .T_proj_world = {}, .response = {}};
  twin.projector->response = {ProjectorResponse::Kind::table, 1.0, {0.125, 0.25, 0.75}};
  return twin;
}

// ambient + r(1) mean and ambient + r(0) mean.
TEST(FormCamera, WhiteAndBlackPassTheResponse) {
  Transport transport;
  transport.mean = ImageF(3, 2, 8.0F);
  transport.ambient = ImageF(3, 2, 0.5F);
  transport.mean(1, 1) = 4.0F;
  const RenderedCamera formed = form_camera(rig(), 0, transport, true);
  EXPECT_EQ(formed.camera, "left");
  ASSERT_TRUE(formed.white && formed.black);
  EXPECT_NEAR((*formed.white)(0, 0), 0.5 + 0.75 * 8.0, 1e-6);
  EXPECT_NEAR((*formed.white)(1, 1), 0.5 + 0.75 * 4.0, 1e-6);
  EXPECT_NEAR((*formed.black)(0, 0), 0.5 + 0.125 * 8.0, 1e-6);
  EXPECT_NEAR((*formed.black)(1, 1), 0.5 + 0.125 * 4.0, 1e-6);
  EXPECT_FALSE(form_camera(rig(), 0, transport).white) << "nobody asked for it";
}

/// A rig of three pitches with this many steps, and a transport of arbitrary light, some pixels dark.
Twin stepping_rig(int steps, double response_gamma = 1.0) {
  Twin twin = rig();
  twin.projector->response = {};
  twin.projector->response.gamma = response_gamma;
  if (response_gamma != 1.0) twin.projector->response.kind = ProjectorResponse::Kind::gamma;
  twin.fringes.directions = {
      {.axis = Axis::x, .pitches_px = {13.0, 14.0, 15.0}, .phase_origin_px = {0, 0, 0}}};
  twin.fringes.steps = steps;
  return twin;
}

Transport lit(const Twin& twin) {
  Transport transport;
  auto any = [n = 0](float scale) mutable {
    ImageF out(3, 2);
    for (float& value : out.data) value = scale * std::sin(static_cast<float>(++n));
    out.data[4] = 0.0F;
    return out;
  };
  transport.mean = any(3.0F);
  transport.ambient = any(0.4F);
  transport.cosine.resize(1);
  transport.sine.resize(1);
  for (int p = 0; p < 3; ++p) {
    transport.cosine[0].push_back(any(2.0F));
    transport.sine[0].push_back(any(2.0F));
  }
  transport.series = choose_series(twin);
  transport.harmonics.assign(1, std::vector<std::vector<Transport::Pair>>(3));
  for (std::size_t p = 0; p < 3; ++p)
    for (std::size_t k = 2; k < transport.series[0][p].a.size(); ++k)
      transport.harmonics[0][p].push_back({any(0.1F), any(0.1F)});
  return transport;
}

/// Both ways to the images of a camera give the same bits; returns how many bytes the kept ones have alone.
std::size_t expect_kept(const Twin& twin) {
  const RenderedCamera formed = form_camera(twin, 0, lit(twin));
  const KeptCamera kept = keep_camera(twin, 0, lit(twin));
  EXPECT_EQ(kept.rendered.camera, formed.camera);
  EXPECT_TRUE(kept.rendered.irradiance.empty());
  EXPECT_EQ(kept.irradiance.size(), formed.irradiance.size());
  std::size_t bytes = 0;
  for (std::size_t k = 0; k < formed.irradiance.size(); ++k) {
    EXPECT_EQ(kept.irradiance[k].floats().data, formed.irradiance[k].data) << k;
    bytes += kept.irradiance[k].bytes();
  }
  return bytes;
}

// 24 images are sums of 8, which are held once; 9 would be sums of 8, too, and are floats.
TEST(KeepCamera, ManyStepsShareWhatTheyAreSumsOf) {
  EXPECT_EQ(expect_kept(stepping_rig(8)), 0U);
  EXPECT_EQ(expect_kept(stepping_rig(3)), 9U * 6U * sizeof(float));
}

TEST(KeepCamera, LightOfImagesAndVignettingGiveTheSameBits) {
  Twin twin = stepping_rig(8);
  for (int k = 0; k < 24; ++k) {
    twin.projector->light_factors.push_back(1.0 + 0.01 * k);
    twin.projector->ambient_factors.push_back(1.0 - 0.02 * k);
  }
  twin.cameras[0].vignetting.kind = Vignetting::Kind::polynomial;
  twin.cameras[0].vignetting.a = {-0.3, 0.1, 0.0};
  EXPECT_EQ(expect_kept(twin), 0U);
}

TEST(KeepCamera, HarmonicsAndPointSpreadAreFormed) {
  EXPECT_EQ(expect_kept(stepping_rig(8, 2.2)), 24U * 6U * sizeof(float));
  Twin twin = stepping_rig(8);
  twin.cameras[0].psf_px = 0.6;
  EXPECT_EQ(expect_kept(twin), 24U * 6U * sizeof(float));
}

}  // namespace
}  // namespace fringetwin::render::form_images_test
