// SPDX-License-Identifier: Apache-2.0
// Lists the parameters that change gray values in a way that needs no rendering: each is a function of the
// irradiance that the twin predicts for the samples (docs/metrics/causes.md, "Causes").
#pragma once
#include "compare/parameters/grid_view.hpp"
#include "compare/parameters/parameter.hpp"

namespace fringetwin::compare {

/// Returns the parameters of the groups light, exposure and timing (of the phase steps `use_steps`, all where
/// it is empty), room_light, camera_response, camera_knee, projector_field, image_shift, image_harmonics,
/// raster, motion and camera_psf; none of others. Their `effect` gives derivatives (image_harmonics has one
/// of the first order alone; that of timing is left out where images that are not compared stand beside the
/// image); `instead` is empty but for image_shift beside pixel_structure. `change` is there for those that a
/// key of twin.toml holds: light, exposure, timing, camera_knee, projector_field, image_harmonics, and
/// image_shift without pixel_structure.
std::vector<Parameter> closed_parameters(const Twin& twin, const std::string& group,
                                         const std::vector<int>& use_steps);

/// Returns the parameters of the group timing of one camera: by how much each of these images is late, and
/// the camera's read-out (timing_columns.cpp).
std::vector<Parameter> timing_parameters(const Twin& twin, std::size_t camera,
                                         const std::vector<int>& compared);

/// Returns the parameters of the groups image_shift and image_harmonics, of these images of the sequence
/// (image_columns.cpp).
std::vector<Parameter> image_shift_parameters(const Twin& twin, const std::vector<int>& compared);
std::vector<Parameter> image_harmonics_parameters(const Twin& twin, const std::vector<int>& compared);
/// Returns whether the light of a projector's fringes has harmonics beyond the first, which go further where
/// a fringe goes and which its own steps mistake for the first: a Parameter::effect_of_sinusoids is not
/// right.
bool fringes_have_overtones(const Twin& twin);

/// Returns the parameters of the group raster: both parts of the waves that each direction names, and the
/// raster's pitch where there are any to tell it by (raster_columns.cpp). The effect of a wave needs
/// GridSamples::waves; that of the pitch is rendered.
std::vector<Parameter> raster_parameters(const Twin& twin);
/// Fills GridSamples::waves of all samples from one rendering of all waves that the twin names, so many
/// points per pixel.
void find_waves(render::Renderer& renderer, const Twin& twin, int points, std::vector<GridSamples>& samples);

/// Returns whether fringes of their own are all that harmonics bring: exposures that reach into other images,
/// things that move, pixels that are seen and light below surfaces are rendered.
bool harmonics_are_fringes(const Twin& twin);
/// Fills GridSamples::harmonics of all samples up to this order from one rendering, which the effects of
/// harmonic_parameter() need (harmonic_columns.cpp).
void find_harmonics(render::Renderer& renderer, const Twin& twin, int highest, int points,
                    std::vector<GridSamples>& samples);

/// Returns whether exposures may reach into another pattern, whose light an image then has, too.
bool sees_other_patterns(const Twin& twin);

/// Returns the irradiance of a pixel in an image of the sequence that the projector's light factor leaves as
/// it is: the twin's light of the room (with a lamp: find_room_light()), and the offset of the camera's
/// texture.
double unprojected_light(const Twin& twin, const GridSamples& samples, std::size_t pixel, int image);

/// Returns the effect of a parameter of a camera's vignetting, which `change` changes.
std::function<void(const EffectInput&, std::vector<float>&)> vignetting_effect(
    std::size_t camera, std::function<void(Twin&, double)> change);
/// Returns the effect of a parameter that all light is in proportion to.
std::function<void(const EffectInput&, std::vector<float>&)> factor_effect();

/// Fills GridSamples::room_light of all samples where the twin has a lamp beside the projector.
void find_room_light(render::Renderer& renderer, const Twin& twin, std::vector<GridSamples>& samples);

/// Fills GridSamples::projector_px of all samples: from one rendering of fringes so wide that their phase
/// tells the place in the projector's image, four points per pixel.
void find_projector_places(render::Renderer& renderer, const Twin& twin, std::vector<GridSamples>& samples);

}  // namespace fringetwin::compare
