#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""moved_camera.py TWIN OUT: prints the fits of a rig whose last camera has turned since it was calibrated. One twin, the
rig as it stands, records; another one, the rig as calibrated, measures."""
import sys
import tomllib

import fringetwin

as_calibrated = fringetwin.Twin(sys.argv[1])
as_it_stands = fringetwin.Twin(sys.argv[1])
with open(as_calibrated.file, "rb") as file:
    camera = tomllib.load(file)["camera"][-1]
pose = list(camera["rt_cam_world"])  # rotation vector (rad), translation (mm); absent, it would have to be written there
pose[1] += 0.0005
as_it_stands.set(f"camera.{camera['name']}.rt_cam_world", pose)
for what, recording in (("as calibrated", as_calibrated), ("turned by half a milliradian", as_it_stands)):
    measured = fringetwin.measure(as_calibrated, recording.render(samples=4, sampler="gauss", seed=1))
    for fit in measured.fits:
        print(f"{what}: {fit}")
