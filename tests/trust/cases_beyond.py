# SPDX-License-Identifier: Apache-2.0
"""Two errors at once, which must both be named; and errors of no group that the program knows, of which it must say so, or
that they are a factor or an offset of each pixel."""
import numpy as np

import cases_listed as one
from cases import add_case, planted
from cases_listed import BALL, FULL_BOTH, GRAY, TWO, WALL
from projection import vector


def double(name, what, plants, rig, each, **expected):
    """each: the two groups, both to be named."""
    def plant(rig_, twin, random):
        for planting in plants:
            planting(rig_, twin, random)
    add_case(name, "double", what, plant, rig, causes=each, each=each, **expected)


K1, MOVED, TURNED = one.projector_k1(0.02), one.moved(0.02, -0.01, 0.03), one.projector_turned(2e-4, -3e-4, 4e-4)
double("k1_and_gamma", "the projector's k1 is 0.02 off and its gamma is 1.1", [K1, one.gamma(1.1)], WALL, "lens response")
double("k1_and_gamma_ball", "sphere; the projector's k1 is 0.02 off and its gamma is 1.1", [K1, one.gamma(1.1)], BALL,
       "lens response")
double("k1_small_and_gamma_small", "the projector's k1 is 0.004 off and its gamma is 1.02",
       [one.projector_k1(0.004), one.gamma(1.02)], WALL, "lens response")
double("turned_and_k1_wall", "the projector is turned by 0.54 mrad and its k1 is 0.02 off", [TURNED, K1], FULL_BOTH,
       "rig lens")
double("pose_and_gamma", "the sphere is 0.037 mm off, the projector's gamma is 1.08", [MOVED, one.gamma(1.08)], BALL,
       "pose response")
double("pose_and_gamma_wall", "the sphere before a wall is 0.037 mm off, the projector's gamma is 1.08",
       [MOVED, one.gamma(1.08)], FULL_BOTH, "pose response", values={"projector.gamma": 1.08})
double("pose_and_blur", "the sphere is 0.037 mm off, the projector's blur is 1.5 px", [MOVED, one.blur(1.5)], BALL,
       "pose blur")
double("size_and_blur_wall", "the radius of the sphere before a wall is 0.05 mm off, the projector's blur is 1.5 px",
       [one.radius(0.05), one.blur(1.5)], FULL_BOTH, "size blur")
double("subsurface_and_blur", "light goes 1 mm below the sphere's surface, the projector's blur is 1.5 px",
       [one.below(1.0), one.blur(1.5)], BALL, "subsurface blur")
double("blur_and_light", "the projector's blur is 1.5 px, and the light flickers by 1 %", [one.blur(1.5), one.flicker(0.01)],
       BALL, "blur light")
double("halo_and_albedo", "12 % of the projector's light is spread by 18 px, and the sphere sends back 0.8, in the twin 0.76",
       [one.halo([(0.12, 18.0)]), one.albedo(0.76)], one.CODED_BOTH, "halo albedo")
double("knee_and_light", "the sensor's line bends by 20 % at 55 % of its scale, and the light flickers by 1 %",
       [one.knee(0.8), one.flicker(0.01)], WALL, "camera_knee light")
double("knee_and_pose", "the sensor's line bends by 20 % at 55 % of its scale, and the sphere is 0.037 mm off",
       [one.knee(0.8), MOVED], BALL, "camera_knee pose")
double("light_drift_and_gamma", "the light rises by 4 % from the first image to the last, the projector's gamma is 1.08",
       [one.light_drift(0.02), one.gamma(1.08)], WALL, "light response")
double("texture_and_gamma", "waves of 10 % in the albedo, and the projector's gamma is 1.08",
       [one.waves(0.1), one.gamma(1.08)], WALL, "texture response", gain=False)
# One sphere alone cannot tell k1 from a turn: the turn takes it up, so one of the two suffices.
add_case("turned_and_k1", "double", "sphere; the projector is turned by 0.54 mrad and its k1 is 0.02 off",
         lambda rig, twin, random: (TURNED(rig, twin, random), K1(rig, twin, random)), BALL, causes="rig lens intrinsics")


def unlisted(what, rig, causes="", **expected):
    return planted("unlisted", what, rig, causes=causes, unlisted=True, gain=False, **expected)


@unlisted("a hot spot of the projector, 30 % and 60 px wide, on the sphere", BALL, one.FIELD, verdict=GRAY)
def hot_spot(rig, twin, random):
    one.hot_spot(0.3, 60)(rig, twin, random)


@unlisted("a hot spot of the projector, 30 % and 60 px wide, on the wall", WALL, one.FIELD, verdict=GRAY)
def hot_spot_wall(rig, twin, random):
    one.hot_spot(0.3, 60)(rig, twin, random)


@unlisted("a gloss of 25 % by the half vector", BALL, "specular", verdict=GRAY)
def gloss(rig, twin, random):
    rig.gloss = lambda cosine: 1 + 0.25 * np.maximum(cosine, 0)**40


@unlisted("8 % of the light comes out of the surface elsewhere", BALL, one.ROOM + " fringe_contrast", verdict=GRAY,
          values={"projector.fringe_contrast": 0.92})
def light_from_elsewhere(rig, twin, random):
    rig.scatter = 0.08


@unlisted("a lamp of 6 % of the full light at the side flickers by a tenth", BALL, one.ROOM, verdict=GRAY)
def flickering_lamp(rig, twin, random):
    one.side_lamp(rig, twin, random)
    rig.besides_factor = 1 + 0.1 * random.uniform(-1, 1, len(rig.patterns()))


@unlisted("dust before the projector: nine dark spots of 20 %, 12 px wide", TWO, one.FIELD, verdict=GRAY)
def dust(rig, twin, random):
    spots = random.uniform((250, 150), (600, 450), (9, 2))
    rig.projector_field = lambda u, v: 1 - 0.2 * sum(np.exp(-((u - a)**2 + (v - b)**2) / (2 * 12**2)) for a, b in spots)


@unlisted("the projector drops the last bits of its levels: steps of 1/24", WALL)
def coarse_levels(rig, twin, random):
    rig.projector_response = lambda level: np.rint(level * 24) / 24
