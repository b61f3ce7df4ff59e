# SPDX-License-Identifier: Apache-2.0
"""fringetwin: a digital twin of fringe-projection rigs, as the command line has it (docs/PYTHON.md).

Lengths are mm, angles and phases rad, image coordinates px with (0, 0) the centre of the top-left pixel, gray values
DN. Images are float32 arrays (height, width). Long calls release Python's lock, and Ctrl-C ends them.
"""
import json
import os
from typing import Any, Dict, Mapping, Optional, Sequence, Union

import numpy as np

from ._core import (CameraImages, Captures, Decode, Measurement as _Measurement, Points, Rendering, StoredImages,
                    Twin as _Twin, UnknownKey, UserError, captures_from as _captures_from, cosim as _cosim, decode,
                    fit_sphere, load_captures, measure as _measure, read_captures, set_quiet, triangulate, version)
from ._readers import PathLike, Run, read_exr, read_points, read_result, read_study
from ._toml import toml_text as _toml_text

__all__ = ["CameraImages", "Captures", "Decode", "Measurement", "Points", "Rendering", "Run", "StoredImages", "Twin",
           "UnknownKey", "UserError", "cosim", "decode", "fit_sphere", "load_captures", "measure", "read_captures", "read_exr",
           "read_points", "read_result", "read_study", "set_quiet", "triangulate", "version"]
__version__ = version().split()[0]


class Twin(_Twin):
    """A twin.toml, or the folder that holds it, with settings in the place of some of its keys.

    The file stays as it is. Everything that is wrong with it, or with a setting, is a UserError.
    """

    def set(self, key: Union[str, Mapping[str, Any]], value: Any = None) -> "Twin":
        """Puts a value at the path of a key, as a study varies it, or several at once: set({key: value, ...}).

        Paths: "projector.blur_px", "camera.left.sensor.bit_depth", "object.sphere.radius_mm",
        "fringes.pitches_px[0]"; docs/formats/twin.md has the keys with their units. Refused settings change nothing.
        """
        values = {key: value} if isinstance(key, str) else key
        self._set({path: _toml_text(one) for path, one in values.items()})
        return self


class Measurement:
    """What one capture set gave.

    result: the content of result.json (numbers that are not finite are None); fits: its rows; points: Points;
    decodes: Decode of each camera, by name; warnings: sentences; timing_s: wall time by stage, s.
    """

    def __init__(self, core: _Measurement) -> None:
        self._core = core
        self.result: Dict[str, Any] = json.loads(core._result_json())
        self.fits = self.result["fits"]
        self.points = core.points
        self.decodes = core.decodes
        self.warnings = core.warnings
        self.timing_s = core.timing_s

    def write(self, out: PathLike, *, npz: bool = False, figures: bool = False) -> Run:
        """Writes points.ply, phase_CAM.exr, report.html and result.json as `fringetwin measure --out` does.

        npz: also measured_CAM.npz; figures: also the plots of the page, figures/NAME.svg.
        """
        self._core._write(out, npz, figures)
        return Run(out)


def measure(twin: Twin, captures: Union[PathLike, Captures, Mapping[str, Sequence[np.ndarray]]], *,
            method_bias: bool = False, out: Optional[PathLike] = None) -> Measurement:
    """Measures a capture set: a folder with a capture.toml, Captures (of Twin.render(), without a copy), or a list of
    arrays (height, width), DN, by camera, in the order of the sequence.

    method_bias: render the twin once, and state what the method itself adds to each fit. out: write there, too.
    """
    if isinstance(captures, (str, os.PathLike)):
        captures = load_captures(twin, captures)
    elif not isinstance(captures, Captures):
        if isinstance(captures, StoredImages) or any(isinstance(captures[name], StoredImages) for name in captures):
            raise TypeError("images of read_captures() are as they are stored: measure a folder, or what "
                            "load_captures(twin, folder) returns")
        captures = _captures_from(twin, {name: list(captures[name]) for name in captures})
    measurement = Measurement(_measure(twin, captures, method_bias))
    if out is not None:
        measurement.write(out)
    return measurement


def cosim(twin: Union[PathLike, Twin], out: PathLike, *, refine: Sequence[str] = (), steps: str = "",
          hold_out: int = 0, hold_out_by: str = "", radiance: bool = False, npz: bool = False, figures: bool = False,
          samples: Optional[int] = None, sampler: Optional[str] = None, phase_error_rad: Optional[float] = None,
          gray_error: Optional[float] = None, seed: Optional[int] = None, device: str = "") -> Run:
    """Does the main job: renders, measures both sides, compares and writes `out` as `fringetwin cosim` does.

    The options are those of the command line (phase_error_rad: --phase-error) without --into and --limits. Without a
    seed it is 0, or 1 where the real images were rendered with 0. Returns the folder with the content of its result.json.
    """
    _cosim(twin if isinstance(twin, Twin) else Twin(twin), out, refine=list(refine), steps=steps, hold_out=hold_out,
           hold_out_by=hold_out_by, radiance=radiance, npz=npz, figures=figures, samples=samples, sampler=sampler,
           phase_error_rad=phase_error_rad, gray_error=gray_error, seed=seed, device=device)
    return Run(out)
