#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Time of a whole measurement from Python over that from the command line, side by side in one run.

bench_python.py [--program build/fringetwin] [--package build/python] [--twin datasets/paper-sphere/twin.toml] [--runs 5]

Both do the same (`cosim`: render, measure, write; the same bits, tests/e2e/python_test.py), in turns; of each the best of
the runs counts. The call alone is what a notebook waits for; the whole process starts Python and numpy besides.
"""
import argparse
import os
import subprocess
import sys
import tempfile
import time

CALL = """
import sys, time
import fringetwin
start = time.perf_counter()
fringetwin.cosim(sys.argv[1], sys.argv[2])
print(time.perf_counter() - start)
"""


def seconds_of(command, environment=None):
    """Returns how long a command took, and what it printed."""
    start = time.perf_counter()
    done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode not in (0, 1):  # 1: limits not met
        sys.exit(f"{command[0]} ended with {done.returncode}: {done.stderr.strip()}")
    return time.perf_counter() - start, done.stdout


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default="build/fringetwin")
    parser.add_argument("--package", default="build/python")
    parser.add_argument("--twin", default="datasets/paper-sphere/twin.toml")
    parser.add_argument("--runs", type=int, default=5)
    options = parser.parse_args()
    program, calls, processes = [], [], []
    with tempfile.TemporaryDirectory() as out:
        for _ in range(options.runs):
            program.append(seconds_of([options.program, "-q", "cosim", options.twin, "--out", out + "/program"])[0])
            whole, printed = seconds_of([sys.executable, "-c", CALL, options.twin, out + "/python"],
                                        os.environ | {"PYTHONPATH": options.package})
            processes.append(whole)
            calls.append(float(printed))
    best = min(program)
    print(f"whole measurement of {options.twin}, best of {options.runs}: command line {best:.3f} s")
    print(f"  from Python, the call alone {min(calls):.3f} s: {100.0 * (min(calls) / best - 1.0):+.1f} %")
    print(f"  with the start of Python    {min(processes):.3f} s: {100.0 * (min(processes) / best - 1.0):+.1f} %")


if __name__ == "__main__":
    main()
