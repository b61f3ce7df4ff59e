#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""gain.py TWIN OUT: prints the gain coefficient of each camera against real images, and what it is worth.

TWIN has real images ([real] captures), datasets/povray-ball-wall/twin.toml for one. A gain is worth as much as the twin:
where another part of the gray values (within pixels, by amplitudes) tells another gain, something else is wrong as well.
"""
import sys

import fringetwin

run = fringetwin.cosim(sys.argv[1], sys.argv[2])
if not run.result["gain"]:
    sys.exit(f"{sys.argv[1]} has no real images: there is no gain to find")
for gain in run.result["gain"]:
    if gain["gain_dn"] is None:
        print(f"{gain['camera']}: no gain: {gain.get('why')}")
        continue
    print(f"{gain['camera']}: {gain['gain_dn']:.4f} +- {gain['gain_total_sigma_dn']:.4f} DN ({gain['state']}"
          f"{': ' + gain['why'] if gain.get('why') else ''}), black level {gain['black_level_dn']:.2f} DN, "
          f"{gain['rms_after_dn']:.2f} DN rms left")
    for check in run.result["gain_checks"]:
        if check["camera"] == gain["camera"] and check["gain_z"] is not None:
            print(f"  {check['part']}: {check['gain_dn']:.4f} DN, {check['gain_z']:+.1f} standard errors away")
for verdict in run.result["explained"]:
    print(f"{verdict['quantity']} {verdict['region']}: {verdict['state']}")
print(f"report: {run.report}")
