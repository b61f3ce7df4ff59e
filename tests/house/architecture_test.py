#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that docs/ARCHITECTURE.md describes the places of tests/house/rooms.txt, all of them and no other.

architecture_test.py ROOT         compares the two files
architecture_test.py --self-test  proves that a place that is missing, or one too many, is seen
"""
import re
import sys


def places_of_rooms(text):
    """ "ROOM/SUB/" of every line of rooms.txt, "ROOM/" for a room's own folder."""
    names = re.findall(r"^(\w+/\S+)\s*->", text, re.MULTILINE)
    return {name.removesuffix(".") if name.endswith("/.") else name + "/" for name in names}


def places_of_page(text):
    """The first cell of each row of the table under "Rooms"; each says something in its last cell."""
    section = text.split("\n## Rooms\n", 1)[-1].split("\n## ", 1)[0]
    return set(re.findall(r"^\| `([\w/*]+/)` \|.*\w.*\|$", section, re.MULTILINE))


def faults(rooms, page):
    listed, described = places_of_rooms(rooms), places_of_page(page)
    return ([f"docs/ARCHITECTURE.md, \"Rooms\", has no row for {name}" for name in sorted(listed - described)] +
            [f"docs/ARCHITECTURE.md describes {name}, which rooms.txt lacks" for name in sorted(described - listed)])


def self_test():
    rooms = "# a -> comment\ntwin ->\ntwin/base ->\ntwin/. -> base\ntwin/* -> .\n"
    page = ("\n## Rooms\n| `twin/base/` | the ground |\n| `twin/` | the whole |\n| `twin/*/` | the rest |\n"
            "\n## Next\n| `x/y/` | z |\n")
    wrong = [f"a sound page: {fault}" for fault in faults(rooms, page)]
    for text in (page.replace("base", "mesh"), page.replace("the ground", ""), page.replace("*", "rest"),
                 page.replace("\n\n## Next", "")):
        if not faults(rooms, text):
            wrong.append(f"not seen: {text}")
    return wrong


def text_of(path):
    with open(path, encoding="utf-8") as f:
        return f.read()


def main():
    if sys.argv[1] == "--self-test":
        found = self_test()
    else:
        found = faults(text_of(f"{sys.argv[1]}/tests/house/rooms.txt"), text_of(f"{sys.argv[1]}/docs/ARCHITECTURE.md"))
    print("\n".join(found) or "docs/ARCHITECTURE.md has every place of rooms.txt and no other")
    sys.exit(1 if found else 0)


main()
