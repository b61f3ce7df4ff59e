// SPDX-License-Identifier: Apache-2.0
// Forms a camera's irradiance images, all patterns of a sequence, from the transport of a single trace.
#pragma once
#include <cstddef>
#include <optional>
#include <vector>

#include "render/base/rendered_camera.hpp"
#include "render/base/transport.hpp"
#include "render/pattern/exposure_mix.hpp"
#include "twin/twin.hpp"

namespace fringetwin::render {

/// Returns the irradiance images of the twin's sequence, in sequence order, as a camera gathers them that
/// sees each pattern alone: with the factors of light and exposure of each image, without the effects of the
/// camera's lens; with `range` those alone.
std::vector<ImageF> form_images(const Twin& twin, std::size_t camera_index, const Transport& transport,
                                std::optional<ImageRange> range = {});

/// Returns the same behind the camera's lens, without the factors of exposure: what exposures see, before
/// their timing (exposure_mix.hpp) and the texture of the pixels.
std::vector<ImageF> form_patterns(const Twin& twin, std::size_t camera_index, const Transport& transport,
                                  ImageRange range);

/// Returns the images of a traced camera as Renderer::render() makes them: patterns, then the lens's effects,
/// then what the camera's exposures see of the patterns, which white and black images do not have.
/// `references` asks for white and black images also where the sequence needs none; with `image` only that
/// one of the sequence is formed.
RenderedCamera form_camera(const Twin& twin, std::size_t camera_index, const Transport& transport,
                           bool references = false, std::optional<std::size_t> image = {});

/// Returns the same images, bit by bit, of which those that are the sum of four images of the transport and
/// no more are kept as such sums (GrayImage::sum) where that takes less memory.
KeptCamera keep_camera(const Twin& twin, std::size_t camera_index, Transport transport);
/// Returns images as they were rendered, kept as floats.
KeptCamera kept_as_floats(RenderedCamera rendered);

/// Returns true when the trace of a camera does not depend on the fringes' mean, amplitude and number of
/// steps: all images are phase steps behind a linear response.
bool holds_any_steps(const Twin& twin);
/// Gives a transport the mean and amplitude of this twin. Needs holds_any_steps(), and > 0 steps, of both
/// twins.
void set_pattern(const Twin& twin, Transport* transport);

}  // namespace fringetwin::render
