#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/get_captures.sh lays out what the repositories hold, and nothing else.

get_captures_test.py --source .       exit status 77 where the captures folder is absent

The repositories are local ones that this test makes: the first images of each set, packed as the repository has them
(BMP, bottom row first), and the other files. Tolerances: none, the values are equal bit by bit. Independent truth: images
written here from plain numbers, as BMP and as PNG with every filter.
"""
import hashlib
import os
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import zlib

SOURCE = os.path.abspath(sys.argv[sys.argv.index("--source") + 1])
CAPTURES = os.environ.get("FRINGETWIN_CAPTURES") or os.path.join(SOURCE, "../shared/captures")
SCRIPT = os.path.join(SOURCE, "scripts/get_captures.sh")
IMAGES = 3  # of each set: a fetch of everything takes minutes
sys.path.insert(0, os.path.join(SOURCE, "scripts"))
sys.dont_write_bytecode = True
import get_captures  # noqa: E402  pylint: disable=wrong-import-position


def write(path, data):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "wb") as file:
        file.write(data)


def read(path):
    with open(path, "rb") as file:
        return file.read()


def bmp(width, height, pixels, bits=8):
    step = bits // 8
    stride = (width * step + 3) // 4 * 4
    rows = [bytes(v for v in pixels[y * width:(y + 1) * width] for _ in range(step)).ljust(stride, b"\0") for y in range(height)]
    palette = b"".join(bytes((v, v, v, 0)) for v in range(256)) if bits == 8 else b""
    start = 54 + len(palette)
    return (struct.pack("<2sIHHI", b"BM", start + stride * height, 0, 0, start)
            + struct.pack("<IiiHHIIiiII", 40, width, height, 1, bits, 0, 0, 0, 0, 0, 0) + palette + b"".join(rows[::-1]))


def filtered_png(width, height, pixels):
    """A gray PNG whose rows take the five filters in turn, from the definitions in the PNG specification."""
    rows = b""
    for y in range(height):
        kind = y % 5
        rows += bytes([kind])
        for x in range(width):
            a = pixels[y * width + x - 1] if x else 0
            b = pixels[(y - 1) * width + x] if y else 0
            c = pixels[(y - 1) * width + x - 1] if x and y else 0
            paeth = min((abs(a + b - c - v), i, v) for i, v in enumerate((a, b, c)))[2]
            rows += bytes([(pixels[y * width + x] - (0, a, b, (a + b) // 2, paeth)[kind]) & 255])
    chunk = lambda kind, body: struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


class Images(unittest.TestCase):
    def test_plain_numbers_are_read_from_bmp_and_png(self):
        width, height = 7, 11  # no multiple of four: BMP pads its rows
        pixels = hashlib.sha512(b"a").digest() + hashlib.sha512(b"b").digest()[:width * height - 64]
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "image")
            for data in (bmp(width, height, pixels), bmp(width, height, pixels, 24), filtered_png(width, height, pixels)):
                write(path, data)
                self.assertEqual(get_captures.read_image(path), (width, height, pixels))
            get_captures.write_png(path, (width, height, pixels))
            self.assertEqual(get_captures.read_image(path), (width, height, pixels))


@unittest.skipUnless(os.path.isdir(os.path.join(CAPTURES, "slmaster-mono-relief")), "no captures")
class Fetch(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.mirror = os.path.join(cls.scratch.name, "mirror")
        cls.manifest = os.path.join(cls.scratch.name, "captures.txt")
        cls.sets = get_captures.read_manifest(os.path.join(SOURCE, "datasets/captures.txt"))
        with open(cls.manifest, "w", encoding="utf-8") as file:
            for name, one in cls.sets.items():
                file.write(f"set {name}\n" + "".join(f"without {reason}\n" for reason in one["without"]))
                if not one["files"]:
                    continue
                images = [f for f in one["files"] if f[0] == "pixels"][:IMAGES]
                one["files"] = images + [f for f in one["files"] if f[0] == "bytes"]
                file.write(f"repository {one['repository']}\ncommit {cls.repository(name, one)}\nlicence {one['licence']}\n"
                           + "".join(" ".join(f) + "\n" for f in one["files"]))

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    @classmethod
    def repository(cls, name, one):
        """A repository with the set's files and one file that is not asked for; its commit."""
        folder = os.path.join(cls.mirror, one["repository"].removeprefix(get_captures.HOST))
        for _, _, source, target in one["files"]:
            data = read(os.path.join(CAPTURES, name, target))
            if source.endswith(".bmp"):
                data = bmp(*get_captures.read_image(os.path.join(CAPTURES, name, target)))
            write(os.path.join(folder, source), data)
        write(os.path.join(folder, "not/asked/for.txt"), b"x")
        return cls.commit(folder)

    @staticmethod
    def commit(folder):
        git = ["git", "-C", folder, "-c", "user.name=test", "-c", "user.email=test@localhost", "-c", "core.autocrlf=false"]
        for args in (["init", "-q"], ["config", "uploadpack.allowFilter", "true"],
                     ["config", "uploadpack.allowAnySHA1InWant", "true"], ["add", "-A"], ["commit", "-q", "-m", "all"]):
            subprocess.run(git + args, check=True)
        return subprocess.run(git + ["rev-parse", "HEAD"], check=True, capture_output=True, text=True).stdout.strip()

    def setUp(self):
        self.target = tempfile.mkdtemp(dir=self.scratch.name)

    def command(self, *sets, manifest=None):
        return [SCRIPT, "--target", self.target, "--mirror", self.mirror, "--manifest", manifest or self.manifest, *sets]

    def run_script(self, *sets, **more):
        return subprocess.run(self.command(*sets, **more), capture_output=True, text=True, check=False)

    def test_every_set_is_laid_out_and_a_second_run_has_nothing_to_do(self):
        done = self.run_script()
        self.assertEqual(done.returncode, 0, done.stderr)
        fetched = {name: one for name, one in self.sets.items() if one["files"]}
        self.assertEqual(sorted(os.listdir(self.target)), sorted(fetched))
        for name, one in fetched.items():
            self.assertIn(f"licence: {one['licence']}", done.stdout)
            found = {os.path.relpath(os.path.join(at, file), os.path.join(self.target, name))
                     for at, _, files in os.walk(os.path.join(self.target, name)) for file in files}
            self.assertEqual(found, {target for _, _, _, target in one["files"]} | {"README.md"})
            for kind, _, _, target in one["files"]:
                here, there = (os.path.join(folder, name, target) for folder in (self.target, CAPTURES))
                reader = get_captures.read_image if kind == "pixels" else read
                self.assertEqual(reader(here), reader(there), target)
        again = self.run_script()
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual(again.stdout.count("nothing to do"), len(fetched))

    def test_a_changed_file_is_refused_by_name_and_nothing_is_left(self):
        name = "mesh-stanford-bunny"
        manifest = os.path.join(self.target, "..", "wrong.txt")
        _, expected, source, _ = self.sets[name]["files"][0]
        with open(self.manifest, encoding="utf-8") as file, open(manifest, "w", encoding="utf-8") as wrong:
            wrong.write(file.read().replace(expected, "0" * 64))
        done = self.run_script(name, manifest=manifest)
        self.assertEqual(done.returncode, 1)
        self.assertIn(f"{source}: SHA-256 expected {'0' * 64}, found {expected}", done.stderr)
        self.assertEqual(os.listdir(self.target), [])

    def test_what_is_there_and_differs_is_left_as_it_is(self):
        name = "mesh-stanford-bunny"
        path = os.path.join(self.target, name, self.sets[name]["files"][0][3])
        write(path, b"mine")
        done = self.run_script(name)
        self.assertEqual(done.returncode, 1)
        self.assertIn(f"found {hashlib.sha256(b'mine').hexdigest()}; it is left as it is", done.stderr)
        self.assertEqual(read(path), b"mine")

    def test_a_run_that_is_stopped_leaves_nothing(self):
        tools = os.path.join(self.scratch.name, "tools")
        write(os.path.join(tools, "git"), b"#!/bin/sh\nexec sleep 60\n")
        os.chmod(os.path.join(tools, "git"), 0o755)
        for seconds_later in [0.0] * 10 + [0.001, 0.01, 0.1]:  # the first come while the folder is being made
            with self.subTest(seconds_later=seconds_later):
                self.stop_once_it_began(tools, seconds_later)

    def stop_once_it_began(self, tools, seconds_later):
        with subprocess.Popen(self.command("mesh-stanford-bunny"), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                              env={**os.environ, "PATH": tools + ":" + os.environ["PATH"]}) as process:
            end = time.monotonic() + 30
            while not os.listdir(self.target) and time.monotonic() < end:
                pass
            self.assertTrue(os.listdir(self.target), "it never began")
            time.sleep(seconds_later)
            process.terminate()
            self.assertIn(b"stopped", process.communicate(timeout=30)[1])
        self.assertEqual(process.returncode, 130)
        self.assertEqual(os.listdir(self.target), [])


if __name__ == "__main__":
    if not os.path.isdir(os.path.join(CAPTURES, "slmaster-mono-relief")):
        done = unittest.main(argv=[sys.argv[0], "Images"], exit=False)
        print(f"SKIPPED: no captures at {CAPTURES} (FRINGETWIN_CAPTURES)")
        sys.exit(77 if done.result.wasSuccessful() else 1)
    unittest.main(argv=[sys.argv[0]])
