// SPDX-License-Identifier: Apache-2.0
// | tolerance | unit | origin                              |
// |-----------|------|-------------------------------------|
// | 1e-6      | E    | single precision of sums below 10   |
#include "render/pattern/form_images.hpp"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace fringetwin::render::form_images_test
