// SPDX-License-Identifier: Apache-2.0
#include "render/pattern/unit_fringes.hpp"

#include <utility>

#include "twin/base/errors.hpp"

namespace fringetwin::render {

Twin showing_fringes(const Twin& twin, std::vector<DirectionFringes> directions) {
  FT_CHECK(twin.projector.has_value(), "a projector that lights the scene");
  Twin view = twin;
  view.projector->response = {};
  view.projector->image_shifts_px.clear();
  view.projector->light_factors.clear();
  view.projector->ambient_factors.clear();
  view.room = {};
  view.fringes = {.directions = std::move(directions),
                  .steps = 3,
                  .unwrap = Unwrap::none,
                  .mean = kUnitLevel,
                  .amplitude = kUnitLevel,
                  .images = {}};
  return view;
}

}  // namespace fringetwin::render
