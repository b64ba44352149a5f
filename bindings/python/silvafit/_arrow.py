# SPDX-License-Identifier: MIT
"""Columns of objects with ``__arrow_c_stream__`` (polars, pyarrow, DuckDB) by Arrow's C data interface.

Source: https://arrow.apache.org/docs/format/CDataInterface.html, CStreamInterface.html, Columnar.html.
"""
from __future__ import annotations

import ctypes
import functools
from typing import Any, Callable, Collection, Dict, List, Optional, Tuple

import numpy as np


class Schema(ctypes.Structure):
    """struct ArrowSchema."""


class Array(ctypes.Structure):
    """struct ArrowArray."""


class Stream(ctypes.Structure):
    """struct ArrowArrayStream."""


def _children(kind: Any) -> List[Tuple[str, Any]]:
    """The common end of both structures."""
    return [("children", ctypes.POINTER(ctypes.POINTER(kind))), ("dictionary", ctypes.POINTER(kind)),
            ("release", ctypes.CFUNCTYPE(None, ctypes.POINTER(kind))), ("private_data", ctypes.c_void_p)]


def _getter(result: Any) -> Any:
    return ctypes.CFUNCTYPE(ctypes.c_int, ctypes.POINTER(Stream), ctypes.POINTER(result))


Schema._fields_ = [("format", ctypes.c_char_p), ("name", ctypes.c_char_p), ("metadata", ctypes.c_void_p),
                   ("flags", ctypes.c_int64), ("n_children", ctypes.c_int64), *_children(Schema)]
Array._fields_ = [*((name, ctypes.c_int64) for name in ("length", "null_count", "offset", "n_buffers", "n_children")),
                  ("buffers", ctypes.POINTER(ctypes.c_void_p)), *_children(Array)]
Stream._fields_ = [("get_schema", _getter(Schema)), ("get_next", _getter(Array)),
                   ("get_last_error", ctypes.CFUNCTYPE(ctypes.c_char_p, ctypes.POINTER(Stream))),
                   ("release", ctypes.CFUNCTYPE(None, ctypes.POINTER(Stream))), ("private_data", ctypes.c_void_p)]

_NUMBERS = {
    "c": np.int8, "C": np.uint8, "s": np.int16, "S": np.uint16, "i": np.int32, "I": np.uint32,
    "l": np.int64, "L": np.uint64, "e": np.float16, "f": np.float32, "g": np.float64,
}
_TIME_UNITS = {"s": "s", "m": "ms", "u": "us", "n": "ns"}


def _buffer(array: Array, number: int, dtype: Any, count: int) -> np.ndarray:
    """A view of the first values of a buffer, which lives as long as the array."""
    address = array.buffers[number]
    if not address or count == 0:
        return np.zeros(count, dtype)
    size = int(np.dtype(dtype).itemsize) * count
    return np.frombuffer(memoryview((ctypes.c_char * size).from_address(address)), dtype)


def _bits(array: Array, number: int) -> np.ndarray:
    end = array.offset + array.length
    packed = _buffer(array, number, np.uint8, (end + 7) // 8)
    return np.unpackbits(packed, bitorder="little")[array.offset:end].astype(bool)


def _missing(array: Array) -> Optional[np.ndarray]:
    """Which values are missing; None: none."""
    if array.null_count == 0 or array.n_buffers == 0 or not array.buffers[0]:
        return None
    return ~_bits(array, 0)


def _with_missing(values: np.ndarray, array: Array, missing: Any) -> np.ndarray:
    """Values, with the one for missing values in their places."""
    places = _missing(array)
    if places is not None:
        values = values.astype(np.float64) if isinstance(missing, float) else values
        values[places] = missing
    return values


def _fixed_width(array: Array, dtype: Any) -> np.ndarray:
    """A copy of the values."""
    return _buffer(array, 1, dtype, array.offset + array.length)[array.offset:].copy()


def _objects(values: List[Any], array: Array) -> np.ndarray:
    result = np.empty(len(values), object)
    result[:] = values
    return _with_missing(result, array, None)


def _texts(array: Array, offset_type: Any) -> np.ndarray:
    ends = _buffer(array, 1, offset_type, array.offset + array.length + 1)[array.offset:]
    last = int(ends[-1]) if len(ends) else 0
    data = ctypes.string_at(array.buffers[2], last) if last else b""
    return _objects([data[a:b].decode() for a, b in zip(ends[:-1].tolist(), ends[1:].tolist())], array)


_VIEW = np.dtype([("length", "<i4"), ("inline", "V12")])
_OUTSIDE = np.dtype([("prefix", "V4"), ("buffer", "<i4"), ("offset", "<i4")])


def _text_views(array: Array) -> np.ndarray:
    """Strings as views: up to 12 bytes inline, longer ones in the buffers after the views."""
    views = _fixed_width(array, _VIEW)
    missing = _missing(array)
    texts: List[Optional[str]] = []
    for row, length in enumerate(views["length"].tolist()):
        if missing is not None and missing[row]:
            texts.append(None)
            continue
        inline = views["inline"][row].tobytes()
        if length <= 12:
            texts.append(inline[:length].decode())
            continue
        place = np.frombuffer(inline, _OUTSIDE)[0]
        address = array.buffers[2 + int(place["buffer"])] + int(place["offset"])
        texts.append(ctypes.string_at(address, length).decode())
    return _objects(texts, array)


def _decimals(array: Array, scale: int) -> np.ndarray:
    halves = _fixed_width(array, np.dtype([("low", "<u8"), ("high", "<i8")]))
    return _with_missing((halves["high"].astype(np.float64) * 2.0**64 + halves["low"]) / 10.0**scale, array, np.nan)


def _times(array: Array, width: Any, unit: str) -> np.ndarray:
    return _with_missing(_fixed_width(array, width).astype(np.int64).astype(f"datetime64[{unit}]"), array, np.datetime64("NaT"))


def _reader(schema: Schema) -> Optional[Callable[[Array], np.ndarray]]:
    """How arrays of a type are read; None: the type is no column of numbers or text."""
    if schema.dictionary:
        index_type = _NUMBERS[schema.format.decode()]
        value_reader = _reader(schema.dictionary.contents)
        if value_reader is None:
            return None
        return functools.partial(_dictionary, index_type=index_type, value_reader=value_reader)
    kind = schema.format.decode()
    if kind in _NUMBERS:
        return lambda array: _with_missing(_fixed_width(array, _NUMBERS[kind]), array, np.nan)
    if kind.startswith("d:"):
        parts = kind[2:].split(",")
        if len(parts) == 3 and parts[2] != "128":
            return None
        return lambda array: _decimals(array, int(parts[1]))
    if kind.startswith("ts") and kind[2] in _TIME_UNITS:
        return lambda array: _times(array, np.int64, _TIME_UNITS[kind[2]])
    return {
        "b": lambda array: _with_missing(_bits(array, 1).astype(np.float64), array, np.nan),
        "n": lambda array: np.full(array.length, np.nan),
        "u": lambda array: _texts(array, np.int32),
        "U": lambda array: _texts(array, np.int64),
        "vu": _text_views,
        "tdD": lambda array: _times(array, np.int32, "D"),
        "tdm": lambda array: _times(array, np.int64, "ms"),
    }.get(kind)


def _dictionary(array: Array, index_type: Any, value_reader: Callable[[Array], np.ndarray]) -> np.ndarray:
    values = value_reader(array.dictionary.contents)
    codes = _with_missing(_fixed_width(array, index_type).astype(np.int64), array, -1)
    filled = np.empty(len(values) + 1, object)
    filled[:-1] = values
    filled[-1] = None
    return filled[codes]


def read_stream(
    data: Any, wanted: Optional[Callable[[List[str]], Collection[str]]] = None
) -> Tuple[List[str], Dict[str, np.ndarray], int]:
    """The names of all columns of a stream, the values of those that are wanted, and the number of rows.

    Parameters
    ----------
    data : object
        With ``__arrow_c_stream__``.
    wanted : callable or None
        Gets the names and returns those to read; None: all whose type can be read.

    Returns
    -------
    (list of str, dict of str to numpy.ndarray, int)
        Numbers with NaN where missing, text as objects with None.
    """
    capsule = data.__arrow_c_stream__()
    address = ctypes.pythonapi.PyCapsule_GetPointer
    address.restype = ctypes.c_void_p
    address.argtypes = [ctypes.py_object, ctypes.c_char_p]
    # The capsule owns the stream and releases it when it goes.
    stream = Stream.from_address(address(capsule, b"arrow_array_stream"))
    schema = Schema()
    _check(stream, stream.get_schema(ctypes.byref(stream), ctypes.byref(schema)))
    try:
        if schema.format != b"+s":
            raise TypeError("an Arrow stream of tables is needed (a struct of columns), not "
                            f"one of type {schema.format.decode()!r}")
        columns = [schema.children[k].contents for k in range(schema.n_children)]
        names = [(child.name or b"").decode() for child in columns]
        chosen = None if wanted is None else set(wanted(names))
        places = {name: place for place, name in enumerate(names) if chosen is None or name in chosen}
        readers = {name: _reader(columns[place]) for name, place in places.items()}
        for name, reader in list(readers.items()):
            if reader is None and wanted is None:
                del readers[name]
            elif reader is None:
                kind = columns[places[name]].format.decode()
                raise TypeError(f"{name}: the Arrow type {kind!r} is neither numbers nor text; "
                                "convert the column first")
        chunks, rows = _read_chunks(stream, {name: places[name] for name in readers}, readers)
        return names, {name: _joined(parts) for name, parts in chunks.items()}, rows
    finally:
        schema.release(ctypes.byref(schema))


def _check(stream: Stream, code: int) -> None:
    if code != 0:
        reason = stream.get_last_error(ctypes.byref(stream))
        raise RuntimeError(f"the Arrow stream failed: {(reason or b'no reason given').decode()}")


def _read_chunks(stream: Stream, places: Dict[str, int], readers: Dict[str, Any]) -> Tuple[Dict[str, list], int]:
    chunks: Dict[str, list] = {name: [] for name in places}
    rows = 0
    while True:
        batch = Array()
        _check(stream, stream.get_next(ctypes.byref(stream), ctypes.byref(batch)))
        if not batch.release:
            return chunks, rows
        rows += batch.length
        try:
            first, end = batch.offset, batch.offset + batch.length
            for name, place in places.items():
                # A slice of the batch is one of all of its columns.
                chunks[name].append(readers[name](batch.children[place].contents)[first:end])
        finally:
            batch.release(ctypes.byref(batch))


def _joined(parts: list) -> np.ndarray:
    return np.concatenate(parts) if parts else np.empty(0)
