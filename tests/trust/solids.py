# SPDX-License-Identifier: Apache-2.0
"""The objects of a rig: where rays meet spheres, planes and one convex mesh, and which points lie in shadow.

An object is a dictionary with the keys of [[object]] in twin.toml: name, shape, its measures, albedo."""
import numpy as np

from projection import rotation, vector

PHI = (1 + 5**0.5) / 2
ICOSAHEDRON = np.array([[-1, PHI, 0], [1, PHI, 0], [-1, -PHI, 0], [1, -PHI, 0], [0, -1, PHI], [0, 1, PHI],
                        [0, -1, -PHI], [0, 1, -PHI], [PHI, 0, -1], [PHI, 0, 1], [-PHI, 0, -1], [-PHI, 0, 1]])
GEM_FACES = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6),
             (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10),
             (8, 6, 7), (9, 8, 1)]
# An icosahedron stretched unevenly: convex, and without a symmetry that would leave its pose undetermined.
GEM_VERTICES = (ICOSAHEDRON / np.hypot(1, PHI) * vector(38, 27, 24)
                + 6 * vector(1, 0, 0) * (ICOSAHEDRON[:, 1:2] > 0))


def sphere(name, center_mm, radius_mm, albedo=0.8):
    return dict(name=name, shape="sphere", center_mm=vector(*center_mm), radius_mm=radius_mm, albedo=albedo)


def plane(name, point_mm, normal, albedo=0.8):
    return dict(name=name, shape="plane", point_mm=vector(*point_mm), normal=vector(*normal), albedo=albedo)


def gem(name, rt_world_object, albedo=0.8):
    return dict(name=name, shape="mesh", rt_world_object=vector(*rt_world_object), albedo=albedo)


def gem_vertices(thing):
    """The mesh's vertices in the world, millimetres."""
    rt = thing["rt_world_object"]
    return GEM_VERTICES @ rotation(rt[:3]).T + rt[3:]


def gem_facets(thing):
    """A point and the outward normal of each facet."""
    vertices = gem_vertices(thing)
    middle = vertices.mean(0)
    for i, j, k in GEM_FACES:
        n = np.cross(vertices[j] - vertices[i], vertices[k] - vertices[i])
        n /= np.linalg.norm(n)
        yield vertices[i], n if n @ (vertices[i] - middle) > 0 else -n


def sphere_roots(thing, origins, d):
    """The nearer ray parameter at which origins + s d meets the sphere (valid where the discriminant is positive)."""
    m = origins - thing["center_mm"]
    a, b = (d * d).sum(-1), (d * m).sum(-1)
    discriminant = b * b - a * ((m * m).sum(-1) - thing["radius_mm"]**2)
    return (-b - np.sqrt(np.maximum(discriminant, 0))) / a, discriminant


def meet(thing, origin, d):
    """Ray parameters (infinite where the ray misses) and surface normals of rays that share their origin."""
    if thing["shape"] == "sphere":
        s, discriminant = sphere_roots(thing, origin, d)
        s = np.where(discriminant > 0, s, np.inf)
        points = origin + d * np.where(np.isfinite(s), s, 0)[..., None]
        return s, (points - thing["center_mm"]) / thing["radius_mm"]
    if thing["shape"] == "plane":
        n = thing["normal"] / np.linalg.norm(thing["normal"])
        return ((thing["point_mm"] - origin) @ n) / (d @ n), np.broadcast_to(n, d.shape)
    near, far = np.full(d.shape[:-1], -np.inf), np.full(d.shape[:-1], np.inf)
    normals = np.zeros(d.shape)
    for point, n in gem_facets(thing):  # a convex solid is what is behind all of its facets
        along = d @ n
        s = ((point - origin) @ n) / along
        enters = (along < 0) & (s > near)
        normals = np.where(enters[..., None], n, normals)
        near = np.where(enters, s, near)
        far = np.where((along >= 0) & (s < far), s, far)
    return np.where(near < far, near, np.inf), normals


def first_hit(things, origin, d):
    """Index of the object that each ray meets first (-1: none), the point, and the normal turned towards the eye."""
    best = np.full(d.shape[:-1], np.inf)
    which = np.full(d.shape[:-1], -1)
    normals = np.zeros(d.shape)
    for i, thing in enumerate(things):
        s, n = meet(thing, origin, d)
        closer = (s > 1e-6) & (s < best)
        best, which = np.where(closer, s, best), np.where(closer, i, which)
        normals = np.where(closer[..., None], n, normals)
    points = origin + d * np.where(np.isfinite(best), best, 0)[..., None]
    away = (normals * d).sum(-1) > 0
    return which, points, np.where(away[..., None], -normals, normals)


def in_shadow(things, points, eye):
    """Is something between a point (moved a little off its surface) and the projector's eye?"""
    to_eye = eye - points
    shadow = np.zeros(points.shape[:-1], bool)
    for thing in things:
        if thing["shape"] == "plane":
            continue  # the only planes here are walls behind everything else
        if thing["shape"] == "sphere":
            s, discriminant = sphere_roots(thing, points, to_eye)
            m = points - thing["center_mm"]
            outside = np.abs((m * m).sum(-1) - thing["radius_mm"]**2) > 1e-3
            shadow |= (discriminant > 0) & (s > 1e-4) & (s < 1) & outside
            continue
        near, far = np.full(shadow.shape, 1e-4), np.full(shadow.shape, 1.0)
        for point, n in gem_facets(thing):
            along = to_eye @ n
            s = ((point - points) @ n) / np.where(along == 0, 1e-30, along)
            near = np.where(along < 0, np.maximum(near, s), near)
            far = np.where(along > 0, np.minimum(far, s), far)
        shadow |= near < far - 1e-6
    return shadow
