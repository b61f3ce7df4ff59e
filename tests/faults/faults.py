#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Faults beside files: a full or broken disk, kills, signals, helpers that fail, no memory, no files to be had.

faults.py --program build/fringetwin --faults build/tests/libfaults.so --out DIR [--all] [--only writes,signals,surroundings] [--seed N]
--only surroundings.little_memory,writes.cosim: one of the surroundings, the writes of one command

Every command that writes is run on a very small rig, is disturbed, and may then leave nothing that looks complete and is not.
--all: every call of every command, 500 moments of signals; else a sample, by the seed. Exit code 1 if there is a fault, 77 without
a Vulkan device unless FRINGETWIN_REQUIRE_DEVICE is set."""
import argparse
import os
import shutil
import signal
import subprocess
import sys
import time

import running
import signals
import surroundings
import writes

PARTS = {"writes": writes, "signals": signals, "surroundings": surroundings}
SKIPPED = 77  # tells CTest so


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--program", required=True)
    parser.add_argument("--faults", required=True)
    parser.add_argument("--out", required=True)
    parser.add_argument("--only", default=",".join(PARTS))
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--seed", type=int, default=1, help="of the sample")
    options = parser.parse_args()
    program = os.path.abspath(options.program)
    if subprocess.run([program, "render", "--device", "list"], capture_output=True, check=False).returncode != 0:
        if os.environ.get("FRINGETWIN_REQUIRE_DEVICE"):
            sys.exit("no Vulkan device")
        print("SKIPPED: no Vulkan device")
        return SKIPPED
    signal.signal(signal.SIGINT, signal.default_int_handler)  # who starts us in the background may have it ignored, by all below us
    begin = time.monotonic()
    suite = running.Suite(program, os.path.abspath(options.faults), options.out, options.seed, options.all)
    for name in options.only.split(","):
        part, _, one = name.partition(".")
        PARTS[part].check(suite, options.all, *([one] if one else []))
    print(f"{suite.cases} cases in {time.monotonic() - begin:.0f} s, {len(suite.found)} faults (seed {options.seed})")
    if not suite.found:
        shutil.rmtree(suite.folder)
    return 1 if suite.found else 0


if __name__ == "__main__":
    sys.exit(main())
