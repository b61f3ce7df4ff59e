# SPDX-License-Identifier: Apache-2.0
"""One error each, of a group that the program knows, large and small: the group must be named, alone or with others that fit
the images as well. What is planted is given in plain numbers."""
import numpy as np

from cases import add_case
from projection import rotation, vector
from rig import legendre_field

BALL, WALL, BOTH = dict(scene="ball"), dict(scene="wall", small=True), dict(scene="ball+wall", small=True)
FULL_BOTH = dict(scene="ball+wall")
CODED_WALL, CODED_BOTH = WALL | dict(unwrap="gray"), BOTH | dict(unwrap="gray")
TWO, N5, N6 = dict(scene="ball+wall", small=True, cameras=2), dict(steps=5), dict(steps=6)
GRAY = {"gray": "not explained"}


def listed(name, what, plant, rig, causes, **expected):
    add_case(name, "cause", what, plant, rig, causes=causes, **expected)


def moved(x, y, z):
    def plant(rig, twin, random):
        twin.things[0]["center_mm"] = twin.things[0]["center_mm"] + vector(x, y, z)
    return plant


def tilted(radians):
    def plant(rig, twin, random):
        twin.things[0]["normal"] = rotation((0, radians, 0)) @ twin.things[0]["normal"]
    return plant


def radius(off_mm):
    def plant(rig, twin, random):
        twin.things[0]["radius_mm"] += off_mm
    return plant


def turn(device, angles):
    """Turns a device of the twin about its own eye."""
    device.R, device.t = rotation(angles) @ device.R, rotation(angles) @ device.t


def projector_turned(*angles):
    return lambda rig, twin, random: turn(twin.projector, angles)


def second_camera_turned(*angles):
    return lambda rig, twin, random: turn(twin.cameras[1], angles)


def projector_k1(off):
    def plant(rig, twin, random):
        twin.projector.k1 += off
    return plant


def camera_middle(off_px):
    def plant(rig, twin, random):
        twin.cameras[0].principal_point[0] += off_px
    return plant


def camera_focal(factor):
    def plant(rig, twin, random):
        twin.cameras[0].focal_px *= factor
    return plant


listed("pose_40um", "the sphere is 0.037 mm off in the twin", moved(0.02, -0.01, 0.03), BALL, "pose")
listed("pose_40um_wall", "the sphere in front of a wall is 0.037 mm off in the twin", moved(0.02, -0.01, 0.03), FULL_BOTH,
       "pose")
listed("pose_tilt_100urad", "the wall is tilted by 0.1 mrad in the twin", tilted(1e-4), dict(scene="wall"), "pose")
listed("pose_tilt_100urad_n7", "N = 7, the wall is tilted by 0.1 mrad in the twin", tilted(1e-4),
       dict(scene="wall", steps=7), "pose")
listed("size_6um", "the sphere's radius is 0.006 mm too large in the twin", radius(0.006), BALL, "size")
listed("size_6um_wall", "the radius of the sphere in front of a wall is 0.006 mm too large in the twin", radius(0.006),
       FULL_BOTH, "size")
listed("rig_turned", "the projector is turned by 0.54 mrad in the twin", projector_turned(2e-4, -3e-4, 4e-4), FULL_BOTH,
       "rig")
listed("rig_turned_small", "the projector is turned by 0.1 mrad about its upright axis in the twin",
       projector_turned(0, 1e-4, 0), BOTH, "rig")
listed("rig_second_camera", "the second camera is turned by 0.3 mrad in the twin",
       second_camera_turned(1e-4, 2e-4, -2e-4), TWO, "rig")
listed("lens_k1", "k1 of the projector is 0.02 too large in the twin", projector_k1(0.02), WALL, "lens")
listed("lens_k1_small", "k1 of the projector is 0.004 too large in the twin", projector_k1(0.004), WALL, "lens")
listed("camera_middle", "the camera's principal point is 0.5 px off in the twin", camera_middle(0.5), BALL, "intrinsics")
listed("camera_middle_small", "the first of two cameras has its principal point 0.1 px off in the twin",
       camera_middle(0.1), TWO, "intrinsics")
listed("camera_focal", "the camera's focal length is 0.1 % too long in the twin", camera_focal(1.001), FULL_BOTH,
       "intrinsics")


def gamma(exponent):
    def plant(rig, twin, random):
        rig.projector_response = lambda level: level**exponent
    return plant


def third_harmonic(amplitude):
    """cos t becomes cos t + amplitude/0.45 cos 3t; 4 z^3 - 3 z is cos 3t of z = cos t."""
    def plant(rig, twin, random):
        rig.projector_response = lambda level: level + amplitude * (4 * ((level - 0.5) / 0.45)**3 - 3 * (level - 0.5) / 0.45)
    return plant


def blur(sigma_px):
    def plant(rig, twin, random):
        rig.blur_px = sigma_px
    return plant


listed("gamma_small", "the projector's gamma is 1.02", gamma(1.02), WALL, "response harmonics", verdict=GRAY,
       values={"projector.gamma": 1.02})
listed("harmonic_n6", "N = 6, a third harmonic of 2 % of the scale", third_harmonic(0.02), WALL | N6, "harmonics",
       verdict=GRAY, values={"projector.harmonic.3": 0.02})
listed("harmonic_small_n6", "N = 6, a third harmonic of 0.6 % of the scale", third_harmonic(0.006), WALL | N6, "harmonics",
       values={"projector.harmonic.3": 0.006})
listed("blur_small", "the projector's blur of 0.5 px is not in the twin", blur(0.5), dict(scene="wall"), "blur", verdict=GRAY)


def contrast_of(what, factor):
    """A factor on the fringes' contrast of the rig or of the twin."""
    def plant(rig, twin, random):
        (rig if what == "rig" else twin).amplitude *= factor
    return plant


listed("contrast_less", "the fringes of all pitches have 0.9 of their contrast", contrast_of("rig", 0.9), BALL, "fringe_contrast",
       verdict=GRAY, values={"projector.fringe_contrast": 0.9})
listed("contrast_more", "the twin's fringes have 0.96 of their contrast", contrast_of("twin", 0.96), BOTH, "fringe_contrast",
       gain=False, values={"projector.fringe_contrast": 1 / 0.96})


def vignetting(a1):
    """1 + a1 r^2, r = 1 in the corners of the image."""
    def plant(rig, twin, random):
        camera = rig.cameras[0]
        middle, half = vector((camera.width - 1) / 2, (camera.height - 1) / 2), np.hypot(camera.width, camera.height) / 2
        rig.camera_field = lambda x, y: 1 + a1 * ((x - middle[0])**2 + (y - middle[1])**2) / half**2
    return plant


def albedo(of_ball):
    def plant(rig, twin, random):
        twin.things[0]["albedo"] = of_ball
    return plant


def waves(depth):
    def plant(rig, twin, random):
        rig.reflectivity = lambda which, P: 1 + depth * np.sin(P[..., 0] * 0.9) * np.sin(P[..., 1] * 0.9)
    return plant


PER_PIXEL = "texture factor"
VARIES = dict(gain=False, verdict=GRAY)
listed("vignetting", "the camera sees 15 % less in the corners", vignetting(-0.15), BOTH, "vignetting", **VARIES,
       values={"left.vignetting.a1": -0.15, "left.vignetting_tilt.x": 0.0, "left.vignetting_tilt.y": 0.0})
listed("vignetting_small", "the camera sees 2 % less in the corners", vignetting(-0.02), BOTH, "vignetting", gain=False,
       values={"left.vignetting.a1": -0.02, "left.vignetting_tilt.x": 0.0, "left.vignetting_tilt.y": 0.0})
listed("albedo", "the sphere sends back 0.8, in the twin 0.72, the wall in both 0.8", albedo(0.72), BOTH, "albedo", **VARIES)
listed("albedo_small", "the sphere sends back 0.8, in the twin 0.79, the wall in both 0.8", albedo(0.79), BOTH, "albedo",
       gain=False)
listed("texture_small", "waves of 3 % in the albedo", waves(0.03), WALL, PER_PIXEL, **VARIES)


def room(share):
    """A gradient over the image up to that share of the full light, 10.2."""
    def plant(rig, twin, random):
        rig.room_light = lambda columns: share * 10.2 * columns / rig.cameras[0].width
    return plant


def flicker(share):
    def plant(rig, twin, random):
        rig.image_factor = 1 + share * random.uniform(-1, 1, len(rig.patterns()))
    return plant


DRIFT = np.linspace(-1, 1, 12)  # over the images


def light_drift(share):
    def plant(rig, twin, random):
        rig.image_factor = 1 + share * DRIFT
    return plant


def light_values(share):
    """ln of each image's light over the geometric mean, by the program's names."""
    ln = np.log(1 + share * DRIFT)
    return {f"image_{k}.light": float(ln[k] - ln.mean()) for k in range(1, len(ln))}


def side_lamp(rig, twin, random):
    rig.lamp = vector(0.5, -0.4, -0.77) / np.linalg.norm((0.5, -0.4, -0.77)), 0.6


def knee(slope, at=0.55):
    """Above this part of the scale the sensor's line is less steep."""
    def plant(rig, twin, random):
        rig.camera_response = lambda x: np.where(x > at, at + slope * (x - at), x)
    return plant


def camera_gamma(exponent):
    def plant(rig, twin, random):
        rig.camera_response = lambda x: np.maximum(x, 0)**exponent
    return plant


def knee_values(slope, at=0.55):
    """In the program's names: of a rig of 12 bits, whose black level is 2 % of full scale."""
    full = 4095
    return {"left.response.knee_dn": at * (full - round(0.02 * full)), "left.response.slope": slope}


def uneven_pixels(factor, offset_share):
    """Factors that scatter by this share, and offsets by this share of full scale; their means stay 1 and 0."""
    def plant(rig, twin, random):
        shape = rig.cameras[0].height, rig.cameras[0].width
        factors, offsets = 1 + factor * random.standard_normal(shape), random.standard_normal(shape)
        rig.pixel_factor = factors / factors.mean()
        rig.pixel_offset_dn = offset_share * rig.full * (offsets - offsets.mean())
    return plant


ROOM, SENSOR = "room_light ambient offset", "camera_response camera_knee sensor_response"
listed("room_light_small", "room light with a gradient over the image, up to 1 % of the full light", room(0.01), WALL,
       ROOM, gain=False)
listed("side_lamp", "a lamp at the side shines on the sphere, 6 % of the full light", side_lamp, BALL, ROOM, **VARIES)
listed("side_lamp_wall", "a lamp at the side shines on sphere and wall, 6 % of the full light", side_lamp, BOTH, ROOM,
       **VARIES)
listed("flicker_small", "the light flickers by 0.3 %", flicker(0.003), WALL, "light flicker")
listed("light_drift", "the light rises by 4 % from the first image to the last", light_drift(0.02), BALL, "light flicker",
       verdict=GRAY, values=light_values(0.02))
listed("light_drift_small", "the light rises by 1 % from the first image to the last", light_drift(0.005), WALL,
       "light flicker", values=light_values(0.005))
listed("knee", "the sensor's line bends by 10 % at 55 % of its scale", knee(0.9), BALL, SENSOR, verdict=GRAY,
       values=knee_values(0.9))
listed("knee_small", "the sensor's line bends by 3 % at 55 % of its scale", knee(0.97), WALL, SENSOR, gain=False,
       values=knee_values(0.97))
listed("knee_strong", "the sensor's line bends by 40 % at 45 % of its scale", knee(0.6, 0.45), WALL, "camera_knee",
       verdict=GRAY, values=knee_values(0.6, 0.45))
listed("knee_early", "the sensor's line bends by 15 % at 20 % of its scale", knee(0.85, 0.2), BOTH, "camera_knee",
       verdict=GRAY, values=knee_values(0.85, 0.2))
listed("uneven_gain", "the gains of the pixels scatter by 1 %", uneven_pixels(0.01, 0.0), WALL, PER_PIXEL, **VARIES)
listed("uneven_pixels", "gains of the pixels scatter by 1 %, offsets by 0.1 % of full scale", uneven_pixels(0.01, 1e-3), BALL,
       PER_PIXEL + " offset", **VARIES)
listed("uneven_offsets", "the offsets of the pixels scatter by 0.2 % of full scale", uneven_pixels(0.0, 2e-3), BALL, "offset",
       **VARIES)


def blur_of(real_px, twin_px):
    def plant(rig, twin, random):
        rig.blur_px, twin.blur_px = real_px, twin_px
    return plant


def halo(parts, blur_px=0.8):
    """Light that is spread further than the blur, which the twin knows."""
    def plant(rig, twin, random):
        rig.blur_px = twin.blur_px = blur_px
        rig.halo = parts
    return plant


listed("halo", "15 % of the projector's light is spread by 3 px, 8 % by 40 px", halo([(0.15, 3.0), (0.08, 40.0)]), CODED_BOTH,
       "halo", verdict=GRAY)
listed("halo_small", "4 % of the projector's light is spread by 25 px", halo([(0.04, 25.0)]), CODED_WALL, "halo", gain=False)


def blur_for_halo(rig, twin, random):
    """The twin's blur leaves the contrast that blur and halo together leave: from the steps of one pitch the two are one number,
    and only the images of the code tell."""
    halo([(0.15, 3.0), (0.08, 40.0)])(rig, twin, random)
    pitch = rig.pitches_px[0]
    twin.blur_px = float(np.sqrt(-np.log(rig.contrast(pitch) / rig.amplitude) * pitch**2 / (2 * np.pi**2)))


listed("blur_for_halo", "the same halo; the twin's blur was fitted to the contrast of the steps in its place", blur_for_halo,
       CODED_WALL, "halo", verdict={"code": "not explained", "phase": "explained"}, gain=False)
def halo_code_lit(rig, twin, random):
    """The images of the code are exposed by themselves."""
    halo([(0.15, 3.0), (0.08, 40.0)])(rig, twin, random)
    rig.image_factor = np.array([1.0 if kind == "step" else 1.04 + 0.02 * random.uniform(-1, 1)
                                 for kind, _, _ in rig.patterns()])


listed("halo_code_lit", "the same halo, and the images of the code get 2 to 6 % more light", halo_code_lit, CODED_BOTH, "halo",
       verdict=GRAY)
listed("blur_coded", "the projector's blur is 1.3 px, the twin's 0.8 px; a Gray code beside the steps", blur_of(1.3, 0.8), CODED_BOTH,
       "blur", verdict=GRAY, values={"projector.blur_px": 1.3})
listed("camera_gamma_small", "the camera's gamma is 0.99", camera_gamma(0.99), WALL, SENSOR, gain=False)


def hot_spot(height, width_px):
    """Brighter by `height` about (430, 280) of the projector's 800 x 600 pixels."""
    def plant(rig, twin, random):
        rig.projector_field = lambda u, v: 1 + height * np.exp(-((u - 430)**2 + (v - 280)**2) / (2 * width_px**2))
    return plant


def field(coefficients):
    """In the words of the twin's key."""
    def plant(rig, twin, random):
        rig.projector_field = legendre_field(coefficients)
    return plant


def field_values(coefficients):
    names = [f"projector.light_field.{order - j}_{j}" for order in range(1, 5) for j in range(order + 1)]
    return dict(zip(names, [*coefficients, *[0.0] * (len(names) - len(coefficients))]))


def field_tilt(rig, twin, random):
    rig.projector_field = lambda u, v: 1 + 0.1 * (u - 400) / 400 + 0.05 * (v - 300) / 300


def defocus(sigma_px):
    def plant(rig, twin, random):
        rig.camera_blur_px = sigma_px
    return plant


def vibration(rms_px):
    def plant(rig, twin, random):
        rig.fringe_shift_px = random.normal(0, rms_px, len(rig.patterns()))
    return plant


def drift(rig, twin, random):
    rig.fringe_shift_px = np.linspace(0, 0.4, len(rig.patterns()))


LATE = {4: 0.1, 9: 0.1}  # images whose exposures reach so far into the next pattern


def late_exposures(rig, twin, random):
    rig.exposure_late = [LATE.get(k, 0.0) for k in range(len(rig.patterns()))]


def read_out(periods):
    def plant(rig, twin, random):
        rig.read_out = periods
    return plant


def moving(x, y, z):
    def plant(rig, twin, random):
        rig.motion_mm = vector(x, y, z)
    return plant


def way(*mm):
    return {f"ball.center_mm.{axis}.motion": moved for axis, moved in zip("xyz", mm)}


def phong(specular):
    def plant(rig, twin, random):
        rig.specular = specular
    return plant


def wider_lobe(specular, shininess):
    """Rig and twin know of the gloss; the rig's lobe is that of an exponent, the twin's that of the usual one."""
    def plant(rig, twin, random):
        rig.specular = twin.specular = specular
        rig.shininess = shininess
    return plant


def below(mean_free_path_mm):
    def plant(rig, twin, random):
        rig.mean_free_path_mm = mean_free_path_mm
    return plant


def believed_bounce(rig, twin, random):
    twin.bounces = 1


BROAD = (0.06, -0.04, -0.18, 0.03, -0.12)
FIELD, SHIFT = "projector_field texture factor", "image_shift"
listed("field_tilt_two_cameras", "two cameras, the projector is brighter at one side by 20 %", field_tilt, TWO,
       "projector_field", **VARIES)
listed("light_field", "a hot spot of the projector, 35 % and as wide as its image", field(BROAD), BOTH, FIELD, **VARIES)
listed("light_field_flat", "one flat wall: a hot spot of the projector, which vignetting may be, too", field(BROAD), WALL,
       FIELD + " vignetting", **VARIES)
listed("light_field_two_cameras", "two cameras, a hot spot of the projector, 35 % and as wide as its image", field(BROAD), TWO,
       "projector_field", **VARIES, values=field_values(BROAD))
listed("hot_spot_small", "a hot spot of the projector, 3 %, 120 px wide", hot_spot(0.03, 120), WALL, FIELD, gain=False)
listed("camera_defocus", "the camera is out of focus by 0.9 px", defocus(0.9), BALL, "camera_psf", verdict=GRAY)
listed("camera_defocus_n5", "N = 5, the camera is out of focus by 0.9 px", defocus(0.9), dict(scene="wall") | N5,
       "camera_psf", verdict=GRAY)
listed("camera_defocus_large", "the camera is out of focus by 1.5 px", defocus(1.5), BOTH, "camera_psf", verdict=GRAY)
listed("vibration", "the fringes of each image are shifted at random by 0.1 px rms", vibration(0.1), BALL, SHIFT)
listed("step_errors", "the phase steps are wrong by 0.02 rad rms", vibration(0.02 * 15 / (2 * np.pi)), BALL, SHIFT)
listed("fringe_drift", "the fringes drift by 0.4 px from the first image to the last", drift, BALL, SHIFT)
# Only `--refine` knows this group.
add_case("late_exposure", "light", "the exposures of two images reach 0.1 into the next pattern; `--refine timing`", late_exposures,
         BALL, expect="explained", refine="timing", values={f"left.image_{k}.late": late for k, late in LATE.items()})
add_case("rolling_shutter", "light", "rows are exposed one after the other, the last one 0.25 of a pattern's time after the first; "
         "`--refine timing`", read_out(0.25), BALL, expect="explained", refine="timing",
         values={"left.timing.read_out": 0.25})
listed("motion", "the sphere moves by 0.05 mm while the images are taken", moving(0.04, 0.0, 0.03), BALL, "motion",
       values=way(0.04, 0.0, 0.03))
listed("motion_small", "the sphere moves by 0.03 mm while the images are taken", moving(0.02, 0.01, -0.02), BALL, "motion",
       values=way(0.02, 0.01, -0.02))
listed("specular", "Phong's lobe of 0.04 on the sphere is not in the twin", phong(0.04), BALL, "specular " + PER_PIXEL,
       **VARIES)
listed("specular_small", "Phong's lobe of 0.008 on the sphere is not in the twin", phong(0.008), BALL,
       "specular " + PER_PIXEL, gain=False)
listed("lobe_wider", "Phong's lobe of 0.04 on the sphere, of the exponent 6, in the twin of 10", wider_lobe(0.04, 6.0), BALL,
       "roughness", gain=False)
listed("lobe_narrower", "two cameras, Phong's lobe of 0.05 on sphere and wall, of the exponent 20, in the twin of 10",
       wider_lobe(0.05, 20.0), TWO, "roughness", **VARIES)
add_case("lobe_refined", "light", "Phong's lobe of 0.04 on the sphere, of the exponent 6, in the twin of 10; `--refine roughness`",
         wider_lobe(0.04, 6.0), BALL, expect="explained", refine="roughness", values={"ball.shininess": 6.0})
listed("subsurface_ball", "light goes 0.5 mm below the sphere's surface", below(0.5), BALL, "subsurface", verdict=GRAY,
       values={"ball.mean_free_path_mm": 0.5})
listed("subsurface_small", "light goes 0.05 mm below the sphere's surface", below(0.05), BALL, "subsurface", gain=False)
listed("subsurface_wall", "light goes 1 mm below a wall's surface", below(1.0), WALL, "subsurface", verdict=GRAY)
listed("subsurface_both", "light goes 2 mm below sphere and wall", below(2.0), FULL_BOTH, "subsurface", verdict=GRAY,
       values={"ball.mean_free_path_mm": 2.0, "wall.mean_free_path_mm": 2.0})
listed("subsurface_two_cameras", "two cameras, light goes 1 mm below sphere and wall", below(1.0), TWO, "subsurface", verdict=GRAY)
add_case("subsurface_refined", "light", "two cameras, light goes 1 mm below sphere and wall; `--refine subsurface`", below(1.0), TWO,
         expect="explained", refine="subsurface", values={"ball.mean_free_path_mm": 1.0, "wall.mean_free_path_mm": 1.0})
listed("bounce", "a groove; the twin has light that goes from one side to the other, the rig has not", believed_bounce,
       dict(scene="groove", small=True, nodes=24), "bounce", verdict=GRAY, gain=False)
listed("bounce_small", "sphere and wall; the twin has light that goes from one to the other, the rig has not",
       believed_bounce, BOTH, "bounce", gain=False)
