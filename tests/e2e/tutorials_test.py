#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The tutorials (docs/tutorials) are true: their commands run, and print what the pages show.

tutorials_test.py NAME --program build/fringetwin --source . --out DIR
  runs the blocks marked `sh` of the page NAME of docs/tutorials, in their order, by one shell in an empty folder below DIR, with
  the program in PATH, and holds what each prints (both streams) against the block marked `text` that follows it
tutorials_test.py --self-test   proves that each way in which a page can be wrong is seen
Exit code 77: the program finds no Vulkan device.

A shown line `...` stands for any lines, `...` within a line for any text; any other text must be the same, but for the width
of spaces.

| number            | tolerance                               | origin                                                        |
|-------------------|-----------------------------------------|---------------------------------------------------------------|
| with a point      | one unit of its last digit, and 0.1 %   | Seeds are fixed. Another driver's single precision changes    |
|                   |                                         | gray values that lie within 1e-5 of a step of rounding, some  |
|                   |                                         | in 10,000: fits move by hundredths of a standard error, and   |
|                   |                                         | shown are two digits of that at most. So digits tip over.     |
| without a point   | 0.1 %: below 1000 none                  | Counts of images and pitches are exact; those of pixels lose  |
|                   |                                         | or gain some at outlines, for the same reason.                |

Times, versions and places are no facts of a tutorial: pages leave them out.
"""
import argparse
import os
import pathlib
import re
import resource
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile

NUMBER = re.compile(r"(?<![\w.])[-+−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
FENCE = re.compile(r"^( *)```(.*)$")
RELATIVE = 1e-3
MARK = "tutorial block {} ends"  # printed by the shell on a stream of its own


class Block:
    def __init__(self, kind, line):
        self.kind, self.line, self.lines, self.shown = kind, line, [], None


def blocks_of(text):
    """The blocks of a page that are run, each with the one that shows what it prints; and what is wrong with the others."""
    blocks, faults, block, after = [], [], None, None
    for number, line in enumerate(text.split("\n"), 1):
        fence = FENCE.match(line)
        if block is None and fence:
            block = Block(fence[2].strip(), number)
            if fence[1]:
                faults.append(f"line {number}: an indented block is not run")
        elif block and fence:
            if block.kind == "sh":
                blocks.append(block)
                after = block
            elif block.kind == "text" and after:
                after.shown, after = block.lines, None
            elif block.kind == "text":
                faults.append(f"line {block.line}: shows the output of nothing")
            elif block.kind != "toml" or any(shown.startswith("fringetwin ") for shown in block.lines):
                faults.append(f"line {block.line}: a block marked \"{block.kind}\" is neither run (sh), output (text) nor a file (toml)")
            block = None
        elif block:
            block.lines.append(line)
    if block:
        faults.append(f"line {block.line}: the block does not end")
    return blocks, faults


def same_number(shown, printed):
    shown, printed = shown.replace("−", "-"), printed.replace("−", "-")
    mantissa, _, exponent = shown.partition("e")
    digits = len(mantissa.partition(".")[2])
    unit = 10.0 ** (int(exponent or 0) - digits) if digits or exponent else 0.0
    rounding = 1e-9 * max(abs(float(shown)), unit)  # of this comparison itself
    return abs(float(shown) - float(printed)) <= max(unit, RELATIVE * abs(float(shown))) + rounding


def same_text(shown, printed):
    """Is a piece without `...` the same, numbers within their tolerance?"""
    texts, printed_texts = NUMBER.split(shown), NUMBER.split(printed)
    return texts == printed_texts and all(map(same_number, NUMBER.findall(shown), NUMBER.findall(printed)))


def same_line(shown, printed):
    shown, printed = " ".join(shown.split()), " ".join(printed.split())
    if "..." not in shown:
        return same_text(shown, printed)
    first, rest = shown.split("...", 1)
    for end in [m.end() for m in re.finditer(r"^|.", printed)]:
        if same_text(first, printed[:end]):
            return not rest or any(same_line(rest, printed[start:]) for start in range(end, len(printed) + 1))
    return False


def unlike(shown, printed):
    """The first shown line that is not printed where it should be, or None."""
    parts, part = [], []
    for line in [*shown, "..."]:
        if line.strip() == "...":
            parts.append(part)
            part = []
        else:
            part.append(line)
    at, anywhere = 0, False
    if shown and shown[-1].strip() != "...":  # the last part must stand at the end
        parts.append(None)
    for k, lines in enumerate(parts):
        if lines is None:
            break
        last = k + 2 == len(parts) and parts[-1] is None
        starts = range(at, len(printed) - len(lines) + 1) if anywhere else [at]
        if last:
            starts = [start for start in starts if start + len(lines) == len(printed)]
        matched = [[same_line(line, text) for line, text in zip(lines, printed[start:])] for start in starts]
        whole = [start for start, same in zip(starts, matched) if len(same) == len(lines) and all(same)]
        if not whole:
            best = max(matched, key=sum, default=[])
            return next((line for line, same in zip(lines, [*best, False]) if not same), lines[-1])
        at, anywhere = whole[0] + len(lines), True
    return None


def script_of(blocks, folder):
    lines = ["set -e -o pipefail"]
    for k, block in enumerate(blocks):
        lines += ["{", *block.lines, "} >" + shlex.quote(str(folder / f"{k}.txt")) + " 2>&1", f"echo '{MARK.format(k)}' >&3"]
    return "\n".join(lines) + "\n"


def run_page(out, work, path, seconds):
    """Runs the shell of a page; returns what is wrong with it as a whole. What it has started ends with it."""
    with open(out / "ended", "w", encoding="utf-8") as ended:
        shell = subprocess.Popen(["stdbuf", "-oL", "bash", "-c", f"exec 3>&{ended.fileno()}; . {shlex.quote(str(out / 'page.sh'))}"], cwd=work,
                                 pass_fds=(ended.fileno(),), stdin=subprocess.DEVNULL, start_new_session=True,
                                 env=os.environ | {"PATH": f"{path}:{os.environ['PATH']}", "LC_ALL": "C.UTF-8"})
        try:
            shell.wait(seconds)
        except subprocess.TimeoutExpired:
            os.killpg(shell.pid, signal.SIGKILL)
            shell.wait()
            return [f"the page did not end within {seconds} s"]
    return []


def check(text, out, program=None, seconds=280):
    """What is wrong with a page, and what its blocks have printed."""
    blocks, faults = blocks_of(text)
    if not blocks:
        faults.append("the page runs nothing")
    shutil.rmtree(out, ignore_errors=True)
    work, printed, path = out / "work", out / "printed", out / "bin"
    for folder in (work, printed, path):
        folder.mkdir(parents=True)
    if program:
        (path / "fringetwin").symlink_to(program)
    (out / "page.sh").write_text(script_of(blocks, printed), encoding="utf-8")
    if late := run_page(out, work, path, seconds):
        return faults + late
    done = (out / "ended").read_text(encoding="utf-8").split("\n")
    for k, block in enumerate(blocks):
        file = printed / f"{k}.txt"
        lines = file.read_text(encoding="utf-8").rstrip("\n").split("\n") if file.is_file() else []
        if MARK.format(k) not in done:
            faults.append(f"line {block.line}: the block " + ("fails:\n" + "\n".join(lines) if file.is_file() else "was not run"))
            if file.is_file():
                continue
        elif block.shown is not None and (wrong := unlike(block.shown, lines)) is not None:
            faults.append(f"line {block.line}: shown is\n  {wrong}\nand printed was\n  " + "\n  ".join(lines))
    return faults


def self_test():
    page = ("# Page\n```sh\necho 'radius 27.0012 mm, 1 of 13 %'\necho 1234567 points\necho took 3 s\n```\nIt says\n```text\n"
            "radius 27.0012 mm, 1 of 13 %\n1234567 points\n...\n```\n```sh\nname=ball\n```\n```toml\nkey = 1\n```\n"
            "```sh\nprintf 'a\\nb 1e-4\\n%s  is here\\n' $name\n```\n```text\n...\nb 1e-4\nball is ...\n```\n")
    shown = page.index("```text")

    def instead(old, new):
        return page[:shown] + page[shown:].replace(old, new, 1)

    right = {"as it is": page, "a last digit tipped over": instead("27.0012", "27.0013"), "a point more": instead("1234567", "1234568")}
    planted = {"a number": instead("27.0012", "27.0302"), "a small count": instead("13", "14"), "a power": instead("b 1e-4", "b 3e-4"),
               "a sign": instead("27.0012", "-27.0012"), "a word": instead("ball is", "bell is"),
               "a line too much": instead("ball is ...", "ball is ...\nand more"), "a line too few": instead("points\n...\n", "points\n"),
               "a first line too few": instead("radius 27.0012 mm, 1 of 13 %\n", ""),
               "a command that fails": instead("name=ball", "false"),
               "a command that fails in a pipe": instead("name=ball", "false | cat"),
               "a program that is not there": instead("name=ball", "no_such_program"),
               "a block behind the end": instead("name=ball", "exit 0"),
               "a block of another mark": instead("```sh\nname", "```bash\nname"),
               "an indented block": page + "1. so\n   ```sh\n   true\n   ```\n",
               "a command without a mark": page + "```\nfringetwin info\n```\n",
               "output of nothing": page + "```text\nno\n```\n", "nothing to run": "# Page\n"}
    with tempfile.TemporaryDirectory() as scratch:
        out = pathlib.Path(scratch) / "it's $out"
        late = check(instead("name=ball", "sleep 60"), out, seconds=2)
        return ([f"a page that does not end: {late}" for _ in range(late != ["the page did not end within 2 s"])] +
                [f"refused: {name}: {found}" for name, text in right.items() if (found := check(text, out))] +
                [f"not seen: {name}" for name, text in planted.items() if not check(text, out)])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("name", nargs="?")
    parser.add_argument("--self-test", action="store_true")
    parser.add_argument("--program", type=pathlib.Path)
    parser.add_argument("--source", type=pathlib.Path)
    parser.add_argument("--out", type=pathlib.Path)
    chosen = parser.parse_args()
    if chosen.self_test:
        found = self_test()
    else:
        program = chosen.program.resolve()
        info = subprocess.run([program, "info"], capture_output=True, text=True, check=False)
        if info.returncode:
            sys.exit(f"fringetwin info ends with exit code {info.returncode}: {info.stderr}")
        if re.search(r"Vulkan device +none", info.stdout) and not os.environ.get("FRINGETWIN_REQUIRE_DEVICE"):
            print("skipped: the program finds no Vulkan device")
            sys.exit(77)
        text = (chosen.source / "docs/tutorials" / f"{chosen.name}.md").read_text(encoding="utf-8")
        found = check(text, chosen.out.resolve(), program)
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        print(f"{used.ru_utime + used.ru_stime:.1f} s of computing")
    print("\n".join(found) or "as shown")
    sys.exit(1 if found else 0)


main()
