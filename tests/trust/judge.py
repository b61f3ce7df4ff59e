# SPDX-License-Identifier: Apache-2.0
"""Holds what the program said of a rig against what was planted in it.

A row is what one run left: verdicts, what was said, gain with its error, seconds. A fault is a word in capitals with the
reason behind it; faults() returns all of a row. The words are told in docs/TRUST.md, "What is held against the program"."""
import json
import os
import re
import tomllib

import numpy as np

import judge_causes
from projection import rotation, rotation_vector
from solids import GEM_VERTICES, gem_vertices
from truths import standard_errors

FINISHED = (0, 1, 3, 5)  # exit codes of a run that wrote its results (docs/CONVENTIONS.md, "Exit codes")


def loaded(path):
    if not os.path.exists(path):
        return None
    with open(path, encoding="utf-8") as f:
        return json.load(f)


def complaints(stderr):
    """The warnings and errors among the lines of standard error, and its last line, the verdict, without paths."""
    lines = [re.sub(r"; (report|written).*", "", line) for line in stderr.strip().splitlines()]
    return [line for line in lines if "warning:" in line or "error:" in line] + lines[-1:]


def row_of(case, truth, known, folder, run, seconds):
    """What a run of cosim in `folder` said. truth: the rig; known: the true values of parameters by name."""
    result = loaded(os.path.join(folder, "out", "result.json"))
    row = dict(name=case.name, exit=run.returncode, seconds=round(seconds, 1), verdict=None, cause=None, missing="",
               wrong=[], warnings=[], gain=[], said=complaints(run.stderr))
    if result is None:
        return row
    row["verdict"] = result["budget_verdict"]
    told = judge_causes.told(case, result.get("causes") or {}, known)
    row.update(cause=told["cause"], missing=told["missing"], wrong=told["wrong"])
    row["warnings"] = result["warnings"]
    row["said"] += result["warnings"] + [f"{q}: {word}" for q, word in row["verdict"].items()]
    row["said"] += [e["why"] for e in result["explained"] if e.get("why")]
    row["said"] += [f'the named cause is {row["cause"]}'] if row["cause"] else []
    row["gain"] = [gain_of(g, sensor, result["warnings"]) for g, sensor in zip(result["gain"], truth.sensors)]
    refined = os.path.join(folder, "out", "refined.toml")
    if case.refine == "pose" and os.path.exists(refined):
        row["refined"] = deviations(os.path.join(folder, "twin.toml"), refined, truth.things[0], result["refinement"])
    elif case.refine and result.get("refinement"):
        row["refined"] = deviations_of_values(case.values, result["refinement"])
    return row


def row_without_run(name, error):
    """The row of a rig that could not be rendered or run to its end."""
    return dict(name=name, exit=None, seconds=0, render_seconds=0, verdict=None, cause=None, missing="",
                wrong=[], warnings=[], gain=[], said=[str(error)], faults=[f"FAILED: {error}"])


def gain_of(g, sensor, warnings):
    """A camera's gain as printed, its error, and whether it is offered without a doubt."""
    state = g.get("state", "sensor value")
    out = dict(camera=g["camera"], state=state, n=g["n"], r2=g["r2"])
    out["doubted"] = state != "sensor value" or any("gain" in w and g["camera"] in w for w in warnings)
    if g["gain_dn"] is None:
        return out
    error = (g["gain_dn"] - sensor["gain_dn"], g["black_level_dn"] - sensor["black_dn"])
    sigma = (g["gain_sigma_dn"], g["black_level_sigma_dn"])
    bias = (g.get("gain_bias_dn") or 0, g.get("black_level_bias_dn") or 0)
    out["printed_dn"] = g["gain_dn"]
    out["gain_error"], out["black_error_dn"] = error[0] / sensor["gain_dn"], error[1]
    out["z"] = [float(e / s) if s else None for e, s in zip(error, sigma)]
    out["z_with_bias"] = [float(e / np.hypot(s, b)) if s or b else None for e, s, b in zip(error, sigma, bias)]
    return out


def first_object(path):
    with open(path, "rb") as f:
        return (tomllib.load(f).get("object") or [{}])[0]


def deviations_of_values(values, refinement):
    """How many standard errors the refined values are off that are planted by name; infinitely many of one that is missing."""
    found = {p["name"]: p for p in refinement["parameters"]}
    z = [standard_errors(name, found[name]["after"], found[name]["after_sigma"], value)
         if name in found and found[name]["after_sigma"] else float("inf") for name, value in values.items()]
    return dict(converged=refinement["converged"], z=z)


def deviations(twin, changes, thing, refinement):
    """How many standard errors the refined object (the twin's, with the changes) is away from the true one,
    direction by direction."""
    refined = {**first_object(twin), **first_object(changes)}
    sigma = [p["after_sigma"] for p in refinement["parameters"]]
    if thing["shape"] == "sphere":
        apart = np.array(refined["center_mm"]) - thing["center_mm"]
    elif thing["shape"] == "plane":  # along the normal at the refined point, and the two tilts together
        n = thing["normal"] / np.linalg.norm(thing["normal"])
        m = np.array(refined["normal"]) / np.linalg.norm(refined["normal"])
        apart = np.array([n @ (np.array(refined["point_mm"]) - thing["point_mm"]), np.linalg.norm(np.cross(n, m))])
        sigma = [sigma[0], float(np.hypot(*sigma[1:3]))]
    else:
        rt = np.array(refined["rt_world_object"])
        moved = (GEM_VERTICES @ rotation(rt[:3]).T + rt[3:]).mean(0) - gem_vertices(thing).mean(0)
        apart = np.concatenate([moved, rotation_vector(rotation(rt[:3]) @ rotation(thing["rt_world_object"][:3]).T)])
    return dict(converged=refinement["converged"], z=[float(a / s) for a, s in zip(apart, sigma)])


def faults(case, row):
    """All that is wrong with a row, in the words of docs/TRUST.md."""
    if row["verdict"] is None:
        told = case.says and re.search(case.says, " ".join(row["said"]), re.IGNORECASE)
        return [] if told and case.expect != "explained" else [f"FAILED: exit {row['exit']}, no result"]
    return [*verdict_faults(case, row), *gain_faults(case, row), *refinement_faults(row), *measure_faults(case, row)]


def verdict_faults(case, row):
    words = row["verdict"]
    explained = all(word == "explained" for word in words.values())
    named = re.search(case.says, " ".join(row["said"]), re.IGNORECASE) if case.says else None
    if row["exit"] not in ((0,) if case.expect == "explained" else FINISHED):
        yield f"FAILED: exit {row['exit']}"
    if case.expect == "explained" and not explained:
        yield "RIGHT-REJECTED: " + ", ".join(f"{q} {w or 'has no verdict'}" for q, w in words.items() if w != "explained")
    if case.group == "right" and row["warnings"]:
        yield f"FALSE-ALARM: {row['warnings'][0]}"
    if case.expect == "not explained" and explained:
        yield "FALSE-EXPLAINED"
    for quantity, pattern in case.verdict.items():
        if not re.fullmatch(pattern, words.get(quantity) or ""):
            yield f"NOT-SEEN: {quantity} is {words.get(quantity) or 'without a verdict'}"
    if case.says and not named:
        yield "NOT-NAMED"
    if case.expect != "explained" and not named and None in (words.get("gray"), words.get("phase")):
        yield "NO-VERDICT"
    yield from row["wrong"]


def gain_faults(case, row):
    for g in row["gain"]:
        if "printed_dn" not in g:
            continue
        if g["printed_dn"] <= 0 or (g["r2"] is not None and g["r2"] < 0):
            yield f"GAIN-SENSELESS: {g['camera']} {g['printed_dn']:.3g} DN"
        if not case.gain:
            continue
        if not g["doubted"] and is_off(g, g["z"]):
            yield f"GAIN-UNWARNED: {g['camera']}"
        if g["state"] == "biased" and is_off(g, g["z_with_bias"]):
            yield f"BIAS-TOO-SMALL: {g['camera']}"


def is_off(g, z):
    """More than 3 standard errors, and more than 0.1 % of the gain or 0.1 DN of the black level, beside the truth."""
    gain, black = (abs(v) > 3 if v is not None else False for v in z)
    return (gain and abs(g["gain_error"]) > 1e-3) or (black and abs(g["black_error_dn"]) > 0.1)


def refinement_faults(row):
    if any("is taken back" in said for said in row["warnings"]):
        yield "TAKEN-BACK"
    if "refined" not in row:
        return
    if not row["refined"]["converged"]:
        yield "NOT-CONVERGED"
    worst = max(map(abs, row["refined"]["z"]), default=0)
    if worst > 3:
        yield f"REFINED-OFF: by {worst:.1f} standard errors"


def measure_faults(case, row):
    if not case.measure or "measure_said" not in row:
        return
    if not re.search(case.says, " ".join(row["measure_said"]), re.IGNORECASE):
        yield "MEASURE-SILENT"
    if row["measure_verdict"] == "pass":
        yield "MEASURE-PASSES"
