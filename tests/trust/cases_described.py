# SPDX-License-Identifier: Apache-2.0
"""Images in another order than told, and fringes described wrongly: each must be named with what would fit."""
from cases import add_case, planted


def sequence(name, what, order, says, rig=None):
    """order(images, steps): which pattern each recorded image shows."""
    def plant(rig, twin, random):
        rig.image_order = order(len(rig.patterns()), rig.steps)
    add_case(name, "sequence", what, plant, rig, says=says, measure=True)


def one_late(images, steps):
    return [0, *range(images - 1)]


LATE = r"one image late|images? 1 .*(repeats|same).* 0\b"
sequence("sequence_late", "every image is the one before it, the first comes twice", one_late, LATE)
sequence("sequence_late_n3", "N = 3, every image is the one before it", one_late, LATE, dict(steps=3))
sequence("sequence_late_two_cameras", "two cameras, every image is the one before it", one_late, LATE,
         dict(cameras=2, scene="ball+wall"))
sequence("sequence_late_wrap", "every image is the one before it, the first is the last", lambda n, N: [n - 1, *range(n - 1)],
         r"one image late|last image.*first")
sequence("sequence_early", "every image is the one after it, the last comes twice", lambda n, N: [*range(1, n), n - 1],
         r"one image early|11 .*(repeats|same).* 10\b")
sequence("sequence_swap", "images 2 and 3 are swapped", lambda n, N: [0, 1, 3, 2, *range(4, n)], r"2 and 3\b.* swap")
sequence("sequence_swap_n6", "N = 6, images 3 and 4 are swapped", lambda n, N: [0, 1, 2, 4, 3, *range(5, n)],
         r"3 and 4\b.* swap", dict(steps=6))
sequence("sequence_pitches", "the images of the first two pitches are exchanged",
         lambda n, N: [*range(N, 2 * N), *range(N), *range(2 * N, n)], r"pitches.* 14, 13, 15")
sequence("sequence_repeat", "image 7 repeats image 6", lambda n, N: [*range(7), 6, *range(8, n)], r"image 7 repeats image 6")
sequence("steps_reversed", "the steps run backwards", lambda n, N: [N * (k // N) + -(k % N) % N for k in range(n)],
         "revers", dict(scene="ball+wall"))


def description(what, says, rig=None, **expected):
    return planted("description", what, dict(scene="ball+wall") | (rig or {}), says=says, **expected)


CODE = dict(unwrap="gray")
ABOVE = dict(projector_above=True, direction="y")


@description("projector above the camera, fringes along x, as told: hardly any depth", "direction", ABOVE, expect="any",
             measure=True)
def direction_without_depth(rig, twin, random):
    rig.direction = twin.direction = "x"


@description("the rig throws fringes along y, the twin says x", "direction", ABOVE)
def direction_other(rig, twin, random):
    twin.direction = "x"


@description("phase_origin_px half a period off (Gray code)", "phase_origin", CODE)
def origin_half_period(rig, twin, random):
    twin.origin_px += 8.0


@description("phase_origin_px half a period off (heterodyne)", "phase_origin")
def origin_half_period_heterodyne(rig, twin, random):
    twin.origin_px += 6.5


@description("the rig shows the lowest bit first, the twin says highest first", "bits of the code|lsb", CODE, measure=True)
def bit_order(rig, twin, random):
    rig.code["order"] = "lsb-first"


@description("the code begins a quarter of a period later than told, which its complementary bit allows for", "", CODE,
             verdict={"code": "not explained", "gray": "explained", "phase": "explained", "geometry": "explained",
                      "coverage": "explained"})
def code_quarter_period(rig, twin, random):
    rig.code["offset_periods"] = 0.25


@description("the code begins half a period later than told", "offset_periods|code 0.5", CODE, measure=True)
def code_half_period(rig, twin, random):
    rig.code["offset_periods"] = 0.5


@description("the complementary bit is shown inverted", "complement|invert", CODE, measure=True)
def complementary_inverted(rig, twin, random):
    rig.inverted_image = len(rig.patterns()) - 1


@description("seven plain bits told as six and a complementary one", "complement", CODE, measure=True)
def complementary_is_bit(rig, twin, random):
    rig.code.update(bits=7, complementary=False)


@description("pitches told 15, 14, 13 in place of 13, 14, 15", r"pitches.* 13, 14, 15", measure=True)
def pitch_order(rig, twin, random):
    twin.pitches_px = [15, 14, 13]
