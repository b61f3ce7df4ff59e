# SPDX-License-Identifier: Apache-2.0
"""Values of Python as TOML text, as the settings of a twin are."""
import json
import math
import os


def toml_text(value):
    """Returns a bool, a number, a text, a path, or a list of these as TOML."""
    if hasattr(value, "tolist"):  # numpy's arrays and numbers
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return repr(value) if math.isfinite(value) else str(value)  # TOML spells inf and nan alike
    if isinstance(value, (str, os.PathLike)):
        return json.dumps(os.fspath(value), ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(toml_text(one) for one in value) + "]"
    raise TypeError(f"a {type(value).__name__} is no value of a twin.toml")
