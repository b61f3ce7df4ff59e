// SPDX-License-Identifier: Apache-2.0
#include "compare/refine/apply_texture.hpp"

#include <algorithm>
#include <memory>
#include <utility>

#include "compare/gray/gray_pair.hpp"
#include "compare/gray/own_light.hpp"
#include "compare/refine/texture_spread.hpp"
#include "render/pattern/pixel_texture.hpp"
#include "twin/captures/capture_set.hpp"

namespace fringetwin::compare {
namespace {

/// Returns the line of each pixel through its values over the light, to which the slopes of this factor add
/// what they do within a pixel of this spread (0: nothing).
PixelTexture texture_by(const OwnKinds& kinds, const GrayOverLight& values, double spread_px,
                        const ImageF& factor) {
  PixelTexture out;
  out.factor = ImageF(factor.width, factor.height, 1.0F);
  if (kinds.offset) out.offset = ImageF(factor.width, factor.height, 0.0F);
#pragma omp parallel for schedule(static)
  for (int y = 0; y < factor.height; ++y)
    for (int x = 0; x < factor.width; ++x) {
      const std::size_t i = factor.index(x, y);
      OwnLightSums sums;
      for (const std::size_t k : values.images()) {
        if (!values.is_usable(k, i)) continue;
        double light = values.light_at(k, i);
        if (spread_px > 0.0 && factor.data[i] > 0.0F)
          light += spread_px * spread_px * render::texture_moment(factor, values.light()[k], x, y) /
                   static_cast<double>(factor.data[i]) / values.exposure(k);
        sums.add(light, values.gray_at(k, i));
      }
      const OwnLight own = sums.line(kinds);
      out.factor.data[i] = static_cast<float>(own.factor);
      if (kinds.offset) out.offset.data[i] = static_cast<float>(own.offset_dn);
    }
  return out;
}

/// Returns the texture of a camera that had `before` and whose images need `now` on top of it.
PixelTexture on_top_of(const PixelTexture& before, const PixelTexture& now) {
  PixelTexture all = now;
  if (all.offset.empty() && !before.offset.empty())
    all.offset = ImageF(now.factor.width, now.factor.height, 0.0F);
  for (std::size_t i = 0; i < now.factor.size(); ++i) {
    all.factor.data[i] = static_cast<float>(now.factor_at(i) * before.factor_at(i));
    if (!all.offset.empty())
      all.offset.data[i] = static_cast<float>(now.factor_at(i) * before.offset_at(i) + now.offset_at(i));
  }
  return all;
}

}  // namespace

void drop_texture_told_anew(const Refinement& refinement, Twin& twin) {
  for (std::size_t c = 0; c < refinement.texture.size(); ++c) {
    const PixelTexture* texture = twin.cameras[c].texture.get();
    if (texture && refinement.texture[c] && refinement.own.factor &&
        (refinement.own.offset || texture->offset.empty()))
      twin.cameras[c].texture = nullptr;
  }
}

void apply_texture(Refinement& refinement, const std::vector<CameraImages>& real,
                   const std::vector<int>& images, Twin& twin, std::vector<CameraImages>& irradiance) {
  const bool fits_spread = std::ranges::find(refinement.asked, kTextureSpread) != refinement.asked.end();
  for (std::size_t c = 0; c < refinement.texture.size(); ++c) {
    if (!refinement.texture[c]) continue;
    Camera& camera = twin.cameras[c];
    const bool as_taken = real[c].radiance || camera.sensor.straight();
    const auto straight = as_taken ? nullptr : straightened(real[c], camera.sensor);
    std::vector<GrayImage>& e = irradiance[c].images;
    const GrayOverLight values(as_taken ? real[c] : *straight, e, images, camera.exposure_factors,
                               *refinement.texture[c]);
    PixelTexture now =
        texture_by(refinement.own, values, 0.0, ImageF(e.front().width, e.front().height, 1.0F));
    if (fits_spread) {
      const double before = camera.texture_spread_px;
      if (const auto fitted = fit_texture_spread(refinement.own, values, now)) {
        camera.texture_spread_px = fitted->spread_px;
        refinement.rows.push_back(
            {camera.name + ".texture_spread_px", "px", before, fitted->spread_px, fitted->sigma_px});
      } else {
        refinement.notes.push_back(
            camera.name + ".texture_spread_px stays at the twin's value: these images do not tell it");
      }
    }
    if (camera.texture_spread_px > 0.0)
      now = texture_by(refinement.own, values, camera.texture_spread_px, now.factor);
    const PixelTexture before = camera.texture ? *camera.texture : PixelTexture{};
    camera.texture = std::make_shared<const PixelTexture>(on_top_of(before, now));
    for (std::size_t k = 0; k < e.size(); ++k) {
      ImageF image = e[k].floats();
      render::apply_pixel_texture(now, camera.texture_spread_px, factor_of(camera.exposure_factors, k),
                                  image);
      e[k] = std::move(image);
    }
  }
}

}  // namespace fringetwin::compare
