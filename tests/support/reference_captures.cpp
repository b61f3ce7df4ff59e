// SPDX-License-Identifier: Apache-2.0
#include "tests/support/reference_captures.hpp"

#include <cmath>

#include "render/reference/reference.hpp"

namespace fringetwin::testing {

std::vector<CameraImages> reference_captures(const Twin& rig, int gauss_n,
                                             const std::function<PixelsOwn(Draws&)>& own) {
  const Camera& camera = rig.cameras.at(0);
  const int width = camera.lens.width(), height = camera.lens.height();
  const render::Reference reference(rig);
  Draws draws;
  CameraImages out;
  out.camera = camera.name;
  out.bit_depth = camera.sensor.bit_depth;
  out.images.assign(expand_sequence(rig.fringes).size(), ImageF(width, height, 0.0F));
  for (int i = 0; i < width * height; ++i) {
    const auto pixel = reference.pixel(0, i % width, i / width, {.gauss_n = gauss_n});
    const PixelsOwn of_pixel = own ? own(draws) : PixelsOwn{};
    for (std::size_t k = 0; k < out.images.size(); ++k)
      out.images[k].as_floats()[static_cast<std::size_t>(i)] = static_cast<float>(
          std::round(camera.sensor.gain_dn * of_pixel.factor * pixel.irradiance[k] + of_pixel.offset_dn +
                     camera.sensor.read_noise_dn.value_or(0.0) * draws.normal(draws.random)));
  }
  return {out};
}

}  // namespace fringetwin::testing
