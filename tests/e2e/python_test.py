#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The Python package does what the command line does: same numbers, same images, same sentences.

python_test.py --program build/fringetwin --package build/python --source .      python_full_test.py: at full size

Tolerances: none. Both ways run the same code on the same device, so images and numbers are equal bit by bit; the
readers are held against numpy's, OpenCV's and SQLite's own reading, which is exact, too. A Ctrl-C
leaves a call without its last file, and a thread counts while another measures.
"""
import ast
import glob
import inspect
import json
import os
import re
import signal
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import zipfile

import numpy as np

from python_and_program import OPTIONS, bytes_of, of_the_result, program, run_tests
import fringetwin

SMALL = 0.25  # of the paper's images


def small_twin(source):
    """The text of the paper's sphere with cameras of a quarter of the pixels a side."""
    with open(os.path.join(source, "datasets/paper-sphere/twin.toml"), encoding="utf-8") as file:
        cameras, rest = file.read().split("[projector]")
    def smaller(found):
        numbers = [float(x) for x in found[2].split(",")]
        scaled = [numbers[0] * SMALL, numbers[1] * SMALL, *((c + 0.5) * SMALL - 0.5 for c in numbers[2:4]), *numbers[4:]]
        return f"{found[1]}{scaled}"
    cameras = cameras.replace("[1440, 1080]", "[360, 270]")
    return re.sub(r"(intrinsics = )\[([^\]]+)\]", smaller, cameras) + "[projector]" + rest


class Python(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.dir = cls.scratch.name
        cls.file = os.path.join(cls.dir, "twin.toml")
        with open(cls.file, "w", encoding="utf-8") as file:
            file.write(small_twin(OPTIONS["source"]))
        program("render", cls.file, "--out", cls.dir + "/cli", "--samples", 4, "--sampler", "gauss", "--radiance")
        program("measure", cls.file, "--captures", cls.dir + "/cli", "--out", cls.dir + "/cli-measured", "--npz")
        cls.twin = fringetwin.Twin(cls.file)
        cls.rendered = cls.twin.render(samples=4, sampler="gauss")

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def test_images_are_those_of_the_command_line(self):
        loaded = fringetwin.load_captures(self.twin, self.dir + "/cli")
        self.assertEqual(list(self.rendered.keys()), ["left", "right"])
        for camera in self.rendered:
            self.assertEqual(len(self.rendered[camera]), self.twin.n_images)
            for k, image in enumerate(self.rendered[camera]):
                self.assertEqual((image.shape, image.dtype), ((270, 360), np.float32))
                np.testing.assert_array_equal(image, loaded[camera][k])
                exr = fringetwin.read_exr(f"{self.dir}/cli/{camera}/{k:04d}.exr")["Y"]
                np.testing.assert_array_equal(self.rendered.irradiance[camera][k], exr)
        self.assertGreater(self.rendered["left"][0].max(), 20)
        self.assertEqual(list(loaded), [name for name, _ in loaded.items()])
        self.assertTrue("right" in loaded and "top" not in loaded and 5 not in loaded)
        self.assertEqual((loaded.get("right").camera, loaded.get("top"), loaded.get("top", 1)), ("right", None, 1))
        left, *_ = loaded.values()
        self.assertEqual(left.camera, "left")
        np.testing.assert_array_equal(left[3:0:-2], [left[3], left[1]])

    def test_arrays_own_the_programs_memory(self):
        first = self.rendered["left"][0]
        self.assertFalse(first.flags.owndata)
        self.assertTrue(np.shares_memory(first, self.rendered["left"][0]))
        points = fringetwin.measure(self.twin, self.rendered).points.p_world_mm  # all else is gone
        self.assertTrue(np.isfinite(points).all() and len(points) > 1000)

    def test_measurement_is_that_of_the_command_line(self):
        run = fringetwin.measure(self.twin, self.dir + "/cli").write(self.dir + "/py-measured", npz=True, figures=True)
        there = fringetwin.Run(self.dir + "/cli-measured")
        self.assertEqual(of_the_result(run.result), of_the_result(there.result))
        self.assertTrue(run.result["fits"])
        for name in ("points.ply", "phase_left.exr", "phase_right.exr", "measured_left.npz", "measured_right.npz"):
            self.assertEqual(bytes_of(run.file(name)), bytes_of(there.file(name)), name)
        self.assert_figures_are_those_of_the_page(run.path, 1)
        from_arrays = fringetwin.measure(self.twin, {c: list(self.rendered[c]) for c in self.rendered})
        self.assertEqual(from_arrays.fits, there.result["fits"])

    def test_stages_alone_are_the_measurement(self):
        measured = fringetwin.measure(self.twin, self.rendered)
        decodes = [fringetwin.decode(self.twin, self.rendered[c]) for c in self.twin.cameras]
        points = fringetwin.triangulate(self.twin, decodes)
        np.testing.assert_array_equal(points.p_world_mm, measured.points.p_world_mm)
        np.testing.assert_array_equal(points.sigma_mm, measured.points.sigma_mm)
        exr = fringetwin.read_exr(self.dir + "/cli-measured/phase_left.exr")
        for name, channel in decodes[0].channels().items():
            np.testing.assert_array_equal(channel, exr[name])
        fit = fringetwin.fit_sphere([[1, 0, 5], [-1, 0, 5], [0, 1, 5], [0, -1, 5], [0, 0, 6]], [0, 0, 4.9], 0.9)
        np.testing.assert_allclose([*fit["center_mm"], fit["radius_mm"]], [0, 0, 5, 1], atol=1e-9)  # converged to 1e-9

    def test_cosim_is_that_of_the_command_line(self):
        program("cosim", self.file, "--out", self.dir + "/cli-cosim", "--samples", 1, "--sampler", "gauss", "--npz", "--figures")
        run = fringetwin.cosim(self.twin, self.dir + "/py-cosim", samples=1, sampler="gauss")
        there = fringetwin.read_result(self.dir + "/cli-cosim")
        self.assertEqual(of_the_result(run.result), of_the_result(there))
        self.assertTrue(os.path.isfile(run.report))
        again = program("diff", self.dir + "/cli-cosim", self.dir + "/py-cosim", code=None)
        self.assertEqual(again.returncode, 0, again.stdout + again.stderr)
        self.assertEqual(glob.glob(self.dir + "/py-cosim/**/*.npz", recursive=True), [])  # only where asked for
        self.assert_arrays_are_those_of_the_files(self.dir + "/cli-cosim/measured_simulated")
        self.assert_figures_are_those_of_the_page(self.dir + "/cli-cosim")

    def test_figures_of_an_earlier_run_go(self):
        out = self.dir + "/compared"
        sides = ("--real", self.dir + "/cli", "--sim", self.dir + "/cli")
        program("compare", self.file, *sides, "--out", out)
        self.assertFalse(os.path.exists(out + "/figures"))  # only where asked for
        os.mkdir(out + "/figures")
        for name, text in (("older.svg", '<svg role="img"><g id="older-gnuplot_canvas"></g></svg>'), ("setup.svg", "<svg></svg>")):
            with open(f"{out}/figures/{name}", "w", encoding="utf-8") as file:
                file.write(text)
        program("compare", self.file, *sides, "--out", out, "--figures", "--npz")
        self.assertTrue(os.path.exists(out + "/figures/setup.svg"))  # somebody else's
        os.remove(out + "/figures/setup.svg")
        self.assert_figures_are_those_of_the_page(out)
        self.assert_arrays_are_those_of_the_files(out + "/measured_real")

    def assert_figures_are_those_of_the_page(self, run, least=4):
        program("export", run, "--figures", "--out", run + "-exported")
        names = sorted(os.path.basename(file) for file in glob.glob(run + "-exported/*.svg"))
        self.assertGreaterEqual(len(names), least)
        self.assertEqual(sorted(os.listdir(run + "/figures")), names)
        for name in names:
            self.assertEqual(bytes_of(f"{run}/figures/{name}"), bytes_of(f"{run}-exported/{name}"), name)

    def test_arrays_are_those_of_the_other_files(self):
        self.assert_arrays_are_those_of_the_files(self.dir + "/cli-measured")
        measured = fringetwin.measure(self.twin, self.dir + "/cli")
        with np.load(self.dir + "/cli-measured/measured_right.npz", allow_pickle=False) as right:
            np.testing.assert_array_equal(right["flags"], measured.decodes["right"].flags)
            self.assertNotIn("p_world_mm", right.files)  # points are of the first camera's pixels
        with np.load(self.dir + "/cli-measured/measured_left.npz", allow_pickle=False) as left:
            for name in ("p_world_mm", "normal_world", "q_cam_px", "sigma_mm"):
                np.testing.assert_array_equal(left[name], getattr(measured.points, name))

    def assert_arrays_are_those_of_the_files(self, folder):
        for camera in self.twin.cameras:
            file = f"{folder}/measured_{camera}.npz"
            with zipfile.ZipFile(file) as archive:
                self.assertIsNone(archive.testzip())  # reads all by its checksums
            with np.load(file, allow_pickle=False) as arrays:
                exr = fringetwin.read_exr(f"{folder}/phase_{camera}.exr")
                self.assertEqual(set(exr), set(arrays.files) & set(exr))
                for name in exr:
                    self.assertEqual(arrays[name].dtype, np.float32)
                    np.testing.assert_array_equal(arrays[name], exr[name])
                self.assertEqual((arrays["mask"].dtype, arrays["flags"].dtype), (np.dtype(bool), np.dtype(np.uint8)))
                np.testing.assert_array_equal(arrays["mask"], arrays["flags"] == 0)
                np.testing.assert_array_equal(arrays["mask"], np.isfinite(exr["column_px"]))
                self.assertTrue(arrays["mask"].any() and not arrays["mask"].all())
        points = fringetwin.read_points(folder + "/points.ply")
        with np.load(f"{folder}/measured_{self.twin.cameras[0]}.npz", allow_pickle=False) as arrays:
            np.testing.assert_array_equal(arrays["p_world_mm"], np.stack([points[a] for a in "xyz"], 1))
            np.testing.assert_array_equal(arrays["normal_world"], np.stack([points["n" + a] for a in "xyz"], 1))
            np.testing.assert_array_equal(arrays["q_cam_px"], np.stack([points["pixel_x"], points["pixel_y"]], 1))
            np.testing.assert_array_equal(arrays["sigma_mm"], points["sigma_mm"])

    def test_settings_are_those_of_a_changed_file(self):
        changed = os.path.join(self.dir, "blurred.toml")
        with open(changed, "w", encoding="utf-8") as file:
            file.write(small_twin(OPTIONS["source"]).replace("intensity = 40.0", "intensity = 40.0\nblur_px = 1"))
        program("render", changed, "--out", self.dir + "/blurred", "--samples", 4, "--sampler", "gauss")
        twin = fringetwin.Twin(self.dir).set("projector.blur_px", 1)  # the folder stands for its twin.toml
        blurred = twin.render(samples=4, sampler="gauss")
        there = fringetwin.load_captures(twin, self.dir + "/blurred")
        np.testing.assert_array_equal(blurred["left"][0], there["left"][0])
        self.assertFalse(np.array_equal(blurred["left"][0], self.rendered["left"][0]))
        self.assertEqual(twin.settings, {"projector.blur_px": "1"})

    def test_results_name_the_settings_and_options_they_were_made_with(self):
        twin = fringetwin.Twin(self.file).set("projector.blur_px", 1)
        measured = fringetwin.measure(twin, self.rendered)
        twin.set("projector.blur_px", 2)
        argv = measured.write(self.dir + "/set-later").result["provenance"]["argv"]
        self.assertEqual(argv, ["fringetwin.measure", self.file, "projector.blur_px=1"])
        run = fringetwin.cosim(self.twin, self.dir + "/options", radiance=True, samples=1, sampler="gauss", seed=3)
        self.assertEqual(run.result["provenance"]["argv"],
                         ["fringetwin.cosim", self.file, "radiance=True", "samples=1", "sampler=gauss", "seed=3"])
        with self.assertRaisesRegex(fringetwin.UserError, "--steps some: is not known"):
            fringetwin.cosim(self.twin, self.dir + "/options", steps="some")
        with self.assertRaisesRegex(fringetwin.UserError, "samples: must be 1 ... 65536, is 0"):
            self.twin.render(samples=0)

    def test_a_folder_is_given_back_after_each_call(self):
        folder = self.dir + "/shared"
        measured = fringetwin.measure(self.twin, self.rendered)
        measured.write(folder)
        subprocess.run([OPTIONS["program"], "measure", self.file, "--captures", self.dir + "/cli", "--out", folder],
                       check=True, capture_output=True, timeout=60)  # it would wait for as long as this process lives
        measured.write(folder)
        there = fringetwin.read_result(self.dir + "/cli-measured")
        self.assertEqual(of_the_result(fringetwin.read_result(folder))["fits"], there["fits"])

    def test_settings_change_while_others_measure(self):
        twin, wrong = fringetwin.Twin(self.file), []
        points = len(fringetwin.measure(twin, self.rendered).points)
        done = threading.Event()
        def change():
            k = 0
            while not done.is_set():
                k += 1
                twin.set("projector.blur_px", k % 7 + 1)
                if twin.settings != {"projector.blur_px": str(k % 7 + 1)}:
                    wrong.append(k)
        thread = threading.Thread(target=change)
        thread.start()
        for _ in range(3):
            self.assertEqual(len(fringetwin.measure(twin, self.rendered).points), points)
        done.set()
        thread.join()
        self.assertEqual(wrong, [])

    def test_errors_are_exceptions_with_the_same_sentence(self):
        missing = program("render", self.dir + "/none.toml", "--out", self.dir + "/none", code=2)
        with self.assertRaises(fringetwin.UserError) as refused:
            fringetwin.Twin(self.dir + "/none.toml")
        self.assertEqual(missing.stderr.strip(), f"fringetwin: error: {refused.exception}")
        self.assertEqual(refused.exception.exit_code, 2)
        twin = fringetwin.Twin(self.file)
        with self.assertRaisesRegex(fringetwin.UnknownKey, "blur_px"):
            twin.set("projector.blurr_px", 1)
        with self.assertRaises(fringetwin.UserError):
            twin.set({"projector.blur_px": 1, "projector.intensity": "bright"})
        self.assertEqual(twin.settings, {})  # a refused setting changes nothing
        with self.assertRaisesRegex(fringetwin.UserError, "camera \"right\" has no images"):
            fringetwin.measure(twin, {"left": [np.zeros((270, 360))] * 12})
        with self.assertRaisesRegex(fringetwin.UserError, "10 x 10 pixels"):
            fringetwin.measure(twin, {c: [np.zeros((10, 10))] * 12 for c in twin.cameras})

    def test_other_threads_run_meanwhile(self):
        counted, done = [0], threading.Event()
        def count():
            while not done.is_set():
                counted[0] += 1
                time.sleep(0.001)
        thread = threading.Thread(target=count)
        thread.start()
        before = counted[0]
        fringetwin.measure(self.twin, self.rendered)
        during = counted[0] - before
        done.set()
        thread.join()
        self.assertGreater(during, 5)  # with the lock held it is 0, or 1 where the thread was about to count

    def test_ctrl_c_ends_a_call_and_nothing_else(self):
        script = ("import fringetwin, functools, itertools, sys, threading, os, signal\n"
                  "small, large = fringetwin.Twin(sys.argv[1]), fringetwin.Twin(sys.argv[2])\n"
                  "fine, images = small.render(samples=1, sampler='gauss'), large.render(samples=1, sampler='gauss')\n"
                  "call = {'cosim': functools.partial(fringetwin.cosim, large, sys.argv[3], samples=256, sampler='gauss'),\n"
                  "        'render': functools.partial(large.render, samples=256, sampler='gauss'),\n"
                  "        'measure': functools.partial(fringetwin._core.measure, large, images)}[sys.argv[4]]\n"
                  "done = []\n"
                  "threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()\n"
                  # no line of Python lies between the end of render or measure and `done`: a call that went on is in it
                  "try:\n  done.extend(itertools.starmap(call, [()]))\n"
                  "except KeyboardInterrupt:\n  print('interrupted', len(done), flush=True)\n"
                  "again = small.render(samples=1, sampler='gauss')\n"
                  "assert (again['left'][0] == fine['left'][0]).all()\n"
                  "print('goes on')\n")
        for call in ("cosim", "render", "measure"):
            with self.subTest(call=call):
                done = subprocess.run([sys.executable, "-c", script, self.file, OPTIONS["source"] + "/datasets/paper-sphere",
                                       self.dir + "/interrupted", call], capture_output=True, text=True, check=False,
                                      timeout=120, env=os.environ | {"PYTHONPATH": OPTIONS["package"]})
                self.assertEqual(done.stdout, "interrupted 0\ngoes on\n", done.stderr)
        # Python alone would have raised the same once the whole of cosim had ended, with all its files written.
        self.assertFalse(os.path.exists(self.dir + "/interrupted/result.json"))

    def test_readers_agree_with_others(self):
        file = self.dir + "/cli-measured/points.ply"
        head, body = bytes_of(file).split(b"end_header\n", 1)
        record = np.dtype([("p", "<f8", 3), ("n", "<f4", 3), ("sigma_mm", "<f4"), ("pixel", "<f4", 2), ("column_px", "<f4"),
                           ("amplitude_dn", "<f4"), ("mean_dn", "<f4"), ("sigma_rad", "<f4")])
        plain = np.frombuffer(body, record)
        points = fringetwin.read_points(file)
        self.assertEqual(len(points), int(re.search(rb"element vertex (\d+)", head)[1]))
        np.testing.assert_array_equal(np.stack([points[a] for a in "xyz"], 1), plain["p"])
        exr = fringetwin.read_exr(self.dir + "/cli-measured/phase_left.exr")
        u, v = (points[name].astype(int) for name in ("pixel_x", "pixel_y"))
        np.testing.assert_array_equal(np.stack([u, v], 1), plain["pixel"])
        np.testing.assert_array_equal(points["sigma_mm"], plain["sigma_mm"])
        for name in ("column_px", "amplitude_dn", "mean_dn", "sigma_rad"):
            np.testing.assert_array_equal(points[name], plain[name])
            np.testing.assert_array_equal(points[name], exr[name][v, u])

    def test_points_of_earlier_versions_are_read(self):
        older = os.path.join(self.dir, "older.ply")  # their names had no "scalar_"
        with open(older, "wb") as ply:
            ply.write(b"ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty double z\nproperty float pixel_x\n"
                      b"property float sigma_mm\nend_header\n" + struct.pack("<dff", 250, 7, 0.5))
        self.assertEqual(fringetwin.read_points(older)[["z", "pixel_x", "sigma_mm"]].tolist(), [(250, 7, 0.5)])

    def test_deviations_are_those_of_the_fit(self):
        fit = fringetwin.read_result(self.dir + "/cli-measured")["fits"][0]["measured"]
        points = fringetwin.read_points(self.dir + "/cli-measured/deviation_sphere.ply")
        self.assertEqual(len(points), fit["n"])
        radius = np.linalg.norm(np.stack([points[a] for a in "xyz"], 1) - fit["center_mm"], axis=1)
        # single precision of the file: half a unit in the last place of a deviation below 2^-7 mm is 2^-31 mm = 5e-10 mm
        np.testing.assert_allclose(points["deviation_mm"], radius - fit["radius_mm"], rtol=0, atol=1e-9)
        rms = np.sqrt(np.mean(points["deviation_mm"].astype(float) ** 2))
        self.assertAlmostEqual(rms, fit["rms_mm"], delta=1e-9)
        outside = points["deviation_mm"] > 0
        self.assertTrue((points["red"] >= points["blue"])[outside].all() and (points["red"] <= points["blue"])[~outside].all())

    def test_a_capture_set_is_read_without_its_twin(self):
        there = fringetwin.read_captures(self.dir + "/cli")
        self.assertEqual(list(there), ["left", "right"])
        for camera, images in there.items():
            self.assertEqual((images.camera, len(images), images.file_bits, images.radiance), (camera, self.twin.n_images, 8, False))
            self.assertIsNone(images.white)
            for k, image in enumerate(images):
                np.testing.assert_array_equal(image, self.rendered[camera][k])
        exr = fringetwin.read_captures(self.dir + "/cli/radiance")["left"]
        self.assertEqual((exr.file_bits, exr.radiance), (32, True))
        np.testing.assert_array_equal(exr[-1], self.rendered.irradiance["left"][self.twin.n_images - 1])
        # what only the twin knows (bits of the sensor, channel, order of the cameras) is not in them
        with self.assertRaisesRegex(TypeError, r"load_captures\(twin, folder\)"):
            fringetwin.measure(self.twin, there)
        with self.assertRaisesRegex(TypeError, r"load_captures\(twin, folder\)"):
            fringetwin.measure(self.twin, there["left"])
        with self.assertRaises(TypeError):
            fringetwin.decode(self.twin, there["left"])
        with self.assertRaisesRegex(fringetwin.UserError, "no such folder"):
            fringetwin.read_captures(self.dir + "/nowhere")

    def test_results_are_read_as_they_are(self):
        with open(self.dir + "/cli-measured/result.json", encoding="utf-8") as result:
            self.assertEqual(fringetwin.read_result(self.dir + "/cli-measured"), json.load(result))

    def test_bad_files_are_refused_in_one_sentence(self):
        good = {name: bytes_of(f"{self.dir}/cli-measured/{name}") for name in ("points.ply", "phase_left.exr", "result.json")}
        ply_head = b"ply\nformat binary_little_endian 1.0\nelement vertex %s\nproperty float x\nend_header\n"
        window = good["phase_left.exr"].index(b"dataWindow\0box2i\0") + len(b"dataWindow\0box2i\0") + 4
        wide = bytearray(good["phase_left.exr"])
        wide[window + 8:window + 16] = b"\xff\xff\xff\x7e" * 2
        bad = {
            fringetwin.read_points: [b"", b"ply\n", good["points.ply"][:-1], good["points.ply"][:40], ply_head % b"-1",
                                     ply_head % b"many", ply_head % b"9999999999999",
                                     (ply_head % b"1").replace(b"float", b"long")],
            fringetwin.read_exr: [b"", b"\x76\x2f\x31\x01", good["phase_left.exr"][:-100], good["phase_left.exr"][:200],
                                  bytes(wide), good["phase_left.exr"].replace(b"channels\0", b"cannels\0\0")],
            fringetwin.read_result: [b"", b"[1]", b"\xff\xfe", good["result.json"][:-4], b"[" * 100000],
            fringetwin.read_study: [b"no database", b"SQLite format 3\0" + b"\xff" * 200],
        }
        path = os.path.join(self.dir, "bad")
        os.mkdir(self.dir + "/empty")
        for read, contents in bad.items():
            for content in contents:
                with open(path, "wb") as file:
                    file.write(content)
                with self.subTest(read=read.__name__, content=content[:60]):
                    with self.assertRaisesRegex(fringetwin.UserError, "^[^\n]*bad: is not an? [^\n]*; let [^\n]*$") as refused:
                        read(path)
                    self.assertEqual(refused.exception.exit_code, 3)
            with self.assertRaisesRegex(fringetwin.UserError, "none: is not there; give"):
                read(self.dir + "/none")
            with self.assertRaises(fringetwin.UserError):
                read(self.dir + "/empty")  # a folder is no file, and has none

    def test_study_tables(self):
        import sqlite3
        with sqlite3.connect(self.dir + "/study.db") as database:
            database.execute("CREATE TABLE point (id INTEGER, note TEXT)")
            database.execute("INSERT INTO point VALUES (1, 'a'), (2, NULL)")
        database.close()
        self.assertEqual(fringetwin.read_study(self.dir), {"point": [{"id": 1, "note": "a"}, {"id": 2, "note": None}]})

    def test_points_and_studies_are_frames_of_pandas(self):
        import pandas
        file = self.dir + "/cli-measured/points.ply"
        points = fringetwin.read_points(file)
        frame = pandas.DataFrame(points)
        self.assertEqual(list(frame.columns), ["x", "y", "z", "nx", "ny", "nz", "sigma_mm", "pixel_x", "pixel_y", "column_px",
                                               "amplitude_dn", "mean_dn", "sigma_rad"])
        for name in frame:
            self.assertEqual(frame[name].dtype, points[name].dtype)
            np.testing.assert_array_equal(frame[name], points[name])
        self.assertTrue((frame[frame.sigma_mm < frame.sigma_mm.median()].z > 0).any())
        with open(self.dir + "/study.toml", "w", encoding="utf-8") as study:
            study.write(f'schema = "fringetwin-study/1"\nname = "frames"\ntwin = "{self.file}"\n'
                        '[[vary]]\nkey = "render.sampler"\nvalues = ["gauss"]\n[[vary]]\nkey = "render.samples"\nvalues = [1, 4]\n'
                        '[[record]]\nresult = "fits.sphere.measured.rms_mm"\nname = "rms_mm"\n')
        program("study", self.dir + "/study.toml", "--out", self.dir + "/study", code=0)
        frame = pandas.DataFrame(fringetwin.read_study(self.dir + "/study")["points"])
        self.assertEqual(list(frame.columns), ["id", "settings", "seed", "status", "reason", "results", "seconds", "traced",
                                               "version", "host", "finished_at", "digest"])
        table = pandas.read_csv(self.dir + "/study/study.csv", float_precision="round_trip")
        self.assertEqual(list(table["render.samples"]), [1, 4])
        self.assertEqual(list(frame.id), list(table.id))
        numbers = pandas.json_normalize(frame.results.map(json.loads))
        self.assertEqual(list(numbers.rms_mm), list(table.rms_mm))
        self.assertTrue((table.rms_mm > 0).all())

    def test_version_is_that_of_the_command_line(self):
        self.assertEqual(fringetwin.version() + "\n", program("--version", code=0).stdout)
        self.assertEqual(fringetwin.__version__, fringetwin.version().split(" ")[0])

    def test_help_speaks_python(self):
        """No documentation or error shows a name of C++; those of the arguments are the stubs'."""
        from fringetwin import _core
        with open(os.path.join(os.path.dirname(fringetwin.__file__), "_core.pyi"), encoding="utf-8") as file:
            functions = {node.name: node for node in ast.parse(file.read()).body if isinstance(node, ast.FunctionDef)}
        told = [(name, getattr(fringetwin, name)) for name in fringetwin.__all__]
        told += [(name, getattr(_core, name)) for name in dir(_core) if not name.startswith("__")]
        for name, one in told[:]:
            if inspect.isclass(one):
                told += [(f"{name}.{member}", vars(one)[member]) for member in vars(one)]
        self.assertIn("Twin.render", dict(told))
        for name, one in told:
            self.assertNotIn("::", one.__doc__ or "", name)
        for name, stub in functions.items():
            signature = getattr(_core, name).__doc__.splitlines()[0]
            arguments = [argument.arg for argument in stub.args.args + stub.args.kwonlyargs]
            self.assertEqual(re.findall(r"[(,] ?(\w+): ", signature), arguments, signature)
        with self.assertRaises(TypeError) as refused:
            fringetwin.load_captures(self.dir, self.dir)
        self.assertNotIn("::", str(refused.exception))
        self.assertIn("twin: fringetwin._core.Twin, folder: os.PathLike", str(refused.exception))
        with self.assertRaisesRegex(fringetwin.UserError, "square"):
            self.twin.render(samples=3, sampler="gauss")  # as Twin.render's documentation says
        self.assertIn("`samples` per pixel (a square number", fringetwin.Twin.render.__doc__)

    def test_stubs_cover_every_public_name(self):
        from fringetwin import _core
        folder = os.path.dirname(fringetwin.__file__)
        with open(os.path.join(folder, "_core.pyi"), encoding="utf-8") as file:
            tree = ast.parse(file.read())
        stubs = {}
        for node in tree.body:
            if isinstance(node, ast.ClassDef):
                stubs[node.name] = {n.name for n in node.body if isinstance(n, ast.FunctionDef)} | {
                    n.target.id for n in node.body if isinstance(n, ast.AnnAssign)}
            elif isinstance(node, ast.FunctionDef):
                stubs[node.name] = None
        public = {name for name in dir(_core) if not name.startswith("_")}
        self.assertEqual(public, set(stubs) - {"_Path"})
        for name in public:
            if inspect.isclass(getattr(_core, name)) and not issubclass(getattr(_core, name), Exception):
                members = {m for m in vars(getattr(_core, name)) if not m.startswith("_")}
                self.assertEqual(members, {m for m in stubs[name] if not m.startswith("_")}, name)
        self.assertTrue(os.path.exists(os.path.join(folder, "py.typed")))
        for name in fringetwin.__all__:
            self.assertTrue(getattr(fringetwin, name).__doc__, name)

    def test_examples_run(self):
        examples = sorted(glob.glob(os.path.join(OPTIONS["source"], "python/examples/*.py")))
        self.assertTrue(examples)
        with_images = os.path.join(OPTIONS["source"], "datasets/povray-ball-wall/twin.toml")
        for example in examples:
            name = os.path.basename(example)
            with self.subTest(example=name):
                done = subprocess.run([sys.executable, example, with_images if name == "gain.py" else self.file,
                                       self.dir + "/example"], check=True, timeout=120, stdout=subprocess.PIPE, text=True,
                                      env=os.environ | {"PYTHONPATH": OPTIONS["package"]})
                if name == "gain.py":
                    self.assertRegex(done.stdout, r"(?m)^left: \d+\.\d{4} \+- 0\.\d{4} DN \(")
                    self.assertIn("within pixels", done.stdout)


run_tests()
