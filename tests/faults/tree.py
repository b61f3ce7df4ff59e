# SPDX-License-Identifier: Apache-2.0
"""What a command has left in its folder: is each file whole, and is what looks complete complete?"""
import json
import os
import sqlite3
import zlib


def files(folder):
    """Relative names and bytes of all files; what SQLite keeps beside an open database is none of ours."""
    found = {}
    for parent, _, names in os.walk(folder):
        for name in names:
            if name.endswith((".db-wal", ".db-shm", ".db-journal")):
                continue
            path = os.path.join(parent, name)
            with open(path, "rb") as file:
                found[os.path.relpath(path, folder)] = file.read()
    return found


def is_temporary(name):
    base = os.path.basename(name)
    return base.startswith(".") and base.endswith(".tmp")


def png_is_whole(data):
    at, ended = 8, False
    while at + 12 <= len(data):
        size = int.from_bytes(data[at:at + 4], "big")
        body = data[at + 4:at + 8 + size]
        if zlib.crc32(body) != int.from_bytes(data[at + 8 + size:at + 12 + size], "big"):
            return False
        ended = body[:4] == b"IEND"
        at += 12 + size
    return ended and at == len(data)


def is_json(data):
    try:
        json.loads(data)
        return True
    except ValueError:
        return False


def database_is_whole(path):
    try:
        with sqlite3.connect(path) as database:
            return database.execute("pragma integrity_check").fetchone()[0] == "ok"
    except sqlite3.Error:
        return os.path.getsize(path) == 0  # its first transaction never came


SAME = (".png", ".exr", ".ply", ".csv", ".svg", ".vnl")
WHOLE = {".png": png_is_whole, ".json": is_json, ".html": lambda d: d.rstrip().endswith(b"</html>"),
         ".toml": lambda d: d.endswith(b"\n"), ".cameramodel": lambda d: d.rstrip().endswith(b"}")}


class Reference:
    """A command's results when nothing disturbs it; files without times, places and command lines are always the same."""

    def __init__(self, found):
        self.names = set(found)
        self.same = {name: data for name, data in found.items() if name.endswith(SAME) and name != "frames.csv"}

    def faults(self, command, folder, exit_code, killed=False, old=None):
        """Sentences about what is wrong in the folder after a run with this exit code; none where all is as it should be.
        `old`: the files that were there before, which a run that failed may have left as they were, all or none."""
        found = files(folder)
        out = [] if killed else [f"{name} is left behind" for name in found if is_temporary(name)]
        for name, data in found.items():
            path = os.path.join(folder, name)
            if is_temporary(name) or name == "capture.journal":
                continue
            if name == "unfinished.csv" and exit_code != 0:  # of a study that was stopped: whole lines of its table
                if not data.endswith(b"\n"):
                    out.append(f"{name} is half-written ({len(data)} bytes)")
                continue
            if name not in self.names:
                out.append(f"{name} does not belong there")
            elif name in self.same:
                if data != self.same[name] and (exit_code == 0 or data != (old or {}).get(name)):
                    out.append(f"{name} is not as it should be ({len(data)} of {len(self.same[name])} bytes)")
            elif name.endswith(".db"):
                if not database_is_whole(path):
                    out.append(f"{name} is damaged")
            elif not WHOLE.get(os.path.splitext(name)[1], bool)(data):
                out.append(f"{name} is half-written ({len(data)} bytes)")
        missing = sorted(self.names - set(found))
        looks_complete = command.sign in found and "capture.journal" not in found
        if missing and (exit_code == 0 or looks_complete):
            out.append(f"exit code {exit_code}, {command.sign} {'is' if command.sign in found else 'is not'} there, "
                       f"but not {', '.join(missing[:3])}")
        if old and command.sign in found and found[command.sign] == old[command.sign]:
            out += [f"{name} is not as it was, but {command.sign} is" for name in old
                    if found.get(name) != old[name] and not name.endswith(".db")]
        elif old and looks_complete:
            out += [f"{name} is as it was, but {command.sign} is not" for name in self.same
                    if found.get(name) == old[name] != self.same[name]]
        return out
