# SPDX-License-Identifier: Apache-2.0
"""The battery's table in Markdown, and the places of tables in docs/TRUST.md: between two marks, nothing else is touched."""
import datetime
import re
import subprocess

import judge_causes
from cases import GROUPS

RIGS = "<!-- made by tests/trust/battery.py: begin -->", "<!-- end -->"
REFINEMENTS = "<!-- made by tests/trust/battery.py --refine: begin -->", "<!-- end of refinements -->"
QUANTITIES = ("gray", "phase", "code", "geometry", "coverage")
SHORT = {"explained": "ok", "not explained": "NOT", "budget too wide": "WIDE", "not compared": "NONE", None: "-"}


def verdicts(row):
    if row["verdict"] is None:
        return "no result"
    return " ".join(SHORT.get(row["verdict"][q], row["verdict"][q]) for q in QUANTITIES if q in row["verdict"])


def cause(row):
    return (row["cause"] or "-").replace("|", "or") + (", NO-CAUSE" if row["missing"] else "")


def number(value, digits, unit, z):
    sigmas = f" ({z:+.1f})" if z is not None else ""
    return f"{value:+.{digits}f}{unit}{sigmas}"


def gains(row):
    cells = []
    for g in row["gain"]:
        if "printed_dn" not in g:
            cells.append("none")
            continue
        cells.append(f"{number(100 * g['gain_error'], 3, ' %', g['z'][0])}, "
                     f"{number(g['black_error_dn'], 2, ' DN', g['z'][1])}{', doubted' if g['doubted'] else ''}")
    return "; ".join(cells) or "-"


def table(cases, rows):
    """A table for each group of rigs, and a sentence with the sums. Faults are given by their words alone."""
    lines = []
    for group in GROUPS:
        of_group = [row for row in rows if cases[row["name"]].group == group]
        if not of_group:
            continue
        lines += [f"### {group.capitalize()}", "", "| rig | planted | verdicts | cause | gain, black level: error (in sigma) "
                  "| faults |", "|---|---|---|---|---|---|"]
        for row in of_group:
            words = dict.fromkeys(fault.split(":")[0] for fault in row["faults"])
            lines.append(f"| `{row['name']}` | {cases[row['name']].planted} | {verdicts(row)} | {cause(row)} "
                         f"| {gains(row)} | {', '.join(words) or 'none'} |")
        lines.append("")
    sound = sum(not row["faults"] for row in rows)
    listed = [row for row in rows if judge_causes.has_listed_cause(cases[row["name"]])]
    named = sum(not row["missing"] and row["verdict"] is not None for row in listed)
    return "\n".join([f"{sound} of {len(rows)} rigs are as they must be. A cause that the program knows is planted in "
                      f"{len(listed)} rigs, and named in {named} of them.", "", *lines])


def made_by(program):
    """When and with what the table was made. A tree that differs from its commit is marked."""
    def told(*command):
        return subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip()

    commit = told("git", "rev-parse", "--short=7", "HEAD") or "unknown"
    changed = told("git", "status", "--porcelain", "--untracked-files=no", "--", ":!docs/TRUST.md")
    return (f"Made on {datetime.date.today().isoformat()} by `make trust` at commit {commit}"
            f"{' with changes' if changed else ''} ({told(program, '--version') or 'no version'}).")


def rewrite(path, text, program, marks):
    replace(path, f"{made_by(program)} {text}", marks)


def replace(path, text, marks):
    begin, end = marks
    with open(path, encoding="utf-8") as f:
        page = f.read()
    if page.count(begin) != 1 or page.count(end) != 1:
        raise ValueError(f"{path} lacks the marks between which its table stands")
    new = re.sub(re.escape(begin) + r".*" + re.escape(end), lambda _: f"{begin}\n{text}{end}", page, flags=re.DOTALL)
    with open(path, "w", encoding="utf-8") as f:
        f.write(new)
