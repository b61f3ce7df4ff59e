#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""own_rig.py TWIN OUT: renders a rig, measures what it would record, and prints the fits."""
import sys

import fringetwin

twin = fringetwin.Twin(sys.argv[1])
captures = twin.render(samples=4, sampler="gauss", seed=1)
measured = fringetwin.measure(twin, captures, out=sys.argv[2])
print(f"{len(measured.points)} points, median sigma {sorted(measured.points.sigma_mm)[len(measured.points) // 2]:.4f} mm")
for fit in measured.fits:
    print(fit)
