# SPDX-License-Identifier: Apache-2.0
"""Readers of the program's files (docs/FORMATS.md), written in Python; what is wrong with a file is a UserError."""
import functools
import json
import os
import sqlite3
import struct
import urllib.parse
import zlib
from typing import Any, Callable, Dict, List, TypeVar, Union

import numpy as np

from ._core import UserError

PathLike = Union[str, "os.PathLike[str]"]
_EXIT_CODE_INPUT = 3  # the program's, for input that it refuses (docs/CONVENTIONS.md, "Exit codes")
# what Python, numpy, zlib and SQLite raise where a file does not hold what it says
_FAULTS = (OSError, ValueError, LookupError, TypeError, OverflowError, MemoryError, RecursionError, struct.error,
           zlib.error, sqlite3.Error)
_Content = TypeVar("_Content")


def _refusal(path: str, what: str, remedy: str) -> UserError:
    error = UserError(f"{path}: {what}; {remedy}")
    error.exit_code = _EXIT_CODE_INPUT
    return error


def _reader(kind: str, in_folder: str = "") -> Callable[..., Any]:
    """Makes a reader of a function that takes the path of a file as text, or of a folder that holds `in_folder`."""
    def of(read: Callable[..., _Content]) -> Callable[[PathLike], _Content]:
        @functools.wraps(read)
        def reader(path: PathLike) -> _Content:
            path = os.fspath(path)
            if in_folder and os.path.isdir(path):
                path = os.path.join(path, in_folder)
            try:
                return read(path)
            except FileNotFoundError as fault:
                raise _refusal(path, "is not there", f"give the path of {kind} that fringetwin wrote") from fault
            except OSError as fault:
                raise _refusal(path, f"cannot be read ({fault.strerror or fault})",
                               f"give the path of {kind} that can be read") from fault
            except _FAULTS as fault:
                raise _refusal(path, f"is not {kind}, or is damaged ({fault})",
                               "let fringetwin write it again") from fault
        return reader
    return of


class Run:
    """A folder that `fringetwin cosim` or `fringetwin measure` wrote.

    path: the folder; result: the content of result.json.
    """

    def __init__(self, path: PathLike) -> None:
        self.path = os.fspath(path)
        self.result: Dict[str, Any] = read_result(path)

    @property
    def report(self) -> str:
        """Path of report.html."""
        return os.path.join(self.path, "report.html")

    def file(self, *parts: str) -> str:
        """Returns the path of a file in the folder."""
        return os.path.join(self.path, *parts)


@_reader("a result.json", "result.json")
def read_result(path: PathLike) -> Dict[str, Any]:
    """Returns the content of a result.json (or of the one in a folder); numbers that are not finite are None."""
    with open(path, encoding="utf-8") as file:
        result = json.load(file)
    if not isinstance(result, dict):
        raise ValueError("it holds no object")
    return result


_PLY_TYPES = {"double": "<f8", "float": "<f4", "float64": "<f8", "float32": "<f4", "int": "<i4", "uint": "<u4",
              "uchar": "u1", "uint8": "u1", "short": "<i2", "ushort": "<u2", "char": "i1"}


@_reader("a points.ply")
def read_points(path: PathLike) -> np.ndarray:
    """Returns the points of a points.ply, or of a deviation_OBJECT.ply, as a structured array.

    Fields: x, y, z (mm, world frame, float64); nx, ny, nz (unit normal), sigma_mm (mm), pixel_x, pixel_y (px, first
    camera), column_px, row_px (px, projector), amplitude_dn, mean_dn (DN), sigma_rad (rad) or deviation_mm (mm), all
    float32; red, green, blue (uint8): those that the file has. Names are without the "scalar_" that the file writes for
    CloudCompare. pandas.DataFrame() takes it as it is.
    """
    with open(path, "rb") as file:
        if file.readline().strip() != b"ply" or file.readline().split()[1:2] != [b"binary_little_endian"]:
            raise ValueError("no binary little-endian PLY")
        fields: List[Any] = []
        n = 0
        for line in iter(file.readline, b""):
            words = line.decode("ascii", "replace").split()
            if words[:1] == ["end_header"]:
                points = np.fromfile(file, np.dtype(fields), n) if n > 0 else np.empty(n, np.dtype(fields))
                if len(points) != n:
                    raise ValueError(f"it holds {len(points)} of {n} points")
                return points
            if words[:2] == ["element", "vertex"]:
                n = int(words[2])
            elif words[:1] == ["property"]:
                fields.append((words[2].removeprefix("scalar_"), _PLY_TYPES[words[1]]))
    raise ValueError("its header has no end")


def _exr_header(data: bytes):
    if data[:4] != b"\x76\x2f\x31\x01" or data[5] & 0x1A:
        raise ValueError("no EXR file of scan lines")
    at, found = 8, {}
    while data[at]:
        end = data.index(b"\0", at)
        key = data[at:end].decode()
        end_type = data.index(b"\0", end + 1)
        size = struct.unpack_from("<I", data, end_type + 1)[0]
        found[key] = data[end_type + 5:end_type + 5 + size]
        at = end_type + 5 + size
    return found, at + 1


def _exr_channels(block: bytes):
    channels, at = [], 0
    while block[at]:
        end = block.index(b"\0", at)
        kind = struct.unpack_from("<i", block, end + 1)[0]
        channels.append((block[at:end].decode(), {0: "<u4", 1: "<f2", 2: "<f4"}[kind]))
        at = end + 17
    return channels


def _exr_unpacked(data: bytes, size: int) -> bytes:
    """Undoes ZIP compression: inflate, add up the differences, interleave the two halves."""
    if len(data) == size:
        return data
    unpacked = zlib.decompressobj().decompress(data, size)  # no more than that, whatever the file holds
    if len(unpacked) != size:
        raise ValueError("a block is too short")
    packed = np.frombuffer(unpacked, np.uint8).astype(np.int64)
    packed[1:] -= 128
    summed = np.cumsum(packed).astype(np.uint8)
    out = np.empty(size, np.uint8)
    half = (size + 1) // 2
    out[0::2], out[1::2] = summed[:half], summed[half:]
    return out.tobytes()


@_reader("an EXR file")
def read_exr(path: PathLike) -> Dict[str, np.ndarray]:
    """Returns the channels of an EXR file of the program, e.g. phase_CAM.exr, by name: arrays (height, width).

    Channels of phase_CAM.exr (docs/formats/results.md): wrapped_x_13 (rad), column_px (px), amplitude_dn, mean_dn
    (DN), sigma_rad (rad); NaN where invalid. Uncompressed and ZIP files can be read.
    """
    with open(path, "rb") as file:
        data = file.read()
    header, at = _exr_header(data)
    rows_of = {0: 1, 2: 1, 3: 16}
    compression = header["compression"][0]
    if compression not in rows_of:
        raise ValueError(f"compression {compression} is not one that fringetwin writes")
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    channels = _exr_channels(header["channels"])
    row_bytes = sum(width * np.dtype(kind).itemsize for _, kind in channels)
    if width < 1 or height < 1 or height * row_bytes > 1032 * len(data):  # zlib packs no byte into less
        raise ValueError(f"{width} x {height} pixels are not in it")
    out = {name: np.empty((height, width), kind) for name, kind in channels}
    n_blocks = -(-height // rows_of[compression])
    for offset in struct.unpack_from(f"<{n_blocks}Q", data, at):
        y, size = struct.unpack_from("<2i", data, offset)
        rows = min(rows_of[compression], y1 - y + 1)
        if y < y0 or size < 0:
            raise ValueError(f"a block is for row {y}")
        block, used = _exr_unpacked(data[offset + 8:offset + 8 + size], rows * row_bytes), 0
        for row in range(y - y0, y - y0 + rows):
            for name, kind in channels:
                out[name][row] = np.frombuffer(block, kind, width, used)
                used += width * np.dtype(kind).itemsize
    return out


@_reader("a study.db", "study.db")
def read_study(path: PathLike) -> Dict[str, List[Dict[str, Any]]]:
    """Returns the tables of a study.db (or of the one in a folder) by name, each a list of rows as dicts.

    pandas.DataFrame(read_study(DIR)["points"]) makes a frame of the points: id, seed, status, reason, seconds (s), traced,
    version, host, finished_at, digest, and as JSON texts settings (TOML by path of the key) and results (numbers by name). The
    study.csv beside it has each setting and each number as a column of its own. The file is opened read-only.
    """
    if not os.path.isfile(path):
        raise FileNotFoundError(path)
    database = sqlite3.connect(f"file:{urllib.parse.quote(os.path.abspath(path))}?mode=ro", uri=True)
    try:
        database.row_factory = sqlite3.Row
        names = [row[0] for row in database.execute("SELECT name FROM sqlite_master WHERE type = 'table'")]
        return {name: [dict(row) for row in database.execute(f'SELECT * FROM "{name}"')] for name in names}
    finally:
        database.close()
