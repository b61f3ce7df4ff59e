# SPDX-License-Identifier: Apache-2.0
"""Holds the causes that a result names against those that were planted.

An alternative is a set of groups that fit the images together; the program names one, or several that cannot be told apart."""
import re

from truths import standard_errors

FARTHEST = 3.0  # standard errors between a printed value and the truth
PER_PIXEL = {"texture", "factor", "offset"}  # words for anything constant of each pixel: they print no value


def groups_in(entry):
    """The groups of one alternative: a name, names joined by "+", a list, or an object with such under "group" or "groups"."""
    if isinstance(entry, dict):
        entry = next((entry[key] for key in ("groups", "group", "name") if entry.get(key)), "")
    words = entry if isinstance(entry, list) else re.split(r"\s*\+\s*|\s+and\s+", entry)
    return {"factor" if "factor" in word else "offset" if "offset" in word else word.strip() for word in words if word}


def alternatives(causes):
    """The sets of groups that a result names: `named`, else those of `together`."""
    if causes.get("named"):
        return [groups_in(causes["named"])]
    return [groups_in(entry) for entry in causes.get("together") or []]


def in_order(causes):
    """The groups named one after the other for several errors, the first included."""
    ordered = sorted((row["order"], row["group"]) for row in causes.get("tested") or [] if row.get("order"))
    return [group for _, group in ordered]


def deviations(causes, groups, truths, planted):
    """How many standard errors the printed values of these groups are off. A value whose truth is not known is left out if its
    group is planted; else the twin's is the true one."""
    out = {}
    for row in [*(causes.get("tested") or []), *(e for e in causes.get("together") or [] if isinstance(e, dict))]:
        for p in row.get("parameters") or []:
            if not groups_in(row) & groups or p.get("estimate") is None or not p.get("estimate_sigma"):
                continue
            truth = truths.get(p["name"], None if groups_in(row) & planted else p["twin"])
            if truth is not None:
                out[p["name"]] = standard_errors(p["name"], p["estimate"], p["estimate_sigma"], truth)
    return out


def has_listed_cause(case):
    """Is something planted that the program has a group for, and left there?"""
    return bool(case.causes) and not case.unlisted and case.expect != "explained"


def told(case, causes, truths):
    """What a row keeps of the causes: the words for the table, whether a listed cause is missing, and what is wrong."""
    named = alternatives(causes)
    allowed, each = set(case.causes.split()), set(case.each.split())
    ordered = in_order(causes) if causes.get("named") else []  # where nothing is named they are those of linear steps
    mentioned = set(ordered).union(*named)
    words = " | ".join("+".join(sorted(groups)) for groups in named)
    out = dict(cause=", then ".join(ordered) or words or None, missing="", wrong=[])
    right = bool(mentioned & allowed) and each <= mentioned
    if not right and has_listed_cause(case):
        out["missing"] = " ".join(sorted(each - mentioned)) or case.causes
    if len(named) > 1 and any(groups & allowed for groups in named):
        return out  # one of several that cannot be told apart: none of their values stands for itself
    for group in sorted(mentioned - allowed):
        off = worst(deviations(causes, {group}, truths, allowed))
        if off and abs(off[1]) > FARTHEST:
            out["wrong"].append(f"WRONG-CAUSE: {group}, {off[0]} by {off[1]:.1f} standard errors")
        elif group in PER_PIXEL and not case.unlisted:
            out["wrong"].append(f"WRONG-CAUSE: {group}")
    alone = len(mentioned) == 1 and mentioned <= allowed and not each and case.group != "double" and not case.unlisted
    off = worst(deviations(causes, mentioned, truths, allowed)) if alone else None
    if off and abs(off[1]) > FARTHEST:
        out["wrong"].append(f"WRONG-VALUE: {off[0]} by {off[1]:.1f} standard errors")
    return out


def worst(deviations_by_name):
    return max(deviations_by_name.items(), key=lambda item: abs(item[1]), default=None)
