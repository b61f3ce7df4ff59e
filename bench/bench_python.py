#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Time of a whole measurement from Python over that from the command line, side by side in one run.

bench_python.py [--program build/fringetwin] [--package build/python] [--twin datasets/paper-sphere/twin.toml] [--runs 9]
                [--most PERCENT]

Both do the same (`cosim`: render, measure, write; the same bits, tests/e2e/python_full_test.py), in turns, each into a
folder of its own; of each the median of the runs counts. Compared is the call in a Python that runs already, which is
what a notebook waits for, with the program's whole run, its start included. The whole process starts Python and numpy
besides, which is told, too, and has no limit. Exit status 1: the call takes more than PERCENT longer than the program's
run. CPU times are told since they hold for a busy machine as well.
"""
import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time

CALL = """
import sys, time
import fringetwin
start = time.perf_counter(), time.process_time()
fringetwin.cosim(sys.argv[1], sys.argv[2])
print(time.perf_counter() - start[0], time.process_time() - start[1])
"""


def more(ours, theirs):
    """Returns by how many percent ours is more than theirs."""
    return 100.0 * (ours / theirs - 1.0)


def cpu_seconds_of_children():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def run(command, environment=None):
    """Returns how long a command took, s, its CPU time, s, and what it printed."""
    start, cpu = time.perf_counter(), cpu_seconds_of_children()
    done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode not in (0, 1):  # 1: limits not met
        sys.exit(f"{command[0]} ended with {done.returncode}: {done.stderr.strip()}")
    return time.perf_counter() - start, cpu_seconds_of_children() - cpu, done.stdout


def medians(options):
    """Returns of the program's runs, of the calls and of the processes of Python that made them: (s, CPU s)."""
    of_program, of_calls, of_processes = [], [], []

    def run_program(out):
        of_program.append(run([options.program, "-q", "cosim", options.twin, "--out", out + "/program"])[:2])

    def run_python(out):
        *process, printed = run([sys.executable, "-c", CALL, options.twin, out + "/python"],
                                os.environ | {"PYTHONPATH": options.package})
        of_processes.append(process)
        of_calls.append([float(number) for number in printed.split()])
    with tempfile.TemporaryDirectory() as out:
        for k in range(options.runs + 1):
            for one in (run_program, run_python) if k % 2 == 0 else (run_python, run_program):
                one(out)
    # the first of both fills caches of kernels, files and bytecode
    return [[statistics.median(seconds) for seconds in zip(*runs[1:])] for runs in (of_program, of_calls, of_processes)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default="build/fringetwin")
    parser.add_argument("--package", default="build/python")
    parser.add_argument("--twin", default="datasets/paper-sphere/twin.toml")
    parser.add_argument("--runs", type=int, default=9)
    parser.add_argument("--most", type=float, metavar="PERCENT", help="exit status 1 where the call takes so much longer")
    options = parser.parse_args()
    if "no Vulkan device" in run([options.program, "info"])[2] and not os.environ.get("FRINGETWIN_REQUIRE_DEVICE"):
        print("skipped: the program finds no Vulkan device")
        sys.exit(77)
    program, call, process = medians(options)
    print(f"whole measurement of {options.twin}, medians of {options.runs} runs in turns:")
    print(f"  command line                  {program[0]:.3f} s             {program[1]:.3f} CPU s")
    for what, (seconds, cpu_s) in (("the call in a running Python", call), ("with the start of Python", process)):
        print(f"  {what:30}{seconds:.3f} s ({more(seconds, program[0]):+5.1f} %)   {cpu_s:.3f} CPU s "
              f"({more(cpu_s, program[1]):+5.1f} %)")
    over = more(call[0], program[0])
    if options.most is not None and over > options.most:
        sys.exit(f"the call takes {over:.1f} % longer than the command line, at most {options.most:g} % are allowed")


if __name__ == "__main__":
    main()
