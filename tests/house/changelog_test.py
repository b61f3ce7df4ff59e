#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the form of CHANGELOG.md, which people append to at once and Git merges by union.

changelog_test.py ROOT         fails where the topmost section is not the project's version, where a heading or the bold name
                               of a list is not known or stands twice, where a bullet lies outside of a list, is too long or
                               stands twice, and where text of a group belongs to no bullet;
changelog_test.py --self-test  plants each of these faults and proves that it is seen.
"""
import re
import sys

GROUPS = ("What breaks", "Added", "Changed", "Mended")
LISTS = ("Files and keys", "Defaults and limits", "Exit codes", "Refused", "Rig files", "Rendering", "Capture",
         "Calibration and photometry", "Measuring", "Comparison and causes", "Refinement", "Studies", "Command line",
         "Pages and results", "Python and packages", "Files of others", "Speed", "Documentation", "Tests and house")
LONGEST = 600  # characters of a bullet: it is read at a glance
SECTION = re.compile(r"## (\d+\.\d+\.\d+) \((unreleased|\d{4}-\d\d-\d\d)\)")


def version_faults(lines, cmake):
    version = re.search(r"^project\(\w+ VERSION ([\d.]+)", cmake, re.MULTILINE)
    first = next((line for line in lines if line.startswith("## ")), "no section")
    section = SECTION.fullmatch(first)
    if not version or not section or section[1] != version[1]:
        yield f"the topmost section is \"{first}\", CMakeLists.txt has version {version and version[1]}"


def faults(text, cmake):
    lines = re.sub(r"<!--.*?-->", lambda m: "\n" * m[0].count("\n"), text, flags=re.DOTALL).split("\n")
    found = list(version_faults(lines, cmake))
    section = group = name = None
    bullet, seen = "", set()

    def fault(number, what):
        found.append(f"CHANGELOG.md:{number}: {what}")

    def once(number, what, *key):
        if (section, *key) in seen:
            fault(number, f"{what} stands twice")
        seen.add((section, *key))

    for number, line in enumerate([*lines, ""], 1):
        if bullet and not line.startswith("  "):
            if len(bullet) > LONGEST:
                fault(number - 1, f"a bullet of {len(bullet)} characters, {LONGEST} at most: {bullet[:60]}")
            once(number - 1, f"\"{bullet[:60]}\"", "bullet", bullet)
            bullet = ""
        if line.startswith("## "):
            section, group, name = line, None, None
            if not SECTION.fullmatch(line):
                fault(number, f"\"{line}\" is not \"## VERSION (unreleased)\" or \"## VERSION (YEAR-MONTH-DAY)\"")
            once(number, f"\"{line}\"", "section")
        elif line.startswith("##"):
            group, name = line.lstrip("# "), None
            if not line.startswith("### ") or group not in GROUPS:
                fault(number, f"\"{line}\" is none of {', '.join('### ' + g for g in GROUPS)}")
            once(number, f"\"{line}\"", "group", group)
        elif re.fullmatch(r"\*\*.*\*\*", line):
            name = line.strip("*")
            if name not in LISTS:
                fault(number, f"\"{name}\" is none of {', '.join(LISTS)}")
            once(number, f"\"{name}\" of {group}", "list", group, name)
        elif re.match(r" ?[-*+] ", line):
            bullet = line.strip()
            if not group or not name:
                fault(number, f"a bullet outside of the lists of a group: {line[:60]}")
        elif bullet:
            bullet += " " + line.strip()
        elif group and line.strip():
            fault(number, f"belongs to no bullet: {line[:60]}")
    return found


def text_of(path):
    with open(path, encoding="utf-8") as f:
        return f.read()


def self_test():
    cmake = "cmake_minimum_required(VERSION 3.25)\nproject(fringetwin VERSION 0.2.0 LANGUAGES CXX)\n"
    good = ("# Changelog\n\n<!-- a comment\n- of two lines -->\n\n## 0.2.0 (unreleased)\nWords.\n\n### Added\n\n**Speed**\n"
            f"- One.\n- {'x' * 400}\n  {'y' * 197}\n\n**Capture**\n- Two.\n\n### Mended\n\n**Speed**\n- Three.\n\n"
            "## 0.1.0 (2026-11-24)\n\n### Added\n\n**Speed**\n- One.\n")
    planted = {"## 0.2.0 (": "## 0.3.0 (", "(unreleased)": "unreleased", "2026-11-24": "soon", "### Mended": "### Fixed",
               "### Added": "#### Added", "### Mended\n\n": "### Added\n\n", "**Capture**": "**Cameras**",
               "\n**Capture**\n": "\n**Speed**\n", "Words.\n": "Words.\n- None.\n", "### Added\n\n**Speed**\n": "### Added\n\n",
               "yyy\n\n": "yyyy\n\n", "- Two.": "- One.", "- Three.": "Three.", "## 0.1.0 (2026-11-24)": "## 0.2.0 (unreleased)"}
    wrong = [f"a sound file: {fault}" for fault in faults(good, cmake)]
    wrong += [f"not in the file: {old!r}" for old in planted if old not in good]
    wrong += [f"not seen: {old!r} made {new!r}" for old, new in planted.items() if not faults(good.replace(old, new, 1), cmake)]
    return wrong


def main():
    if sys.argv[1] == "--self-test":
        found = self_test()
    else:
        found = faults(text_of(f"{sys.argv[1]}/CHANGELOG.md"), text_of(f"{sys.argv[1]}/CMakeLists.txt"))
    print("\n".join(found) or "CHANGELOG.md begins with the project's version, and every bullet lies in a list that is known")
    sys.exit(1 if found else 0)


main()
