#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the structure of the house that rooms.txt beside this file describes.

include_direction.py ROOT         fails where an include of ours runs against rooms.txt, where files or sub-rooms
                                  include each other in a circle, where a folder is not listed or is too full;
include_direction.py --self-test  plants each of these faults in a scratch tree and proves that it is seen.
"""
import os
import re
import sys
import tempfile

MOST_FILES = 40  # directly in one folder, tests included: a stranger still overlooks such a list
MOST_FILES_IN = {"study": 25}
SOURCE = re.compile(r"\.(cpp|hpp|h|comp|glsl)$")
INCLUDE = re.compile(r'^\s*#\s*include\s*["<]([^">]+)[">]', re.MULTILINE)


class Rooms:
    """What rooms.txt says: which rooms a room may include, which places of its own room a place may include."""

    def __init__(self, text):
        self.rooms = {}  # room -> rooms
        self.places = {}  # "room/sub" or "room/." -> set of "room/sub"
        self.faults = []
        for number, line in enumerate(text.splitlines(), 1):
            line = line.split("#")[0].strip()
            if not line:
                continue
            if "->" not in line:
                self.faults.append(f"rooms.txt:{number}: no '->' in \"{line}\"")
                continue
            place, targets = (part.strip() for part in line.split("->"))
            known = self.places if "/" in place else self.rooms
            room = place.split("/")[0]
            if "/" in place and room not in self.rooms:
                self.faults.append(f"rooms.txt:{number}: {place} stands before its room")
            full = [f"{room}/{t}" if "/" in place else t for t in targets.split()]
            for target in full:
                if target not in known:
                    self.faults.append(f"rooms.txt:{number}: {place} names {target}, which no line above describes")
            known[place] = set(full)

    def place_of(self, path):
        """The place of a file, "room/sub" or "room/."; None for a file that is in no room."""
        parts = path.split("/")
        if len(parts) < 2 or parts[0] not in self.rooms:
            return None
        return f"{parts[0]}/{parts[1]}" if len(parts) > 2 else f"{parts[0]}/."

    def line_of(self, place):
        """The name by which rooms.txt describes a place, which may be "room/*"; None where it does not."""
        others = place.split("/")[0] + "/*"
        if place in self.places or place.endswith("/.") or others not in self.places:
            return place if place in self.places else None
        return others

    def allows(self, source, target):
        """May a file of the place `source` include one of the place `target`?"""
        room, other = source.split("/")[0], target.split("/")[0]
        if room != other:
            return other in self.rooms[room]
        return target == source or self.line_of(target) in self.places.get(self.line_of(source), ())


def own_files(root, rooms):
    """Paths from the root of all sources in the rooms, sorted."""
    found = []
    for room in rooms.rooms:
        for folder, _, names in os.walk(os.path.join(root, room)):
            found += [os.path.relpath(os.path.join(folder, name), root) for name in names if SOURCE.search(name)]
    return sorted(found)


def resolve(root, source, included, rooms):
    """Path from the root of an include of ours, however it is written; None for a foreign header."""
    parts = [part for part in included.split("/") if part != "."]
    while parts and parts[0] == "..":  # what is behind the dots decides, wherever they lead
        parts.pop(0)
    if len(parts) >= 2 and parts[0] in rooms.rooms:
        return "/".join(parts)
    beside = os.path.normpath(os.path.join(os.path.dirname(source), included))
    return beside if included.startswith(".") or os.path.exists(os.path.join(root, beside)) else None


def is_test(path):
    return path.endswith("_test.cpp")


def circles(graph):
    """Strongly connected groups of more than one node (Tarjan's algorithm, without recursion)."""
    index, low, on_stack, stack, groups = {}, {}, set(), [], []
    for start in sorted(graph):
        if start in index:
            continue
        index[start] = low[start] = len(index)
        stack.append(start)
        on_stack.add(start)
        work = [(start, iter(sorted(graph.get(start, ()))))]
        while work:
            node, targets = work[-1]
            for target in targets:
                if target not in index:
                    index[target] = low[target] = len(index)
                    stack.append(target)
                    on_stack.add(target)
                    work.append((target, iter(sorted(graph.get(target, ())))))
                    break
                if target in on_stack:
                    low[node] = min(low[node], index[target])
            else:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[node])
                if low[node] == index[node]:
                    group = []
                    while not group or group[-1] != node:
                        group.append(stack.pop())
                        on_stack.discard(group[-1])
                    if len(group) > 1:
                        groups.append(sorted(group))
    return groups


def check(root, rooms):
    """All faults, a sentence each."""
    faults = list(rooms.faults)
    files = own_files(root, rooms)
    if not files:
        return [f"no source file of ours under {root}"]
    full = {}
    file_graph, place_graph = {}, {}
    for path in files:
        place = rooms.place_of(path)
        full[place] = full.get(place, 0) + 1
        if rooms.line_of(place) is None:
            faults.append(f"unlisted folder: {path} is in {place}, which rooms.txt does not describe")
            continue
        with open(os.path.join(root, path), encoding="utf-8", errors="replace") as source:
            included = INCLUDE.findall(source.read())
        for name in included:
            target = resolve(root, path, name, rooms)
            if target is None or rooms.place_of(target) is None:
                continue
            target_place = rooms.place_of(target)
            # A test may use what stands above its subject in the same room: it is no part of the house's statics.
            upward = not rooms.allows(place, target_place)
            if upward and is_test(path) and target_place.split("/")[0] == place.split("/")[0]:
                continue
            if upward:
                faults.append(f"upward include: {path} includes {target}")
            if is_test(path):
                continue
            stem, target_stem = os.path.splitext(path)[0], os.path.splitext(target)[0]
            if stem != target_stem:
                file_graph.setdefault(stem, set()).add(target_stem)
            if place != target_place:
                place_graph.setdefault(place, set()).add(target_place)
    for place, n in sorted(full.items()):
        most = MOST_FILES_IN.get(place.split("/")[0], MOST_FILES)
        if n > most:
            faults.append(f"too full: {n} files directly in {place}, more than {most}")
    for group in circles(file_graph):
        faults.append("circle of files: " + ", ".join(group))
    for group in circles(place_graph):
        faults.append("circle of places: " + ", ".join(group))
    return faults


def write(root, path, text):
    os.makedirs(os.path.dirname(os.path.join(root, path)), exist_ok=True)
    with open(os.path.join(root, path), "w", encoding="utf-8") as file:
        file.write(text)


SELF_TEST_ROOMS = """
twin ->
twin/base ->
twin/. -> base
twin/file -> base .
render -> twin
render/base ->
render/* -> base
render/. -> base *
"""

# What is planted (path -> text), and how the sentence about it begins.
PLANTED = [
    ({"twin/base/bad.hpp": line + "\n"}, "upward include: twin/base/bad.hpp includes render/renderer.hpp")
    for line in (
        '#include "render/renderer.hpp"', "#include <render/renderer.hpp>", '# include "render/renderer.hpp"',
        "  #  include  <render/renderer.hpp>", '#include "../../render/renderer.hpp"',
        '#include "./../../render/renderer.hpp"', '#include"render/renderer.hpp"')
] + [
    ({"twin/base/bad.hpp": '#include "twin/file/twin_file.hpp"\n'}, "upward include: twin/base/bad.hpp"),
    ({"twin/base/bad.hpp": '#include "../file/twin_file.hpp"\n'}, "upward include: twin/base/bad.hpp"),
    ({"twin/base/bad_test.cpp": '#include "render/renderer.hpp"\n'}, "upward include: twin/base/bad_test.cpp"),
    ({"twin/attic/bad.hpp": "\n"}, "unlisted folder: twin/attic/bad.hpp"),
    ({"render/base/bad.hpp": '#include "render/mist/mist.hpp"\n'}, "upward include: render/base/bad.hpp"),
    ({"render/snow/bad.hpp": '#include "render/mist/mist.hpp"\n'}, "upward include: render/snow/bad.hpp"),
    ({"twin/base/one.hpp": '#include "twin/base/two.hpp"\n', "twin/base/two.hpp": '#include "twin/base/one.hpp"\n'},
     "circle of files: twin/base/one, twin/base/two"),
    # a header and its source are one: the circle runs through the source of one
    ({"twin/base/one.cpp": '#include "twin/base/two.hpp"\n', "twin/base/two.hpp": '#include "twin/base/one.hpp"\n'},
     "circle of files: twin/base/one, twin/base/two"),
    ({"twin/base/bad.hpp": '#include "twin/twin.hpp"\n', "twin/twin.hpp": '#include "twin/base/errors.hpp"\n'},
     "circle of places: twin/., twin/base"),
    ({f"twin/base/f{i}.hpp": "\n" for i in range(MOST_FILES + 1)}, "too full: "),
]


def self_test():
    """Every planted fault must be seen, each alone; a tree without any must pass, one without sources must not."""
    clean = {
        "twin/base/errors.hpp": "#include <vector>\n// see \"render/renderer.hpp\"\n",
        "twin/twin.hpp": '#include "twin/base/errors.hpp"\n',
        "twin/base/errors_test.cpp": '#include "twin/twin.hpp"\n',
        "twin/file/twin_file.hpp": '#include "twin/twin.hpp"\n#include <opencv2/core.hpp>\n',
        "render/base/base.hpp": "",
        "render/mist/mist.hpp": '#include "render/base/base.hpp"\n',
        "render/renderer.hpp": '#include "twin/file/twin_file.hpp"\n#include "render/mist/mist.hpp"\n',
    }
    rooms = Rooms(SELF_TEST_ROOMS)
    for planted, sentence in [({}, None)] + PLANTED:
        with tempfile.TemporaryDirectory() as root:
            for path, text in {**clean, **planted}.items():
                write(root, path, text)
            faults = check(root, rooms)
            if sentence is None and faults:
                return f"refuses a tree without a fault: {faults}"
            if sentence is not None and not any(fault.startswith(sentence) for fault in faults):
                return f"does not see {planted}: {faults}"
    with tempfile.TemporaryDirectory() as root:
        if not check(root, rooms):
            return "passes a tree without sources"
    for text in ("twin ->\ntwin/base -> file\ntwin/file ->\n", "twin -> render\nrender ->\n", "twin\n", "twin/base ->\n"):
        if not Rooms(text).faults:
            return f"accepts this list of rooms: {text!r}"
    print(f"include_direction: sees all {len(PLANTED)} planted faults")
    return None


def main():
    if sys.argv[1:] == ["--self-test"]:
        fault = self_test()
        if fault:
            sys.exit(f"include_direction: {fault}")
        return
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "rooms.txt"), encoding="utf-8") as file:
        rooms = Rooms(file.read())
    faults = check(sys.argv[1], rooms)
    for fault in faults:
        print(fault)
    if faults:
        sys.exit(f"include_direction: {len(faults)} faults")
    print("all includes run as rooms.txt says, without a circle")


if __name__ == "__main__":
    main()
