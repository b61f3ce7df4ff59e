// SPDX-License-Identifier: Apache-2.0
#include "render/pattern/projector_places.hpp"

#include <cmath>

#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::render {
namespace {

constexpr int kPitchOverWidth = 4;  ///< the phase stays within a quarter of a period
constexpr int kSteps = 4;

Eigen::Vector2d pitch_px(const Projector& projector) {
  return kPitchOverWidth * Eigen::Vector2d(projector.lens.width(), projector.lens.height());
}

}  // namespace

Twin showing_places(const Twin& twin) {
  FT_CHECK(twin.projector.has_value(), "a projector that lights the scene");
  Twin view = twin;
  view.projector =
      Projector{.lens = twin.projector->lens, .T_proj_world = twin.projector->T_proj_world, .response = {}};
  view.render.bounces = 0;
  view.room = {};
  for (Camera& camera : view.cameras)
    camera.vignetting = {}, camera.texture = nullptr, camera.exposure_factors.clear(), camera.timing.reset();
  const Eigen::Vector2d pitches_px = pitch_px(*twin.projector);
  view.fringes = {
      .directions = {{Axis::x, {pitches_px.x()}, {0.0}, {}}, {Axis::y, {pitches_px.y()}, {0.0}, {}}},
      .steps = kSteps,
      .unwrap = Unwrap::none,
      .images = {}};
  return view;
}

Eigen::Vector2d place_in_projector_px(const std::vector<ImageF>& images, std::size_t pixel,
                                      const Projector& projector) {
  const auto e = [&](int k) { return static_cast<double>(images[static_cast<std::size_t>(k)].data[pixel]); };
  Eigen::Vector2d phase_rad;
  for (int axis = 0; axis < 2; ++axis) {
    const int first = kSteps * axis;
    phase_rad[axis] = std::atan2(e(first + 3) - e(first + 1), e(first) - e(first + 2));
  }
  return phase_rad.cwiseProduct(pitch_px(projector)) / kTwoPi;
}

}  // namespace fringetwin::render
