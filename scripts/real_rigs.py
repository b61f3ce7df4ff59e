#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the program on every real capture set that is here, each with its best twin, and writes docs/REAL_RIGS.md.

    scripts/real_rigs.py --program build/fringetwin --out out/real [--page docs/REAL_RIGS.md] [--only SET ...]

A set is one entry of RUNS. Sets whose images are missing are named on the page; `make captures` fetches them. With --only the
page keeps what it says of the other sets; each says which version ran it. Pictures (the
maps of the gray differences, scaled down) need OpenCV's Python module, which comes with mrcal; without it the page has none.
"""
import argparse
import json
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent

# name of the set; twin under datasets/; where the twin comes from, and what of it held-out images have told; options of cosim; what
# more is refined where all images are fitted: waveforms of single images are told by all steps only
RUNS = [
    ("slmaster-mono-relief", "slmaster-mono-relief/twin.toml",
     "calibration of the set; the shape from the images' own depth map, contrast and room light from its pixels (datasets/README.md)",
     "contrast and room light of the twin; the shape is built in each fold from the steps that are fitted",
     ["--hold-out", "3", "--refine", "exposure,light,image_shift,harmonics,harmonics_field,harmonics_high,raster,texture,offset"],
     "image_harmonics"),
    ("cpsd-plane-4freq12step", "cpsd-plane-4freq12step/twin-rig.toml",
     "no calibration: a relative rig solved from the set's own phase, whose lengths mean nothing (datasets/README.md)",
     "where the projector's columns lie, and the lenses",
     ["--hold-out", "3", "--refine", "exposure,contrast,blur,projector.blur_field_px2.u,projector.blur_field_px2.v,harmonics,harmonics_high,texture,texture_spread,"
      "offset"], None),
    ("slsdk-stereo-statue", "slsdk-stereo-statue/twin-rig.toml",
     "stereo calibration of the set, whose cameras measure the shape; the projector solved from that shape by `calibrate --projector-from` (docs/CALIBRATION.md)",
     "the projector; the shape is built in each fold from the steps that are fitted",
     ["--hold-out", "4", "--refine", "exposure,texture,offset"], None),
    ("kamino-procam-board", "kamino-procam-board/twin-board.toml",
     "joint calibration of the set's five board poses; the sheet a mesh from the set's own code, which bulges (datasets/README.md)",
     "the sheet's shape, the projector's focal length and centre, the blur and halo that the fit starts from",
     ["--hold-out", "5", "--refine", "blur,halo,texture,offset"], None),
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


def run(program, twin, options, out, captures):
    """Runs cosim; returns its result and the seconds it took."""
    start = time.monotonic()
    status = subprocess.run([str(program), "cosim", f"datasets/{twin}", "--out", str(out), *options], cwd=ROOT,
                            env=os.environ | {"FRINGETWIN_CAPTURES": str(captures)}).returncode
    if status not in (0, 1, 5):
        sys.exit(f"{twin}: the program ended with exit code {status}; the page is not written")
    return json.loads((out / "result.json").read_text(encoding="utf-8")), time.monotonic() - start


def version_of(program):
    return subprocess.run([program, "--version"], capture_output=True, text=True, check=True).stdout.split("\n")[0]


def kept(page, name):
    """Returns the row and the section of a set on a page that was written before; two times None without."""
    text = page.read_text(encoding="utf-8") if page and page.is_file() else ""
    row = re.search(rf"^\| \[{re.escape(name)}\].*$", text, re.MULTILINE)
    section = re.search(rf"^## {re.escape(name)}\n.*?(?=^## |\Z)", text, re.MULTILINE | re.DOTALL)
    return (row[0], section[0].rstrip() + "\n") if row and section else (None, None)


def explained(result):
    """Returns what was found of each quantity, a line each."""
    return "".join(f"\n- {e['quantity']} {e['region']}: {e['state']}; χ² {number(e['chi2'], 3)} (limit {number(e['chi2_limit'], 3)}), "
                   f"of regions {number(e['regional_chi2'], 3)} ({number(e['regional_limit'], 3)})"
                   for e in result["explained"] if e.get("chi2") is not None)


def row_of(name, ratio, result, seconds):
    """Returns the table's row of a set; `ratio`: of its held-out images."""
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
    for name, twin, origin, told, options, more in RUNS:
        if args.only and name not in args.only:
            row, section = kept(args.page, name)
            if row:
                rows.append(row)
                sections.append(section)
            continue
        if not (captures / name).is_dir():
            missing.append(name)
            continue
        out = args.out / name
        print(f"== {name}", file=sys.stderr)
        result, seconds = run(args.program, twin, options, out, captures)
        ratio = held_out(result)
        commands = f"`fringetwin cosim datasets/{twin} {' '.join(options)}`\n"
        if more:
            fit = ["--refine", f"{options[options.index('--refine') + 1]},{more}"]
            of_held_out = explained(result)
            result, more_seconds = run(args.program, twin, fit, out, captures)
            seconds += more_seconds
            commands += f"{of_held_out}\n\nAll images fitted, which the table's other columns are of: `fringetwin cosim datasets/{twin} {' '.join(fit)}`\n"
        rows.append(row_of(name, ratio, result, seconds))
        image = picture(out, name) if args.page else None
        shown = f"\n\n![gray difference of {name}, mean of its images](images/{image})" if image else ""
        sections.append(f"## {name}\nTwin: `datasets/{twin}`: {origin}. Told by images that are held out, too: {told}. Run with {version_of(args.program)}.\n{commands}{explained(result)}{shown}\n")
    if not rows:
        sys.exit(f"no real captures at {captures} (FRINGETWIN_CAPTURES); `make captures` fetches them")
    table = ("| set | held-out images: rms over predicted noise (least … largest image) | phase difference, rad rms | gain, DN "
             "| verdicts | cause | time, s |\n|---|---|---|---|---|---|---|\n" + "\n".join(rows))
    lack = f"\n\nNot run, since their images are not here: {', '.join(missing)}." if missing else ""
    print(table + lack)
    if args.page:
        write_whole(args.page, f"""# Real rigs

What the program says of real captures, written by `make real` (two CPU cores, Mesa's software driver). The images are fetched by `make captures`; two
commands, and a stranger gets these numbers. Columns: [held-out images](metrics/gray.md#held-out-images-held_out), [phase](metrics/phase.md), [gain and what it is worth](metrics/gray.md), [verdicts](metrics/verdict.md), [causes](metrics/causes.md).
Nothing that a fold fits has seen the images which it predicts, but for each one's own brightness. The twin before the fit may have: each set says what. The
time is that of all runs of a set.

{table}{lack}

{chr(10).join(sections)}""")


if __name__ == "__main__":
    main()
