#!/usr/bin/env python3
"""Pages of docs/benchmarks from pareto.json and needs.json: performance_tables.py OUT FOLDER TWIN...

Reads OUT/TWIN/measured_at, a line that says at which commit and when, and OUT/TWIN/{pareto,needs}/*.json; writes
FOLDER/TWIN.md."""
import json
import math
import sys


def sci(value):
    return "–" if value is None or not math.isfinite(value) else f"{value:.1e}"


def plain(value, digits=3):
    return "–" if value is None or not math.isfinite(value) else f"{value:.{digits}g}"


def um(value):
    return plain(None if value is None else 1e3 * value, 2)


def ms(value):
    return "–" if value is None else f"{value:.0f}" if value >= 100 else f"{value:.1f}"


def machine(run):
    p = run["provenance"]
    return f"{p['machine']}; {p['device']} ({p['driver']}); fringetwin {p['version']}"


def pareto_table(run):
    rows = [
        f"Machine: {machine(run)}. {run['n_cameras']} cameras x {run['n_images']} images.",
        f"Pixels: {run['subset']['text']}. The reference is known to "
        f"{plain(run['reference']['edge_uncertainty_dn'], 2)} DN at the edges.",
        "",
        "| scheme | samples | precision | frame ms | phase, interior rad | phase, all rad | gray, interior DN "
        "| gray, all DN | gray, edges DN | fit error µm | fit shift µm | chain s | |",
        "|---|--:|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|---|",
    ]
    for p in run["points"]:
        e = p["error"]
        notes = [name for key, name in (("default", "**default**"), ("published", "**published scheme**"),
                                        ("phase_front", "phase front"), ("gray_front", "gray front"),
                                        ("fit_front", "fit front"),
                                        ("fit_reference", "reference of the fit shifts")) if p[key]]
        if p["time_extrapolated_from_samples"]:
            notes.append(f"time extrapolated from {p['time_extrapolated_from_samples']} samples")
        size = p["samples"] or f"to {p['target_rad']:.0e}"
        rows.append(
            f"| {p['scheme']} | {size} | {p['precision']} | {ms(p['frame_ms'])} "
            f"| {sci(e['phase_interior_rms_rad'])} | {sci(e['phase_rms_rad'])} | {sci(e['gray_interior_rms_dn'])} "
            f"| {sci(e['gray_rms_dn'])} | {sci(e['gray_edge_rms_dn'])} | {um(p['fit_error_mm'])} "
            f"| {um(p['fit_shift_mm'])} | {plain(p['chain_s'])} | {', '.join(notes)} |")
    return "\n".join(rows)


def needs_table(run):
    t, small = run["tolerance"], run["smallest_model"]
    rows = [
        "| effect | without it | phase rad | gray DN | gray, edges DN | fit mm | x time | for the tolerance |",
        "|---|---|--:|--:|--:|--:|--:|---|",
    ]
    for r in run["effects"]:
        if r["state"] == "off":
            continue
        c = r["change"]
        rows.append(f"| {r['name']} | {r['without']} | {sci(c['phase_rms_rad'])} | {sci(c['gray_rms_dn'])} "
                    f"| {sci(c['gray_edge_rms_dn'])} | {sci(r['fit_mm'])} | {plain(r['cost'])} "
                    f"| {r['recommendation']} |")
    e = run["renderer_error"]
    rows.append(f"| renderer's own error | double-precision reference | {sci(e['phase_rms_rad'])} "
                f"| {sci(e['gray_rms_dn'])} | {sci(e['gray_edge_rms_dn'])} | | | |")
    off = ", ".join(r["name"] for r in run["effects"] if r["state"] == "off")
    left = ", ".join(small["left_off"]) or "nothing"
    c = small["change"]
    rows += ["", f"Off in this scene: {off}. For {plain(t['phase_rad'])} rad, {plain(t['gray_dn'])} DN and "
             f"{plain(t['fit_mm'])} mm can be left off: {left} (together {sci(c['phase_rms_rad'])} rad, "
             f"{sci(c['gray_rms_dn'])} DN, {sci(c['fit_mm'])} mm; {plain(small['time_full_s'])} s become "
             f"{plain(small['time_s'])} s)."]
    return "\n".join(rows)


def page(out, twin):
    with open(f"{out}/{twin}/measured_at", encoding="utf-8") as f:
        measured_at = f.read().strip()
    tables = {}
    for kind, table in (("pareto", pareto_table), ("needs", needs_table)):
        with open(f"{out}/{twin}/{kind}/{kind}.json", encoding="utf-8") as f:
            run = json.load(f)
        tables[kind] = table(run)
    return f"""# Time against error: {run["twin"]}

Written by `scripts/performance.sh`: do not edit. What the columns mean: `docs/PERFORMANCE.md`. Scene: `datasets/{twin}/twin.toml`.

Measured at {measured_at}.

## Error against time of every sampling scheme
{tables["pareto"]}

## What the scene needs
{tables["needs"]}
"""


def main():
    out, folder, twins = sys.argv[1], sys.argv[2], sys.argv[3:]
    for twin in twins:
        text = page(out, twin)
        with open(f"{folder}/{twin}.md", "w", encoding="utf-8") as f:
            f.write(text)


main()
