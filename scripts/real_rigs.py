#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the program on every real capture set that is here, each with its best twin, and writes docs/REAL_RIGS.md.

    scripts/real_rigs.py --program build/fringetwin --out out/real [--page docs/REAL_RIGS.md] [--only SET ...]

A set is one entry of RUNS. Sets whose images are missing are named on the page; `make captures` fetches them. Pictures (the
maps of the gray differences, scaled down) need OpenCV's Python module, which comes with mrcal; without it the page has none.
"""
import argparse
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent

# name of the set; twin under datasets/; where the twin comes from; options of cosim
RUNS = [
    ("slmaster-mono-relief", "slmaster-mono-relief/twin.toml",
     "calibration of the set; the shape from the images' own depth map, contrast and room light from its pixels (datasets/README.md)",
     ["--hold-out", "3", "--refine", "exposure,light,image_shift,harmonics,harmonics_field,texture,offset"]),
    ("cpsd-plane-4freq12step", "cpsd-plane-4freq12step/twin-rig.toml",
     "no calibration: a relative rig solved from the set's own phase, whose lengths mean nothing (datasets/README.md)",
     ["--hold-out", "3", "--refine", "exposure,contrast,blur,projector.blur_field_px2.u,projector.blur_field_px2.v,harmonics,harmonics_high,texture,texture_spread,"
      "offset"]),
    ("slsdk-stereo-statue", "slsdk-stereo-statue/twin-rig.toml",
     "stereo calibration of the set, whose cameras measure the shape; the projector solved from that shape by `calibrate --projector-from` (docs/CALIBRATION.md)",
     ["--hold-out", "4", "--refine", "exposure,texture,offset"]),
    ("kamino-procam-board", "kamino-procam-board/twin-board.toml",
     "joint calibration of the set's five board poses; the sheet a mesh from the set's own code, which bulges (datasets/README.md)",
     ["--hold-out", "5", "--refine", "blur,halo,texture,offset"]),
]


def held_out(result):
    """Returns the ratio of all held-out images of a run, and its least and largest; None without any."""
    rows = [r for r in result.get("held_out") or [] if r.get("predicted_dn")]
    if not rows:
        return None
    found = sum(r["n"] * r["rms_dn"] ** 2 for r in rows)
    predicted = sum(r["n"] * r["predicted_dn"] ** 2 for r in rows)
    ratios = [r["ratio"] for r in rows]
    return math.sqrt(found / predicted), min(ratios), max(ratios)


def number(value, digits=4):
    return "–" if value is None else f"{value:.{digits}g}"


def row_of(name, result, seconds):
    """Returns the table's row of a set."""
    ratio = held_out(result)
    gain = "; ".join(f"{number(g['gain_dn'], 6)} ± {number(g['gain_total_sigma_dn'], 2)} ({g['state']})"
                     for g in result["gain"])
    phase = "; ".join(f"{p['rms_rad']:.4f}" for p in result["phase"]) or "–"
    verdicts = ", ".join(f"{k}: {v}" for k, v in (result.get("budget_verdict") or {}).items() if v)
    causes = result.get("causes") or {}
    tested = {t["group"]: t["cause"] for t in causes.get("tested", [])}
    named = [tested.get(g, g) for g in causes.get("together") or []]
    told = "–" if ratio is None else f"**{ratio[0]:.2f}** ({ratio[1]:.2f} … {ratio[2]:.2f})"
    return (f"| [{name}](#{name}) | {told} | {phase} | {gain} | {verdicts} | {' or '.join(named) or 'none named'} "
            f"| {seconds:.0f} |")


def picture(out, name):
    """Writes the map of the gray differences, scaled down, beside the page's pictures. Returns its name, or None."""
    maps = sorted(out.glob("gray_difference_*.png"))
    try:
        import cv2
    except ImportError:
        print("no picture: this python3 has no OpenCV (cv2)", file=sys.stderr)
        return None
    if not maps:
        return None
    image = cv2.imread(str(maps[0]))
    scale = 480 / image.shape[1]
    small = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    target = ROOT / "docs/images" / f"real-{name}.png"
    # 5 bits a channel: the map's colours stay apart, and the file small
    cv2.imwrite(str(target), small & 0xF8, [cv2.IMWRITE_PNG_COMPRESSION, 9])
    return target.name


def write_whole(path, text):
    with tempfile.NamedTemporaryFile("w", dir=path.parent, delete=False, encoding="utf-8") as part:
        part.write(text)
    os.chmod(part.name, 0o644)
    os.replace(part.name, path)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", type=pathlib.Path, required=True)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--page", type=pathlib.Path, help="default: the table on standard output alone")
    parser.add_argument("--only", nargs="+", choices=[r[0] for r in RUNS], help="these sets")
    args = parser.parse_args()
    captures = pathlib.Path(os.environ.get("FRINGETWIN_CAPTURES", ROOT.parent / "shared/captures"))
    rows, sections, missing = [], [], []
    for name, twin, origin, options in RUNS:
        if args.only and name not in args.only:
            continue
        if not (captures / name).is_dir():
            missing.append(name)
            continue
        out = args.out / name
        command = [str(args.program), "cosim", f"datasets/{twin}", "--out", str(out), *options]
        print(f"== {name}", file=sys.stderr)
        start = time.monotonic()
        status = subprocess.run(command, cwd=ROOT, env=os.environ | {"FRINGETWIN_CAPTURES": str(captures)}).returncode
        seconds = time.monotonic() - start
        if status not in (0, 1, 5):
            sys.exit(f"{name}: the program ended with exit code {status}; the page is not written")
        result = json.loads((out / "result.json").read_text(encoding="utf-8"))
        rows.append(row_of(name, result, seconds))
        image = picture(out, name) if args.page else None
        shown = f"\n\n![gray difference of {name}, mean of its images](images/{image})" if image else ""
        why = "".join(f"\n- {e['quantity']} {e['region']}: {e['state']}; χ² {number(e['chi2'], 3)} (limit {number(e['chi2_limit'], 3)}), "
                      f"of regions {number(e['regional_chi2'], 3)} ({number(e['regional_limit'], 3)})"
                      for e in result["explained"] if e.get("chi2") is not None)
        sections.append(f"## {name}\nTwin: `datasets/{twin}`: {origin}.\n`fringetwin cosim datasets/{twin} {' '.join(options)}`\n{why}{shown}\n")
    if not rows:
        sys.exit(f"no real captures at {captures} (FRINGETWIN_CAPTURES); `make captures` fetches them")
    table = ("| set | held-out images: rms over predicted noise (least … largest image) | phase difference, rad rms | gain, DN "
             "| verdicts | cause | time, s |\n|---|---|---|---|---|---|---|\n" + "\n".join(rows))
    lack = f"\n\nNot run, since their images are not here: {', '.join(missing)}." if missing else ""
    print(table + lack)
    if args.page:
        version = subprocess.run([args.program, "--version"], capture_output=True, text=True, check=True).stdout.split("\n")[0]
        write_whole(args.page, f"""# Real rigs

What the program says of real captures, written by `make real` ({version}, two CPU cores, Mesa's software driver). The images are fetched by `make captures`; two
commands, and a stranger gets these numbers. Columns: [held-out images](metrics/gray.md#held-out-images-held_out), [phase](metrics/phase.md), [gain and what it is worth](metrics/gray.md), [verdicts](metrics/verdict.md), [causes](metrics/causes.md).

{table}{lack}

{chr(10).join(sections)}""")


if __name__ == "__main__":
    main()
