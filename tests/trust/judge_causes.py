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
    return {row["group"] for row in causes.get("tested") or [] if row.get("order")}


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
    mentioned = set().union(*named) | (in_order(causes) if each and not case.unlisted else set())
    out = dict(cause=" | ".join("+".join(sorted(groups)) for groups in named) or None, missing="", wrong=[])
    right = bool(mentioned & allowed) and each <= mentioned
    if not right and has_listed_cause(case):
        out["missing"] = " ".join(sorted(each - mentioned)) or case.causes
    if not named or (len(named) > 1 and any(groups & allowed for groups in named)):
        return out
    if mentioned & allowed:
        if len(named[0]) == 1 and not each and case.group != "double":  # it stands alone, and so does its value
            off = deviations(causes, named[0] & allowed, truths, allowed)
            out["wrong"] = [f"WRONG-VALUE: {name} by {z:.1f} standard errors" for name, z in off.items() if abs(z) > FARTHEST]
        return out
    for groups in named:
        off = deviations(causes, groups, truths, allowed)
        worst = max(off.items(), key=lambda item: abs(item[1]), default=None)
        if worst and abs(worst[1]) > FARTHEST:
            out["wrong"].append(f"WRONG-CAUSE: {'+'.join(sorted(groups))}, {worst[0]} by {worst[1]:.1f} standard errors")
        elif groups <= PER_PIXEL and not case.unlisted:
            out["wrong"].append(f"WRONG-CAUSE: {'+'.join(sorted(groups))}")
    return out
