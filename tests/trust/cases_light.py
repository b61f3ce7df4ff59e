# SPDX-License-Identifier: Apache-2.0
"""Light, projector, sensor and colours of surfaces that are not as the twin says: what biases the gain."""
import numpy as np

from cases import add_case, planted
from rig import PROJECTOR_SIZE

WALL, BALL_N3 = dict(scene="wall"), dict(steps=3)
RESPONSE = "response harmonics"


@planted("light", "a full well clips at 3600 of 4095", expect="any", says=r"\b3600\b")
def full_well(rig, twin, random):
    rig.sensors[0]["gain_dn"] *= 1.25
    rig.full_well_dn = 3600


@planted("light", "room light with a gradient over the image, up to 5 % of the full light", WALL,
         verdict={"gray": "not explained"}, causes="room_light ambient offset")
def room_gradient(rig, twin, random):
    rig.room_light = lambda columns: 0.05 * 10.2 * columns / 360


def flickering(rig, twin, random):
    rig.image_factor = 1 + 0.02 * random.uniform(-1, 1, len(rig.patterns()))


add_case("flicker", "light", "the light flickers by 2 %", flickering, causes="light flicker")
add_case("flicker_n3", "light", "N = 3, the light flickers by 2 %", flickering, BALL_N3, causes="light flicker")


@planted("light", "the images of the code get 3 % more light than the phase steps", WALL | dict(unwrap="gray", small=True),
         expect="any", verdict={"gray": "explained", "phase": "explained", "code": "explained"},
         says="images of the code have other light")
def code_lit(rig, twin, random):
    rig.image_factor = np.array([1.0 if kind == "step" else 1.03 for kind, _, _ in rig.patterns()])


@planted("light", "the camera's gamma is 0.95", verdict={"gray": "not explained"}, causes="sensor_response camera_response")
def camera_gamma(rig, twin, random):
    rig.camera_response = lambda x: np.maximum(x, 0)**0.95


@planted("light", "the projector's blur of 2.2 px is not in the twin", verdict={"gray": "not explained"}, says="blur",
         causes="blur", fast=True)
def blur_missing(rig, twin, random):
    rig.blur_px = 2.2


@planted("light", "8 bits, the projector's blur of 1.8 px is not in the twin", WALL | dict(bits=8),
         verdict={"gray": "not explained"}, says="blur", causes="blur")
def blur_missing_8bit(rig, twin, random):
    rig.blur_px = 1.8


@planted("light", "POV-Ray's images; the projector's blur of 1.5 px is not in the twin",
         dict(scene="ball+wall", pinhole=True), povray=True, verdict={"gray": "not explained"}, says="blur", causes="blur")
def pov_blur(rig, twin, random):
    rig.blur_px = 1.5


@planted("light", "square fringes (third harmonic of 33 %)", verdict={"gray": "not explained"},
         says="harmonic|sinus|response", causes=RESPONSE)
def third_harmonic(rig, twin, random):
    rig.projector_response = lambda level: np.where(level > 0.5, 0.95, 0.05)


def projector_gamma(rig, twin, random):
    rig.projector_response = lambda level: level**1.15


add_case("gamma_n3", "light", "N = 3, the projector's gamma is 1.15", projector_gamma, BALL_N3,
         verdict={"gray": "not explained", "phase": "not explained"}, says=RESPONSE.replace(" ", "|"), causes=RESPONSE,
         values={"projector.gamma": 1.15})
add_case("gamma_n4", "light", "N = 4, the projector's gamma is 1.15", projector_gamma,
         verdict={"gray": "not explained"}, says=RESPONSE.replace(" ", "|"), causes=RESPONSE,
         values={"projector.gamma": 1.15})


def checkered(rig, twin, random):
    rig.reflectivity = lambda which, P: np.where(
        (np.floor(P[..., 0] / 8) + np.floor(P[..., 1] / 8)) % 2 > 0, 1.0, 0.35)


TEXTURED = dict(gain=False, verdict={"gray": "not .*"}, says="texture|reflectivity", causes="texture albedo")
add_case("checker", "surface", "squares of 8 mm, 1 and 0.35 of the albedo", checkered, WALL, **TEXTURED)
add_case("checker_n3", "surface", "N = 3, squares of 8 mm, 1 and 0.35 of the albedo", checkered, WALL | BALL_N3,
         **TEXTURED)


@planted("surface", "a dark board (4 %) with bright circles", WALL, **TEXTURED)
def dark_board(rig, twin, random):
    def circles(which, P):
        x, y = np.mod(P[..., 0], 16) - 8, np.mod(P[..., 1], 16) - 8
        return np.where(x * x + y * y < 16, 1.0, 0.04)
    rig.reflectivity = circles


@planted("surface", "the albedo falls by 6 % across the sphere, as the shading does", verdict={"gray": "not explained"},
         causes="texture albedo")
def albedo_with_shading(rig, twin, random):
    rig.reflectivity = lambda which, P: 1 + 0.03 * (P[..., 0] - 3) / 27


def unchanged_but_textured(rig, twin, random):
    """The texture is in POV-Ray's scene."""


add_case("pov_texture", "surface", "POV-Ray's images; smooth texture of 15 %", unchanged_but_textured,
         dict(scene="ball+wall", pinhole=True), povray=True, texture="*(0.85+0.15*sin(0.9*x)*sin(0.9*y))", **TEXTURED)


def checkered_finely(rig, twin, random):
    """Squares of 1.6 to 1.9 pixels, so that hardly a pixel sees one of them alone."""
    rig.reflectivity = lambda which, P: np.where(
        (np.floor(P[..., 0] / 1.3) + np.floor(P[..., 1] / 1.3)) % 2 > 0, 1.0, 0.6)


def checkered_and_lens(rig, twin, random):
    checkered(rig, twin, random)
    twin.projector.k1 += 0.02


# Each pixel's own factor is fitted: what the edges do to the phase within a pixel stays, and is no reason to take it back.
FITTED = dict(scene="wall", small=True, nodes=12)  # 12: the edges cut pixels anywhere
OWN = dict(gain=False, refine="texture,offset")
add_case("refine_checker", "surface", "squares of 8 mm, 1 and 0.35 of the albedo; `--refine texture,offset`", checkered,
         FITTED, expect="any", verdict={"phase": "explained", "coverage": "explained"}, **OWN)
add_case("refine_checker_spread", "surface",
         "squares of 8 mm, 1 and 0.35 of the albedo, too sharp for it; `--refine texture,texture_spread,offset`", checkered,
         FITTED, expect="any", verdict={"phase": "explained", "coverage": "explained"}, gain=False,
         refine="texture,texture_spread,offset")
add_case("refine_fine_checker", "surface", "squares of 1.3 mm, 1 and 0.6 of the albedo; `--refine texture,offset`",
         checkered_finely, FITTED, expect="any", verdict={"coverage": "explained"}, **OWN)
add_case("refine_checker_lens", "surface",
         "squares of 8 mm, 1 and 0.35 of the albedo, the projector's k1 is 0.02 off; `--refine texture,offset`",
         checkered_and_lens, FITTED, verdict={"phase": "not explained"}, causes="lens rig pose intrinsics", **OWN)


def waves_before_a_blurred_camera(rig, twin, random):
    """The camera's blur is known; that it mixes reflectivity and fringes within a pixel is not in the twin."""
    rig.camera_blur_px = twin.camera_blur_px = 0.9
    rig.pitches_px = twin.pitches_px = [40, 44, 48]  # half a radian from pixel to pixel; the linear model is for such
    rig.reflectivity = lambda which, P: 0.65 * (1 + 0.4 * np.sin(0.8 * P[..., 0]) * np.sin(0.7 * P[..., 1]))


add_case("refine_texture_spread", "surface", "waves of 40 % in the albedo before a camera whose known blur is 0.9 px; "
         "`--refine texture,texture_spread,offset`", waves_before_a_blurred_camera, FITTED, expect="explained", gain=False,
         refine="texture,texture_spread,offset", values={"left.texture_spread_px": float(np.sqrt(1 / 12 + 0.9**2))})


BLUR_FIELD = dict(u=0.5, v=-0.4, u2=0.9, uv=0.3, v2=0.6)  # px^2, beside 1.5^2: contrasts fall by 5 % to the corners


def sharper_in_the_middle(rig, twin, random):
    def more(u, v):
        a, b = (2 * (x + 0.5) / size - 1 for x, size in zip((u, v), PROJECTOR_SIZE))
        return sum(c * t for c, t in zip(BLUR_FIELD.values(), (a, b, a * a, a * b, b * b)))
    rig.blur_px = twin.blur_px = 1.5
    rig.blur_field = more


add_case("refine_blur_field", "surface", "the projector is sharper in its middle than in its corners; `--refine blur,blur_field`",
         sharper_in_the_middle, dict(scene="wall", small=True), expect="explained", refine="blur,blur_field",
         values={"projector.blur_px": 1.5, **{f"projector.blur_field_px2.{k}": c for k, c in BLUR_FIELD.items()}})


# (cosine, sine) of the fifth harmonic: the same all over, and by terms over the projector's image
FIFTH = {"": (0.01, 0.006), "1_0": (0.01, 0.02), "2_0": (-0.03, 0.02)}


def fifth_harmonic_over_the_projector(rig, twin, random):
    """A parabola across the projector's image, of which the camera sees a part."""
    def more(phase, u, v):
        a = 2 * (u + 0.5) / PROJECTOR_SIZE[0] - 1
        terms = {"": 1, "1_0": a, "2_0": (3 * a * a - 1) / 2}
        return sum(terms[t] * (c * np.cos(5 * phase) + s * np.sin(5 * phase)) for t, (c, s) in FIFTH.items())
    rig.waveform = more
    rig.pitches_px = twin.pitches_px = [60, 64, 68]  # pixels resolve a fifth of these


FIFTH_NAMES = {t: "projector.harmonic." if t == "" else f"projector.harmonics_field.{t}." for t in FIFTH}
add_case("refine_harmonics_field", "light", "the fringe's fifth harmonic follows a parabola across the projector's image, of which "
         "the camera sees a part; `--refine harmonics,harmonics_field`", fifth_harmonic_over_the_projector,
         dict(scene="ball", steps=8, nodes=6), expect="explained", refine="harmonics,harmonics_field",
         values={FIFTH_NAMES[t] + "5" + name: part for t, pair in FIFTH.items()
                 for name, part in zip(("", ".quadrature"), pair)})


def projector_steps(rig, twin, random):
    """A response that waves about its line, as of a table with few entries: harmonics up to the fourteenth."""
    rig.projector_response = lambda level: level + 0.003 * np.sin(2 * np.pi * 4 * level)
    rig.pitches_px = twin.pitches_px = [60, 64, 68]


add_case("refine_harmonics_high", "light", "the projector's response waves about its line by 0.3 % of the scale, four times over "
         "it; `--refine harmonics,harmonics_high`", projector_steps, dict(scene="wall", small=True, steps=12, nodes=6),
         expect="explained", refine="harmonics,harmonics_high")


SHORT = {5: 0.03, 10: 0.02}  # images whose exposures miss so much of the light of bright levels


def light_missed(lost):
    """More of bright levels than of dark ones: what a part of the projector's frame shows, as its blur leaves it."""
    return lambda phase: -lost / 2 * (1 + np.tanh(np.cos(phase) / 0.4))


def exposed_in_part(rig, twin, random):
    rig.image_waveform = {k: light_missed(lost) for k, lost in SHORT.items()}
    rig.pitches_px = twin.pitches_px = [60, 64, 68]


def exposed_in_part_on_checker(rig, twin, random):
    exposed_in_part(rig, twin, random)
    flickering(rig, twin, random)
    rig.reflectivity = lambda which, P: 1 + 0.1 * np.sin(P[..., 0] / 3) * np.sin(P[..., 1] / 4)


def waveforms_found(mean, amplitude):
    """The lost light as a factor on all of the image's light, and the harmonics besides."""
    phases, out = np.arange(4096) / 4096 * 2 * np.pi, {}
    for k, lost in SHORT.items():
        missed = light_missed(lost)(phases)
        factor = 1 + np.mean(missed) / mean
        for order in range(1, 7):
            size = 2 * np.mean(missed * np.cos(order * phases)) + (amplitude if order == 1 else 0)
            out[f"image_{k}.harmonic.{order}"] = size / factor - (amplitude if order == 1 else 0)
    return out


EIGHT = dict(scene="ball", steps=8, nodes=6)
add_case("short_exposures", "light", "the exposures of two images miss a part of the projector's frame: 3 and 2 % of the light of "
         "bright levels", exposed_in_part, EIGHT, verdict={"gray": "not explained"}, says="varies from image to image", gain=False)
add_case("short_exposures_refined", "light", "the same; `--refine light,image_harmonics`", exposed_in_part, EIGHT, expect="explained",
         refine="light,image_harmonics", values=waveforms_found(0.5, 0.45), gain=False)
add_case("short_exposures_textured", "light", "the same, with light that flickers by 2 % on a texture of 10 %; "
         "`--refine light,image_harmonics,texture,offset`", exposed_in_part_on_checker,
         dict(scene="wall", small=True, steps=8, nodes=6), expect="explained", gain=False,
         refine="light,image_harmonics,texture,offset")


# (cosine, sine) of what the shown levels are off, as of fringes of few levels: of orders that pixels do not resolve
FINE = {55: (0.012, -0.004), 58: (0.0, 0.008)}


def fine_levels_shown_by_pixels(rig, twin, random):
    rig.fine_levels = lambda phase: sum(c * np.cos(k * phase) + s * np.sin(k * phase) for k, (c, s) in FINE.items())
    rig.pitches_px = twin.pitches_px = [60, 64, 68]
    rig.blur_px = twin.blur_px = 0.6
    twin.raster = (1, 54, [(0, 0)] * 5)


def raster_told(rig, twin, random):
    fine_levels_shown_by_pixels(rig, twin, random)
    twin.raster = (1, 54, [FINE.get(k, (0, 0)) for k in range(54, 59)])


FINE_WALL = dict(scene="wall", small=True, steps=8, nodes=6)
add_case("fine_levels", "light", "what pixels of the projector show is off by 1.3 % and 0.8 % in waves of the orders 55 and 58, which "
         "beat with the pixels", fine_levels_shown_by_pixels, FINE_WALL, verdict={"gray": "not explained"})
add_case("fine_levels_told", "light", "the same; the twin says it", raster_told, FINE_WALL, expect="explained")
add_case("fine_levels_refined", "light", "the same; the twin names the orders, `--refine raster`", fine_levels_shown_by_pixels, FINE_WALL,
         expect="explained", refine="raster",
         values={f"projector.raster.x.{k}{name}": part for k, pair in FINE.items() for name, part in zip(("", ".quadrature"), pair)})


def saturating(x):
    """Straight up to a twentieth of the scale, then less and less steep: 5.5 % below the line at full scale."""
    over = np.maximum(x - 0.05, 0)
    return np.minimum(x, 0.05) + 8 * (1 - np.exp(-over / 8))


def bent(response, textured):
    def plant(rig, twin, random):
        rig.camera_response = response
        if textured:
            rig.reflectivity = lambda which, P: 0.65 * (1 + 0.45 * np.sin(0.04 * P[..., 0] + 1) * np.sin(0.03 * P[..., 1] + 1))
    return plant


def knee_at_045(x):
    return np.where(x > 0.45, 0.45 + 0.8 * (x - 0.45), x)


BENT = dict(scene="wall", small=True)
add_case("refine_bend", "light", "the camera's gray values saturate by 5.5 %; `--refine camera_response`",
         bent(saturating, False), BENT, expect="explained", refine="camera_response")
add_case("refine_bend_texture", "light", "the camera's gray values saturate by 5.5 %, and waves of 45 % in the albedo; "
         "`--refine camera_response,texture,offset`", bent(saturating, True), BENT, expect="explained", gain=False,
         refine="camera_response,texture,offset")
add_case("refine_knee_texture", "light", "the sensor's line bends by 20 % at 45 % of its scale, and waves of 45 % in the "
         "albedo; `--refine camera_knee,texture,offset`", bent(knee_at_045, True), BENT, expect="explained", gain=False,
         refine="camera_knee,texture,offset",
         values={"left.response.knee_dn": 0.45 * (4095 - 82), "left.response.slope": 0.8})
