#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""what_if.py TWIN OUT: prints what a blur of the projector does to the brightest fringe contrast and to the points."""
import sys

import numpy as np

import fringetwin

twin = fringetwin.Twin(sys.argv[1])
for blur_px in (0.5, 1.0, 2.0):
    twin.set("projector.blur_px", blur_px)
    measured = fringetwin.measure(twin, twin.render(samples=4, sampler="gauss"))
    amplitude = measured.decodes[twin.cameras[0]].channels()["amplitude_dn"]
    print(f"blur {blur_px} px: amplitude {np.nanmax(amplitude):.1f} DN, {len(measured.points)} points")
