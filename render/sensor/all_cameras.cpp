// SPDX-License-Identifier: Apache-2.0
#include "render/sensor/all_cameras.hpp"

#include "render/sensor/sensor.hpp"
namespace fringetwin::render {

std::vector<RenderedCamera> render_all(Renderer& renderer, const Twin& twin, const Sampling& sampling,
                                       std::uint64_t seed, Progress* progress) {
  std::vector<RenderedCamera> out;
  for (std::size_t i = 0; i < twin.cameras.size(); ++i) {
    throw_if_cancelled();
    out.push_back(renderer.render(twin, i, sampling, seed));
    if (progress) progress->advance();
  }
  return out;
}

std::vector<RenderedCamera> render_all(Renderer& renderer, const Twin& twin, std::uint64_t seed) {
  return render_all(renderer, twin, choose_sampling(twin), seed);
}

std::vector<CameraImages> expose_all(const std::vector<RenderedCamera>& rendered, const Twin& twin,
                                     std::uint64_t seed) {
  std::vector<CameraImages> out;
  for (std::size_t i = 0; i < rendered.size(); ++i) {
    throw_if_cancelled();
    out.push_back(expose(rendered[i], twin.cameras[i], i, seed));
  }
  return out;
}

}  // namespace fringetwin::render
