# SPDX-License-Identifier: Apache-2.0
"""Light that goes below a surface: a half space of isotropic scattering events, whose reflection of an uneven light is that of
Chandrasekhar's H functions for an even one with a wave number besides (docs/PHYSICS.md, "Subsurface light")."""
import numpy as np

REFRACTION = 1.4


def scattering_loss(albedo):
    """s^2 = 1 - share of the light that an event leaves, by van de Hulst's albedo of the half space, looked up in a table."""
    s = np.linspace(1, 0, 20001)
    return np.interp(albedo, (1 - s) * (1 - 0.139 * s) / (1 + 1.17 * s), s)**2


class Below:
    """What a pattern along one axis of the projector becomes at places of surfaces. along_x, along_y: change of that coordinate per
    mean free path along two tangents; to_light, to_viewer: components of the unit vectors along these."""

    def __init__(self, along, to_light, to_viewer, albedo):
        self.along, self.lost = along, scattering_loss(albedo)
        self.light, self.viewer = (np.array(way) / REFRACTION for way in (to_light, to_viewer))

    def reflected(self, k):
        waves = k * self.along  # rad per mean free path along both tangents
        squared = (waves**2).sum(0)

        def slant(way, sign):
            return (1 + sign * 1j * (waves * way).sum(0)) / np.sqrt(1 - (way**2).sum(0))
        a, b = slant(self.light, -1), slant(self.viewer, 1)

        def h(x):
            return (x + np.sqrt(squared + 3)) / (x + np.sqrt(squared + 3 * self.lost))
        return h(a) * h(b) / (a + b)

    def kept(self, pitch_px):
        """The complex number that fringes of a pitch are multiplied by."""
        return self.reflected(2 * np.pi / pitch_px) / self.reflected(0.0)
