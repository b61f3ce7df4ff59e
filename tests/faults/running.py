# SPDX-License-Identifier: Apache-2.0
"""Runs the program in a suite's scratch folder, and keeps what undisturbed runs of each command give."""
import dataclasses
import os
import random
import shutil
import subprocess
import sys
import time

import rig
import tree

LONGEST_S = 150
SLOW = ("cosim of captures", "needs", "pareto")  # seconds each


@dataclasses.dataclass
class Run:
    code: int
    out: str
    err: str
    seconds: float


def until(process, condition):
    """Waits for what a running process is to do, whatever else the machine does; no longer than it runs."""
    begin = time.monotonic()
    while not condition() and process.poll() is None and time.monotonic() - begin < LONGEST_S:
        time.sleep(0.01)


def sentences(run):
    return run.err.count("fringetwin: error: ")


class Suite:
    def __init__(self, program, faults, folder, seed, everything):
        self.program, self.faults, self.folder = program, faults, os.path.realpath(folder)
        shutil.rmtree(self.folder, ignore_errors=True)
        os.makedirs(self.folder)
        self.seed, self.random, self.found, self.cases = seed, random.Random(seed), [], 0
        self.rig = rig.Rig(program, os.path.join(self.folder, "rig"))
        self.commands = {name: c for name, c in self.rig.commands().items() if everything or name not in SLOW}
        self.references, self.seconds, self.printed, self.folders = {}, {}, {}, 0
        for command in self.commands.values():
            self.references[command.name] = tree.Reference(self.undisturbed(command))

    def undisturbed(self, command):
        out = self.fresh_folder()
        run = self.run(command, out, {})
        if run.code != 0:
            sys.exit(f"{command.name}: exit code {run.code} without any fault: {run.err}")
        self.seconds[command.name], self.printed[command.name] = run.seconds, run.out
        os.makedirs(out, exist_ok=True)  # by a command that only prints there is none
        found = tree.files(out)
        good = os.path.join(self.folder, "good", command.name)
        shutil.rmtree(good, ignore_errors=True)
        shutil.copytree(out, good)
        return found

    def fresh_folder(self):
        """Returns a name that is free, the same each time: results tell the command line."""
        out = os.path.join(self.folder, "out")
        shutil.rmtree(out, ignore_errors=True)
        return out

    def complete_folder(self, command):
        out = self.fresh_folder()
        shutil.copytree(os.path.join(self.folder, "good", command.name), out)
        return out

    def old_folder(self, command):
        """Results of another run: whole, but not what a new run writes, except where it would go on with them."""
        out = self.complete_folder(command)
        if command.name != "capture":
            for name in tree.files(out):
                if not name.endswith(".db"):
                    with open(os.path.join(out, name), "ab") as file:
                        file.write(b"\n")
        return out

    def start(self, line, environment=None, **more):
        with_ours = {**os.environ, **(environment or {})}
        return subprocess.Popen(line, env={k: v for k, v in with_ours.items() if v is not None}, stdin=subprocess.DEVNULL,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, errors="replace", **more)

    def finish(self, process, longest_s=LONGEST_S):
        begin = time.monotonic()
        try:
            out, err = process.communicate(timeout=longest_s)
        except subprocess.TimeoutExpired:
            process.kill()
            out, err = process.communicate()
            return Run(-1000, out, err, time.monotonic() - begin)
        return Run(process.returncode, out, err, time.monotonic() - begin)

    def run(self, command, out, environment, again=False, **more):
        return self.finish(self.start(command.line(self.program, out, again), environment, **more))

    def report(self, part, faults):
        """Takes the sentences about one case; None: it was none."""
        if faults is None:
            return
        self.cases += 1
        for fault in faults:
            print(f"FAULT {part}: {fault}", flush=True)
            self.found.append(fault)
