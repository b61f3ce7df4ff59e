# SPDX-License-Identifier: Apache-2.0
"""Rotations, and cameras and projectors as a pinhole with one radial term, in numpy's double precision.

World to device: Q = R P + t, millimetres. Pixel coordinates are those of docs/CONVENTIONS.md: the centre of the first
pixel is (0, 0)."""
import numpy as np


def vector(*values):
    return np.array(values, float)


def rotation(rotation_vector):
    """The matrix of a rotation vector (radians), by Rodrigues' formula."""
    r = np.asarray(rotation_vector, float)
    angle = np.linalg.norm(r)
    if angle < 1e-14:
        return np.eye(3)
    x, y, z = r / angle
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def rotation_vector(R):
    """The rotation vector (radians) of a matrix; angles near pi do not occur here."""
    angle = np.arccos(np.clip((np.trace(R) - 1) / 2, -1, 1))
    v = vector(R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1])
    return v / 2 if angle < 1e-9 else v * angle / (2 * np.sin(angle))


def aimed_at(eye, target, up=(0, 1, 0)):
    """R and t of a device that stands at `eye` and looks at `target`."""
    z = (target - eye) / np.linalg.norm(target - eye)
    x = np.cross(up, z)
    x /= np.linalg.norm(x)
    R = np.stack([x, np.cross(z, x), z])
    return R, -R @ eye


class Device:
    """A camera or a projector: width and height in pixels, focal length, principal point, radial term k1, pose."""

    def __init__(self, width, height, focal_px, principal_point, k1, R, t):
        self.width, self.height, self.focal_px = width, height, focal_px
        self.principal_point, self.k1, self.R, self.t = vector(*principal_point), k1, R, vector(*t)

    @property
    def eye(self):
        return -self.R.T @ self.t

    def directions(self, u, v):
        """The world directions (not normalised) of pixel coordinates; the lens is inverted by fixed-point steps."""
        a = (u - self.principal_point[0]) / self.focal_px
        b = (v - self.principal_point[1]) / self.focal_px
        x, y = a.copy(), b.copy()
        for _ in range(12):
            radial = 1 + self.k1 * (x * x + y * y)
            x, y = a / radial, b / radial
        return np.stack([x, y, np.ones_like(x)], -1) @ self.R

    def pixels(self, points):
        """Where the device sees world points."""
        Q = points @ self.R.T + self.t
        x, y = Q[..., 0] / Q[..., 2], Q[..., 1] / Q[..., 2]
        radial = 1 + self.k1 * (x * x + y * y)
        return (self.focal_px * x * radial + self.principal_point[0],
                self.focal_px * y * radial + self.principal_point[1])
