# SPDX-License-Identifier: Apache-2.0
"""What a case of the battery is: a rig, what is planted in it or in its twin, and what the program must say.

The modules cases_*.py fill CASES, a group each; all_cases() loads them."""
import importlib
from dataclasses import dataclass, field
from typing import Callable

GROUPS = ("right", "coverage", "noise", "sequence", "description", "light", "surface", "geometry", "refinement", "cause",
          "double", "unlisted")
CASES = {}


@dataclass
class Case:
    name: str
    group: str
    planted: str  # in words, for the table
    plant: Callable  # (rig, twin, random numbers): changes the rig or the twin
    rig: dict = field(default_factory=dict)  # how Rig() is made
    # "explained": every quantity, and no warning. "not explained": at least one is not. "any": the verdict may be either.
    expect: str = "not explained"
    verdict: dict = field(default_factory=dict)  # of a quantity: the word that budget_verdict must have, as a pattern
    says: str = ""  # pattern that a warning, an error, a verdict or a named cause must match
    causes: str = ""  # names of causes that may be named; one of them must be, or it counts as NO-CAUSE
    each: str = ""  # of two errors: names that must all be among those named
    values: dict = field(default_factory=dict)  # planted values of parameters that rig and twin do not hold, by name
    unlisted: bool = False  # is it in no group of the program's? Then no cause, or a word for each pixel, is right, too
    gain: bool = True  # does the sensor still have one gain and black level?
    refine: str = ""  # what cosim --refine is asked for
    measure: bool = False  # must `fringetwin measure` say it, too, from the images alone?
    povray: bool = False  # are the images POV-Ray's?
    texture: str = ""  # in POV-Ray's words
    fast: bool = False  # is it one of CTest's e2e/trust?


def planted(group, what, rig=None, **expected):
    """Registers the function below it as what the case of its name plants."""
    def add(plant):
        CASES[plant.__name__] = Case(plant.__name__, group, what, plant, rig or {}, **expected)
        return plant
    return add


def add_case(name, group, what, plant, rig=None, **expected):
    CASES[name] = Case(name, group, what, plant, rig or {}, **expected)


def nothing(rig, twin, random):
    """Rig and twin stay alike."""


def all_cases():
    for module in ("compared", "described", "light", "geometry", "listed", "beyond"):
        importlib.import_module("cases_" + module)
    return {case.name: case for group in GROUPS for case in CASES.values() if case.group == group}
