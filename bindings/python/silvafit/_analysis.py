# SPDX-License-Identifier: MIT
"""Analyses of the libraries by their names: arguments as JSON, results as tables."""
from __future__ import annotations

import dataclasses
import json
import os
from typing import Any, Dict, List, Optional, Tuple

import numpy as np
import pandas as pd

from . import _core, _location
from ._data import data_frame
from ._errors import UsageError


@dataclasses.dataclass
class Result:
    """Tables by name, the rows of the input that the first one has, further results, and fits by label."""

    tables: Dict[str, Any]
    rows: np.ndarray
    json: dict
    fits: List[Tuple[str, Any]]
    library: Any

    def frame(self, name: str, index: Optional[pd.Index] = None) -> pd.DataFrame:
        return data_frame(self.tables[name], index)


def _plain(value: Any) -> Any:
    """Values of numpy and pandas, and paths, as JSON has them."""
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if hasattr(value, "keys"):
        return {key: value[key] for key in value.keys()}
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError


def _text_of(name: str, value: Any) -> str:
    try:
        return f"{json.dumps(name)}: {json.dumps(value, default=_plain, allow_nan=False)}"
    except (TypeError, ValueError):
        raise UsageError(f"{value!r} is a value of the wrong type", column=name) from None


def analysis(
    name: str, table: Any = None, *, fits: Any = (), library: Any = None, plots: Any = None, listener: Any = None,
    catalogue: Any = None, **arguments: Any,
) -> Result:
    """Run an analysis (study/analyses.hpp).

    Parameters
    ----------
    table, plots : Table, path or None
    fits, library, catalogue : objects of the extension
    listener : Listener, optional
    **arguments
        None is an argument that is not given.
    """
    text = "{" + ", ".join(_text_of(key, value) for key, value in arguments.items() if value is not None) + "}"
    found = _core.analysis(name, text, table, plots, list(fits), library, str(_location.data_directory()), catalogue, listener)
    return Result(found["tables"], np.asarray(found["rows"], dtype=np.intp), json.loads(found["json"] or "{}"),
                  found["fits"], found["library"])
