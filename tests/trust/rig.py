# SPDX-License-Identifier: Apache-2.0
"""A rig of known truth and the gray values that its cameras record, in numpy's double precision.

Nothing here is code of the program. A pixel is an integral over its area by Gauss-Legendre nodes: midpoints would leave
theta^2 / (24 n^2) of the fringe's amplitude, theta the fringe's phase over a pixel, which is 0.1 % for 0.8 rad and
n = 5 and would be taken for the program's error. The same class serves as the rig and, copied, as what its user believes
(the twin); a case plants a difference in one of them."""
import math

import numpy as np

import solids
from below import Below
from projection import Device, aimed_at, vector

PROJECTOR_SIZE = (800, 600)
CAMERA_NAMES = ("left", "right")
BEYOND_MM = 1e4  # on the way to a far lamp: behind all objects
NORMAL_AT = np.linspace(-9, 9, 18001)
NORMAL_CDF = np.array([0.5 * math.erfc(-x / math.sqrt(2)) for x in NORMAL_AT])  # straight between: off by 3e-8


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def blurred(images, sigma_px, reach):
    """Images less a margin of `reach` pixels under a Gaussian point spread. Its samples serve for 0.7 px and more: less than
    1e-3 of a fringe is aliased."""
    kernel = np.exp(-np.arange(-reach, reach + 1)**2 / (2 * sigma_px**2))
    kernel /= kernel.sum()
    for axis in (1, 2):
        size = images.shape[axis] - 2 * reach
        images = sum(weight * images.take(range(i, i + size), axis) for i, weight in enumerate(kernel))
    return images


def mean_between(first, last, at, integral):
    """The mean of a function from `first` to `last`, by its integral tabulated at the coordinates `at`: nodes would miss a code's
    edges."""
    width = np.where(np.abs(last - first) > 1e-6, last - first, 1e-6)
    return (np.interp(first + width, at, integral) - np.interp(first, at, integral)) / width


def legendre_field(coefficients):
    """(u, v) -> factor whose logarithm is a sum of Legendre's P_i P_j, by rising order i + j and falling i, over the projector's
    image from -1 to 1."""
    orders = [(order - j, j) for order in range(1, 5) for j in range(order + 1)]

    def factor(u, v):
        table = np.zeros((5, 5))
        for (i, j), c in zip(orders, coefficients):
            table[i, j] = c
        a, b = (2 * (x + 0.5) / size - 1 for x, size in zip((u, v), PROJECTOR_SIZE))
        return np.exp(np.polynomial.legendre.legval2d(np.clip(a, -1, 1), np.clip(b, -1, 1), table))
    return factor


def things_of(scene):
    ball = solids.sphere("ball", (3, -2, 292), 27.0)
    wall = solids.plane("wall", (0, 0, 335), (0.06, -0.04, -1))
    small = solids.sphere("small", (33, 20, 303), 11.0)
    stone = solids.gem("gem", (0.25, -0.35, 0.1, 1, 2, 300))
    groove = [solids.plane(name, (0, 0, 335), (slope, 0, -1)) for name, slope in (("right_side", -0.6), ("left_side", 0.6))]
    return {"ball": [ball], "wall": [wall], "ball+wall": [ball, wall], "balls": [ball, small], "gem": [stone],
            "groove": groove}[scene]


class Rig:
    def __init__(self, scene="ball", cameras=1, steps=4, bits=12, direction="x", projector_above=False,
                 unwrap="heterodyne", nodes=3, pinhole=False, small=False, large=False):
        self.place_devices(cameras, projector_above, pinhole, (200, 150) if small else (720, 540) if large else (360, 270))
        self.things = things_of(scene)
        self.direction, self.steps, self.unwrap, self.origin_px = direction, steps, unwrap, 0.0
        # Pixels of a small image are wider, so the fringes are, too.
        self.pitches_px = [16] if unwrap == "gray" else [18, 20, 22] if small else [13, 14, 15]
        self.code = dict(bits=6, order="msb-first", complementary=True, offset_periods=0.0)
        self.mean, self.amplitude, self.intensity, self.blur_px = 0.5, 0.45, 40.0, 0.0
        self.bits, self.full = bits, 2**bits - 1
        # A white surface of albedo 0.8 that faces the projector fills three quarters of the scale.
        self.sensors = [dict(gain_dn=0.75 * self.full / (0.8 / np.pi * self.intensity) * (1 - 0.03 * c),
                             black_dn=round(0.02 * self.full) + 3.0 * c, electrons_per_dn=9000 / self.full,
                             read_noise_dn=self.full * 4e-4 + 0.5) for c in range(cameras)]
        self.nodes = nodes
        self.gate_mm = 3.0
        self.bounces = 0  # what a twin believes of light from surface to surface; the rig itself has none
        # What a case may plant besides, as functions; None: nothing.
        self.reflectivity = None  # (object, points) -> factor on the albedo
        self.gloss = None  # (cosine between normal and half vector) -> factor on the light sent back
        self.specular, self.shininess = 0.0, 10.0  # Phong's lobe, as docs/PHYSICS.md has it, on every object
        self.scatter = 0.0  # the share of the light that comes out of the surface elsewhere: fringes become their mean
        self.mean_free_path_mm = 0.0  # of light below the surface of every object; phase steps alone know it
        self.projector_field = None  # (u, v) -> factor on the projector's light
        self.light_field = []  # what a twin believes of it: ln of the factor, terms of Legendre's products
        self.room_light = None  # (pixel columns) -> irradiance beside the projector's
        self.lamp = None  # unit vector towards a far lamp that is on all the time, and its irradiance on a white surface
        self.besides_factor = None  # a factor on the light of room and lamp in each image
        self.blur_field = None  # (u, v) -> variance in px^2 by which the blur of the fringes differs from blur_px there
        self.waveform = None  # (phase in rad, u, v) -> light that phase steps have besides a sinusoid's
        self.fine_levels = None  # (phase in rad) -> what a pixel of the projector shows besides, from the phase in its middle
        self.raster = None  # what a twin says of it: (pitch in px, first order, [(cosine, sine), ...])
        self.image_waveform = {}  # image -> (phase in rad) -> light that this phase step has besides
        self.halo = []  # (share, sigma in px) of light that the projector spreads further than its blur
        self.image_factor = None  # a factor on the light of each image
        self.fringe_shift_px = None  # how far the fringes of each image are shifted along the projector's coordinate
        self.motion_mm = None  # way of the first object (a sphere) from the first image to the last, about its place
        self.exposure_late = None  # of each image: how much after its pattern its exposure begins, of the time to the next image
        self.read_out = 0.0  # how much later the last row of a camera begins than the first, in the same unit
        self.camera_field = None  # (column, row) -> factor on what a camera sees
        self.camera_blur_px = 0.0  # sigma of the camera's own blur
        self.projector_response = None  # drive level -> light
        self.camera_response = None  # 0..1 -> 0..1, before noise
        self.pixel_factor = self.pixel_offset_dn = None  # of each pixel of all cameras (PRNU, DSNU)
        self.full_well_dn = None  # gray value at which a pixel is full
        self.image_order = None  # recorded image k shows pattern image_order[k]
        self.inverted_image = None  # the image that is shown as its negative

    def place_devices(self, cameras, projector_above, pinhole, size):
        width, height = size
        focal = 2.45 * width
        k1 = 0.0 if pinhole else 1.0
        middle = ((width - 1) / 2, (height - 1) / 2) if pinhole else (width / 2 - 0.3, height / 2 + 0.7)
        self.cameras = [Device(width, height, focal, middle, -0.08 * k1, np.eye(3), (0, 0, 0))]
        target = vector(0, 0, 300)
        if cameras == 2:
            R, t = aimed_at(vector(120, -4, 8), target)
            self.cameras.append(Device(width, height, focal * 1.01, (width / 2 + 2, height / 2 - 1), -0.06, R, t))
        eye, up = (vector(4, -110, 6), (0.03, 1, 0)) if projector_above else (vector(-110, 9, 6), (0, 1, 0))
        self.projector = Device(*PROJECTOR_SIZE, 1520.0, (402, 297), 0.03 * k1, *aimed_at(eye, target, up))

    def thing(self, name):
        return next(t for t in self.things if t["name"] == name)

    def patterns(self):
        """(kind, pitch or bit, step) of every image of the sequence, in order."""
        out = [("step", p, n) for p in range(len(self.pitches_px)) for n in range(self.steps)]
        if self.unwrap == "gray":
            bits = range(self.code["bits"])
            out += [("bit", b, 0) for b in (bits if self.code["order"] == "lsb-first" else reversed(bits))]
            out += [("complementary", 0, 0)] if self.code["complementary"] else []
        return out

    def contrast(self, pitch):
        """The amplitude that the projector's blur and halo leave."""
        return self.amplitude * sum(share * np.exp(-2 * np.pi**2 * sigma**2 / pitch**2) for share, sigma in self.spreads())

    def spreads(self):
        """(share, sigma in px) of each Gaussian that the projector's light is spread by."""
        rest = 1 - sum(share for share, _ in self.halo)
        return [(rest, self.blur_px)] + [(share, np.hypot(self.blur_px, sigma)) for share, sigma in self.halo]

    def light(self, pattern, u, more_blur_px2=0.0, place=None, below=None, besides=None):
        """What the projector throws in a phase step at projector coordinate u, 0 ... 1, where its blur differs by
        more_blur_px2; place: (u, v) there, for a waveform that is not the same all over; below: what surfaces make of it; besides:
        (phase in rad) -> light of this image alone."""
        _, k, n = pattern
        pitch = self.pitches_px[k]
        phase = 2 * np.pi * ((u - self.origin_px) / pitch + n / self.steps)
        kept = np.exp(-2 * np.pi**2 * more_blur_px2 / pitch**2)
        if below:
            inside = below.kept(pitch)
            kept, phase = kept * np.abs(inside), phase + np.angle(inside)
        level = self.mean + kept * self.contrast(pitch) * np.cos(phase)
        if self.projector_response:
            level = self.projector_response(level)
        level = level + self.waveform(phase, *place) if self.waveform else level
        level = level + self.light_of_pixels(u, pitch, n) if self.fine_levels else level
        return level + besides(phase) if besides else level

    def light_of_pixels(self, u, pitch, step):
        """The sum over the projector's pixels near u, each a square of one level, spread by the blur."""
        def left_of(x):
            return np.interp(x / self.blur_px, NORMAL_AT, NORMAL_CDF)
        out, middle = np.zeros_like(u), np.round(u)
        for pixel in (middle + j for j in range(-8, 9)):
            level = self.fine_levels(2 * np.pi * ((pixel - self.origin_px) / pitch + step / self.steps))
            out += level * (left_of(u - pixel + 0.5) - left_of(u - pixel - 0.5))
        return out

    def bit_integral(self, pattern):
        """Projector coordinates, and the integral up to there of what the projector throws in an image of the code: tabulated in
        sixteenths of a pixel about the code's edges, spread by each Gaussian."""
        kind, k, _ = pattern
        spread = self.blur_px > 0 or bool(self.halo)
        reach = np.ceil(8 * max(sigma for _, sigma in self.spreads()))
        at = self.origin_px + np.arange(-reach - 16, PROJECTOR_SIZE[0] + reach + 16, 1 / 16)  # ends of cells
        sharp = self.bit(kind, k, at[:-1] + 1 / 32)
        shown = np.zeros_like(sharp) if spread else sharp
        for share, sigma in self.spreads() if spread else []:
            offsets = np.arange(-np.ceil(6 * sigma * 16), np.ceil(6 * sigma * 16) + 1) / 16
            kernel = np.exp(-0.5 * (offsets / max(sigma, 1e-6))**2)
            shown = shown + share * np.convolve(sharp, kernel / kernel.sum(), mode="same")
        return at, np.concatenate([[0], np.cumsum(shown)]) / 16

    def bit(self, kind, k, u):
        """A bit of the code as it is shown, at projector coordinate u."""
        period = (u - self.origin_px) / self.pitches_px[0] - self.code["offset_periods"]
        number = np.floor(2 * period if kind == "complementary" else period).astype(int)
        return ((number ^ (number >> 1)) >> k & 1).astype(float)

    def irradiance(self, c):
        """Irradiance images of camera c, one for each pattern."""
        camera, patterns = self.cameras[c], self.patterns()
        nodes, weights = np.polynomial.legendre.leggauss(self.nodes)
        margin = int(np.ceil(5 * self.camera_blur_px))
        X, Y = np.meshgrid(*(np.arange(-margin, size + margin, dtype=float) for size in (camera.width, camera.height)))
        out = np.zeros((len(patterns), *X.shape))
        integrals = {pattern: self.bit_integral(pattern) for pattern in patterns if pattern[0] != "step"}
        ends = np.concatenate([[-1], np.cumsum(weights) - 1])  # of the part of a pixel that a node stands for
        for ia, (a, wa) in enumerate(zip(nodes, weights)):
            for ib, (b, wb) in enumerate(zip(nodes, weights)):
                for k, pattern in enumerate(patterns):
                    if k == 0 or self.motion_mm is not None:
                        factor, place, besides, more_blur, below = self.traced(camera, X, Y, a / 2, b / 2, k / (len(patterns) - 1) - 0.5)
                        coordinate = place[0 if self.direction == "x" else 1]
                    shift = 0 if self.fringe_shift_px is None else self.fringe_shift_px[k]
                    lamps = besides if self.besides_factor is None else besides * self.besides_factor[k]
                    if pattern[0] == "step":
                        shown = self.light(pattern, coordinate + shift, more_blur, place, below, self.image_waveform.get(k))
                    else:
                        axis, node, i = (1, a, ia) if self.direction == "x" else (0, b, ib)
                        per_px = np.gradient(coordinate, axis=axis)
                        first, last = (coordinate + shift + per_px * (end - node) / 2 for end in ends[i:i + 2])
                        shown = mean_between(first, last, *integrals[pattern])
                    out[k] += wa * wb / 4 * (factor * shown + lamps)
        out = blurred(out, self.camera_blur_px, margin) if margin else out
        return self.exposed_in_time(out) if self.exposure_late is not None or self.read_out else out

    def exposed_in_time(self, shown):
        """What exposures of a whole pattern's length see that begin before or after their pattern, each row in its own time: the
        light that has come in until a time is a line from pattern to pattern, and an exposure is a difference of two of its points."""
        n, rows = shown.shape[:2]
        so_far = np.concatenate([np.zeros_like(shown[:1]), np.cumsum(np.concatenate([shown[:1], shown, shown[-1:]]), 0)])
        late = np.zeros(n) if self.exposure_late is None else np.asarray(self.exposure_late)
        begin = 1 + np.arange(n)[:, None] + late[:, None] + self.read_out * ((np.arange(rows) + 0.5) / rows - 0.5)

        def until(time):
            whole = np.floor(time).astype(int)
            row = np.arange(rows)
            part = (time - whole)[..., None]
            return (1 - part) * so_far[whole, row] + part * so_far[np.minimum(whole + 1, n + 2), row]
        return until(begin + 1) - until(begin)

    def traced(self, camera, X, Y, right, down, time):
        """Of the points `right` and `down` of the pixels' centres: what the camera gets of a level of 1 of the projector, the
        place (u, v) in the projector, the light besides, by how much the blur's variance differs, and what light goes through
        below the surface.
        time: -0.5 ... 0.5."""
        eye, d = self.projector.eye, camera.directions(X + right, Y + down)
        things = self.things if self.motion_mm is None else self.things_at(time)
        albedo = vector(*[t["albedo"] for t in things], 0)
        which, P, N = solids.first_hit(things, camera.eye, d)
        to_eye = eye - P
        cosine = np.maximum((N * to_eye).sum(-1) / np.linalg.norm(to_eye, axis=-1), 0)
        cosine *= ~solids.in_shadow(things, P + N * 1e-3, eye)
        u, v = self.projector.pixels(P)
        lit = ((which >= 0) & (u > -0.5) & (u < self.projector.width - 0.5) & (v > -0.5) & (v < self.projector.height - 0.5))
        factor = np.where(lit, albedo[which] / np.pi * self.intensity * cosine, 0)
        if self.reflectivity:
            factor = factor * self.reflectivity(which, P)
        if self.gloss or self.specular:
            factor = self.shining(factor, unit(to_eye), N, unit(-d))
        if self.projector_field:
            factor = factor * self.projector_field(u, v)
        besides = np.where(which >= 0, self.room_light(X), 0) if self.room_light else 0
        if self.lamp:
            shines = np.maximum(N @ self.lamp[0], 0)
            start = P + N * 1e-3
            shines *= ~solids.in_shadow(things, start, start + BEYOND_MM * self.lamp[0])
            besides = besides + albedo[which] * self.lamp[1] * shines
        if self.scatter:
            besides = besides + factor * self.scatter * self.mean
            factor = factor * (1 - self.scatter)
        if self.camera_field:
            seen = self.camera_field(X + right, Y + down)
            factor, besides = factor * seen, besides * seen
        below = self.below(P, N, unit(to_eye), unit(-d), albedo[which]) if self.mean_free_path_mm else None
        return factor, (u, v), besides, self.blur_field(u, v) if self.blur_field else 0.0, below

    def below(self, P, N, to_light, to_camera, albedo):
        """What light goes through below the surface at points P, by differences along two tangents."""
        first = np.cross(N, vector(0.6, 0.8, 0))
        first = first / np.maximum(np.linalg.norm(first, axis=-1, keepdims=True), 1e-9)  # beside all objects there is no normal
        tangents = (first, np.cross(N, first))
        axis, step_mm = 0 if self.direction == "x" else 1, 0.01
        along = [(self.projector.pixels(P + step_mm * t)[axis] - self.projector.pixels(P - step_mm * t)[axis])
                 / (2 * step_mm) * self.mean_free_path_mm for t in tangents]
        return Below(np.array(along), *([(way * t).sum(-1) for t in tangents] for way in (to_light, to_camera)), albedo)

    def things_at(self, time):
        moved = dict(self.things[0], center_mm=self.things[0]["center_mm"] + self.motion_mm * time)
        return [moved, *self.things[1:]]

    def shining(self, factor, to_light, N, to_camera):
        """The light sent back, with gloss or with Phong's lobe."""
        if self.gloss:
            return factor * self.gloss((N * unit(to_light + to_camera)).sum(-1))
        mirrored = 2 * (N * to_light).sum(-1)[..., None] * N - to_light
        lobe = np.maximum((mirrored * to_camera).sum(-1), 0)**self.shininess
        return factor + np.where(factor > 0, self.intensity * self.specular * lobe, 0)

    def expose(self, c, E, random):
        """Gray values of camera c under irradiance E: shot and read noise, rounding, clipping."""
        sensor = self.sensors[c]
        if self.image_factor is not None:
            E = E * self.image_factor[:, None, None]
        signal = sensor["gain_dn"] * np.maximum(E, 0)
        if self.pixel_factor is not None:
            signal = signal * self.pixel_factor
        if self.camera_response:
            scale = self.full - sensor["black_dn"]
            signal = scale * self.camera_response(signal / scale)
        signal = signal + np.sqrt(signal / sensor["electrons_per_dn"]) * random.standard_normal(signal.shape)
        if self.pixel_offset_dn is not None:
            signal = signal + self.pixel_offset_dn
        values = signal + sensor["black_dn"] + sensor["read_noise_dn"] * random.standard_normal(signal.shape)
        if self.full_well_dn:
            values = np.minimum(values, self.full_well_dn)
        values = np.clip(np.rint(values), 0, self.full).astype(int)
        if self.inverted_image is not None:
            others = np.delete(values, self.inverted_image, 0)
            values[self.inverted_image] = np.clip(others.max(0) + others.min(0) - values[self.inverted_image], 0, self.full)
        return values[self.image_order] if self.image_order is not None else values
