#!/usr/bin/env python3
"""What a Vulkan device does with the renderer, in one Markdown page: gpu_report.py --device NAME [--beside NAME] --out PAGE

Runs the device tests on the device, then, on it and on the one --beside (the CPU's llvmpipe, say) in turns: error against
time of the frames of the sphere and of the free-form part in single and double precision, the whole simulated
measurement, and the driver's ray query against the own hierarchy. Everything is measured, nothing is asserted but the
tests: the exit code is 1 where one of them fails. --only tests,frames,chain,rays does a part.
Standard library only, so that it runs on a machine that has the built program and nothing else."""
import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TESTS = ("render_device_tests", "accuracy_tests", "hard_tests", "compare_device_tests")
SCENES = {"sphere": "paper-sphere", "free-form part, 81,920 triangles": "paper-freeform"}
CHAIN = ("paper-ideal-sphere", "paper-sphere", "paper-freeform")
# What is worth a row of a page: the default, the cheapest rules, the published scheme.
ROWS = {("adaptive", None), ("gauss", 4), ("gauss", 16), ("sobol", 64), ("multi-jittered", 1024)}


PARTS = ("tests", "frames", "chain", "rays")


def slug(device):
    """A device's name as a part of a file's name; two of one maker have two."""
    return re.sub(r"[^A-Za-z0-9]+", "-", device).strip("-")


def run(command, device, log, limit_s=3600, **variables):
    """The command with the device chosen: its output, its exit code, its wall seconds. `log` is a folder."""
    environment = dict(os.environ, FRINGETWIN_DEVICE=device, FRINGETWIN_REQUIRE_DEVICE="1", **variables)
    begin = time.monotonic()
    try:
        done = subprocess.run([str(c) for c in command], cwd=ROOT, env=environment, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, timeout=limit_s, check=False)
        text, code = done.stdout, done.returncode
    except subprocess.TimeoutExpired as late:
        text, code = (late.stdout or b"").decode(errors="replace") + f"\nstopped after {limit_s} s\n", 124
    seconds = time.monotonic() - begin
    name = f"{Path(str(command[0])).name}-{slug(device)}.log".lower()
    with open(log / name, "a", encoding="utf-8") as f:
        f.write(f"$ {' '.join(map(str, command))}   # {device}, exit {code}, {seconds:.1f} s\n{text}\n")
    return text, code, seconds


def describe(build, name):
    """The device whose name has `name` in it, as `info --json` lists it."""
    text = subprocess.run([str(build / "fringetwin"), "info", "--json"], stdout=subprocess.PIPE, text=True, check=True).stdout
    info = json.loads(text)
    for device in info["devices"]:
        if name.lower() in device["name"].lower():
            return device, info["version"]
    sys.exit(f"gpu_report.py: no Vulkan device has \"{name}\" in its name; there is: "
             + ", ".join(d["name"] for d in info["devices"]))


def test_section(build, device, log, scratch, shards):
    """The table of the device tests, each program in so many parts side by side; whether all passed."""
    rows, failures = ["| tests | passed | failed | skipped | s |", "|---|--:|--:|--:|--:|"], []
    for name in TESTS:
        records = [scratch / f"{name}-{k}.json" for k in range(shards)]

        def part(k, name=name, records=records):
            return run([build / "tests" / name, f"--gtest_output=json:{records[k]}"], device, log,
                       GTEST_TOTAL_SHARDS=str(shards), GTEST_SHARD_INDEX=str(k))

        begin = time.monotonic()
        with ThreadPoolExecutor(shards) as pool:
            codes = [code for _, code, _ in pool.map(part, range(shards))]
        cases = []
        for record, code in zip(records, codes):
            if record.exists():
                cases += [c for suite in json.loads(record.read_text())["testsuites"] for c in suite["testsuite"] if c["status"] == "RUN"]
            else:
                failures.append(f"{name} ended with {code} and without a record")
        failed = [c for c in cases if "failures" in c]
        skipped = [c for c in cases if c["result"] == "SKIPPED"]
        failures += [f"`{c['classname']}.{c['name']}`: " + c["failures"][0]["failure"].strip().replace("\n", "; ") for c in failed]
        rows.append(f"| {name} | {len(cases) - len(failed) - len(skipped)} | {len(failed)} | {len(skipped)} | {time.monotonic() - begin:.0f} |")
    text = "\n".join(rows)
    if failures:
        text += "\n\nFailed:\n\n" + "\n".join(f"- {f}" for f in failures)
    return text, not failures


def sci(value):
    return "–" if value is None else f"{value:.1e}"


def chosen(point):
    size = None if point["scheme"] == "adaptive" and point["default"] else point["samples"] or -1
    return (point["scheme"], size) in ROWS


def frames_section(build, devices, log, scratch, quick):
    """Error against time per scheme and precision, the devices side by side."""
    out = []
    for title, twin in SCENES.items():
        tables = {}
        for device in devices:
            folder = scratch / f"pareto-{twin}-{slug(device['name'])}"
            # A slow device's published scheme is timed in windows: it is the longest row by far.
            options = ["--longest", "20"] + (["--quick"] if quick else ["--windows", "6", "--rounds", "2"])
            text, code, _ = run([build / "fringetwin", "-q", "pareto", f"datasets/{twin}/twin.toml", "--out", folder, *options], device["name"], log)
            if code:
                out.append(f"### {title}\n`pareto` ended with {code} on {device['name']}: {text.strip().splitlines()[-1] if text.strip() else ''}")
                continue
            points = [p for p in json.loads((folder / "pareto.json").read_text())["points"] if chosen(p)]
            tables[device["name"]] = {(p["scheme"], p["samples"], p["precision"]): p for p in points}
        if not tables:
            continue
        names = list(tables)
        rows = [f"### {title}", "| scheme | precision | " + " | ".join(f"frame ms, {n} | phase rad, all | gray DN, all" for n in names) + " |",
                "|---|---|" + "--:|--:|--:|" * len(names)]
        for key in tables[names[0]]:
            scheme, samples, precision = key
            cells = []
            for name in names:
                p = tables[name].get(key)
                if not p:
                    cells += ["–", "–", "–"]
                    continue
                late = " (extrapolated)" if p["time_extrapolated_from_samples"] else ""
                cells += [f"{p['frame_ms']:.1f}{late}", sci(p["error"]["phase_rms_rad"]), sci(p["error"]["gray_rms_dn"])]
            rows.append(f"| {scheme} {samples or '(default)'} | {precision} | " + " | ".join(cells) + " |")
        out.append("\n".join(rows))
    return "\n\n".join(out)


def chain_section(build, devices, log, scratch, runs):
    """The whole simulated measurement; the smallest of `runs` whole times, the devices in turns."""
    best = {}
    for twin in CHAIN:
        for i in range(runs):
            for device in devices:
                folder = scratch / f"chain-{twin}-{slug(device['name'])}-{i}"
                _, code, _ = run([build / "fringetwin", "-q", "cosim", f"datasets/{twin}/twin.toml", "--out", folder], device["name"], log)
                if code not in (0, 1):  # a signal is negative
                    continue
                t = json.loads((folder / "result.json").read_text())["timing_s"]
                whole, key = t["render"] + t["measure_simulated"], (twin, device["name"])
                if key not in best or whole < best[key][0]:
                    best[key] = (whole, t["render"])
    rows = ["| twin | " + " | ".join(f"render s, {d['name']} | whole s" for d in devices) + " |", "|---|" + "--:|--:|" * len(devices)]
    for twin in CHAIN:
        cells = []
        for device in devices:
            whole, render = best.get((twin, device["name"]), (float("nan"), float("nan")))
            cells += [f"{render:.3f}", f"{whole:.3f}"]
        rows.append(f"| {twin} | " + " | ".join(cells) + " |")
    return "\n".join(rows)


def rays_section(build, devices, log):
    out = []
    for device in devices:
        text, code, _ = run([build / "bench" / "bench_ray_query"], device["name"], log)
        out.append(f"```\n{text.strip()}\n```" + (f"\nIt ended with {code}.\n" if code else ""))
    return "\n".join(out)


def processor():
    try:
        names = [line.split(":", 1)[1].strip() for line in open("/proc/cpuinfo", encoding="utf-8") if line.startswith("model name")]
        return f"{len(names)} x {names[0]}"
    except (OSError, IndexError):
        return f"{os.cpu_count()} CPUs"


def commit():
    done = subprocess.run(["git", "describe", "--always", "--dirty"], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=False)
    return done.stdout.strip() or "unknown"


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--device", required=True, help="a part of the device's name")
    options.add_argument("--beside", help="a part of the name of a device to measure beside it")
    options.add_argument("--build", type=Path, default=ROOT / "build", help="the build folder")
    options.add_argument("--out", type=Path, required=True, help="the page")
    options.add_argument("--logs", type=Path, help="a folder for the whole output of every program (default: PAGE.logs)")
    options.add_argument("--only", default=",".join(PARTS), help="parts of the page")
    options.add_argument("--shards", type=int, default=1, help="parts that each test program is run in, side by side")
    options.add_argument("--quick", action="store_true", help="few schemes and pixels, one run each")
    a = options.parse_args()
    wanted = [part.strip() for part in a.only.split(",")]
    for part in wanted:
        if part not in PARTS:
            options.error(f"--only: no part is named \"{part}\"; there are {', '.join(PARTS)}")
    devices, version = [], ""
    for name in filter(None, (a.device, a.beside)):
        device, version = describe(a.build, name)
        devices.append(device)
    logs = a.logs or a.out.with_suffix(".logs")
    logs.mkdir(parents=True, exist_ok=True)
    first = devices[0]
    page = [f"# {first['name']}",
            "Written by `scripts/gpu_report.py`: do not edit. What the columns mean: `docs/PERFORMANCE.md`.",
            f"Measured on {time.strftime('%Y-%m-%d')} at commit {commit()}, fringetwin {version}. Machine: {processor()}. "
            + "; ".join(f"{d['name']}: {d['driver']}, Vulkan {d['api_version']}" for d in devices) + "."]
    passed = True

    def write():
        partial = a.out.with_suffix(".tmp")
        partial.write_text("\n\n".join(page) + "\n", encoding="utf-8")
        os.replace(partial, a.out)

    with tempfile.TemporaryDirectory() as scratch_name:
        scratch = Path(scratch_name)
        for part, title, make in (
                ("chain", "Whole simulated measurement: 2 cameras x 12 images of 1440 x 1080 px, decoded and fitted",
                 lambda: chain_section(a.build, devices, logs, scratch, 1 if a.quick else 3)),
                ("rays", "The driver's ray query beside the own hierarchy", lambda: rays_section(a.build, devices, logs)),
                ("frames", "Frames: error against time", lambda: frames_section(a.build, devices, logs, scratch, a.quick)),
                ("tests", "Device tests", lambda: test_section(a.build, first["name"], logs, scratch, a.shards))):
            if part not in wanted:
                continue
            print(f"gpu_report.py: {part}", file=sys.stderr, flush=True)
            body = make()
            if part == "tests":
                body, passed = body
            page.append(f"## {title}\n{body}")
            write()  # what is measured stays, whatever happens to the rest
    print(a.out)
    return 0 if passed else 1


if __name__ == "__main__":
    sys.exit(main())
