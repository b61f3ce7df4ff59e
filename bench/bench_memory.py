#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Memory and time of a comparison of large images: two cameras of 5 Mpx, 48 images each, by stage.

bench_memory.py [--program build/fringetwin] [--twin datasets/paper-sphere/twin.toml] [--out FOLDER] [--share 1.0]

The rig is the paper's with cameras of 2448 x 2048 px, two directions of fringes at three pitches and eight steps, and a
wall behind the sphere, so that the whole image is lit. Its images are rendered with sensor noise first; `cosim` then
compares a twin whose gain is 2 % off with them. Told are for each stage the peak of the memory that the program holds
(VmRSS, looked at fifty times a second), its time, and the CPU time of the whole. `--share` scales the images' sides, to
try the script. Without --out the files go into a folder that is removed at the end (1.6 GB).
"""
import argparse
import os
import pathlib
import re
import resource
import subprocess
import sys
import tempfile
import threading
import time

FULL = (2448, 2048)  # px
SIDE_OF_PAPER = 1440.0  # px: the width that the paper's focal lengths are of

WALL = """[[object]]
name = "wall"
shape = "plane"
point_mm = [0, 0, 330]
normal = [0.1, 0, -1]
[object.material]
diffuse = 0.6

"""


def with_larger_cameras(text, width, height):
    """Returns the twin with cameras of this size, which see what they saw and more above and below."""
    times = width / SIDE_OF_PAPER

    def camera(match):
        focal_x, focal_y, centre_x, centre_y, *distortion = [float(word) for word in match.group(1).split(",")]
        numbers = [times * focal_x, times * focal_y, times * centre_x, times * centre_y + 0.5 * (height - times * 1080.0)]
        return "intrinsics = [" + ", ".join(f"{n:.6g}" for n in numbers + distortion) + "]\nrt_cam"

    text = text.replace("imagersize = [1440, 1080]", f"imagersize = [{width}, {height}]")
    return re.sub(r"intrinsics = \[([^\]]*)\]\nrt_cam", camera, text, count=2)


def rig(text, share):
    """Returns the twin.toml of the bench, without real images, made of the paper's."""
    text = text[:text.index("# The images of the physical measurement")]
    text = with_larger_cameras(text, round(share * FULL[0]), round(share * FULL[1]))
    text = text.replace('directions = ["x"]', 'directions = ["x", "y"]').replace("steps = 4", "steps = 8")
    text = text.replace("[camera.sensor]", "[camera.sensor]\nelectrons_per_dn = 100\nread_noise_dn = 0.4")
    return text.replace("[measure]", WALL + "[measure]", 1)


class Memory(threading.Thread):
    """Looks at the memory of a process until it ends."""

    def __init__(self, process):
        super().__init__(daemon=True)
        self.process, self.peak_kb = process, 0

    def run(self):
        while self.process.poll() is None:
            try:
                status = pathlib.Path(f"/proc/{self.process.pid}/status").read_text()
            except OSError:
                return
            found = re.search(r"VmRSS:\s*(\d+)", status)
            if found:
                self.peak_kb = max(self.peak_kb, int(found.group(1)))
            time.sleep(0.02)

    def taken(self):
        """Returns the peak since it was asked last, GB."""
        peak, self.peak_kb = self.peak_kb, 0
        return peak / 1e6


def run_by_stages(command):
    """Runs a command that says its stages (-v); returns [(stage, s, GB)] and the status."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    memory = Memory(process)
    memory.start()
    stages, said = [], []
    for line in process.stderr:
        said.append(line)
        took = re.match(r"fringetwin: stage (\w+) took ([\d.]+) s", line)
        if took:
            stages.append((took.group(1), float(took.group(2)), memory.taken()))
    if process.wait() not in (0, 1):  # 1: limits not met
        sys.exit(f"{' '.join(command)} ended with {process.returncode}: {''.join(said[-3:]).strip()}")
    return stages


def measure(options, folder):
    text = rig(pathlib.Path(options.twin).read_text(), options.share)
    (folder / "truth.toml").write_text(text)
    (folder / "twin.toml").write_text(text.replace("gain_dn = 22.0", "gain_dn = 22.44") + '\n[real]\ncaptures = "captures"\n')
    program = os.path.abspath(options.program)
    subprocess.run([program, "-q", "render", folder / "truth.toml", "--seed", "7", "--out", folder / "captures"], check=True)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    start = time.perf_counter()
    stages = run_by_stages([program, "-v", "cosim", str(folder / "twin.toml"), "--out", str(folder / "out")])
    whole, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"{'stage':20s} {'s':>7s} {'GB':>6s}")
    for stage, seconds, peak_gb in stages:
        print(f"{stage:20s} {seconds:7.2f} {peak_gb:6.2f}")
    cpu = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    print(f"{'whole':20s} {whole:7.2f} {after.ru_maxrss / 1e6:6.2f}   {cpu:.1f} CPU s")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default="build/fringetwin")
    parser.add_argument("--twin", default="datasets/paper-sphere/twin.toml")
    parser.add_argument("--out", type=pathlib.Path)
    parser.add_argument("--share", type=float, default=1.0)
    options = parser.parse_args()
    if options.out:
        options.out.mkdir(parents=True, exist_ok=True)
        measure(options, options.out)
    else:
        with tempfile.TemporaryDirectory() as folder:
            measure(options, pathlib.Path(folder))


if __name__ == "__main__":
    main()
