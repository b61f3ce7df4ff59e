#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Man pages and completions, against what --help says and what the sources define.

manual_test.py CHECK --program build/fringetwin --source .      CHECK: help, man, bash, zsh, fish

Every command of the program, and every option of it, is in its manual page, which groff formats without a warning, and
is what each shell offers, asked as it asks itself. Help groups options by what they are for, and says what a number is
where none is given. Exit code 77: the shell or the formatter is not installed.
"""
import argparse
import os
import pathlib
import pty
import re
import select
import shutil
import subprocess
import sys
import tempfile
import time

OPTION = re.compile(r"^  (-[^ ].*?)(?:  |$)", re.MULTILINE)
# Names of values that are numbers.
NUMBERS = {"N", "K", "MS", "MM", "M", "RAD", "DN", "PX", "S", "HZ", "BITS", "RATIO", "SHARE", "FACTOR", "SIGMAS", "SIZE"}
# Processes that the program starts of itself.
HIDDEN = {"study-worker", "study-shard"}


def run(command, **options):
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False, **options)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}: exit code {done.returncode}\n{done.stderr}")
    return done.stdout


class Program:
    """The program as its help pages describe it."""

    def __init__(self, program):
        self.program = program
        self.pages = {}
        self.read_below(())

    def read_below(self, path):
        text = run([self.program, *path, "--help"])
        section = re.search(r"\nCommands:\n(.*?)\n\n", text, re.DOTALL)
        commands = set(re.findall(r"^  ([\w-]+)", section[1], re.MULTILINE)) if section else set()
        options = {word.strip(",") for names in OPTION.findall(text) for word in names.split() if word.startswith("-")}
        self.pages[path] = (commands, options)
        for command in commands:
            self.read_below((*path, command))


def source_words(source):
    """Commands and options that the sources add, but for hidden commands."""
    words = set()
    for file in pathlib.Path(source, "cli").glob("*.cpp"):
        text = file.read_text(encoding="utf-8")
        words |= set(re.findall(r'add_subcommand\(\s*"([\w-]+)"', text)) - HIDDEN
        for names in re.findall(r'add_(?:option|flag|twin_option)\((?:\*?sub, )?\s*"([^"]+)"', text):
            words |= {name for name in names.split(",") if name.startswith("-")}
    return words


def help_entries(page):
    """Of a help page: for each option its section, its names, its value and its sentence."""
    for section, body in re.findall(r"^(\w[^\n]*):\n((?:  [^\n]*\n)+)", page, re.MULTILINE):
        for entry in re.findall(r"^  -[^\n]*\n(?:   +[^\n]*\n)*", body, re.MULTILINE):
            head = re.match(r"  (.*?)(?:  |\n)", entry)[1]
            names = [word.strip(",") for word in head.split() if word.startswith("-")]
            value = head.split()[-1].rstrip(".")
            yield section, names, "" if value in names else value, " ".join(entry[len(head) + 2:].split())


def check_help(program, _scratch):
    wrong, seen = [], 0
    for path, (_, options) in program.pages.items():
        page = run([program.program, "help", *path])
        entries = list(help_entries(page))
        listed = {name for _, names, _, _ in entries for name in names}
        wrong += [f"{' '.join(path)} {option}: not understood on the page" for option in sorted(options - listed)]
        for section, names, value, sentence in entries:
            what = f"{' '.join(path)} {names[-1]}"
            seen += value in NUMBERS
            if section.lower() == "options":
                wrong.append(f"{what}: in no group that says what it is for")
            if value in NUMBERS and not re.search(r"\brequired\b|default: \S", sentence):
                wrong.append(f"{what} {value}: says no default")
    return wrong if seen > 50 else [f"only {seen} options with numbers were found"]


def check_man(program, _scratch):
    listed = dict(line.partition(" ")[::2] for line in run([program.program, "man", "--list"]).splitlines())
    wrong = []
    if sorted(tuple(path.split()) for path in listed.values()) != sorted(program.pages):
        wrong.append(f"man --list names {sorted(listed)}")
    for file, words in listed.items():
        commands, options = program.pages[tuple(words.split())]
        page = run([program.program, "man", *words.split()])
        groff = subprocess.run(["groff", "-man", "-ww", "-Kutf8", "-Tascii", "-P-cbou", "-rHY=0"], input=page, text=True,
                               capture_output=True, timeout=60, check=False)
        if groff.returncode != 0 or groff.stderr:
            wrong.append(f"{file}: groff says {groff.stderr.strip()}")
        shown = set(re.findall(r"[\w-]+", groff.stdout))
        wrong += [f"{file} lacks {word}" for word in sorted((commands | options) - shown)]
        if not re.search(rf"^NAME\n\s+{file.removesuffix('.1')}\s+-\s+\S", groff.stdout, re.MULTILINE):
            wrong.append(f"{file}: no line of its name for apropos")
    return wrong


def bash_offer(program, scratch):
    script = pathlib.Path(scratch, "completion.bash")
    script.write_text(run([program.program, "completions", "bash"]), encoding="utf-8")
    run(["bash", "-n", str(script)])

    def offer(words):
        code = ('source "$0"; COMP_WORDS=(fringetwin "$@"); COMP_CWORD=$#; '
                '_fringetwin fringetwin "${COMP_WORDS[COMP_CWORD]}" ""; printf "%s\\n" "${COMPREPLY[@]}"')
        return set(run(["bash", "-c", code, str(script), *words], cwd=scratch).split())
    return offer


def fish_offer(program, scratch):
    script = pathlib.Path(scratch, "completion.fish")
    script.write_text(run([program.program, "completions", "fish"]), encoding="utf-8")

    def offer(words):
        code = f"source {script}; complete -C 'fringetwin {' '.join(words)}'"
        lines = run(["fish", "--no-config", "-c", code], cwd=scratch, env={**os.environ, "HOME": scratch}).splitlines()
        return {line.partition("\t")[0] for line in lines}
    return offer


class Zsh:
    """A shell in a terminal, asked by Ctrl-D for what it would complete."""

    def __init__(self, program, scratch):
        pathlib.Path(scratch, "_fringetwin").write_text(run([program.program, "completions", "zsh"]), encoding="utf-8")
        process, self.terminal = pty.fork()
        if process == 0:
            os.chdir(scratch)
            os.execvpe("zsh", ["zsh", "-f", "-i"], {**os.environ, "TERM": "dumb", "HOME": scratch, "PS1": ""})
        # a line must be done before the next is typed, as typing ahead is echoed by the terminal
        for number, line in enumerate((
                "stty cols 300 rows 200", "unsetopt zle_bracketed_paste prompt_sp; LISTMAX=1000; fpath=($PWD $fpath)",
                "autoload -Uz compinit; compinit -u -D", "zstyle ':completion:*' verbose no")):
            self.do(line, number)

    def do(self, line, number, most_s=60):
        """Types a line and waits until the shell has done it: it then prints what no echo of the line holds."""
        os.write(self.terminal, f"{line}; print done-$((100 + {number}))\n".encode())
        text, end = "", time.monotonic() + most_s
        while f"done-{100 + number}" not in text:
            if not select.select([self.terminal], [], [], max(0.0, end - time.monotonic()))[0]:
                sys.exit(f"zsh did not do this within {most_s} s: {line}\n{text}")
            text += os.read(self.terminal, 65536).decode(errors="replace")
        while select.select([self.terminal], [], [], 0.3)[0]:  # the prompt
            os.read(self.terminal, 65536)

    def answer(self, keys, silence_s=0.7):
        """What the shell writes until it is silent for so long."""
        os.write(self.terminal, keys.encode())
        text, end = "", time.monotonic() + 30
        while time.monotonic() < end and select.select([self.terminal], [], [], silence_s if text else 10)[0]:
            text += os.read(self.terminal, 65536).decode(errors="replace")
        return text

    def __call__(self, words):
        typed = "fringetwin " + " ".join(words)
        for silence_s in (0.7, 3, 10):  # on a busy machine the shell loads what it completes with for longer
            text = self.answer(typed + "\x04", silence_s)
            self.answer("\x15", silence_s)
            offered = {word for line in text.replace("\r", "\n").split("\n") if not line.startswith(typed.split(" -")[0])
                       for word in line.split()}
            if offered:
                break
        return offered


def check_offers(program, offer, scratch):
    """What is offered is what there is, no less and no more."""
    wrong = []

    def expect(words, wanted):
        found = offer(words)
        if found != wanted:
            wrong.append(f"fringetwin {' '.join(words)}: offered {sorted(found)}, there are {sorted(wanted)}")
    for path, (commands, options) in program.pages.items():
        long_options = {option for option in options if option.startswith("--")}
        expect([*path, "--"], long_options)
        if commands:
            expect([*path, ""], commands)
    expect(["cosim", "--steps", ""], {"even", "odd"})
    expect(["import", "opencv", "--unit", ""], {"mm", "m"})
    expect(["completions", ""], {"bash", "zsh", "fish"})
    expect(["help", "photo"], {"photometry"})
    expect(["photo"], {"photometry"})
    pathlib.Path(scratch, "rig").mkdir()
    pathlib.Path(scratch, "rig", "real").mkdir()
    pathlib.Path(scratch, "rig", "rig.toml").touch()
    return wrong


def check_bash(program, scratch):
    offer = bash_offer(program, scratch)
    wrong = check_offers(program, offer, scratch)
    for words, wanted in ((["render", "rig/"], {"rig/rig.toml", "rig/real"}), (["render", "--out", "rig/"], {"rig/real"}),
                          (["render", "--out", "=", "rig/"], {"rig/real"}), (["-q", "render", "rig/ri"], {"rig/rig.toml"})):
        if offer(words) != wanted:
            wrong.append(f"fringetwin {' '.join(words)}: offered {offer(words)}, wanted {wanted}")
    return wrong


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("check", choices=["help", "man", "bash", "zsh", "fish"])
    parser.add_argument("--program", required=True)
    parser.add_argument("--source", required=True)
    chosen = parser.parse_args()
    tool = {"man": "groff", "help": "sh"}.get(chosen.check, chosen.check)
    if not shutil.which(tool):
        print(f"skipped: {tool} is not installed")
        sys.exit(77)
    program = Program(chosen.program)
    known = {word for path, (commands, options) in program.pages.items() for word in commands | options}
    wrong = [f"--help lacks {word}, which the sources add" for word in sorted(source_words(chosen.source) - known)]
    with tempfile.TemporaryDirectory() as scratch:
        if chosen.check == "help":
            wrong += check_help(program, scratch)
        elif chosen.check == "man":
            wrong += check_man(program, scratch)
        elif chosen.check == "bash":
            wrong += check_bash(program, scratch)
        else:
            offer = Zsh(program, scratch) if chosen.check == "zsh" else fish_offer(program, scratch)
            wrong += check_offers(program, offer, scratch)
    print("\n".join(wrong) or f"{chosen.check}: {len(program.pages)} commands with "
          f"{sum(len(options) for _, options in program.pages.values())} options")
    sys.exit(1 if wrong else 0)


main()
