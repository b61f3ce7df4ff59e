// SPDX-License-Identifier: Apache-2.0
#include "compare/parameters/parameter_groups.hpp"

#include "twin/base/errors.hpp"

namespace fringetwin::compare {

const std::vector<ParameterGroup>& parameter_groups() {
  static const std::vector<ParameterGroup> groups{
      {"pose", "where the objects are", "an object is not where the twin says (pose)"},
      {"size", "radius of spheres and cylinders, size of meshes", "an object is larger or smaller (size)"},
      {"rig", "poses of the projector and the second camera", "pose of the projector or the second camera"},
      {"intrinsics", "principal point and focal length of every lens",
       "principal point or focal length of a lens (intrinsics)"},
      {"lens", "radial distortion k1, k2 of every lens", "lens distortion"},
      {"response", "gamma of the projector", "the projector's response (gamma)"},
      {"harmonics", "harmonics 2 to 7 of the projected fringe, in phase and in quadrature (6 steps or more)",
       "harmonics of the projected fringe", "",
       "harmonics_field besides, where they vary over the projector's image"},
      {"blur", "width of the projector's blur", "blur of the projected pattern"},
      {"halo", "light that the projector's lens spreads further than its blur: shares and widths",
       "the projector spreads a part of its light further than its blur (halo: tails of its point spread)"},
      {"vignetting", "gain over each camera's image: tilt and r^2",
       "gain that varies over the image (vignetting)"},
      {"albedo", "diffuse reflectivity of each object", "reflectivity of the objects (albedo)"},
      {"specular", "gloss of each object, its shininess held", "gloss of the objects (specular)"},
      {"roughness", "width of the lobe of each glossy object: its roughness, or its shininess",
       "the objects shine in a wider or a narrower lobe (roughness)"},
      {"subsurface", "how far light goes below the surface of each object (mean free path)",
       "light goes below the surface of an object and leaves it beside (subsurface: wax, plastic, marble, "
       "skin)"},
      {"bounce", "light that reaches a surface by way of another",
       "light that reaches a surface by way of others (interreflection)"},
      {"gloss", "light that leaves surfaces for others by their lobes",
       "light that shiny surfaces mirror to others, and others in them (glossy interreflection)"},
      {"bounce_albedo",
       "a factor on the reflectivity of all objects beside the same direct light: what goes from surface to "
       "surface",
       "surfaces send more or less of their light to others (reflectivity beside bounces)", "", "", false},
      {"light", "brightness of each image", "the light differed from image to image (lamp flicker or drift)",
       "",
       "have it taken out by [measure] light = \"corrected\", or record again with a steady lamp or "
       "exposures of "
       "whole periods of the mains"},
      {"lamp", "direction and light of the room's lamp", "the lamp beside the projector (room.lamp)"},
      {"room_light", "light over each camera's image that is the same in all images",
       "light that is no projector's (room light, a lamp, scattering)",
       "record again in the dark, or subtract an image of the dark room; a lamp far away is [room] lamp"},
      {"camera_response", "curve of each camera's gray values over the light",
       "a camera's gray values do not follow the light in proportion (its response)", "",
       "switch gamma and other curves off in the camera, and keep its values below the bend"},
      {"camera_knee", "a level of each camera's gray values from which on they rise less, and by how much",
       "a camera's gray values bend at a level (knee of its response)", "",
       "switch the knee (WDR, gamma) off in the camera, or keep its values below it"},
      {"projector_field", "light over the projector's image, to the fourth order",
       "the projector is brighter here than there (hot spot, its own vignetting: light_field)", "",
       "texture in its place: a factor per pixel takes it away"},
      {"image_shift", "shift of the fringes of each image",
       "the fringes moved from image to image (vibration, wrong phase steps)", "",
       "record again on a firm base; check the projector's phase steps"},
      {"motion", "steady motion of each object while the images are taken",
       "an object moved while the images were taken", "", "record again with everything at rest, or faster"},
      {"camera_psf", "width of each camera's blur", "blur of a camera's image (out of focus)",
       "put the width that the causes name into psf_px of the camera"},
      {"exposure", "exposure of each image of each camera", "the exposure differed from image to image", "",
       "hold the exposure, and trigger it by the projector", false},
      {"timing", "when each image of each camera is exposed beside its pattern, and the read-out of its rows",
       "exposures reached into another pattern (late or early ones, a rolling shutter)", "",
       "expose when the projector says so, and for no longer than a pattern is shown", false},
      {"harmonics_field",
       "how the harmonics vary over the projector's image: five terms of each number, up to the second order",
       "the form of the fringe differs over the projector's image (harmonics_field)", "", "", false},
      {"harmonics_high",
       "harmonics 8 to 16 of the projected fringe, in phase and in quadrature (9 steps or more)",
       "fine structure of the projected fringe (harmonics 8 to 16)", "", "", false},
      {"image_harmonics",
       "waveform of the fringes of each image beside that of all: contrast, harmonics 2 to 7 (6 steps or "
       "more)",
       "the form of the fringe differs from image to image (image_harmonics)", "",
       "let each exposure hold whole frames of the projector", false},
      {"raster",
       "waves that the fringes' fine structure makes with the projector's pixels, of the orders that "
       "[fringes] raster names, and the raster's pitch",
       "what the fringes show is coarse beside the projector's pixels (raster)", "", "", false,
       "name its orders in [fringes] raster (docs/formats/twin.md)"},
      {"contrast", "contrast of each pitch's fringes, of that of the widest pitch",
       "the contrast of the fringes falls from pitch to pitch in another way than by blur (veiling glare)",
       "", "", false},
      {"fringe_contrast", "contrast of the fringes of all pitches together",
       "the fringes of all pitches have another contrast than the twin's (the projector's black level, "
       "glare, "
       "the amplitude shown)"},
      {"blur_field", "how the blur's variance varies over the projector's image: a quadratic, five numbers",
       "the projector is sharper here than there (blur_field_px2)", "", "", false},
  };
  return groups;
}

const ParameterGroup& parameter_group(const std::string& name) {
  for (const ParameterGroup& group : parameter_groups())
    if (group.name == name) return group;
  FT_CHECK(false, "a known parameter group");
  return parameter_groups().front();
}

}  // namespace fringetwin::compare
