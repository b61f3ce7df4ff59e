#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Bad files of every kind, given to the program as a user would: each must be refused in one sentence.

bad_files.py --program build/fringetwin --files tests/bad_files [--only READER or READER/NAME] [--jobs N] [--list] [--sanitized]

The files are those of tests/bad_files/READER (its README says what is wrong with each) and what bad_files_made.py and
bad_files_binary.py make. Of each run is asked: exit code 2 or 3, at most 2 s of computing, at most 500 MB of memory, one
sentence of at most 500 characters that names the file and holds no control character, nothing left that looks complete.
The good files of tests/bad_files/good must pass the same way without being refused, or the bad ones would prove nothing;
where a reader's files are the program's own, it makes the good one itself.
--sanitized: the program is one of the preset asan, which is slower, larger, and needs all addresses.
"""
import argparse
import concurrent.futures
import dataclasses
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time

import bad_files_binary
import bad_files_made
import bad_files_records

MOST_CHARACTERS = 500
LEAST_CASES = 200
REFUSED = (2, 3)
INTERNAL, NO_DEVICE = 70, 4
DEVICE_FIRST = ("journal",)  # readers that are reached only with a Vulkan device, and after a rendering: not timed


@dataclasses.dataclass
class Limits:
    """What a run may take, and what it is given."""

    seconds: float = 2.0  # of computing: a machine with other work makes no run fail
    megabytes: int = 500
    wait: float = 30.0  # who waits for a pipe computes nothing and is killed
    address_space_kb: str = str(16 << 20)  # so that a run that fails here takes no machine along


SANITIZED = Limits(40.0, 2500, 120.0, "unlimited")


class Place:
    """A folder with the good files, and the program's arguments for a bad file of one reader in it."""

    def __init__(self, folder, good, bad):
        self.folder, self.bad = folder, bad
        for file in good.iterdir():
            shutil.copyfile(file, folder / file.name)

    def put(self, name):
        """Puts the bad file under that name and returns its path as text."""
        path = self.folder / name
        path.parent.mkdir(exist_ok=True)
        if path.exists():
            path.unlink()
        self.bad.put(path)
        return str(path)

    def edit(self, name, old, new):
        path = self.folder / name
        text = path.read_text()
        assert old in text, f"{name} has no {old}"
        path.write_text(text.replace(old, new))

    def at(self, name):
        return str(self.folder / name)


def as_mesh(place, name):
    place.put(name)
    place.edit("twin.toml", bad_files_made.SPHERE, f'shape = "mesh"\nfile = "{name}"')
    return ["render", place.at("twin.toml")], name


def as_image(place, suffix):
    """The fourth of twelve images, or all of them."""
    images = place.folder / "left"
    images.mkdir()
    good = bad_files_binary.exr() if suffix == ".exr" else bad_files_binary.png()
    names = []
    for i in range(12):
        names.append(f"left/{i:04d}{suffix if i == 3 or place.bad.everywhere or suffix == '.exr' else '.png'}")
        if i == 3 or place.bad.everywhere:
            place.put(names[-1])
        else:
            (place.folder / names[-1]).write_bytes(good)
    place.edit("capture.toml", 'pattern = "left/%04d.png"', f"files = {names}".replace("'", '"'))
    shown = "left/0" if place.bad.everywhere else names[3]
    return ["measure", place.at("twin.toml"), "--captures", str(place.folder)], shown


def as_colour_image(place):
    """The same in a set that takes one colour of its images."""
    schema = 'schema = "fringetwin-captures/1"\n'
    place.edit("capture.toml", schema, schema + 'channel = "green"\n')
    return as_image(place, place.bad.suffix or ".png")


def as_capture_set(place):
    (place.folder / "left").mkdir()
    for i in range(12):
        (place.folder / f"left/{i:04d}.png").write_bytes(bad_files_binary.png())
    place.put("capture.toml")
    return ["measure", place.at("twin.toml"), "--captures", str(place.folder)], None


def as_matrix(place):
    """The first letter of the bad file's name says which matrix it is: D, R, T; K otherwise."""
    letter = place.bad.name[0] if place.bad.name[0] in "DRT" else "K"
    place.put(f"{letter}.txt")
    files = ",".join(place.at(f"{x}.txt") for x in "KDRT")
    return ["import", "matrices", "--camera", f"left={files}@1280x720"], f"{letter}.txt"


def as_corners(place):
    return ["calibrate", "--corners-cache", place.put("corners.vnl"), "--focal", "500", "--imagersize", "640x480",
            "--object-spacing", "0.01", "--object-width-n", "4", "--object-height-n", "4", "--names", "left,right",
            "left*", "right*"], "corners.vnl"


def as_calibration(place):
    place.put("calibration.json")
    with open(place.folder / "twin.toml", "a") as twin:
        twin.write('[uncertainty]\ncalibration = "calibration.json"\n')
    return ["cosim", place.at("twin.toml")], "calibration.json"


def as_pattern(place):
    name = "pattern" + (place.bad.suffix or ".png")
    place.put(name)
    place.edit("twin.toml", "steps = 4", f'steps = 4\nimages = ["{name}"]')
    return ["render", place.at("twin.toml")], name


def as_journal(place):
    place.put("out/capture.journal")
    return ["capture", place.at("twin.toml"), "--resume", "--camera", "twin:" + place.at("twin.toml")], "capture.journal"


def as_store(place):
    place.put("out/study.db")
    return ["study", place.at("study.toml")], "study.db"


def as_shard(place):
    place.put("shard-0.jsonl")
    return ["study-shard", str(place.folder), "0"], "shard-0.jsonl"


def interrupted_capture(program, place):
    """The program's own journal, of the steps until a Ctrl-C."""
    arguments = ["capture", place.at("twin.toml"), "--camera", "twin:" + place.at("twin.toml"), "--average", "10"]  # a second: time for it
    journal = place.folder / "out/capture.journal"
    with subprocess.Popen([program, *arguments, "--out", place.at("out")], stdin=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as child:
        until = time.monotonic() + SANITIZED.wait
        while child.poll() is None and time.monotonic() < until and not (journal.exists() and journal.read_bytes().count(b"\n") > 1):
            time.sleep(0.01)
        child.terminate()
    return [*arguments, "--resume"], r"recorded \d of 12 patterns|recorded 1[01] of 12"


def finished_study(program, place):
    """The program's own database, of a study of one point."""
    place.edit("study.toml", "noise_seeds = 2", "noise_seeds = 1")
    place.edit("study.toml", "[18, 19, 20]", "[19]")
    place.edit("study.toml", "[[8, 20], [10, 80]]", "[[8, 20]]")
    arguments = ["study", place.at("study.toml")]
    subprocess.run([program, *arguments, "--out", place.at("out")], check=False, stdin=subprocess.DEVNULL,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return arguments, "1 done before"


def whole_shard(program, place):
    """A shard of this program's version."""
    version = subprocess.run([program, "--version"], check=True, capture_output=True, text=True).stdout.strip()
    place.edit("round.json", '"version": "0"', f'"version": "{version}"')
    (place.folder / "shard-0.jsonl").write_text(
        '{"twin":"%s","device":"","records":[],"virtual_rig":false,"calibration":false}\n'
        '{"id":0,"settings":{},"seed":0,"group":0,"trace":"t","form":"f","sensors":[[8,20.0]],"mean":0.5,"amplitude":0.5}\n'
        % place.at("twin.toml"))
    return ["study-shard", str(place.folder), "0"], None


def as_opencv(place):
    """One camera whose matrix, distortion, rotation and translation all come from the file."""
    name = "calibration" + (place.bad.suffix or ".yml")
    return ["import", "opencv", place.put(name), "--camera", "left=M1,D1,R,T@1280x720"], name


# What a reader's bad file is given to the program as: arguments without --out, and the name that the sentence must hold
# (None: begins with any file, since TOML files name others).
READERS = {
    "twin": lambda p: (["render", p.put("twin.toml")], None),
    "capture_set": as_capture_set,
    "study": lambda p: (["study", p.put("study.toml")], None),
    "cameramodel": lambda p: (["import", "mrcal", p.put("left.cameramodel")], "left.cameramodel"),
    "opencv": as_opencv,
    "kalibr": lambda p: (["import", "kalibr", p.put("camchain.yaml")], "camchain.yaml"),
    "matrices": as_matrix,
    "corners": as_corners,
    "ply": lambda p: as_mesh(p, "part.ply"),
    "obj": lambda p: as_mesh(p, "part.obj"),
    "stl": lambda p: as_mesh(p, "part.stl"),
    "png": lambda p: as_image(p, ".png"),
    "tiff": lambda p: as_image(p, p.bad.suffix or ".tif"),
    "colour": as_colour_image,
    "exr": lambda p: as_image(p, ".exr"),
    "result_json": lambda p: (["diff", p.put("other.json"), p.at("result.json")], "other.json"),
    "calibration_json": as_calibration,
    "patterns": as_pattern,
    "journal": as_journal,
    "study_store": as_store,
    "shard": as_shard,
}
# Readers of what the program itself leaves: their good files are made by it, and then read without a fault. The pattern is
# what stderr then says (None: an attempt's log has the point).
OWN_FILES = {"journal": interrupted_capture, "study_store": finished_study, "shard": whole_shard}
NO_OUT = ("diff", "study-shard")


def run(program, arguments, folder, limits):
    """Exit code (negative: a signal's), standard error, seconds of computing, megabytes at most (not less than this process
    has: the kernel counts what a process had before it became the program)."""
    if arguments[0] not in NO_OUT:
        arguments = arguments + ["--out", str(folder / "out")]
    script = f'ulimit -c 0; ulimit -v {limits.address_space_kb}; exec "$@"'
    environment = {**os.environ, "FRINGETWIN_CACHE": str(folder / "cache"), "OMP_WAIT_POLICY": "passive"}
    if folder.name in OWN_FILES:  # the sanitizer loses some bytes of its own where a driver is loaded
        environment["ASAN_OPTIONS"] = "detect_leaks=0"
    with open(folder / "stderr", "wb") as err:
        child = subprocess.Popen(["/bin/sh", "-c", script, "sh", program, *arguments], stdin=subprocess.DEVNULL,
                                 stdout=subprocess.DEVNULL, stderr=err, cwd=folder, env=environment)
        killer = threading.Timer(limits.wait, child.kill)
        killer.start()
        _, status, usage = os.wait4(child.pid, 0)
        killer.cancel()
        child.returncode = os.waitstatus_to_exitcode(status)
    text = (folder / "stderr").read_bytes().decode("utf-8", "replace")
    return child.returncode, text, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def faults_of(name, bad, limits, ended):
    code, text, seconds, megabytes = ended
    if code == NO_DEVICE and name in DEVICE_FIRST:
        return []
    found = []
    accepted = REFUSED + ((0,) if bad.may_pass else ())
    if code not in accepted:
        found.append(f"exit code {code}")
    if seconds > limits.seconds and name not in DEVICE_FIRST:
        found.append(f"{seconds:.1f} s")
    if megabytes > limits.megabytes and name not in DEVICE_FIRST:
        found.append(f"{megabytes:.0f} MB")
    if code == 0:
        return found
    others = [line for line in text.splitlines() if not line.startswith("fringetwin: ")]
    if others:
        found.append(f"{len(others)} lines are not the program's: {others[0][:200]!r}")
    sentences = re.findall(r"^fringetwin: error: (.*)$", text, re.MULTILINE)
    if len(sentences) != 1 or not text.endswith("\n"):
        return found + [f"{len(sentences)} sentences: {text[-300:]!r}"]
    sentence = sentences[0]
    if len(sentence) > MOST_CHARACTERS:
        found.append(f"{len(sentence)} characters: {sentence[:120]!r}...")
    if re.search(r"[\x00-\x09\x0b-\x1f\x7f-\x9f]", text):
        found.append(f"control characters: {text[-300:]!r}")
    if not (bad.shown in sentence if bad.shown else sentence.startswith("/")):
        found.append(f"does not name {bad.shown or 'a file'}: {sentence[:300]!r}")
    return found


def check(program, good, limits, reader, bad):
    """What is wrong with the way the program takes this file; the folder is gone afterwards."""
    if bad.put is None:
        return check_own_file(program, good, limits, reader)
    with tempfile.TemporaryDirectory(prefix="fringetwin-bad-") as scratch:
        folder = pathlib.Path(scratch) / reader  # beside good/, as in tests/bad_files
        folder.mkdir()
        (folder.parent / "good").symlink_to(good)
        arguments, bad.shown = READERS[reader](Place(folder, good, bad))
        ended = run(program, arguments, folder, limits)
        if bad.good:
            return [f"refused: {ended[1][-400:]!r}"] if ended[0] in (*REFUSED, INTERNAL) or ended[0] < 0 else []
        complete = [name for name in ("capture.toml", "result.json", "twin.toml") if (folder / "out" / name).exists()]
        left = [f"left {name}" for name in complete if ended[0] != 0]
        return faults_of(reader, bad, limits, ended) + left


def check_own_file(program, good, limits, reader):
    """What is wrong with the way the program takes a file of its own."""
    with tempfile.TemporaryDirectory(prefix="fringetwin-good-") as scratch:
        folder = pathlib.Path(scratch) / reader
        folder.mkdir()
        arguments, said = OWN_FILES[reader](program, Place(folder, good, None))
        code, text, _, _ = run(program, arguments, folder, limits)
        log = folder / "shard-0.attempt-0.jsonl"
        taken = re.search(said, text) if said else log.exists() and '"id":0' in log.read_text()
        return [] if code == NO_DEVICE or (code == 0 and taken) else [f"exit code {code}: {text[-400:]!r}"]


def cases(files):
    """(reader, bad file), all of them."""
    for reader in READERS:
        if (files / reader).is_dir():
            for file in sorted((files / reader).iterdir()):
                if file.name != "README":
                    yield reader, bad_files_made.file_of(file)
        for bad in bad_files_made.common(reader, files / "good"):
            yield reader, bad
        for made in (bad_files_made, bad_files_binary, bad_files_records):
            for bad in made.own(reader):
                yield reader, bad
        for bad in bad_files_made.good(reader, files / "good") + bad_files_binary.good(reader):
            yield reader, bad
        if reader in OWN_FILES:
            yield reader, bad_files_made.Bad("good_of_this_program", None, good=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True)
    parser.add_argument("--files", required=True, type=pathlib.Path)
    parser.add_argument("--only", default="")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--every", type=int, default=1, help="take each so manieth bad file only")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--sanitized", action="store_true")
    options = parser.parse_args()
    program = os.path.abspath(options.program)
    limits = SANITIZED if options.sanitized else Limits()
    options.files = options.files.absolute()
    every = list(cases(options.files))
    named = [(reader, bad) for reader, bad in every if f"{reader}/{bad.name}".startswith(options.only)]
    chosen = [case for i, case in enumerate(named) if i % options.every == 0 or case[1].good]
    if options.list:
        print("\n".join(f"{reader}/{bad.name}" for reader, bad in chosen))
        return
    start = time.monotonic()
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        results = list(pool.map(lambda case: check(program, options.files / "good", limits, *case), chosen))
    wrong = [(f"{reader}/{bad.name}", faults) for (reader, bad), faults in zip(chosen, results) if faults]
    for name, faults in wrong:
        print(f"{name}: {'; '.join(faults)}")
    n_bad = sum(not bad.good for _, bad in every)
    print(f"{len(chosen)} files in {time.monotonic() - start:.0f} s, {len(wrong)} not as they should be")
    if n_bad < LEAST_CASES:
        sys.exit(f"only {n_bad} bad files, at least {LEAST_CASES} are asked for")
    sys.exit(1 if wrong or not chosen else 0)


if __name__ == "__main__":
    main()
