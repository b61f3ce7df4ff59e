#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes board.ply, the sheet of paper as a smooth surface, from the points that `fringetwin measure` finds.

    fringetwin measure datasets/kamino-procam-board/twin.toml --captures datasets/kamino-procam-board --out DIR
    datasets/kamino-procam-board/make_board.py DIR/points.ply datasets/kamino-procam-board/board.ply

A Gray code alone gives each pixel a whole word, so a single depth is 3 mm off. Around each node, every 25 px of the image, a
quadratic in the inverse depth is fitted to the points within 50 px, outliers (black squares, tape) left out: 10,000 points make
0.03 mm of it. A plane does not do: the sheet bulges by 3 mm in one corner.
"""
import sys

import numpy as np

LEFT, RIGHT, TOP, BOTTOM = 204, 1086, 168, 798  # of the sheet in the image, px
STEP, RADIUS = 25, 50


def read_points(path):
    """Returns the vertices of a binary PLY as a structured array."""
    raw = open(path, "rb").read()
    end = raw.index(b"end_header\n") + 11
    properties = [line.split()[1:] for line in raw[:end].decode().splitlines() if line.startswith("property")]
    return np.frombuffer(raw, [(name.removeprefix("scalar_"), "<f8" if kind == "double" else "<f4")
                               for kind, name in properties], offset=end)


def fit_around(x, y, inverse_depth):
    """Returns the inverse depth of the surface at a pixel."""
    rows = slice(max(y - RADIUS, TOP), min(y + RADIUS, BOTTOM) + 1)
    columns = slice(max(x - RADIUS, LEFT), min(x + RADIUS, RIGHT) + 1)
    values = inverse_depth[rows, columns]
    v, u = np.mgrid[rows, columns]
    a, b = (u - x) / RADIUS, (v - y) / RADIUS
    terms = np.stack([np.ones_like(a), a, b, a * a, a * b, b * b], axis=-1)
    used = np.isfinite(values)
    for _ in range(5):
        fitted = np.linalg.lstsq(terms[used], values[used], rcond=None)[0]
        residual = values - terms @ fitted
        used = np.isfinite(values) & (np.abs(residual) < 3 * 1.4826 * np.median(np.abs(residual[used])))
    return fitted[0]


def main():
    points = read_points(sys.argv[1])
    u, v = (np.rint(points[name]).astype(int) for name in ("pixel_x", "pixel_y"))
    inverse_depth = np.full((1024, 1280), np.nan)
    inverse_depth[v, u] = 1 / points["z"]
    # the rays of the pixels from the points themselves: x/z and y/z are smooth over the image
    near = (np.abs(u - 640) < 500) & (np.abs(v - 512) < 400)
    s, t = (u - 640) / 500, (v - 512) / 400
    powers = [(i, j) for i in range(8) for j in range(8 - i)]
    terms = lambda p, q: np.stack([p**i * q**j for i, j in powers], axis=-1)
    rays = [np.linalg.lstsq(terms(s, t)[near][::7], (points[n] / points["z"])[near][::7], rcond=None)[0] for n in "xy"]
    columns, rows = np.arange(LEFT + 6, RIGHT - 4, STEP), np.arange(TOP + 6, BOTTOM - 4, STEP)
    with open(sys.argv[2], "w", encoding="ascii") as out:
        faces = 2 * (len(columns) - 1) * (len(rows) - 1)
        out.write(f"ply\nformat ascii 1.0\nelement vertex {len(columns) * len(rows)}\n"
                  "property float x\nproperty float y\nproperty float z\n"
                  f"element face {faces}\nproperty list uchar int vertex_indices\nend_header\n")
        for y in rows:
            for x in columns:
                z = 1 / fit_around(x, y, inverse_depth)
                at = terms(np.array((x - 640) / 500), np.array((y - 512) / 400))
                out.write(f"{at @ rays[0] * z:.3f} {at @ rays[1] * z:.3f} {z:.3f}\n")
        n = len(columns)
        for j in range(len(rows) - 1):
            for i in range(n - 1):
                a = j * n + i
                out.write(f"3 {a} {a + n} {a + n + 1}\n3 {a} {a + n + 1} {a + 1}\n")


main()
