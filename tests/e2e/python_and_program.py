# SPDX-License-Identifier: Apache-2.0
"""What the tests of the Python package share: their options, the program as a user runs it, and what two runs that did
the same have in common.

A test that imports this takes --program build/fringetwin --package build/python --source . (and then the names of its
cases), and finds the package by `import fringetwin` afterwards.
"""
import argparse
import os
import subprocess
import sys
import unittest

NO_FACTS_OF_THE_RUN = ("command", "argv", "timing_s", "created", "created_utc", "host", "provenance", "inputs_sha256")


def parsed():
    parser = argparse.ArgumentParser()
    for name in ("program", "package", "source"):
        parser.add_argument("--" + name, required=True, type=os.path.abspath)
    arguments, rest = parser.parse_known_args()
    return vars(arguments), rest


OPTIONS, CASES = parsed()
sys.path.insert(0, OPTIONS["package"])


def program(*args, code=None):
    """Runs the program; `code`: the exit status that it must have, 0 or 1 (limits not met) where it is left out."""
    done = subprocess.run([OPTIONS["program"], *map(str, args)], capture_output=True, text=True, check=False)
    if code is None:
        assert done.returncode in (0, 1), done.stderr
    else:
        assert done.returncode == code, (done.returncode, done.stderr)
    return done


def of_the_result(result):
    """Returns a result without what differs between two runs that did the same: commands, times, places."""
    return {key: value for key, value in result.items() if key not in NO_FACTS_OF_THE_RUN}


def bytes_of(path):
    with open(path, "rb") as file:
        return file.read()


def run_tests():
    """Runs the tests of the file that was started; exit status 77 where the program finds no device."""
    if "no Vulkan device" in program("info").stdout and not os.environ.get("FRINGETWIN_REQUIRE_DEVICE"):
        print("skipped: the program finds no Vulkan device")
        sys.exit(77)
    unittest.main(argv=[sys.argv[0], *CASES])
