# SPDX-License-Identifier: Apache-2.0
"""Objects and devices that do not stand where the twin says, and starts from which a refinement must find back."""
import numpy as np

from cases import add_case, nothing, planted
from projection import rotation, rotation_vector, vector

WALL = dict(scene="wall")
SEEN = dict(verdict={"geometry": "not explained"})


def principal_point(shift_px):
    def plant(rig, twin, random):
        twin.projector.principal_point[0] += shift_px
    return plant


add_case("principal_point_05", "geometry", "the projector's principal point is 0.5 px off", principal_point(0.5), WALL,
         verdict={"phase": "not explained"}, causes="intrinsics")
add_case("principal_point_1", "geometry", "the projector's principal point is 1 px off", principal_point(1.0),
         verdict={"phase": "not explained"}, causes="intrinsics")


def tilted(degrees):
    def plant(rig, twin, random):
        twin.things[0]["normal"] = rotation((0, np.radians(degrees), 0)) @ twin.things[0]["normal"]
    return plant


for angle in (1, 5, 30):
    add_case(f"plane_tilt_{angle}", "geometry", f"the plane is tilted by {angle} degrees in the twin", tilted(angle), WALL,
             causes="pose", fast=angle == 1, **SEEN)


@planted("geometry", "the plane is turned by 0.01 degrees about the middle of its points", WALL, causes="pose", **SEEN)
def plane_tilt_small(rig, twin, random):
    wall = twin.things[0]
    # The mean of the measured points, found with the right twin: a turn about it moves no centroid.
    wall["point_mm"] = vector(0.19907193861678818, -0.5604551380765327, 335.0344601834143)
    wall["normal"] = rotation((0, 1.7e-4, 0)) @ (wall["normal"] / np.linalg.norm(wall["normal"]))


@planted("geometry", "the sphere's radius is 0.05 mm too large in the twin", causes="size", **SEEN)
def radius_off(rig, twin, random):
    twin.things[0]["radius_mm"] += 0.05


def start(name, what, rig, shift_mm, turn_degrees=(0, 0, 0)):
    """The twin's object stands elsewhere; `--refine pose` must find the rig's place."""
    def plant(rig, twin, random):
        thing, turn = twin.things[0], rotation(np.radians(turn_degrees))
        if thing["shape"] == "sphere":
            thing["center_mm"] = thing["center_mm"] + vector(*shift_mm)
        elif thing["shape"] == "plane":
            thing["point_mm"] = thing["point_mm"] + vector(*shift_mm)
            thing["normal"] = turn @ thing["normal"]
        else:
            rt = thing["rt_world_object"]
            thing["rt_world_object"] = np.concatenate([rotation_vector(turn @ rotation(rt[:3])), rt[3:] + vector(*shift_mm)])
        twin.gate_mm = 8.0
    add_case(name, "refinement", what, plant, rig, expect="explained", refine="pose", causes="pose")


SPHERE, MESH = dict(scene="ball"), dict(scene="gem", nodes=8)
start("refine_sphere_2mm", "sphere 2 mm off", SPHERE, (1.2, -0.8, 1.4))
start("refine_sphere_half_fringe", "sphere half a fringe (3.5 mm) off in depth", SPHERE, (0, 0, 3.5))
start("refine_plane_2mm_1deg", "plane 2 mm and 1 degree off", WALL, (0, 0, 2), (0.7, 0.7, 0))
start("refine_plane_half_fringe", "plane half a fringe (3.9 mm) off", WALL, (0, 0, 3.9))
start("refine_mesh_2mm", "mesh 2 mm off", MESH, (1.2, -0.8, 1.4))
start("refine_mesh_1deg", "mesh 1 degree off", MESH, (0, 0, 0), (0.6, 0.6, 0.5))
start("refine_mesh_2mm_1deg", "mesh 2 mm and 1 degree off", MESH, (1.2, -0.8, 1.4), (0.6, 0.6, 0.5))
start("refine_mesh_half_fringe", "mesh half a fringe (3.5 mm) off", MESH, (0, 0, 3.5))


def projector_moved(rig, twin, random):
    """Its eye is elsewhere in the twin: along its columns the fringes hardly tell, and the light's fall-off does."""
    projector = twin.projector
    projector.t = projector.t - projector.R @ vector(0.05, 0.1, 0.1)


def camera_moved_and_gamma(rig, twin, random):
    camera = twin.cameras[1]
    camera.t = camera.t - camera.R @ vector(0.1, 0, 0)
    rig.projector_response = lambda drive: drive ** 1.15


def moved_and_grown(rig, twin, random):
    ball = twin.things[0]
    ball["center_mm"] = ball["center_mm"] + vector(0.1, 0, 0.05)
    ball["radius_mm"] += 0.02


add_case("refine_rig_moved", "refinement", "the projector is 0.15 mm off in the twin; `--refine rig`", projector_moved,
         dict(scene="ball+wall", small=True), expect="explained", refine="rig", causes="rig")
LARGE = dict(scene="ball+wall", cameras=2, large=True)  # a refinement looks at one pixel of ten, the fits at all
add_case("refine_right_rig", "refinement", "nothing, on ten times as many pixels as a refinement looks at; `--refine rig`",
         nothing, LARGE, expect="explained", refine="rig")
add_case("refine_rig_and_response", "refinement", "the second camera is 0.1 mm off in the twin, the projector's gamma is 1.15; "
         "`--refine rig,response`", camera_moved_and_gamma, LARGE, expect="explained", refine="rig,response")
add_case("refine_pose_and_size", "refinement", "the sphere is 0.11 mm off and its radius 0.02 mm too large; `--refine pose,size`",
         moved_and_grown, dict(scene="ball", small=True), expect="explained", refine="pose,size")
