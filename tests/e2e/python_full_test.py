#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Python and the command line write the same at full size: the paper's sphere, and the real relief of slmaster.

python_full_test.py --program build/fringetwin --package build/python --source . PaperSphere
python_full_test.py ... Relief        renders and measures the real images (FRINGETWIN_CAPTURES); exit status 77 without
python_full_test.py ... ReliefCosim   compares the two as well (a minute of computing)

Tolerances: none. Both ways run the same code on the same device: every file has the same bytes, but for result.json and
report.html, which name command and times; of result.json all other numbers are equal. The arrays are held against the
files, which numpy (EXR, PLY, NPZ) and mrcal's reader of images (PNG) read without the program.
"""
import os
import sys
import tempfile
import unittest

import mrcal
import numpy as np

from python_and_program import CASES, OPTIONS, bytes_of, of_the_result, program, run_tests
import fringetwin

CAPTURES = os.environ.get("FRINGETWIN_CAPTURES") or os.path.join(OPTIONS["source"], "../shared/captures")
NAMES_THE_RUN = ("result.json", "report.html")


def files_of(folder):
    return sorted(os.path.relpath(os.path.join(place, name), folder) for place, _, names in os.walk(folder) for name in names)


class SameFiles(unittest.TestCase):
    dataset = ""

    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.dir = scratch.name
        self.folder = os.path.join(OPTIONS["source"], "datasets", self.dataset)
        self.file = self.folder + "/twin.toml"
        self.twin = fringetwin.Twin(self.folder)

    def assert_same_files(self, python, command_line, least):
        """Every file that is in one of two folders is in the other, with the same bytes; at least `least` by extension."""
        names = files_of(command_line)
        self.assertEqual(files_of(python), names)
        for extension, n in least.items():
            self.assertGreaterEqual(sum(name.endswith(extension) for name in names), n, extension)
        for name in names:
            if os.path.basename(name) not in NAMES_THE_RUN:
                self.assertEqual(bytes_of(f"{python}/{name}"), bytes_of(f"{command_line}/{name}"), name)

    def assert_same_result(self, python, command_line):
        """What both results say is equal, and of their provenance all but the call."""
        ours, theirs = fringetwin.read_result(python), fringetwin.read_result(command_line)
        self.assertEqual(of_the_result(ours), of_the_result(theirs))
        of_run = ("argv", "command")
        self.assertEqual(*({key: value for key, value in result["provenance"].items() if key not in of_run}
                           for result in (ours, theirs)))
        self.assertTrue(ours["provenance"]["inputs_sha256"])

    def compared_by_both(self, least):
        """A co-simulation by Python and one by the program are the same; returns the run and the program's folder."""
        there = self.dir + "/there"
        program("cosim", self.file, "--out", there, "--radiance", "--npz")
        run = fringetwin.cosim(self.twin, self.dir + "/here", radiance=True, npz=True)
        self.assert_same_files(run.path, there, least)
        self.assert_same_result(run.path, there)
        return run, there

    def assert_images_are_those_of_the_files(self, images, pattern, shape):
        """Gray values as arrays are those of the PNG files, which another library reads."""
        self.assertEqual(len(images), self.twin.n_images)
        for k, image in enumerate(images):
            self.assertEqual((image.shape, image.dtype), (shape, np.float32))
            np.testing.assert_array_equal(image, mrcal.load_image(pattern % k))
        self.assertGreater(images[0].max(), 20)

    def assert_measured_is_that_of_the_files(self, measured, folder):
        """Points and phases as arrays are those of points.ply and of the EXR and NPZ files."""
        points, found = fringetwin.read_points(folder + "/points.ply"), measured.points
        self.assertGreater(len(points), 50000)
        np.testing.assert_array_equal(found.p_world_mm, np.stack([points[a] for a in "xyz"], 1))
        np.testing.assert_array_equal(found.normal_world, np.stack([points["n" + a] for a in "xyz"], 1))
        np.testing.assert_array_equal(found.q_cam_px, np.stack([points["pixel_x"], points["pixel_y"]], 1))
        np.testing.assert_array_equal(found.sigma_mm, points["sigma_mm"])
        for camera in self.twin.cameras:
            exr, decode = fringetwin.read_exr(f"{folder}/phase_{camera}.exr"), measured.decodes[camera]
            channels = decode.channels()
            self.assertEqual(set(channels), set(exr))
            with np.load(f"{folder}/measured_{camera}.npz", allow_pickle=False) as arrays:
                np.testing.assert_array_equal(arrays["flags"], decode.flags)
                for name, channel in channels.items():
                    np.testing.assert_array_equal(channel, exr[name])
                    np.testing.assert_array_equal(channel, arrays[name])


class PaperSphere(SameFiles):
    dataset = "paper-sphere"

    def test_cosim_is_that_of_the_command_line(self):
        run, there = self.compared_by_both({".png": 24, ".exr": 26, ".ply": 2, ".npz": 2})
        rendered = self.twin.render()
        loaded = fringetwin.load_captures(self.twin, there + "/simulated")
        for camera in self.twin.cameras:
            pattern = f"{there}/simulated/{camera}/%04d"
            self.assert_images_are_those_of_the_files(rendered[camera], pattern + ".png", (1080, 1440))
            for k, image in enumerate(rendered.irradiance[camera]):
                np.testing.assert_array_equal(image, fringetwin.read_exr(pattern % k + ".exr")["Y"])
                np.testing.assert_array_equal(rendered[camera][k], loaded[camera][k])
        measured = fringetwin.measure(self.twin, rendered)
        ours, theirs = measured.fits[0]["measured"], run.result["fits"][0]["simulated"]  # which knows what the method adds
        self.assertEqual(ours, {key: theirs[key] for key in ours})
        self.assert_measured_is_that_of_the_files(measured, there + "/measured_simulated")


class Relief(SameFiles):
    dataset = "slmaster-mono-relief"

    def test_real_images_are_measured_as_the_command_line_does(self):
        there = self.dir + "/there"
        program("measure", self.file, "--captures", self.folder, "--out", there, "--npz")
        captures = fringetwin.load_captures(self.twin, self.folder)
        self.assert_images_are_those_of_the_files(captures["camera"], f"{CAPTURES}/{self.dataset}/L/%02d.png", (1024, 1280))
        measured = fringetwin.measure(self.twin, captures)
        run = measured.write(self.dir + "/here", npz=True)
        self.assert_same_files(run.path, there, {".exr": 1, ".ply": 1, ".npz": 1})
        self.assert_same_result(run.path, there)
        self.assert_measured_is_that_of_the_files(measured, there)

    def test_images_of_the_measured_shape_are_those_of_the_command_line(self):
        there = self.dir + "/there"
        program("render", self.file, "--out", there, "--radiance")
        rendered = self.twin.render()
        rendered.write(self.dir + "/here", radiance=True)
        self.assert_same_files(self.dir + "/here", there, {".png": 17, ".exr": 17})
        self.assert_images_are_those_of_the_files(rendered["camera"], there + "/camera/%04d.png", (1024, 1280))


class ReliefCosim(SameFiles):
    dataset = "slmaster-mono-relief"

    def test_cosim_is_that_of_the_command_line(self):
        run, there = self.compared_by_both({".png": 19, ".exr": 19, ".ply": 2, ".npz": 2})
        self.assertTrue(run.result["gain"] and run.result["phase"] and run.result["coverage"])
        for side in ("real", "simulated"):  # of the odd steps; the shape is that of the even ones
            points = fringetwin.read_points(f"{run.path}/measured_{side}/points.ply")
            self.assertGreater(len(points), 50000)
            with np.load(f"{there}/measured_{side}/measured_camera.npz", allow_pickle=False) as arrays:
                np.testing.assert_array_equal(np.stack([points[a] for a in "xyz"], 1), arrays["p_world_mm"])


def main():
    if any(case.startswith("Relief") for case in CASES) and not os.path.isdir(f"{CAPTURES}/slmaster-mono-relief"):
        print(f"skipped: {CAPTURES} has no slmaster-mono-relief (`make captures`)")
        sys.exit(77)
    os.environ["FRINGETWIN_CAPTURES"] = CAPTURES
    run_tests()


main()
