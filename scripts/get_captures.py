#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fetches the public real captures that datasets/captures.txt lists, each from its repository at its commit.

get_captures.py [--target DIR] [--mirror DIR] [--manifest FILE] [SET ...]

Images are stored as gray PNG of the same values; their SHA-256 is that of "WIDTH HEIGHT\\n" and the values, row by row,
so it does not depend on how they were packed. A set is made under a temporary name and renamed once every file agrees.
What lies there already is compared and never overwritten. Needs git and the standard library.
Exit status: 0 all there, 1 a set is refused or could not be fetched, 2 wrong use.
"""
import argparse
import hashlib
import itertools
import os
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import zlib

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
STOPS = {signal.SIGINT, signal.SIGTERM}
HOST = "https://github.com/"


class Refused(Exception):
    pass


def say(text):
    print(f"get_captures: {text}", flush=True)


def read_manifest(path):
    """The sets in order: name -> {repository, commit, licence, without: [...], files: [(kind, sha256, source, target)]}"""
    sets, current = {}, None
    with open(path, encoding="utf-8") as file:
        for number, line in enumerate(file, 1):
            key, _, value = line.strip().partition(" ")
            if not key or key.startswith("#"):
                continue
            if key == "set":
                current = sets.setdefault(value, {"without": [], "files": []})
            elif current is not None and key in ("repository", "commit", "licence"):
                current[key] = value
            elif current is not None and key == "without":
                current["without"].append(value)
            elif current is not None and key in ("pixels", "bytes") and len(value.split()) == 3:
                current["files"].append((key, *value.split()))
            else:
                raise Refused(f"{path}, line {number}: \"{key}\" is not understood here")
    for name, one in sets.items():
        if one["files"] and not {"repository", "commit", "licence"} <= one.keys():
            raise Refused(f"{path}: set {name} lacks its repository, commit or licence")
    return sets


def gray_of(raw, channels, pixels, path):
    """Every pixel's value, where all its channels are equal."""
    planes = [raw[c::channels] for c in range(channels)]
    if len(planes[0]) != pixels or any(plane != planes[0] for plane in planes[1:]):
        raise Refused(f"{path}: is not a whole gray image")
    return planes[0]


def unfiltered(kind, row, above, step):
    if kind == 0:
        return row
    if kind == 1:
        out = bytearray(len(row))
        for c in range(step):
            out[c::step] = bytes(v & 255 for v in itertools.accumulate(row[c::step]))
        return bytes(out)
    if kind == 2:
        return bytes((a + b) & 255 for a, b in zip(row, above))
    out = bytearray(row)
    for i, value in enumerate(row):
        left, up, corner = (out[i - step], above[i], above[i - step]) if i >= step else (0, above[i], 0)
        if kind == 3:
            guess = (left + up) // 2
        else:
            to_left, to_up, to_corner = abs(up - corner), abs(left - corner), abs(left + up - 2 * corner)
            guess = left if to_left <= to_up and to_left <= to_corner else up if to_up <= to_corner else corner
        out[i] = (value + guess) & 255
    return bytes(out)


def read_png(data, path):
    at, packed = 8, b""
    width, height, depth, colour, _, _, interlaced = struct.unpack(">IIBBBBB", data[16:29])
    if depth != 8 or colour not in (0, 2) or interlaced:
        raise Refused(f"{path}: only 8-bit gray or RGB PNG without interlacing is read")
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        packed += data[at + 8:at + 8 + size] if kind == b"IDAT" else b""
        at += size + 12
    raw, step = zlib.decompress(packed), 3 if colour == 2 else 1
    length, rows, above = width * step, [], bytes(width * step)
    for y in range(height):
        start = y * (length + 1)
        above = unfiltered(raw[start], raw[start + 1:start + 1 + length], above, step)
        rows.append(above)
    return width, height, gray_of(b"".join(rows), step, width * height, path)


def read_bmp(data, path):
    start, header, width, height, _, bits, packing = struct.unpack("<I I i i H H I", data[10:34])
    if bits not in (8, 24) or packing or width <= 0 or height == 0:
        raise Refused(f"{path}: only BMP of 8 or 24 bit that is not packed is read")
    step, rows = bits // 8, abs(height)
    stride = (width * step + 3) // 4 * 4
    lines = [data[start + y * stride:start + y * stride + width * step] for y in range(rows)]
    raw = b"".join(lines if height < 0 else lines[::-1])
    if bits == 8:
        colours = struct.unpack("<I", data[46:50])[0] or 256
        palette = data[14 + header:14 + header + 4 * colours]
        entries = [palette[4 * i:4 * i + 3] for i in range(colours)]
        if any(len(set(entry)) != 1 for entry in entries) or max(raw) >= colours:
            raise Refused(f"{path}: is not a gray image")
        raw = raw.translate(bytes(entry[0] for entry in entries).ljust(256, b"\0"))
    return width, rows, gray_of(raw, step, width * rows, path)


def read_image(path):
    with open(path, "rb") as file:
        data = file.read()
    try:
        if data.startswith(b"\x89PNG\r\n\x1a\n"):
            return read_png(data, path)
        if data.startswith(b"BM"):
            return read_bmp(data, path)
    except (struct.error, zlib.error, IndexError, ValueError) as error:
        raise Refused(f"{path}: is a damaged image ({error})") from error
    raise Refused(f"{path}: is neither PNG nor BMP")


def write_png(path, image):
    width, height, pixels = image
    rows = b"".join(b"\0" + pixels[y * width:(y + 1) * width] for y in range(height))

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0))
                   + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def digest_of_image(image):
    return hashlib.sha256(f"{image[0]} {image[1]}\n".encode() + image[2]).hexdigest()


def digest(kind, path):
    if kind == "pixels":
        return digest_of_image(read_image(path))
    with open(path, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()


def git(folder, *args):
    done = subprocess.run(["git", "-c", "core.autocrlf=false", *args], cwd=folder, capture_output=True, text=True, check=False,
                          env={**os.environ, "GIT_TERMINAL_PROMPT": "0"})
    if done.returncode:
        last = (done.stderr.strip().splitlines() or ["no message"])[-1]
        raise Refused(f"git {args[0]} failed: {last}")


def check_out(one, folder, mirror):
    """The files of a set as its repository has them, and no other, in `folder`."""
    address = one["repository"]
    if mirror:
        address = os.path.join(os.path.abspath(mirror), address.removeprefix(HOST))
    os.makedirs(folder)
    git(folder, "init", "-q")
    git(folder, "remote", "add", "origin", address)
    git(folder, "sparse-checkout", "set", "--no-cone", *("/" + source for _, _, source, _ in one["files"]))
    git(folder, "fetch", "-q", "--depth", "1", "--filter=blob:none", "origin", one["commit"])
    git(folder, "checkout", "-q", "FETCH_HEAD")


def lay_out(one, source_folder, folder):
    for kind, expected, source, target in one["files"]:
        origin, path = os.path.join(source_folder, source), os.path.join(folder, target)
        if not os.path.isfile(origin):
            raise Refused(f"the commit has no file {source}")
        os.makedirs(os.path.dirname(path), exist_ok=True)
        if kind == "pixels":
            image = read_image(origin)
            found = digest_of_image(image)
        else:
            found = digest(kind, origin)
        if found != expected:
            raise Refused(f"{source}: SHA-256 expected {expected}, found {found}")
        if kind == "pixels":
            write_png(path, image)
        else:
            shutil.copyfile(origin, path)


def compare(one, folder):
    """Is the set there? Raises where a file is missing or differs."""
    if not os.path.lexists(folder):
        return False
    for kind, expected, _, target in one["files"]:
        path = os.path.join(folder, target)
        if not os.path.isfile(path):
            raise Refused(f"{path} is missing; move the folder away to have it fetched anew")
        found = digest(kind, path)
        if found != expected:
            raise Refused(f"{path}: SHA-256 expected {expected}, found {found}; it is left as it is")
    return True


def make_set(name, one, part, folder, mirror):
    """Checks the set's repository out into `part`, lays its files out there and renames what is complete to `folder`."""
    check_out(one, os.path.join(part, "git"), mirror)
    made = os.path.join(part, "made")
    lay_out(one, os.path.join(part, "git"), made)
    with open(os.path.join(made, "README.md"), "w", encoding="utf-8") as file:
        file.write(f"# {name}\nSource: {one['repository']} @ {one['commit']}\nLicence: {one['licence']}\n"
                   + "".join(f"Without: {reason}\n" for reason in one["without"]))
    os.rename(made, folder)


def fetch(name, one, target, mirror):
    folder = os.path.join(target, name)
    if compare(one, folder):
        say(f"{name}: is there, all {len(one['files'])} files agree, nothing to do")
        return
    say(f"{name}: from {one['repository']} at {one['commit']}; licence: {one['licence']}")
    for reason in one["without"]:
        say(f"{name}: without {reason}")
    os.makedirs(target, exist_ok=True)
    # A stop waits while the folder is made and while it is removed: one that came in between would leave it behind.
    signal.pthread_sigmask(signal.SIG_BLOCK, STOPS)
    part = tempfile.mkdtemp(prefix=f".{name}.part-", dir=target)
    try:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, STOPS)
        make_set(name, one, part, folder, mirror)
    finally:
        signal.pthread_sigmask(signal.SIG_BLOCK, STOPS)
        shutil.rmtree(part)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, STOPS)
    say(f"{name}: {len(one['files'])} files in {folder}")


def stop(*_):
    raise KeyboardInterrupt


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--target", default=os.environ.get("FRINGETWIN_CAPTURES") or os.path.join(ROOT, "../shared/captures"))
    parser.add_argument("--mirror", help=f"a folder with OWNER/REPO, in place of {HOST}")
    parser.add_argument("--manifest", default=os.path.join(ROOT, "datasets/captures.txt"))
    parser.add_argument("sets", nargs="*", metavar="SET")
    options = parser.parse_args()
    signal.signal(signal.SIGTERM, stop)
    try:
        sets = read_manifest(options.manifest)
    except (OSError, Refused) as error:
        parser.error(str(error))
    unknown = [name for name in options.sets if name not in sets]
    if unknown:
        parser.error(f"no set {unknown[0]}; there are {', '.join(sets)}")
    failed = False
    for name in options.sets or sets:
        if not sets[name]["files"]:
            say(f"{name}: cannot be fetched: {'; '.join(sets[name]['without'])}")
            failed = failed or name in options.sets
            continue
        try:
            fetch(name, sets[name], options.target, options.mirror)
        except (OSError, Refused) as error:
            print(f"get_captures: {name}: refused: {error}", file=sys.stderr)
            failed = True
    return 1 if failed else 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        print("get_captures: stopped; what was not finished is removed", file=sys.stderr)
        sys.exit(130)
