#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The battery of planted rigs: rigs of known truth, rendered by numpy or POV-Ray, given to the program and judged.

battery.py --program build/fringetwin --out DIR [--refine] [--only A,B | --fast | --page docs/TRUST.md] [--jobs N] [--keep]

Each rig lies in DIR/NAME: twin.toml, real/, out/, row.json. The table of all rigs of the run is DIR/table.md; --page
writes it into the page, between its two marks. --refine takes a part of the rigs and refines one group of the twin after the
other (refinements.py), with a table of its own. Exit code 1 if a rig has a fault, 2 for a wrong call, 77
without a Vulkan device unless FRINGETWIN_REQUIRE_DEVICE is set. Needs numpy and, for the rigs pov_*, povray."""
import argparse
import concurrent.futures
import copy
import json
import os
import shutil
import subprocess
import sys
import time
import zlib

import numpy as np

import cases
import files
import judge
import page
import povray_light
import refinements
import truths
from rig import Rig

LONGEST_RUN_S = 900
NO_DEVICE = 4  # the program's exit code (docs/CONVENTIONS.md, "Exit codes")
SKIPPED = 77  # tells CTest so


def build(case, folder):
    """Renders the case's rig into folder/real, writes its twin beside, and returns the rig and the true values by name."""
    random = np.random.default_rng(zlib.crc32(case.name.encode()))
    rig = Rig(**case.rig)
    twin = copy.deepcopy(rig)
    case.plant(rig, twin, random)
    os.makedirs(folder)
    light = ([povray_light.irradiance(rig, folder, case.texture)] if case.povray
             else [rig.irradiance(c) for c in range(len(rig.cameras))])
    images = [rig.expose(c, E, random) for c, E in enumerate(light)]
    files.write_captures(os.path.join(folder, "real"), images, rig.bits)
    files.write_twin(folder, twin)
    return rig, truths.truths(rig, twin, case.values)


def run_program(program, *arguments):
    return subprocess.run([program, *arguments], capture_output=True, text=True, timeout=LONGEST_RUN_S)


def refined(name, program, folder, keep):
    """Renders the case of that name and runs it without a refinement and with each; the rows of refinements.py."""
    case = cases.all_cases()[name]
    shutil.rmtree(folder, ignore_errors=True)
    started = time.monotonic()
    _, known = build(case, folder)
    runs = {}
    for group in ("", *refinements.groups_of(name)):
        out = os.path.join(folder, "refined_" + group if group else "out")
        run = run_program(program, "cosim", os.path.join(folder, "twin.toml"), "--out", out,
                          *(["--refine", group] if group else []))
        runs[group] = run, judge.loaded(os.path.join(out, "result.json"))
        if not keep:
            for heavy in ("simulated", "measured_real", "measured_simulated"):
                shutil.rmtree(os.path.join(out, heavy), ignore_errors=True)
    if runs[""][1] is None:
        raise OSError(f"no result without a refinement: {runs[''][0].stderr}")
    rows = [refinements.row_of(case, known, group, runs[""][1], *runs[group]) for group in refinements.groups_of(name)]
    with open(os.path.join(folder, "rows.json"), "w", encoding="utf-8") as f:
        json.dump(rows, f, indent=1)
    told = "; ".join(f"{row['group']} {refinements.cell(row)}" for row in rows)
    print(f"{name} [{time.monotonic() - started:.0f} s]: {told}", flush=True)
    return rows


def judged(name, program, folder, keep):
    """Renders, runs and judges the case of that name; its row, with the list "faults", is kept as row.json."""
    case = cases.all_cases()[name]
    shutil.rmtree(folder, ignore_errors=True)
    started = time.monotonic()
    truth, known = build(case, folder)
    rendered = time.monotonic()
    twin_file, out = os.path.join(folder, "twin.toml"), os.path.join(folder, "out")
    run = run_program(program, "cosim", twin_file, "--out", out, *(["--refine", case.refine] if case.refine else []))
    row = judge.row_of(case, truth, known, folder, run, time.monotonic() - rendered)
    row["render_seconds"] = round(rendered - started, 1)
    if case.measure:
        measured = os.path.join(folder, "measured")
        run = run_program(program, "measure", twin_file, "--captures", os.path.join(folder, "real"), "--out", measured)
        row["measure_said"] = judge.complaints(run.stderr)
        row["measure_verdict"] = (judge.loaded(os.path.join(measured, "result.json")) or {}).get("verdict")
    row["faults"] = list(judge.faults(case, row))
    with open(os.path.join(folder, "row.json"), "w", encoding="utf-8") as f:
        json.dump(row, f, indent=1)
    if not keep:
        for heavy in ("real", "out/simulated", "out/measured_real", "out/measured_simulated", "measured"):
            shutil.rmtree(os.path.join(folder, heavy), ignore_errors=True)
    return row


def chosen(options, parser):
    known = cases.all_cases()
    if options.page and (options.only or options.fast):
        parser.error("a page shows all rigs: --page goes with neither --only nor --fast")
    if options.only:
        names = options.only.split(",")
        unknown = [name for name in names if name not in known]
        if unknown:
            parser.error(f"no rig is named {', '.join(unknown)}; --list names all")
        return {name: known[name] for name in names}
    if options.refine:
        return {name: known[name] for name in refinements.RIGS}
    return {name: case for name, case in known.items() if case.fast or not options.fast}


def rows_of(selected, options):
    """Runs the cases, a line each as they end; the rows in the order of the cases."""
    rows = {}
    with concurrent.futures.ProcessPoolExecutor(options.jobs) as pool:
        running = {pool.submit(judged, name, options.program, os.path.join(options.out, name), options.keep): name
                   for name in selected}
        for done in concurrent.futures.as_completed(running):
            name = running[done]
            try:
                row = done.result()
            except (subprocess.SubprocessError, OSError) as error:  # no POV-Ray, a run that does not end
                row = judge.row_without_run(name, error)
            rows[name] = row
            print(f"{row['name']} [{row['render_seconds']:.0f} + {row['seconds']:.0f} s]: "
                  f"{'; '.join(row['faults']) or 'as it must be'}{' (NO-CAUSE)' if row['missing'] else ''}", flush=True)
    return [rows[name] for name in selected]


def publish(table, name, marks, options):
    with open(os.path.join(options.out, name), "w", encoding="utf-8") as f:
        f.write(table)
    if options.page:
        page.rewrite(options.page, table, options.program, marks)


def refine_all(selected, options):
    """All refinements of the chosen rigs; the exit code."""
    rows = []
    with concurrent.futures.ProcessPoolExecutor(options.jobs) as pool:
        running = {name: pool.submit(refined, name, options.program, os.path.join(options.out, name), options.keep)
                   for name in selected}
        for name, done in running.items():
            try:
                rows += done.result()
            except (subprocess.SubprocessError, OSError) as error:  # a run that does not end, or leaves no result
                rows += [refinements.row_without_run(name, group, error) for group in refinements.groups_of(name)]
                print(f"{name}: {error}", flush=True)
    publish(refinements.table(selected, rows), "refinements.md", page.REFINEMENTS, options)
    faulty = sum(bool(row["faults"]) for row in rows)
    print(f"{len(rows) - faulty} of {len(rows)} refinements as they must be; table: {options.out}/refinements.md")
    return 1 if faulty else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default="build/fringetwin")
    parser.add_argument("--out")
    parser.add_argument("--only", help="names of rigs, separated by commas")
    parser.add_argument("--refine", action="store_true", help="refine groups of twins, right ones too, and judge that")
    parser.add_argument("--fast", action="store_true", help="the rigs of the test e2e/trust")
    parser.add_argument("--list", action="store_true", help="print the rigs' names and end")
    parser.add_argument("--jobs", type=int, default=1, help="rigs at a time")
    parser.add_argument("--keep", action="store_true", help="keep images and clouds, 10 to 30 MB a rig")
    parser.add_argument("--page", help="the page whose table is written anew")
    options = parser.parse_args()
    selected = chosen(options, parser)
    if options.list:
        print("\n".join(selected))
        return
    if not options.out:
        parser.error("--out is missing")
    if options.refine:
        sys.exit(refine_all(selected, options))
    rows = rows_of(selected, options)
    if all(row["exit"] == NO_DEVICE for row in rows) and not os.environ.get("FRINGETWIN_REQUIRE_DEVICE"):
        print("skipped: the program finds no Vulkan device")
        sys.exit(SKIPPED)
    table = page.table(selected, rows)
    publish(table, "table.md", page.RIGS, options)
    faulty = [row["name"] for row in rows if row["faults"]]
    print(f"{len(rows) - len(faulty)} of {len(rows)} rigs as they must be; table: {options.out}/table.md")
    sys.exit(1 if faulty else 0)


if __name__ == "__main__":
    main()
