# SPDX-License-Identifier: Apache-2.0
"""Irradiance images by POV-Ray, a path from light to gray value of which no line is ours.

POV-Ray sends one ray through the middle of a pixel. Each image is rendered three and six times as fine; the error of
the mean over midpoints falls with the square of their spacing, so (36 E6 - 9 E3) / 27 has none of that order."""
import os
import re
import subprocess

import numpy as np

from solids import GEM_FACES, gem_vertices


def pov_vector(v):
    return "<" + ",".join(repr(float(x)) for x in v) + ">"


def pov_scene(rig, pattern, texture):
    """The scene of one phase step; lenses are pinholes (Rig(pinhole=True)), the camera stands in the origin."""
    camera, projector = rig.cameras[0], rig.projector
    pitch, step = rig.pitches_px[pattern[1]], pattern[2]
    X, Y, Z = [f"({R[0]}*x+{R[1]}*y+{R[2]}*z+{t})" for R, t in zip(projector.R, projector.t)]
    u = f"({projector.focal_px}*{X}/{Z}+{projector.principal_point[0]})"
    v = f"({projector.focal_px}*{Y}/{Z}+{projector.principal_point[1]})"
    inside = "*".join(f"select({edge},0,1)" for edge in (f"{u}+.5", f"{projector.width}-.5-{u}", f"{v}+.5",
                                                         f"{projector.height}-.5-{v}"))
    coordinate = u if rig.direction == "x" else v
    light = (f"({rig.mean}+{rig.contrast(pitch)}"
             f"*cos(2*pi*({coordinate}-{rig.origin_px})/{pitch}+2*pi*{step}/{rig.steps}))")
    material = (f"texture {{ pigment {{ function {{ {inside}*{light}{texture} }} color_map {{ [0 rgb 0][1 rgb 1] }} }} "
                "finish { ambient 0 diffuse 1 } }")
    lines = ["#version 3.7;", "global_settings { assumed_gamma 1.0 max_trace_level 2 }", "background { rgb 0 }",
             f"camera {{ perspective location <0,0,0> direction <0,0,1> right <{camera.width / camera.focal_px},0,0> "
             f"up <0,{-camera.height / camera.focal_px},0> }}",
             f"light_source {{ {pov_vector(projector.eye)} rgb 1 }}"]
    for thing in rig.things:
        if thing["shape"] == "sphere":
            body = f'sphere {{ {pov_vector(thing["center_mm"])}, {thing["radius_mm"]}'
        elif thing["shape"] == "plane":
            n = thing["normal"] / np.linalg.norm(thing["normal"])
            body = f'plane {{ {pov_vector(n)}, {float(n @ thing["point_mm"])}'
        else:
            V = gem_vertices(thing)
            body = "mesh { " + " ".join("triangle { " + ",".join(pov_vector(V[i]) for i in face) + " }"
                                        for face in GEM_FACES)
        lines.append(f"{body} {material} }}")
    return "\n".join(lines) + "\n"


def rendered(folder, scene, camera, fineness):
    """The scene in numbers of 0 ... 1, each pixel the mean of fineness x fineness rays."""
    source, image = os.path.join(folder, "scene.pov"), os.path.join(folder, "scene.ppm")
    with open(source, "w", encoding="utf-8") as f:
        f.write(scene)
    subprocess.run(["povray", f"+I{source}", f"+O{image}", f"+W{fineness * camera.width}", f"+H{fineness * camera.height}",
                    "+FP16", "Grayscale_Output=on", "File_Gamma=1.0", "-A", "-D", "+WT1"],
                   check=True, capture_output=True)
    with open(image, "rb") as f:
        data = f.read()
    head = re.match(rb"P[56]\s+(?:#.*\s)*(\d+)\s+(\d+)\s+(\d+)\s", data)
    width, height = int(head[1]), int(head[2])
    pixels = np.frombuffer(data[head.end():], ">u2").astype(float).reshape(height, width, -1)[:, :, 0] / 65535
    os.remove(source)
    os.remove(image)
    return pixels.reshape(camera.height, fineness, camera.width, fineness).mean((1, 3))


def irradiance(rig, folder, texture=""):
    """As Rig.irradiance() of its only camera. All objects have the same albedo; texture: a factor in POV-Ray's words."""
    out = []
    for pattern in rig.patterns():
        scene = pov_scene(rig, pattern, texture)
        coarse, fine = (rendered(folder, scene, rig.cameras[0], z) for z in (3, 6))
        out.append(np.maximum((36 * fine - 9 * coarse) / 27, 0) * rig.things[0]["albedo"] / np.pi * rig.intensity)
    return np.array(out)
