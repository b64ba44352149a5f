# SPDX-License-Identifier: MIT
"""Analyses of the libraries by their names: arguments as JSON, results as tables."""
from __future__ import annotations

import contextlib
import dataclasses
import json
import os
from types import MappingProxyType
from typing import Any, Dict, Iterator, List, Mapping, Optional, Tuple, Union

import numpy as np
import pandas as pd

from . import _core, _location
from ._data import Frame, data_frame, has_long_integers
from ._errors import InputError, UsageError, located_in, warn, with_labels
from ._listener import Listener


@dataclasses.dataclass
class Result:
    """Tables by name, the rows of the input that the first one has, further results, and fits by label."""

    tables: Dict[str, Any]
    rows: np.ndarray
    json: dict
    fits: List[Tuple[str, Any]]
    library: Any
    labels: Dict[str, Any]  #: how labels become those of the data again, by column of the tables

    def frame(self, name: str, index: Optional[pd.Index] = None) -> pd.DataFrame:
        return data_frame(self.tables[name], index, self.labels)


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


@contextlib.contextmanager
def _explaining_labels(labels: Dict[str, Any]) -> Iterator[None]:
    """Says why a column of integers has no numbers."""
    try:
        yield
    except InputError as error:
        if has_long_integers(labels.get(error.column or "")):
            error.message = ("has integers beyond 2**53 that are no exact numbers, so that they can only be labels; for a measure "
                             "use astype(float)")
        raise


def analysis(
    name: str, data: Union[Frame, str, None] = None, *, fits: Any = (), library: Any = None, plots: Any = None,
    listener: Optional[Listener] = None, catalogue: Any = None, settings: Mapping[str, Any] = MappingProxyType({}), **arguments: Any,
) -> Result:
    """Run an analysis (study/analyses.hpp). Errors, notes and warnings name rows by the index of the data.

    Parameters
    ----------
    data : Frame, path or None
    plots : Table, path or None
    fits, library, catalogue : objects of the extension
    listener : Listener, optional
    settings : dict
        What a user gave under any names, which are none of the arguments of this function.
    **arguments
        None is an argument that is not given.
    """
    twice = settings.keys() & arguments.keys()
    if twice:
        raise UsageError("is an argument of the function, and no setting", column=min(twice))
    arguments.update(settings)
    table, index, labels = (data.table, data.rows, data.labels) if isinstance(data, Frame) else (data, None, {})
    if listener is not None:
        listener.index = index
    text = "{" + ", ".join(_text_of(key, value) for key, value in arguments.items() if value is not None) + "}"
    with located_in(index), _explaining_labels(labels):
        found = _core.analysis(name, text, table, plots, list(fits), library, str(_location.data_directory()), catalogue, listener)
    for warning in found["warnings"]:
        warn(with_labels(warning, index))
    sources = {column: labels[source] for column, source in found["label_columns"].items() if source in labels}
    return Result(found["tables"], np.asarray(found["rows"], dtype=np.intp), json.loads(found["json"] or "{}"),
                  found["fits"], found["library"], {**labels, **sources})
