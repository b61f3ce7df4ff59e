#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Plants every fault that judge.py knows in a row, and checks that it is found, and that a sound row has none."""
import subprocess
import sys

import judge
import judge_causes
import refinements
from cases import Case, all_cases, nothing

ALL_OK = {"gray": "explained", "phase": "explained", "geometry": "explained"}


def gain(**changed):
    return dict(camera="left", state="sensor value", n=1000, r2=0.999, doubted=False, printed_dn=300.0, gain_error=0.0,
                black_error_dn=0.0, z=[0.0, 0.0], z_with_bias=[0.0, 0.0]) | changed


def words(expected, **changed):
    """The words that the judge finds, for a case that expects so, in a row that is sound but for what is changed."""
    case = Case("rig", expected.pop("group", "light"), "", nothing, **expected)
    row = dict(exit=0, verdict=dict(ALL_OK), cause=None, wrong=[], warnings=[], said=[],
               gain=[gain()]) | changed
    return [fault.split(":")[0] for fault in judge.faults(case, row)]


RIGHT = dict(group="right", expect="explained")
GRAY = ALL_OK | {"gray": "not explained"}
EXPECTED = [
    ([], words(dict(RIGHT))),
    ([], words({}, verdict=GRAY)),
    ([], words(dict(says="swap"), exit=3, verdict=None, said=["error: images 1 and 2 swapped"])),
    ([], words(dict(causes="blur"), verdict=GRAY, cause="blur", gain=[gain(gain_error=0.2, z=[90, 0], doubted=True)])),
    ([], words(dict(RIGHT), gain=[gain(gain_error=0.0009, z=[5, 0])])),
    ([], words(dict(expect="any", says="3600"), said=["values stop at 3600 DN"])),
    (["FALSE-EXPLAINED"], words({})),
    (["RIGHT-REJECTED"], words(dict(RIGHT), verdict=GRAY)),
    (["RIGHT-REJECTED"], words(dict(RIGHT), verdict=ALL_OK | {"geometry": None})),
    (["FALSE-ALARM"], words(dict(RIGHT), warnings=["left: this is odd"])),
    (["NOT-SEEN"], words(dict(verdict={"coverage": "not explained"}), verdict=GRAY)),
    (["NOT-NAMED"], words(dict(says="swap"), verdict=GRAY, said=["the wallpaper is odd"])),
    (["NO-VERDICT"], words({}, verdict=GRAY | {"phase": None})),
    (["WRONG-CAUSE"], words(dict(causes="blur"), verdict=GRAY, cause="pose", wrong=["WRONG-CAUSE: pose"])),
    (["GAIN-UNWARNED"], words({}, verdict=GRAY, gain=[gain(gain_error=0.002, z=[3.5, 0])])),
    (["GAIN-UNWARNED"], words({}, verdict=GRAY, gain=[gain(black_error_dn=-0.5, z=[0, -4])])),
    (["BIAS-TOO-SMALL"], words({}, verdict=GRAY, gain=[gain(state="biased", doubted=True, gain_error=0.2, z=[90, 0],
                                                            z_with_bias=[4, 0])])),
    (["GAIN-SENSELESS"], words(dict(gain=False), verdict=GRAY, gain=[gain(printed_dn=-3.0)])),
    (["GAIN-SENSELESS"], words(dict(gain=False), verdict=GRAY, gain=[gain(r2=-0.1)])),
    (["NOT-CONVERGED", "REFINED-OFF"], words(dict(RIGHT), refined=dict(converged=False, z=[0.1, -3.2]))),
    (["TAKEN-BACK"], words(dict(refine="texture"), verdict=GRAY, warnings=["--refine texture is taken back: chi2 would rise"])),
    (["MEASURE-SILENT", "MEASURE-PASSES"], words(dict(measure=True, says="swap"), verdict=GRAY, said=["swap"],
                                                 measure_said=[], measure_verdict="pass")),
    (["FAILED"], words(dict(RIGHT), exit=70)),
    (["FAILED"], words(dict(says="swap"), exit=3, verdict=None, said=["error: no such file"])),
]


TRUTHS = {"ball.center_mm.z": 292.0, "projector.blur_px": 1.5}


def causes(named=None, together=(), order=(), **estimates):
    """The causes of a result: rows of pose, blur and texture; an estimate is a value and its standard error."""
    rows = [dict(group=group, order=order.index(group) + 1 if group in order else 0,
                 parameters=[dict(name=name, twin=twin, estimate=value, estimate_sigma=sigma)])
            for group, name, twin in (("pose", "ball.center_mm.z", 292.0), ("blur", "projector.blur_px", 0.0))
            for value, sigma in [estimates.get(group, (twin, 0.1))]]
    return dict(named=named, together=list(together), tested=[*rows, dict(group="texture", order=0, parameters=[])])


def told(found, **expected):
    """Is a cause missing, and which words are against those found?"""
    row = judge_causes.told(Case("rig", "cause", "", nothing, **expected), found, TRUTHS)
    return [bool(row["missing"]), [word.split(":")[0] for word in row["wrong"]]]


BLUR, OFF = dict(causes="blur"), (293.0, 0.1)
TWO = dict(causes="pose blur", each="pose blur")
EXPECTED_OF_CAUSES = [
    ([False, []], told(causes("blur", blur=(1.4, 0.1)), **BLUR)),
    ([False, ["WRONG-VALUE"]], told(causes("blur", blur=(1.4, 0.03)), **BLUR)),
    ([True, []], told(causes(), **BLUR)),
    ([True, []], told({}, **BLUR)),
    ([True, ["WRONG-CAUSE"]], told(causes("pose", pose=OFF), **BLUR)),
    ([True, []], told(causes("pose", pose=(293.0, 0.5)), **BLUR)),
    ([True, ["WRONG-CAUSE"]], told(causes("texture"), **BLUR)),
    ([False, []], told(causes(None, ["pose", "blur"], pose=OFF), **BLUR)),
    ([False, []], told(causes(None, [dict(group="pose"), dict(groups=["blur", "lens"])], pose=OFF), **BLUR)),
    ([True, ["WRONG-CAUSE"]], told(causes(None, ["pose", "lens"], pose=OFF), **BLUR)),
    ([False, []], told(causes("blur", order=["blur", "pose"], blur=(2, 0.1)), **TWO)),
    ([False, []], told(causes(None, ["pose + blur", "lens + blur"]), **TWO)),
    ([True, ["WRONG-CAUSE"]], told(causes("blur", order=["blur", "pose"], pose=OFF), causes="blur lens", each="blur lens")),
    ([False, ["WRONG-CAUSE"]], told(causes(None, ["pose + blur"], pose=OFF), **BLUR)),
    ([True, []], told(causes("blur", order=["blur"], blur=(2, 0.1)), **TWO)),
    ([False, []], told(causes(), unlisted=True)),
    ([False, []], told(causes("a factor per pixel"), unlisted=True)),
    ([False, ["WRONG-CAUSE"]], told(causes("pose", pose=OFF), unlisted=True)),
]


def result(named=None, notes=(), after=0.0, sigma=0.1, converged=True, **states):
    """A result with a refinement of the blur, or, as the one before it, with causes that print 1.5 +- 0.1 for it."""
    rows = [dict(quantity=q, region="left", state=states.get(q, "explained"), n=10000, n_regions=100,
                 chi2=states.get(q + "_chi2", 1.0), chi2_limit=9.0 if q == "geometry" else 1.15,
                 regional_chi2=1.0, regional_limit=1.5) for q in ALL_OK]
    return dict(explained=rows, causes=causes(named, blur=(1.5, 0.1)) | dict(n=100), warnings=list(notes), refinement=dict(
        converged=converged, n=100, parameters=[dict(name="projector.blur_px", before=0.0, after=after, after_sigma=sigma)]))


def refinement(before, after, stderr="", planted="blur"):
    """The words against a refinement of the blur, planted with 1.5 px unless another cause is."""
    run = subprocess.CompletedProcess([], 0 if after else 2, stderr=stderr)
    known = TRUTHS if planted == "blur" else {}
    row = refinements.row_of(Case("rig", "cause", "", nothing, causes=planted), known, "blur", before, run, after)
    return [fault.split(":")[0] for fault in row["faults"]]


EXPECTED_OF_REFINEMENTS = [
    ([], refinement(result("blur"), result(after=1.6))),
    ([], refinement(result(), None, "a: error: blur and contrast cannot be told apart\n")),
    (["FAILED"], refinement(result(), None, "a: error: no such file\n")),
    (["REFINED-OFF"], refinement(result(), result(after=2.0))),
    (["REFINED-OFF"], refinement(result(), result(after=0.9), planted="pose")),
    ([], refinement(result(), result(after=0.5), planted="pose")),
    ([], refinement(result(), result(None, ["what is left is not explained: the values are not to be trusted"], after=2.0))),
    (["NOT-CONVERGED"], refinement(result(), result(after=1.5, converged=False))),
    ([], refinement(result(), result(None, ["the refinement did not converge"], after=1.5, converged=False))),
    (["REFINED-WORSE"], refinement(result(), result(after=1.5, phase="not explained"))),
    (["REFINED-WORSE"], refinement(result(gray="not explained", gray_chi2=2.0),
                                   result(after=1.5, gray="not explained", gray_chi2=2.2))),
    ([], refinement(result(gray="not explained", gray_chi2=2.0), result(after=1.5, gray="not explained", gray_chi2=2.05))),
    ([], refinement(result(geometry="not explained", geometry_chi2=16.0),
                    result(after=1.5, geometry="not explained", geometry_chi2=24.0))),
    (["REFINED-WORSE"], refinement(result(geometry="not explained", geometry_chi2=16.0),
                                   result(after=1.5, geometry="not explained", geometry_chi2=26.0))),
    (["NOT-AS-CAUSE"], refinement(result("blur"), result(after=1.5, sigma=0.01))),
    (["NOT-AS-CAUSE"], refinement(result("blur"), result(after=1.17))),
]


def main():
    wrong = [f"expected {expected}, found {found}"
             for expected, found in EXPECTED + EXPECTED_OF_CAUSES + EXPECTED_OF_REFINEMENTS if expected != found]
    if len(all_cases()) < 110:
        wrong.append(f"only {len(all_cases())} rigs: a module of cases is not loaded")
    wrong += [f"no rig is named {name}" for name in refinements.RIGS if name not in all_cases()]
    complained = judge.complaints("a: warning: odd\nrender 100 %\nx: verdict pass; report: /somewhere/swap/report.html\n")
    if complained != ["a: warning: odd", "x: verdict pass"]:
        wrong.append(f"complaints: {complained}")
    print("\n".join(wrong) or "every planted fault is found")
    sys.exit(1 if wrong else 0)


main()
