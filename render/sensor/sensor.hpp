// SPDX-License-Identifier: Apache-2.0
// Turns the irradiance E at the sensor into gray values (docs/CONVENTIONS.md, "Light"):
// DN = clamp(round(f(gain E) + black + noise), 0, 2^bits - 1), f the camera's response, f(x) = x without one;
// gain and black level are the pixel's own where the sensor has maps of them.
#pragma once
#include <cstdint>

#include "render/base/rendered_camera.hpp"
#include "twin/captures/capture_set.hpp"

namespace fringetwin::render {

/// Exposes one image. The result does not depend on the number of threads: the noise of a pixel depends on
/// (seed, camera, image, pixel) only.
ImageF expose(const ImageF& irradiance, const Sensor& sensor, std::uint64_t seed, std::uint32_t camera,
              std::uint32_t image);
ImageF expose(const GrayImage& irradiance, const Sensor& sensor, std::uint64_t seed, std::uint32_t camera,
              std::uint32_t image);
/// Exposes all images of one camera.
CameraImages expose(const RenderedCamera& rendered, const Camera& camera, std::size_t camera_index,
                    std::uint64_t seed);
CameraImages expose(const KeptCamera& kept, const Camera& camera, std::size_t camera_index,
                    std::uint64_t seed);
/// Returns the irradiance itself as a capture set, without quantisation.
CameraImages as_radiance(RenderedCamera rendered);
CameraImages as_radiance(KeptCamera kept);

}  // namespace fringetwin::render
