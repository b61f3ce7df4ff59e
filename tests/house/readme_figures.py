#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that every figure README.md prints is asserted by a test at most 1.5 times looser than it is printed.

readme_figures.py ROOT         compares README.md, readme_figures.txt beside this file and the tests that it names;
readme_figures.py --self-test  plants faults in a scratch tree and proves that each is seen.
"""
import os
import re
import sys
import tempfile

LIST = "tests/house/readme_figures.txt"
LOOSEST = 1.5
NUMBER = r"\d+(?:,\d{3})*(?:\.\d+)?(?:e[+-]?\d+)?"
# A number with one of these units is a claim; so is "6 of 6".
CLAIM = re.compile(rf"(?<![\w.,]){NUMBER}(?:\s?(?:mm|µm|nm|%|DN|rad|px|σ|×|times|ms|s|°)(?!\w)| of \d+)")
FENCED = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
UNSAID = re.compile(r"`[^`\n]*`|\]\([^)\s]*\)")  # what is typed, and where a link leads, claims nothing
KEYS = (("figure", "held by", "line", "value"), ("exempt", "reason"))


def text_of(path):
    with open(path, encoding="utf-8") as f:
        return f.read()


def blanked(pattern, text):
    return pattern.sub(lambda m: " " * len(m[0]), text)


def records(text):
    """The blocks of the list between empty lines, as dictionaries; a line that begins with # is a comment."""
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    blocks = re.split(r"\n\s*\n", "\n".join(lines))
    return [dict(line.partition(": ")[::2] for line in block.strip().splitlines()) for block in blocks if block.strip()]


def number(text):
    """The number that a text begins with, per cent as a fraction; None where there is none."""
    found = re.match(rf"({NUMBER})(\s*%)?", text)
    return float(found[1].replace(",", "")) / (100.0 if found[2] else 1.0) if found else None


def half_a_digit(printed):
    """Half a unit of the last digit of the number that a text begins with."""
    digits, _, exponent = re.match(NUMBER, printed)[0].partition("e")
    return 0.5 * 10.0 ** (int(exponent or 0) - len(digits.partition(".")[2])) * (0.01 if "%" in printed else 1.0)


def body_of(text, test):
    """The text of a test or function, up to its closing brace at the margin; all of it without a name."""
    if test not in text:
        return ""
    return text[text.index(test):].split("\n}\n", 1)[0] if test else text


def figure_faults(root, figure):
    """What is wrong with one record of the list, but for README's own text."""
    source, _, test = figure["held by"].partition(", ")
    value = re.fullmatch(r"(.+) (<=|>=|=) (\S+)", figure["value"])
    if not value or number(value[1]) is None or number(value[3]) is None:
        return [f"\"{figure['value']}\" is not \"PRINTED <= ASSERTED\", \">=\" or \"=\""]
    if value[1] not in figure["figure"]:
        return [f"the figure does not hold its printed value {value[1]}"]
    if not os.path.isfile(os.path.join(root, source)):
        return [f"{source} does not exist"]
    text = text_of(os.path.join(root, source))
    lines = [line for line in body_of(text, test).splitlines() if figure["line"] in line]
    if not any(re.search(rf"(?<![\w.]){re.escape(value[3])}u?(?!\.?\w)", line) for line in lines):
        return [f"{figure['held by']}: no line \"{figure['line']}\" with {value[3]}"]
    printed, asserted = number(value[1]), number(value[3])
    commits = re.findall(r"commit ([0-9a-f]{7})", text) if source.startswith("docs/") else []
    if re.search(r"\d\s?m?s$", value[1]) and not any(commit in figure["figure"] for commit in commits):
        return [f"a time stands beside the commit of the page that measured it, which is not in {source}"]
    if value[2] == "=":
        loose = abs(asserted - printed) > half_a_digit(value[1])
    else:
        loose = asserted > LOOSEST * printed if value[2] == "<=" else asserted < printed / LOOSEST
    return [f"{value[1]} is printed, {value[3]} asserted"] if loose else []


def faults(root):
    readme = blanked(FENCED, text_of(os.path.join(root, "README.md")))
    said, found = blanked(UNSAID, readme), []
    accounted = [False] * len(readme)
    for record in records(text_of(os.path.join(root, LIST))):
        name = record.get("figure") or record.get("exempt")
        if tuple(record) not in KEYS or not all(record.values()):
            found.append(f"{LIST}: a record has \"{', '.join(record)}\": not figure, held by, line, value or exempt, reason")
            continue
        if name not in readme:
            found.append(f"README.md does not say \"{name}\"")
        part = record["value"].rsplit(" ", 2)[0] if "value" in record else name
        for at in re.finditer(re.escape(name), readme):
            first = at.start() + name.find(part)
            accounted[first:first + len(part)] = [True] * len(part)
        if "figure" in record:
            found += [f"\"{name}\": {fault}" for fault in figure_faults(root, record)]
    for claim in CLAIM.finditer(said):
        if not all(accounted[claim.start():claim.end()]):
            line = readme.count("\n", 0, claim.start()) + 1
            found.append(f"README.md:{line}: \"{claim[0]}\" is neither held by a test nor exempt in {LIST}")
    return found


def self_test():
    good = {
        "README.md": "# A\n```\n7 mm\n```\n| rms | 0.5 mm | 2 mm |\n`--to 3 mm`, 99 % of them, 6 of 6 in (at 0123abc) 1.0 s, 12 bit\n",
        LIST: "# comment\nfigure: rms | 0.5 mm\nheld by: t.cpp, Rms\nline: EXPECT_LE(rms\nvalue: 0.5 mm <= 0.7\n\n"
              "figure: 99 % of\nheld by: t.cpp\nline: EXPECT_GE(share\nvalue: 99 % >= 0.95\n\n"
              "figure: 6 of 6\nheld by: t.cpp, Rms\nline: size()\nvalue: 6 of 6 = 6\n\n"
              "figure: (at 0123abc) 1.0 s\nheld by: docs/PERFORMANCE.md\nline: default\nvalue: 1.0 s = 0.98\n\n"
              "exempt: | 2 mm |\nreason: another system's\n",
        "t.cpp": "TEST(A, Rms) {\n  EXPECT_LE(rms, 0.7);\n  EXPECT_EQ(size(), 6u);\n}\nTEST(A, B) {\n"
                 "  EXPECT_GE(share, 0.95);\n  EXPECT_LE(rms, 0.8);\n}\n",
        "docs/PERFORMANCE.md": "Measured at commit 0123abc.\n| default | 0.98 |\n"}
    planted = [("README.md", *change) for change in (
        ("rms | 0.5", "rms | 0.4"), ("| 2 mm |", "| 2 mm | 3 mm |"), ("12 bit", "12 px"), ("12 bit", "5 of 6"),
        ("12 bit", "1e-4 rad"), ("12 bit", "1.5 µm"), ("12 bit", "4 σ"), ("12 bit", "30× faster"), ("| 2 mm |", "| 3 |"))]
    planted += [(LIST, *change) for change in (
        ("0.5 mm <= 0.7", "0.5 mm <= 0.8"), ("t.cpp, Rms", "u.cpp, Rms"), ("line: EXPECT_LE(rms", "line: EXPECT_LE(max"),
        ("0.5 mm <= 0.7", "0.5 mm"), ("reason: another system's", "reason: "), ("6 of 6 = 6", "6 of 6 = 7"),
        ("0.5 mm <= 0.7", "0.6 mm <= 0.7"))]
    planted += [("t.cpp", "rms, 0.7", "rms, 0.76"), ("t.cpp", "rms, 0.7", "rms, 0.71"), ("t.cpp", "Rms", "Other"),
                ("t.cpp", "share, 0.95", "share, 0.6"), ("docs/PERFORMANCE.md", "0.98", "1.06"), ("docs/PERFORMANCE.md", "0123", "4567")]
    loose = [((LIST, "0.5 mm <= 0.7", "0.5 mm <= 0.8"), ("t.cpp", "rms, 0.7", "rms, 0.8")),
             ((LIST, ">= 0.95", ">= 0.6"), ("t.cpp", "share, 0.95", "share, 0.6")),
             ((LIST, "= 0.98", "= 1.06"), ("docs/PERFORMANCE.md", "0.98", "1.06")),
             ((LIST, "docs/PERFORMANCE.md\nline: default", "q.cpp\nline: default"), ("t.cpp", "", ""))]

    def run(changes):
        with tempfile.TemporaryDirectory() as root:
            for name, text in {**good, "q.cpp": "default 0.98\n"}.items():
                for file, old, new in changes:
                    text = text.replace(old, new, 1) if file == name else text
                os.makedirs(os.path.dirname(os.path.join(root, name)), exist_ok=True)
                with open(os.path.join(root, name), "w", encoding="utf-8") as f:
                    f.write(text)
            return faults(root)

    wrong = [f"a sound tree: {fault}" for fault in run([])]
    return wrong + [f"not seen: {changes}" for changes in [*([p] for p in planted), *loose] if not run(changes)]


def main():
    found = self_test() if sys.argv[1] == "--self-test" else faults(sys.argv[1])
    print("\n".join(found) or "every figure of README.md is held by a test")
    sys.exit(1 if found else 0)


main()
