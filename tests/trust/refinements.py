# SPDX-License-Identifier: Apache-2.0
"""Refines groups of a twin, also such as are right, on rigs with one error or none, and judges what comes out.

A row is one rig with one group: the parameters, how many standard errors they are off, and the faults in the words of
docs/TRUST.md, "Refinements"."""
import math
import re

import judge
import judge_causes
from truths import standard_errors

GROUPS = ("pose", "rig", "lens", "response", "blur")
RIGS = ("right_sphere_n4", "right_plane_n4", "right_small_two_cameras", "pose_40um", "size_6um_wall", "rig_turned", "lens_k1",
        "camera_middle", "gamma_n4", "blur_missing", "vignetting", "albedo", "texture_small", "side_lamp", "flicker", "knee",
        "camera_gamma", "hot_spot", "camera_defocus", "vibration", "gloss", "light_from_elsewhere", "pose_and_gamma_wall",
        "motion")
ALSO = {"motion": ("motion", "pose_40um", "right_sphere_n4"),
        "camera_knee": ("knee", "camera_gamma", "right_sphere_n4")}  # groups that only these rigs are refined by
COLUMNS = (*GROUPS, *ALSO)
FARTHEST = 4.0  # standard errors between a refined value and the truth
WARNED = r"refine|converge|not told|told apart|not to be trusted"
PLACES = ("pose", "size", "rig", "intrinsics", "lens", "motion")  # a factor and an offset per pixel are projected out of their fits
RANK = {"explained": 0, "budget too wide": 1, "not compared": 2, "not explained": 2}


def groups_of(rig):
    return (*GROUPS, *(group for group, rigs in ALSO.items() if rig in rigs))


def row_of(case, known, group, before, run, after):
    """known: the true values by name; before, after: the results without the refinement and with it; run: the latter's."""
    said = (after or {}).get("warnings", []) + [line for line in judge.complaints(run.stderr) if "warning:" in line]
    row = row_without_run(case.name, group, f"exit {run.returncode}, no refinement")
    refinement = (after or {}).get("refinement")
    if refinement is None:
        row["refused"] = bool(re.search("told apart|no parameter", run.stderr))
        row["faults"] = [] if row["refused"] else row["faults"]
        return row
    row["converged"], row["warned"] = refinement["converged"], any(re.search(WARNED, line) for line in said)
    row["off"] = deviations(case, known, group, refinement)
    row["faults"] = [*off_truth(row), *worse(before, after), *other_than_causes(group, before, refinement)]
    return row


def row_without_run(name, group, error):
    return dict(name=name, group=group, refused=False, converged=None, warned=False, off={}, faults=[f"FAILED: {error}"])


def deviations(case, known, group, refinement):
    """How many standard errors the values are off, by name. What is not known and not planted is right as the twin has it."""
    out = {}
    for p in refinement["parameters"]:
        truth = known.get(p["name"], None if group in case.causes.split() else p["before"])
        if truth is not None and p["after_sigma"]:
            out[p["name"]] = standard_errors(p["name"], p["after"], p["after_sigma"], truth)
    return out


def off_truth(row):
    if row["warned"]:
        return
    if not row["converged"]:
        yield "NOT-CONVERGED: and no warning says so"
    name, z = max(row["off"].items(), key=lambda item: abs(item[1]), default=("", 0))
    if abs(z) > FARTHEST:
        yield f"REFINED-OFF: {name} by {z:.1f} standard errors, and no warning"


def worse(before, after):
    """Rows of the verdict that the refinement made worse, by their word or by more than their sum's own spread."""
    old = {(e["quantity"], e["region"]): e for e in before["explained"]}
    for e in after["explained"]:
        b = old.get((e["quantity"], e["region"]))
        if b is None:
            continue
        where = f"REFINED-WORSE: {e['quantity']} of {e['region']}"
        if RANK[e["state"]] > RANK[b["state"]]:
            yield f"{where}, {b['state']} before and {e['state']} after"
            continue
        for key, limit, n in (("chi2", "chi2_limit", e["n"]), ("regional_chi2", "regional_limit", e["n_regions"])):
            if e[key] is None or b[key] is None or e[key] <= e[limit]:
                continue
            spread = b[key] * (1.02 + 2 * math.sqrt(2 / max(n, 1)))
            if e[key] > ((math.sqrt(b[key]) + 1)**2 if e["quantity"] == "geometry" else spread):
                yield f"{where}, {key} {b[key]:.3g} before and {e[key]:.3g} after"


def other_than_causes(group, before, refinement):
    """Values and standard errors that contradict what the causes of the run before printed for this group, if named. The
    refinement of what says where things are takes no light into account, so it may know less; and where it leaves out a
    parameter of the group that the causes fit, it knows the others better."""
    causes = before.get("causes") or {}
    if {group} not in judge_causes.alternatives(causes):
        return
    printed = {p["name"]: p for row in causes["tested"] if row["group"] == group for p in row["parameters"]}
    more = math.sqrt(refinement["n"] / causes["n"])  # a finer grid of pixels tells more
    fitted = {p["name"] for p in refinement["parameters"] if p["after_sigma"]}
    least = 0 if group in PLACES else 0.5
    most = 2 if set(printed) <= fitted else math.inf
    for p in refinement["parameters"]:
        c = printed.get(p["name"])
        if c is None or not c.get("estimate_sigma") or not p["after_sigma"]:
            continue
        apart = abs(p["after"] - c["estimate"]) / max(p["after_sigma"], c["estimate_sigma"])
        if apart > 3:
            yield f"NOT-AS-CAUSE: {p['name']} {apart:.1f} standard errors from what the causes print"
        elif not least < c["estimate_sigma"] / (p["after_sigma"] * more) < most:
            yield f"NOT-AS-CAUSE: {p['name']} +- {p['after_sigma']:.2g}, the causes say {c['estimate_sigma']:.2g}"


def cell(row):
    if row["refused"]:
        return "refused"
    words = list(dict.fromkeys(fault.split(":")[0] for fault in row["faults"]))
    if words == ["FAILED"]:
        return "FAILED"
    farthest = max(map(abs, row["off"].values()), default=None)
    return ", ".join((["kept"] if farthest is None else [f"{farthest:.1f}"]) + (["warned"] if row["warned"] else []) + words)


def table(cases, rows):
    """Rigs down, groups across: the farthest parameter in standard errors, whether there is a warning, and the faults."""
    lines = [f"{sum(not row['faults'] for row in rows)} of {len(rows)} refinements are as they must be.", "",
             "| rig | planted | " + " | ".join(COLUMNS) + " |", "|---" * (2 + len(COLUMNS)) + "|"]
    for name in dict.fromkeys(row["name"] for row in rows):
        of_rig = {row["group"]: cell(row) for row in rows if row["name"] == name}
        lines.append(f"| `{name}` | {cases[name].planted} | " + " | ".join(of_rig.get(group, "-") for group in COLUMNS) + " |")
    return "\n".join(lines) + "\n"
