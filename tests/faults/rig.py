# SPDX-License-Identifier: Apache-2.0
"""A rig so small that a command takes a moment, and the commands that write, each with its own folder for results."""
import dataclasses
import math
import os
import subprocess

TWIN = """schema = "fringetwin-twin/1"
name = "small"
[[camera]]
name = "left"
lensmodel = "LENSMODEL_OPENCV4"
imagersize = [160, 120]
intrinsics = [260, 260, 79.5, 59.5, -0.1, 0.1, 0, 0]
rt_cam_world = [0, 0, 0, 0, 0, 0]
[camera.sensor]
gain_dn = 20
electrons_per_dn = 40
[projector]
lensmodel = "LENSMODEL_PINHOLE"
imagersize = [1280, 720]
intrinsics = [1700, 1700, 639.5, 359.5]
rt_cam_world = [0, 0.35, 0, -95, 0, 12]
intensity = 40
[fringes]
directions = ["x"]
pitches_px = [13, 14, 15]
steps = 4
[[object]]
name = "ball"
shape = "sphere"
center_mm = [0, 0, 270]
radius_mm = 19
[[object]]
name = "wall"
shape = "plane"
point_mm = [0, 0, 300]
normal = [0.3, 0, -1]
material = { diffuse = 0.4 }
[measure]
triangulate = "projector"
[[measure.fit]]
object = "ball"
"""
RESULTS = """[real.results]
[[real.results.fit]]
object = "ball"
radius_mm = 19
"""
STUDY = """schema = "fringetwin-study/1"
name = "small"
twin = "twin.toml"
noise_seeds = {seeds}
[[vary]]
key = "camera.left.sensor.electrons_per_dn"
values = [40.0, 10.0]
[[record]]
result = "fits.ball.measured.radius_mm"
"""
OPENCV = """%YAML:1.0
---
M1: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 156., 0., 47.5, 0., 156., 35.5, 0., 0., 1. ]
D1: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ -0.1, 0.1, 0., 0., 0. ]
"""
BOARD = (7, 6, 0.02)  # corners per row, rows, metres


def corners_of_views():
    """A corner file: a camera of 640 x 480 px and focal length 600 looks at the board from twelve sides."""
    lines = ["# filename x y level"]
    width, height, spacing = BOARD
    for view in range(12):
        a, b, c = 0.5 * math.sin(1.7 * view), 0.5 * math.cos(2.3 * view), 0.4 * math.sin(0.9 * view)
        for row in range(height):
            for column in range(width):
                x, y, z = spacing * (column - width / 2), spacing * (row - height / 2), 0.0
                x, y = x * math.cos(c) - y * math.sin(c), x * math.sin(c) + y * math.cos(c)
                y, z = y * math.cos(a) - z * math.sin(a), y * math.sin(a) + z * math.cos(a)
                x, z = x * math.cos(b) + z * math.sin(b), -x * math.sin(b) + z * math.cos(b)
                z += 0.35 + 0.01 * view
                noise = 0.03 * math.sin(12.9 * row + 78.2 * column + 37.7 * view)
                lines.append(f"left-{view:02d}.png {600 * x / z + 319.5 + noise:.6f} {600 * y / z + 239.5 - noise:.6f} 0")
    return "\n".join(lines) + "\n"


@dataclasses.dataclass
class Command:
    name: str
    words: list          # "{out}" stands for the folder of results
    sign: str            # the file that says: all the others are there; "" of a command that only prints
    again: tuple = ()    # more words where something is there already
    same_words: bool = False  # it prints the same each time

    def line(self, program, out, again=False):
        return [program] + [w.replace("{out}", out) for w in self.words] + list(self.again if again else ())


class Rig:
    """The inputs in a folder, made by the program itself."""

    def __init__(self, program, folder):
        self.program, self.folder = program, folder
        os.makedirs(folder, exist_ok=True)
        for name, text in (("twin.toml", TWIN), ("cosim.toml", TWIN + RESULTS), ("real.toml", TWIN + '[real]\ncaptures = "set"\n'), ("rig.yml", OPENCV),
                           ("STUDY.toml", STUDY.format(seeds=3)), ("LONG.toml", STUDY.format(seeds=100)),
                           ("corners.vnl", corners_of_views())):
            with open(self.path(name), "w", encoding="ascii") as file:
                file.write(text)
        for words in (["render", self.path("twin.toml"), "--seed", "7", "--out", self.path("set")],
                      ["measure", self.path("twin.toml"), "--captures", self.path("set"), "--out", self.path("measured")]):
            subprocess.run([program, "-q", *words], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def path(self, name):
        return os.path.join(self.folder, name)

    def commands(self):
        twin, images = self.path("twin.toml"), self.path("set")
        width, height, spacing = BOARD
        return {c.name: c for c in (
            Command("render", ["render", twin, "--out", "{out}", "--radiance"], "capture.toml"),
            Command("measure", ["measure", twin, "--captures", images, "--out", "{out}"], "result.json"),
            Command("compare", ["compare", twin, "--real", images, "--sim", images, "--out", "{out}"], "result.json"),
            Command("cosim", ["cosim", self.path("cosim.toml"), "--out", "{out}"], "result.json"),
            Command("cosim of captures", ["cosim", self.path("real.toml"), "--out", "{out}"], "result.json"),
            Command("photometry", ["photometry", twin, "--captures", images, "--out", "{out}"], "photometry.json"),
            Command("calibrate", ["calibrate", "--corners-cache", self.path("corners.vnl"), "--lensmodel", "LENSMODEL_PINHOLE",
                                  "--focal", "600", "--imagersize", "640x480", "--object-spacing", str(spacing),
                                  "--object-width-n", str(width), "--object-height-n", str(height), "--names", "left",
                                  "--out", "{out}", "left-*"], "calibration.json"),
            Command("import", ["import", "opencv", self.path("rig.yml"), "--out", "{out}", "--camera", "left=M1,D1@160x120"],
                    "twin.toml"),
            Command("import captures", ["import", "captures", twin, "--map", "left=" + images + "/left/*.png",
                                        "--out", "{out}"], "capture.toml", ("--overwrite",)),
            Command("study", ["study", self.path("STUDY.toml"), "--out", "{out}", "--jobs", "2", "--figures"], "report.html"),
            Command("capture", ["capture", twin, "--camera", "twin:" + twin, "--out", "{out}", "--references"],
                    "capture.toml", ("--resume",)),
            Command("needs", ["needs", twin, "--windows", "1", "--rounds", "1", "--out", "{out}"], "needs.json"),
            Command("pareto", ["pareto", twin, "--quick", "--windows", "1", "--rounds", "1", "--out", "{out}"], "pareto.json"),
            Command("diff", ["diff", self.path("measured"), self.path("measured")], "", same_words=True),
            Command("info", ["info"], ""),
        )}
