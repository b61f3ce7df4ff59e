# SPDX-License-Identifier: Apache-2.0
"""What the true values are of the parameters that the program prints, by the program's names for them.

They come from the rig's plain numbers. Turns and shifts count from the twin's place: Q = turn (R P + t) + shift. A tilt of a
plane adds tilt u + tilt v to its normal n, with u in the plane of x and y, and v = n x u."""
import numpy as np

from projection import rotation_vector
from rig import CAMERA_NAMES

AXES = "xyz"


def vectors(name, values):
    return {f"{name}.{axis}": float(value) for axis, value in zip(AXES, values)}


def of_sphere(true, twin):
    return vectors(true["name"] + ".center_mm", true["center_mm"]) | {true["name"] + ".radius_mm": float(true["radius_mm"])}


def of_plane(true, twin):
    n = twin["normal"] / np.linalg.norm(twin["normal"])
    m = true["normal"] / np.linalg.norm(true["normal"])
    u = np.array([-n[1], n[0], 0]) / np.hypot(n[0], n[1])
    name = true["name"]
    return {name + ".offset_mm": float((true["point_mm"] - twin["point_mm"]) @ m / (m @ n)),
            name + ".tilt_rad.u": float(m @ u / (m @ n)), name + ".tilt_rad.v": float(m @ np.cross(n, u) / (m @ n))}


def of_device(name, true, twin, moves):
    out = {name + ".k1": true.k1, name + ".k2": 0.0, name + ".focal_px": true.focal_px,
           **vectors(name + ".principal_point_px", true.principal_point)}
    if moves:
        turn = true.R @ twin.R.T
        out |= vectors(name + ".turn_rad", rotation_vector(turn)) | vectors(name + ".shift_mm", true.t - turn @ twin.t)
    return out


def truths(rig, twin, values):
    """The values of all parameters that are known, by name. values: those that neither rig nor twin hold."""
    out = of_device("projector", rig.projector, twin.projector, True)
    out |= {"projector.blur_px": rig.blur_px, "projector.gamma": 1.0}
    for name, true, believed in zip(CAMERA_NAMES, rig.cameras, twin.cameras):
        out |= of_device(name, true, believed, name != CAMERA_NAMES[0]) | {name + ".psf_px": rig.camera_blur_px}
    shapes = dict(sphere=of_sphere, plane=of_plane)
    for thing in twin.things:
        true = next((t for t in rig.things if t["name"] == thing["name"]), None)
        if true and true["shape"] in shapes:
            out |= shapes[true["shape"]](true, thing) | {
                true["name"] + ".specular": rig.specular, true["name"] + ".shininess": rig.shininess}
    if rig.projector_response and "projector.gamma" not in values:
        out.pop("projector.gamma")
    return out | values


def standard_errors(name, value, sigma, truth):
    """How many standard errors a printed value is off. A blur is fitted as sigma^2, whose error the program carries over to
    sigma by the derivative, or, near zero, by the difference of the roots; so squares are compared."""
    if not name.endswith(("blur_px", "psf_px")):
        return (value - truth) / sigma
    return (value**2 - truth**2) / (2 * value * sigma if value > 2 * sigma else sigma**2 + 2 * value * sigma)
