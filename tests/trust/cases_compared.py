# SPDX-License-Identifier: Apache-2.0
"""Right twins; objects, cameras and light that one of the two sides lacks; noise that the twin states wrongly."""
import numpy as np

import solids
from cases import add_case, nothing, planted
from rig import legendre_field, unit


def right(name, rig=None, what="nothing", plant=nothing, **more):
    add_case(name, "right", what, plant, rig, expect="explained", **more)


right("right_sphere_n3", dict(steps=3), fast=True)
right("right_sphere_n4")
right("right_sphere_n7_8bit", dict(steps=7, bits=8), fast=True)
right("right_plane_n4", dict(scene="wall"), fast=True)
right("right_gem_n4", dict(scene="gem", nodes=8))  # 3 nodes leave chi2 = 1.05 at the edges of its facets
right("right_two_cameras_n4", dict(scene="ball+wall", cameras=2))
right("right_two_cameras_n3", dict(cameras=2, steps=3))
right("right_balls_n7", dict(scene="balls", steps=7))
right("right_ball_wall_n4_10bit", dict(scene="ball+wall", bits=10))
right("right_vertical", dict(projector_above=True, direction="y"), fast=True)
right("right_gray_code", dict(scene="ball+wall", unwrap="gray"), fast=True)
right("right_small_ball_wall", dict(scene="ball+wall", small=True))
right("right_small_groove", dict(scene="groove", small=True, nodes=24))  # its fold cuts a whole column of pixels alike
right("right_small_two_cameras", dict(scene="ball+wall", small=True, cameras=2))
right("pov_right_ball_wall", dict(scene="ball+wall", pinhole=True), povray=True)
right("pov_right_n3_8bit", dict(scene="ball+wall", pinhole=True, steps=3, bits=8), povray=True)


def both_start_elsewhere(rig, twin, random):
    rig.origin_px = twin.origin_px = 3.25


def both_overexposed(rig, twin, random):  # at 1.6 times 61 % of the pixels clip: that is most, and is said
    for side in (rig, twin):
        side.sensors[0]["gain_dn"] *= 1.4


def other_gain_in_twin(rig, twin, random):
    twin.sensors[0]["gain_dn"] *= 1.15
    twin.sensors[0]["black_dn"] += 3


right("right_origin", what="nothing; the fringes start a quarter of a period further, as told", plant=both_start_elsewhere)
right("right_some_saturated", dict(scene="ball+wall"), what="nothing; some pixels saturate in rig and twin",
      plant=both_overexposed)
right("right_gain_unknown", what="gain 15 % and black level 3 DN off in the twin: they are fitted",
      plant=other_gain_in_twin)


HOT_SPOT = [0.06, -0.04, -0.18, 0.03, -0.12]  # brightest beside the middle, by 35 % over two of the corners


def field_known(rig, twin, random):
    rig.projector_field, twin.light_field = legendre_field(HOT_SPOT), HOT_SPOT


def lamp_known(rig, twin, random):
    rig.lamp = twin.lamp = unit(np.array((0.5, -0.4, -0.77))), 0.6


right("right_light_field", dict(scene="ball+wall", small=True), plant=field_known,
      what="nothing; a hot spot of the projector, as the twin has it")
right("right_light_field_two_cameras", dict(scene="ball+wall", small=True, cameras=2), plant=field_known,
      what="nothing; two cameras, a hot spot of the projector, as the twin has it")
right("right_lamp", plant=lamp_known, what="nothing; a lamp at the side, as the twin has it")
right("right_lamp_wall", dict(scene="ball+wall", small=True), plant=lamp_known,
      what="nothing; a lamp at the side, as the twin has it: the sphere's shadow of it lies on the wall")


def coverage(what, rig=None, **expected):
    return planted("coverage", what, rig, verdict={"coverage": "not explained"}, **expected)


@coverage("the small sphere is not in the twin", dict(scene="balls"), says="real side only|only on the real side")
def object_missing_in_twin(rig, twin, random):
    twin.things.remove(twin.thing("small"))


@coverage("the twin has a second sphere that is not there", says="simulated side only|only on the simulated side")
def object_invented_by_twin(rig, twin, random):
    twin.things.append(solids.sphere("small", (33, 20, 303), 11.0))


@coverage("a sphere of 21 % of the area stands in front of the wall, the twin has the wall alone", dict(scene="wall"),
          says="coverage|side only")
def big_object_missing(rig, twin, random):
    rig.things.insert(0, solids.sphere("stranger", (-20, -10, 300), 20.0))


@coverage("POV-Ray's images; the second ball is not in the twin", dict(scene="balls", pinhole=True), povray=True,
          says="real side only|only on the real side")
def pov_missing_ball(rig, twin, random):
    twin.things.remove(twin.thing("small"))


@coverage("most of the object saturates in rig and twin (exposure 2.4 times)", dict(scene="ball+wall"), says="satur")
def saturated_mostly(rig, twin, random):
    rig.sensors[0]["gain_dn"] *= 2.4
    twin.sensors[0]["gain_dn"] *= 2.4


@coverage("most of the object saturates, the twin does not know", dict(scene="ball+wall"), says="satur")
def saturated_real_only(rig, twin, random):
    rig.sensors[0]["gain_dn"] *= 2.4


@planted("coverage", "the wall is nearly black in rig and twin: its fringes are below min_modulation",
         dict(scene="ball+wall"), verdict={"coverage": "not .*"}, says="modulation|dark")
def modulation_lost(rig, twin, random):
    for side in (rig, twin):
        side.thing("wall")["albedo"] = 0.004


@planted("coverage", "the second camera stands 6 mrad (5 px) elsewhere in the twin", dict(cameras=2),
         verdict={"gray": "not .*", "phase": "not .*"}, says="right")
def second_camera_turned(rig, twin, random):
    turn = solids.rotation((0, 6e-3, 0))
    twin.cameras[1].R = turn @ twin.cameras[1].R


@planted("coverage", "the second camera got 0.6 % of the light", dict(cameras=2), verdict={"gray": "not .*"}, says="right")
def second_camera_dark(rig, twin, random):
    rig.sensors[1]["gain_dn"] *= 0.006


def noise(name, what, k, rig=None, bright_image=False, **expected):
    """The twin states k times the noise that the images have; one image may be 2 % too bright besides."""
    def plant(rig, twin, random):
        twin.sensors[0]["read_noise_dn"] *= k
        twin.sensors[0]["electrons_per_dn"] /= k * k
        if bright_image:
            rig.image_factor = np.ones(len(rig.patterns()))
            rig.image_factor[5] = 1.02
    says = "too wide|times the noise" if k > 1 else ""
    add_case(name, "noise", what, plant, rig, says=says, **expected)


noise("noise_2x_wide", "the twin's noise is 2 times too wide", 2)
noise("noise_2x_wide_n3", "N = 3, the twin's noise is 2 times too wide", 2, dict(scene="wall", steps=3))
noise("noise_6x_wide_bright", "noise 6 times too wide, image 5 is 2 % too bright", 6, bright_image=True, causes="light")
noise("noise_6x_wide_bright_n3", "N = 3, noise 6 times too wide, image 5 is 2 % too bright", 6,
      dict(scene="wall", steps=3), bright_image=True, causes="light")
noise("noise_20x_wide", "noise 20 times too wide", 20)
noise("noise_20x_wide_bright", "noise 20 times too wide, image 5 is 2 % too bright", 20, bright_image=True)
noise("noise_20x_wide_bright_n3", "N = 3, noise 20 times too wide, image 5 is 2 % too bright", 20, dict(steps=3),
      bright_image=True)
noise("noise_half", "the rig has 2 times the noise of the twin", 1 / 2, verdict={"phase": "not explained"})
noise("noise_third_n3", "N = 3, the rig has 3 times the noise of the twin", 1 / 3, dict(steps=3),
      verdict={"phase": "not explained"}, fast=True)
