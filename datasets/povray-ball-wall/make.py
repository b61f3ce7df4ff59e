#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Makes this data set anew: a ball before a wall as POV-Ray renders them, recorded by a 12-bit sensor with noise, and two
twins of the rig. No line of the program takes part, so the truth is known: that of `rig` below.

make.py [FOLDER]: writes FOLDER/real/, FOLDER/twin.toml and FOLDER/twin-moved.toml (default: beside this file). Needs
numpy and povray; two minutes."""
import copy
import os
import shutil
import sys

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "..", "tests", "trust"))
import files  # noqa: E402
import povray_light  # noqa: E402
from rig import Rig  # noqa: E402

SEED = 20261123
GAIN_ERROR = 1.05  # the twins' gain over the true one: what a user knows of a sensor before the first comparison
MOVED_MM = (0.05, -0.03, 0.1)  # where the twin "moved" has the ball, less where it is


def main():
    folder = sys.argv[1] if len(sys.argv) > 1 else HERE
    rig = Rig(scene="ball+wall", pinhole=True)
    os.makedirs(folder, exist_ok=True)
    light = povray_light.irradiance(rig, folder)
    recorded = rig.expose(0, light, np.random.default_rng(SEED))
    shutil.rmtree(os.path.join(folder, "real"), ignore_errors=True)
    files.write_captures(os.path.join(folder, "real"), [recorded], rig.bits)
    right = copy.deepcopy(rig)
    right.sensors[0]["gain_dn"] *= GAIN_ERROR
    moved = copy.deepcopy(right)
    moved.thing("ball")["center_mm"] = np.asarray(moved.thing("ball")["center_mm"]) + MOVED_MM
    true_gain = f"The true gain is {rig.sensors[0]['gain_dn']:.6g} DN; here it is 5 % too large: cosim finds the true one."
    licence, made = "SPDX-License-Identifier: Apache-2.0", "Made by make.py."
    files.write_twin(folder, right, name="povray-ball-wall",
                     comment=[licence, f"A twin that is right but for its gain. {made}", true_gain])
    files.write_twin(folder, moved, file="twin-moved.toml", name="povray-ball-wall-moved",
                     comment=[licence, f"The same twin with its ball moved by {MOVED_MM} mm: cosim says so, and --refine pose finds",
                              f"the true place, (3, -2, 292). {made}", true_gain])


if __name__ == "__main__":
    main()
