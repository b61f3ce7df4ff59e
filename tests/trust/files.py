# SPDX-License-Identifier: Apache-2.0
"""Writes what a user of the program has: the images of a capture set with capture.toml, and twin.toml."""
import os
import struct
import zlib

import numpy as np

from projection import rotation_vector
from rig import CAMERA_NAMES
from solids import GEM_FACES, GEM_VERTICES


def write_png(path, values, bits):
    """Gray values as PNG of 8 or 16 bits; more than 8 bits lie in the low bits of 16."""
    deep = bits > 8
    height, width = values.shape
    rows = np.zeros((height, 1 + width * (2 if deep else 1)), "u1")  # each row begins with its filter, 0
    rows[:, 1:] = np.ascontiguousarray(values.astype(">u2" if deep else "u1")).view("u1").reshape(height, -1)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 16 if deep else 8, 0, 0, 0, 0)
    with open(path, "wb") as f:
        f.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows.tobytes(), 1))
                + chunk(b"IEND", b""))


def write_captures(folder, images_of_cameras, bits):
    lines = ['schema = "fringetwin-captures/1"']
    for name, images in zip(CAMERA_NAMES, images_of_cameras):
        os.makedirs(os.path.join(folder, name))
        for k, image in enumerate(images):
            write_png(os.path.join(folder, name, f"{k:04d}.png"), image, bits)
        lines += ["[[camera]]", f'name = "{name}"', f'pattern = "{name}/%04d.png"']
    write_text(os.path.join(folder, "capture.toml"), lines)


def raster_text(pitch_px, first, waves):
    return f"{{ pitch_px = {pitch_px}, first = {first}, waves = {[list(wave) for wave in waves]} }}"


def write_twin(folder, twin, file="twin.toml", name="trust", comment=()):
    lines = [*(f"# {line}" for line in comment), 'schema = "fringetwin-twin/1"', f'name = "{name}"', 'cameramodel_unit = "mm"']
    for name, camera, sensor in zip(CAMERA_NAMES, twin.cameras, twin.sensors):
        lines += ["[[camera]]", f'name = "{name}"', *device_lines(camera),
                  *([f"psf_px = {twin.camera_blur_px}"] if twin.camera_blur_px else []), "[camera.sensor]", f"bit_depth = {twin.bits}",
                  f'gain_dn = {sensor["gain_dn"]}', f'black_level_dn = {sensor["black_dn"]}',
                  f'electrons_per_dn = {sensor["electrons_per_dn"]}', f'read_noise_dn = {sensor["read_noise_dn"]}']
    lines += ["[projector]", *device_lines(twin.projector), f"intensity = {twin.intensity}", f"blur_px = {twin.blur_px}",
              *([f"light_field = {numbers(twin.light_field)}"] if twin.light_field else []), "[fringes]", f'directions = ["{twin.direction}"]', f"pitches_px = {twin.pitches_px}",
              *([f"raster = {raster_text(*twin.raster)}"] if twin.raster else []), f"steps = {twin.steps}", f'unwrap = "{twin.unwrap}"', f"mean = {twin.mean}",
              f"amplitude = {twin.amplitude}", f"phase_origin_px = {twin.origin_px}"]
    if twin.unwrap == "gray":
        code = twin.code
        lines += ["[fringes.gray]", f'bits = {code["bits"]}', f'order = "{code["order"]}"',
                  f'complementary = {str(code["complementary"]).lower()}', f'offset_periods = {code["offset_periods"]}']
    for thing in twin.things:
        lines += ["[[object]]", f'name = "{thing["name"]}"', f'shape = "{thing["shape"]}"']
        if thing["shape"] == "mesh":
            write_gem(os.path.join(folder, "gem.ply"))
            lines += ['file = "gem.ply"', 'unit = "mm"']
        lines += [f"{key} = {numbers(thing[key])}"
                  for key in ("center_mm", "radius_mm", "point_mm", "normal", "rt_world_object") if key in thing]
        lines += ["[object.material]", f'diffuse = {thing["albedo"]}']
        if twin.specular:
            lines += [f"specular = {twin.specular}", f"shininess = {twin.shininess}"]
    if twin.lamp:
        lines += ["[room]", f"lamp = {numbers(twin.lamp[0] * twin.lamp[1])}"]
    if twin.bounces:
        lines += ["[render]", f"bounces = {twin.bounces}"]
    lines += ["[real]", 'captures = "real"']
    for thing in twin.things:
        lines += ["[[measure.fit]]", f'object = "{thing["name"]}"', f"gate_mm = {twin.gate_mm}"]
    write_text(os.path.join(folder, file), lines)


def device_lines(device):
    focal, middle = device.focal_px, device.principal_point
    return ['lensmodel = "LENSMODEL_OPENCV4"', f"imagersize = [{device.width}, {device.height}]",
            f"intrinsics = {numbers((focal, focal, *middle, device.k1, 0, 0, 0))}",
            f"rt_cam_world = {numbers((*rotation_vector(device.R), *device.t))}"]


def write_gem(path):
    lines = ["ply", "format ascii 1.0", f"element vertex {len(GEM_VERTICES)}", "property double x", "property double y",
             "property double z", f"element face {len(GEM_FACES)}", "property list uchar int vertex_indices", "end_header"]
    lines += [" ".join(repr(float(x)) for x in v) for v in GEM_VERTICES]
    write_text(path, lines + ["3 {} {} {}".format(*face) for face in GEM_FACES])


def numbers(value):
    return [float(x) for x in value] if np.ndim(value) else float(value)


def write_text(path, lines):
    with open(path, "w", encoding="utf-8") as f:
        f.write("\n".join(lines) + "\n")
