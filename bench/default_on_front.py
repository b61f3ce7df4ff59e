#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Counts on ten scenes how often the default sampling is the cheapest scheme of its error.

default_on_front.py [--program build/fringetwin] [--source .] [--out out/default_on_front] [--scenes a,b] [--least 9]
                    [--clock wall|cpu] [--quick] [--longest 1.5] [--windows 8] [--rounds 3] [--runs 1]
                    [--list]

Every scene is a twin.toml that this script writes into OUT/NAME (one template, one camera unless the scene is about two,
no fit, so that images alone are timed); `fringetwin pareto` renders it by every scheme x samples x precision. A rival of
the default is a scheme whose error is no larger, in phase (`phase_interior_rms_rad`) and, separately, in gray
(`gray_rms_dn`: all pixels, edges included). The default is on the front when its frame takes at most 1.1 times as long as
its cheapest rival's; the default itself is one of its rivals, so a ratio is at least 1.

Times are pareto's: the smallest of ROUNDS renders, all schemes in turns. Schemes that take longer than LONGEST seconds
are extrapolated, which never makes one of them a rival that counts. Where other programs run, a ratio within 10 % of the
limit says little: such a scene is run once more than RUNS times and of every scheme the smallest time counts. `--clock cpu` compares
CPU times of all threads, which other programs disturb less but which do not see that a step runs on one core alone.
Both ratios are always in OUT/default_on_front.json. Exit status 0: at least LEAST scenes in ten (in proportion, of fewer)
are on the front in phase, and in gray; 1: fewer; 77: no scene could be run (no Vulkan device).
"""
import argparse
import json
import math
import os
import pathlib
import subprocess
import sys
import time

MOST = 1.1  # times the cheapest rival's time
NEAR = 0.1  # a ratio so near to the limit is measured again

TEMPLATE = """schema = "fringetwin-twin/1"
name = "{name}"

{cameras}
[projector]
lensmodel = "LENSMODEL_OPENCV4"
imagersize = [1280, 720]
intrinsics = [1700.15, 1701.22, 627.73, 406.54, 0.1328, -0.3361, -0.0006, -0.0001]
rt_cam_world = [-0.0099, 0.3754, 0.0276, -94.5914, -0.1889, 12.4706]
intensity = 40.0
{projector}
[fringes]
{fringes}
{objects}"""

CAMERA = """[[camera]]
name = "{name}"
lensmodel = "{model}"
imagersize = [{width}, {height}]
intrinsics = [{intrinsics}]
rt_cam_world = [{pose}]
{keys}[camera.sensor]
bit_depth = 8
gain_dn = 22.0
{tables}
"""

HETERODYNE = """directions = ["x"]
pitches_px = [13, 14, 15]
steps = 4
unwrap = "heterodyne"
"""


def camera(name="left", scale=1.0, pose="0, 0, 0, 0, 0, 0", model="LENSMODEL_OPENCV4", distortion="-0.1251, 0.1620, 0.0003, -0.0004",
           size=None, keys="", tables=""):
    """Returns the left camera of the published rig, `scale` times as many pixels a side, or with a sensor of its own
    `size` (px) around the same axis."""
    width, height = size or (round(1440 * scale), round(1080 * scale))
    cx, cy = (0.5 * (width - 1), 0.5 * (height - 1)) if size else (734.47 * scale, 578.34 * scale)
    intrinsics = f"{2359.53 * scale:.2f}, {2359.09 * scale:.2f}, {cx:.2f}, {cy:.2f}, {distortion}"
    return CAMERA.format(name=name, model=model, width=width, height=height, intrinsics=intrinsics, pose=pose, keys=keys,
                         tables=tables)


def thing(name, shape, material="diffuse = 0.8", **keys):
    lines = [f'[[object]]\nname = "{name}"\nshape = "{shape}"']
    lines += [f"{key} = {json.dumps(value)}" for key, value in keys.items()]
    return "\n".join(lines) + f"\n[object.material]\n{material}\n"


def sphere(radius_mm, z_mm=250, x_mm=0, **more):
    return thing("sphere", "sphere", center_mm=[x_mm, 0, z_mm], radius_mm=radius_mm, **more)


def plane(z_mm=270, normal=(0, 0, -1), **more):
    return thing("plane", "plane", point_mm=[0, 0, z_mm], normal=list(normal), **more)


def mesh(file, pose, unit="mm"):
    return thing("part", "mesh", file=str(file), unit=unit, rt_world_object=pose)


class Scene:
    def __init__(self, name, why, objects, cameras=None, fringes=HETERODYNE, projector="", needs=None):
        self.name, self.why, self.needs = name, why, needs
        self.twin = TEMPLATE.format(name=name, cameras=cameras or camera(), projector=projector, fringes=fringes, objects=objects)


def scenes(source):
    """Returns the ten scenes; what sets each apart for whoever chooses the sampling is its second word."""
    datasets = pathlib.Path(source).resolve() / "datasets"
    bunny = pathlib.Path(os.environ.get("FRINGETWIN_CAPTURES", "captures")) / "mesh-stanford-bunny/bun_zipper.ply"
    right = camera("right", pose="-0.0086, 0.7078, 0.0058, -189.5009, -1.1664, 66.0589")
    return [
        Scene("small-sphere", "two cameras of the published rig, a sphere on 0.5 % of the image: arrays of the whole image dominate",
              sphere(5), cameras=camera() + right),
        Scene("sphere-fills", "a sphere as high as the image: the closed form nearly everywhere, its grazing rim is refined",
              sphere(70, 330)),
        Scene("plane-fills", "a tilted plane over the whole image: no edge at all, so a fixed rule has no drawback",
              plane(normal=(0.3, 0.1, -1))),
        Scene("blurred-5mpx", "5 Mpx, a blurred projector and a sphere of 40 mm: few rays, many pixels to write",
              sphere(20, 300), cameras=camera(scale=1.6, size=(2448, 2048)), projector="blur_px = 2.0\n"),
        Scene("freeform", "the free-form part of 81,920 facets: pieces are clipped, outlines take most of the rays",
              mesh(datasets / "paper-freeform/freeform.ply", [0, 0, 0, 0, 0, 270])),
        Scene("bunny", "a scanned mesh of 69,451 facets with folds that hide and shade one another: scan lines",
              mesh(bunny, [math.pi, 0, 0, 25, 110, 290], "m"), needs=bunny),
        Scene("two-directions", "fringes in both directions: twice the sums in every sample and twice the images",
              sphere(25, 270) + plane(310), fringes=HETERODYNE.replace('["x"]', '["x", "y"]')),
        Scene("depth-of-field", "a lens with depth of field: the adaptive trace does not apply, a fixed rule stands in",
              sphere(19, 270), cameras=camera(scale=0.5, tables="[camera.optics]\nf_number = 8.0\nfocal_length_mm = 16.0\n"
                                                                "focus_distance_mm = 255.0\n")),
        Scene("gray-code", "Gray code and phase steps: edges in the pattern, the adaptive trace does not apply",
              sphere(30, 270) + plane(320), cameras=camera(scale=0.5),
              fringes='directions = ["x"]\npitches_px = [16]\nsteps = 4\nunwrap = "gray"\n[fringes.gray]\nbits = 7\n'),
        Scene("glossy-shadows", "a rough glossy ball and a cylinder before a wall, seen through strong distortion: many silhouettes, "
              "shadow borders and highlights",
              sphere(15, 255, -20, material='diffuse = 0.5\nspecular = 0.3\nspecular_model = "ggx"\nroughness = 0.3') +
              thing("bar", "cylinder", point_mm=[30, 0, 270], axis=[0.2, 1, 0], radius_mm=6.0) + plane(320),
              cameras=camera(distortion="-0.35, 0.18, 0.002, -0.001")),
    ]


def tiny():
    """Returns the scene of the quick check: a sphere on few pixels."""
    return Scene("tiny", "a sphere on 144 x 108 px: for a check of this script alone", sphere(20), cameras=camera(scale=0.1))


def run_pareto(options, scene, folder):
    """Returns pareto.json of one run, or None where the program finds no Vulkan device."""
    folder.mkdir(parents=True, exist_ok=True)
    twin = folder / "twin.toml"
    twin.write_text(scene.twin, encoding="utf-8")
    command = [options.program, "-q", "pareto", str(twin), "--out", str(folder)]
    if options.quick:
        command.append("--quick")
    else:
        command += ["--longest", f"{options.longest:g}", "--windows", str(options.windows), "--rounds", str(options.rounds)]
    done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode == 4 and not os.environ.get("FRINGETWIN_REQUIRE_DEVICE"):
        return None
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)} ended with {done.returncode}: {done.stderr.strip()}")
    return json.loads((folder / "pareto.json").read_text(encoding="utf-8"))


def name_of(point):
    size = point["samples"] if point["samples"] is not None else f"{point['target_rad']:.0e}"
    return f"{point['scheme']} {size} {point['precision']}"


def smaller_times(a, b):
    """Returns the points of a with the smaller times of both runs."""
    of_b = {name_of(p): p for p in b}
    for p in a:
        for clock in ("frame_ms", "frame_cpu_ms"):
            p[clock] = min(p[clock], of_b[name_of(p)][clock])
    return a


def verdict(points, error, clock):
    """Returns the default, its cheapest rival by this error and clock, and the ratio of their times."""
    default = next((p for p in points if p["default"]), None)
    if default is None:  # what stands in is none of pareto's schemes
        return {"default": None, "rival": None, "ratio": math.inf}
    measured = [p for p in points if p["time_extrapolated_from_samples"] is None and p["error"][error] is not None]
    rivals = [p for p in measured if p["error"][error] <= default["error"][error]]
    rival = min(rivals, key=lambda p: p[clock], default=default)
    return {"default": default, "rival": rival, "ratio": default[clock] / rival[clock]}


ERRORS = {"phase": ("phase_interior_rms_rad", "rad"), "gray": ("gray_rms_dn", "DN")}
CLOCKS = {"wall": "frame_ms", "cpu": "frame_cpu_ms"}


def judge(points):
    """Returns the verdicts of a scene, error by error and clock by clock."""
    return {e: {c: verdict(points, key, clock) for c, clock in CLOCKS.items()} for e, (key, _) in ERRORS.items()}


def is_near(verdicts, clock):
    ratios = [verdicts[e][clock]["ratio"] for e in ERRORS]
    return any(ratio > 1.0 and abs(ratio / MOST - 1.0) <= NEAR for ratio in ratios)  # 1: no rival is faster


def row(scene, error, clock, found):
    key, unit = ERRORS[error]
    one, other = found[error][clock], "cpu" if clock == "wall" else "wall"
    if one["default"] is None:
        return f"{scene:15} {error:5}  the default is none of pareto's schemes"
    text = [f"{name_of(p):24} {p[CLOCKS[clock]]:7.0f} ms {p['error'][key]:.1e} {unit:3}" for p in (one["default"], one["rival"])]
    return (f"{scene:15} {error:5}  {text[0]}  {text[1]}  {one['ratio']:5.2f} ({found[error][other]['ratio']:.2f})"
            f"{'' if one['ratio'] <= MOST else '  not on the front'}")


def brief(found):
    """Returns what is written of a scene's verdicts: names, times, errors, ratios."""
    def of(point, error):
        return None if point is None else {"scheme": name_of(point), "frame_ms": point["frame_ms"],
                                           "frame_cpu_ms": point["frame_cpu_ms"], "error": point["error"][ERRORS[error][0]]}
    return {e: {c: {"default": of(v["default"], e), "rival": of(v["rival"], e),
                    "ratio": v["ratio"] if math.isfinite(v["ratio"]) else None} for c, v in clocks.items()}
            for e, clocks in found.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default="build/fringetwin")
    parser.add_argument("--source", default=pathlib.Path(__file__).resolve().parent.parent, help="the repository, for its meshes")
    parser.add_argument("--out", default="out/default_on_front")
    parser.add_argument("--scenes", metavar="A,B", help="these alone, by name (tiny: a check of this script)")
    parser.add_argument("--least", type=float, default=9, help="of ten scenes, on the front in phase and in gray")
    parser.add_argument("--clock", choices=CLOCKS, default="wall")
    parser.add_argument("--quick", action="store_true", help="pareto --quick: few schemes, one timing")
    parser.add_argument("--longest", type=float, default=1.5, help="s; slower schemes are rendered in windows only")
    parser.add_argument("--windows", type=int, default=8)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--runs", type=int, default=1, help="of pareto; of each scheme the smallest time counts")
    parser.add_argument("--list", action="store_true", help="print the scenes and end")
    options = parser.parse_args()
    chosen = scenes(options.source)
    if options.scenes:
        names = options.scenes.split(",")
        known = {s.name: s for s in [*chosen, tiny()]}
        if unknown := [n for n in names if n not in known]:
            sys.exit(f"no scene {', '.join(unknown)}: {', '.join(known)}")
        chosen = [known[n] for n in names]
    if options.list:
        for scene in chosen:
            print(f"{scene.name:15} {scene.why}")
        return
    out, record, on_front, n_run = pathlib.Path(options.out), {}, dict.fromkeys(ERRORS, 0), 0
    other = "CPU" if options.clock == "wall" else "wall"
    print(f"{'scene':15} {'error':5}  {'the default':24} {'time':>10} {'error':>11}  {'cheapest as good':24} {'time':>10} {'error':>11}"
          f"  ratio ({other})")
    for scene in chosen:
        if scene.needs and not scene.needs.exists():
            print(f"{scene.name:15} left out: {scene.needs} is not there (make captures, FRINGETWIN_CAPTURES)")
            continue
        start = time.perf_counter()
        run = run_pareto(options, scene, out / scene.name)
        if run is None:
            print("skipped: the program finds no Vulkan device")
            sys.exit(77)
        points = run["points"]
        found = judge(points)
        n_runs = 1
        while n_runs < options.runs or (n_runs == options.runs and is_near(found, options.clock)):
            points = smaller_times(points, run_pareto(options, scene, out / scene.name)["points"])
            found = judge(points)
            n_runs += 1
        n_run += 1
        for error in ERRORS:
            on_front[error] += found[error][options.clock]["ratio"] <= MOST
            print(row(scene.name, error, options.clock, found), flush=True)
        record[scene.name] = {"why": scene.why, "runs": n_runs, "took_s": time.perf_counter() - start,
                              "warnings": run["warnings"], **brief(found)}
    text = ", ".join(f"{error} {n} of {n_run}" for error, n in on_front.items())
    print(f"on the front (at most {MOST:g} times the {options.clock} time of the cheapest scheme of at most its error): {text}")
    out.mkdir(parents=True, exist_ok=True)
    (out / "default_on_front.json").write_text(json.dumps(
        {"clock": options.clock, "most": MOST, "on_front": on_front, "n_scenes": n_run, "scenes": record}, indent=2) + "\n",
        encoding="utf-8")
    if n_run == 0:
        sys.exit(77)
    if min(on_front.values()) < options.least / 10.0 * n_run:
        sys.exit(1)


if __name__ == "__main__":
    main()
