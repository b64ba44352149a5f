# SPDX-License-Identifier: MIT
"""Data of any kind as tables of the libraries, and tables as DataFrames."""
from __future__ import annotations

import dataclasses
import logging
import os
from typing import Any, Callable, Collection, Dict, Iterable, List, Mapping, Optional, Tuple, Union

import numpy as np
import pandas as pd

from . import _arrow, _core

#: Integers beyond this may be no exact doubles; columns of such can only be labels.
_LARGEST_EXACT = 2**53

Choice = Callable[[List[str]], Collection[str]]


@dataclasses.dataclass
class Frame:
    """A table, and what pandas knows of it."""

    table: Any
    index: Optional[pd.Index]
    names: List[str]  #: of all columns of the data, also those that the table lacks
    labels: Dict[str, Any]  #: how texts of label columns become values again: int, float, bool, or values by text

    @property
    def rows(self) -> pd.Index:
        return pd.RangeIndex(self.table.rows) if self.index is None else self.index

    def aligned(self, values: Any, places: Any, name: Optional[str]) -> pd.Series:
        """Values of some rows as a series of all rows, NaN elsewhere."""
        result = np.full(self.table.rows, np.nan)
        result[np.asarray(places, dtype=np.intp)] = values
        return pd.Series(result, index=self.rows, name=name)

    def state(self) -> dict:
        """For pickle."""
        return {"rows": self.table.rows, "columns": self.table.columns(), "index": self.index,
                "names": self.names, "labels": self.labels}

    @classmethod
    def restored(cls, state: dict) -> "Frame":
        table = _core.table(state["rows"], state["columns"])
        return cls(table, state["index"], state["names"], state["labels"])


def _labels_of(values: Any, texts: List[str]) -> Optional[Dict[str, Any]]:
    """The values that texts stand for, where these are not the texts themselves."""
    pairs = {text: value for text, value in zip(texts, values) if not isinstance(value, str)}
    return pairs or None


def _text_column(codes: Any, values: Any) -> Tuple[Any, Any]:
    texts = [value if isinstance(value, str) else text_of(value) for value in values]
    return (np.asarray(codes, dtype=np.int32), texts), _labels_of(values, texts)


def text_of(value: Any) -> str:
    """A label; whole numbers have no decimals, and midnights are dates."""
    if isinstance(value, bytes):
        return value.decode()
    if isinstance(value, pd.Timestamp):
        return str(value.date() if value == value.normalize() and value.tz is None else value)
    if isinstance(value, (float, np.floating)) and float(value).is_integer():
        return str(int(value))
    return str(value)


def _integers(values: np.ndarray) -> Tuple[Any, Any]:
    if values.size and _needs_labels((int(values.min()), int(values.max())), values):
        return _labels(values)
    return values.astype(np.float64), int


def _needs_labels(extremes: Iterable[int], values: Iterable[Any]) -> bool:
    """Whether some integers are no doubles, such as 2**53 + 1."""
    return any(abs(value) > _LARGEST_EXACT for value in extremes) and any(int(float(value)) != int(value) for value in values)


def has_long_integers(restore: Any) -> bool:
    """Whether a column consists of labels because its integers are no doubles."""
    return isinstance(restore, dict) and any(isinstance(value, (int, np.integer)) and int(float(value)) != int(value) for value in restore.values())


def _labels(values: Any) -> Tuple[Any, Any]:
    codes, unique = pd.factorize(values)
    return _text_column(codes, list(unique))


def _objects(values: Any) -> Tuple[Any, Any]:
    """Numbers among objects are numbers if there is nothing else."""
    values = np.asarray(values, dtype=object)
    texts = _core.text(values)
    if texts is not None:
        return texts, None
    # An empty text is a missing value, as in files.
    values = np.array(values)
    values[[isinstance(value, str) and not value.strip() for value in values]] = None
    kind = pd.api.types.infer_dtype(values, skipna=True)
    if kind == "integer" and _needs_labels(values[~pd.isna(values)], values[~pd.isna(values)]):
        return _labels(values)
    if kind in ("integer", "floating", "mixed-integer-float", "decimal", "boolean"):
        numbers = pd.to_numeric(pd.Series(values).astype(object), errors="coerce")
        return numbers.to_numpy(np.float64, na_value=np.nan), {"integer": int, "boolean": bool}.get(kind, float)
    if kind == "empty":
        return np.full(len(values), np.nan), None
    return _labels(values)


def _column(name: str, values: Any) -> Tuple[Any, Any]:
    """A column as numbers or (codes, texts), and how its labels become values again."""
    if isinstance(values, np.ma.MaskedArray):
        values = _without_mask(values)
    if not isinstance(values, (pd.Series, pd.Index, pd.api.extensions.ExtensionArray)):
        values = np.asarray(values)
        if values.ndim != 1:
            raise TypeError(f"{name}: a column has one dimension, this one has {values.ndim}")
        if values.dtype.kind not in "fiubmMOUS":
            raise TypeError(f"{name}: values of type {values.dtype} are neither numbers nor text")
    try:
        return _converted(pd.Series(values, copy=False))
    except (TypeError, ValueError) as error:
        raise TypeError(f"{name}: the values are neither numbers nor text ({error})") from error


def _without_mask(values: Any) -> np.ndarray:
    """Masked values are missing."""
    mask = np.ma.getmaskarray(values)
    if not mask.any():
        return values.data
    plain = np.array(values.data, dtype=object)
    plain[mask] = None
    return plain


def _converted(values: pd.Series) -> Tuple[Any, Any]:
    kinds = pd.api.types
    dtype = getattr(values.dtype, "subtype", values.dtype)  # of sparse columns
    if isinstance(dtype, pd.CategoricalDtype):
        return _text_column(values.cat.codes.to_numpy(), list(values.cat.categories))
    if kinds.is_bool_dtype(dtype):
        return values.to_numpy(np.float64, na_value=np.nan), bool
    if kinds.is_integer_dtype(dtype):
        return _objects(values.to_numpy(object, na_value=None)) if values.isna().any() else _integers(values.to_numpy())
    if kinds.is_float_dtype(dtype):
        return values.to_numpy() if isinstance(dtype, np.dtype) else values.to_numpy(np.float64, na_value=np.nan), float
    if kinds.is_datetime64_any_dtype(dtype) or kinds.is_timedelta64_dtype(dtype):
        return _labels(values)
    is_text = not isinstance(dtype, np.dtype) and kinds.is_string_dtype(dtype)
    return _objects(values.to_numpy(object, na_value=None) if is_text else np.asarray(values, dtype=object))


Columns = Tuple[List[str], Dict[str, Any], Optional[pd.Index], int]


def _named_columns(data: Any, choose: Optional[Choice]) -> Columns:
    """Names of all columns, those that are chosen, the index, and the number of rows."""
    if isinstance(data, pd.DataFrame):
        data = _with_positions(data)
        return _columns_of_frame(data, choose)
    if hasattr(data, "__arrow_c_stream__"):
        names, columns, rows = _arrow.read_stream(data, choose)
        return names, columns, None, rows
    if isinstance(data, np.ndarray) and data.dtype.names:
        data = {name: data[name] for name in data.dtype.names}
    if isinstance(data, Mapping):
        names = [str(name) for name in data]
        chosen = names if choose is None else choose(names)
        index = _common_index(data)
        rows = _length(next(iter(data.items()), ("", ())))
        return names, {str(name): data[name] for name in data if str(name) in chosen}, index, rows
    if isinstance(data, (str, os.PathLike)):
        raise TypeError("data are a table here, not a file; read it first, for example by pandas.read_csv")
    raise TypeError(
        f"data of type {type(data).__name__} are no table; give a pandas DataFrame, a dict of arrays, or an "
        "object with __arrow_c_stream__ (polars, pyarrow, DuckDB)")


def _common_index(data: Mapping) -> Optional[pd.Index]:
    """Rows of a dict are those of the same place, so that Series cannot have different indices."""
    series = [(name, column) for name, column in data.items() if isinstance(column, pd.Series)]
    for name, column in series[1:]:
        if not column.index.equals(series[0][1].index):
            raise TypeError(f"{name}: the index is not that of {series[0][0]}; give a DataFrame of both, "
                            "pd.DataFrame(data), or their values without an index")
    return series[0][1].index if series else None


def _length(item: Tuple[Any, Any]) -> int:
    name, column = item
    try:
        return len(column)
    except TypeError:
        raise TypeError(f"{name}: one value is no column; give a value for each row") from None


def _columns_of_frame(data: pd.DataFrame, choose: Optional[Choice]) -> Columns:
    """The same of a DataFrame, where named levels of the index count as columns."""
    columns = [str(name) for name in data.columns]
    if len(set(columns)) < len(columns):
        twice = next(name for name in columns if columns.count(name) > 1)
        raise TypeError(f"{twice}: two columns have this name")
    levels = [name for name in data.index.names if isinstance(name, str) and name not in columns]
    names = columns + levels
    chosen = names if choose is None else choose(names)
    keep = {name: data.iloc[:, place] for place, name in enumerate(columns)
            if name in chosen and not _is_geometry(data.dtypes.iloc[place])}
    keep.update({name: data.index.get_level_values(name) for name in levels if name in chosen})
    return names, keep, data.index, len(data)


def _is_geometry(dtype: Any) -> bool:
    return str(dtype) == "geometry"


def has_geometry(data: pd.DataFrame) -> bool:
    """Whether it is a GeoDataFrame with an active geometry."""
    return any(_is_geometry(dtype) for dtype in data.dtypes) and hasattr(data, "to_crs") and hasattr(data, "geometry")


def _with_positions(data: pd.DataFrame) -> pd.DataFrame:
    """Points of geopandas give the columns x and y; others of these names become x_column and y_column, as for layers."""
    if not has_geometry(data):
        return data
    points = data.geometry
    if not (points.geom_type.dropna() == "Point").all():
        return data
    check_projected(points)
    positions = {"x": points.x, "y": points.y}
    for name, values in positions.items():
        if name in data.columns and not np.allclose(pd.to_numeric(data[name], errors="coerce"), values, rtol=0.0, atol=1e-3, equal_nan=True):
            logging.getLogger("silvafit").info("the column %s differs from the positions of the points; the points are used, and the "
                                               "column is called %s_column", name, name)
            data = data.rename(columns={name: f"{name}_column"})
    return data.assign(**positions)


def check_projected(shapes: Any) -> None:
    """Positions are meters. Files without a reference system are often read as degrees, which reach to 180."""
    from ._errors import UsageError

    if shapes.crs is None or shapes.empty:
        return
    if not shapes.crs.is_geographic:
        unit = shapes.crs.axis_info[0]
        if unit.unit_conversion_factor != 1.0:
            raise UsageError(f"the coordinates are in the unit {unit.unit_name}, but meters are needed; transform them first, for "
                             "example by trees.to_crs(trees.estimate_utm_crs())", column="geometry")
        return
    west, south, east, north = shapes.total_bounds
    if max(abs(west), abs(east)) <= 180.0 and max(abs(south), abs(north)) <= 90.0:
        raise UsageError("the coordinates are degrees, but meters are needed; project them first, for "
                         "example by trees.to_crs(trees.estimate_utm_crs())", column="geometry")


def frame_of(data: Any, choose: Optional[Choice] = None) -> Frame:
    """A table of the columns that are chosen.

    Parameters
    ----------
    data : DataFrame, dict of arrays, or object with ``__arrow_c_stream__``
    choose : callable, optional
        Gets all names, returns those to convert; without, all.
    """
    if isinstance(data, Frame):
        return data
    names, columns, index, rows = _named_columns(data, choose)
    converted = []
    labels = {}
    for name, values in columns.items():
        column, restore = _column(name, values)
        count = len(column[0]) if isinstance(column, tuple) else len(column)
        if count != rows:
            raise TypeError(f"{name}: the column has {count} values, others have {rows}")
        converted.append((name, column))
        if restore is not None:
            labels[name] = restore
    return Frame(_core.table(rows, converted), index, names, labels)


def source_of(data: Any) -> Union[str, Frame]:
    """A path, or a table."""
    return os.fspath(data) if isinstance(data, (str, os.PathLike)) else frame_of(data)


def _with_type(values: np.ndarray, restore: Any) -> np.ndarray:
    """Numbers as whole numbers or booleans, if all of them have values."""
    if restore in (int, bool) and not np.isnan(values).any():
        return values.astype(np.int64 if restore is int else bool)
    return np.array(values)


def restored_labels(texts: List[str], restore: Any) -> list:
    """Labels with the types that their column has; other texts, such as that of all groups, remain."""
    def value(text: str) -> Any:
        if isinstance(restore, dict):
            return restore.get(text, text)
        try:
            return restore(float(text))
        except ValueError:
            return text

    return texts if restore is None else [value(text) for text in texts]


def data_frame(table: Any, index: Optional[pd.Index], labels: Dict[str, Any], are_data: bool = False) -> pd.DataFrame:
    """A table of the libraries as a DataFrame.

    Parameters
    ----------
    table : Table
    index : Index, optional
    labels : dict
        How columns of labels become those of the data again: numbers, booleans, and categories of other values.
    are_data : bool
        Numbers have the types of the data, too.
    """
    columns = {}
    for name, values in table.columns():
        if isinstance(values, tuple):
            codes, texts = values
            restore = labels.get(name)
            with_none = np.empty(len(texts) + 1, object)
            for place, label in enumerate(restored_labels(texts, restore)):
                with_none[place] = label
            labels_of_rows = pd.Series(with_none[codes], dtype=object)
            columns[name] = (labels_of_rows if restore is None else labels_of_rows.infer_objects()).array
        else:
            columns[name] = _with_type(values, labels.get(name) if are_data else None)
    return pd.DataFrame(columns, index=index)
