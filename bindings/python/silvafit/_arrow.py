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


Schema._fields_ = [
    ("format", ctypes.c_char_p),
    ("name", ctypes.c_char_p),
    ("metadata", ctypes.c_void_p),
    ("flags", ctypes.c_int64),
    ("n_children", ctypes.c_int64),
    ("children", ctypes.POINTER(ctypes.POINTER(Schema))),
    ("dictionary", ctypes.POINTER(Schema)),
    ("release", ctypes.CFUNCTYPE(None, ctypes.POINTER(Schema))),
    ("private_data", ctypes.c_void_p),
]
Array._fields_ = [
    ("length", ctypes.c_int64),
    ("null_count", ctypes.c_int64),
    ("offset", ctypes.c_int64),
    ("n_buffers", ctypes.c_int64),
    ("n_children", ctypes.c_int64),
    ("buffers", ctypes.POINTER(ctypes.c_void_p)),
    ("children", ctypes.POINTER(ctypes.POINTER(Array))),
    ("dictionary", ctypes.POINTER(Array)),
    ("release", ctypes.CFUNCTYPE(None, ctypes.POINTER(Array))),
    ("private_data", ctypes.c_void_p),
]
Stream._fields_ = [
    ("get_schema", ctypes.CFUNCTYPE(ctypes.c_int, ctypes.POINTER(Stream), ctypes.POINTER(Schema))),
    ("get_next", ctypes.CFUNCTYPE(ctypes.c_int, ctypes.POINTER(Stream), ctypes.POINTER(Array))),
    ("get_last_error", ctypes.CFUNCTYPE(ctypes.c_char_p, ctypes.POINTER(Stream))),
    ("release", ctypes.CFUNCTYPE(None, ctypes.POINTER(Stream))),
    ("private_data", ctypes.c_void_p),
]

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


def _fixed_width(array: Array, dtype: Any) -> np.ndarray:
    return _buffer(array, 1, dtype, array.offset + array.length)[array.offset:]


def _numbers(array: Array, dtype: Any) -> np.ndarray:
    values = _fixed_width(array, dtype)
    missing = _missing(array)
    if missing is None:
        return values.copy()
    result = values.astype(np.float64)
    result[missing] = np.nan
    return result


def _with_none(values: List[Any], array: Array) -> np.ndarray:
    result = np.empty(len(values), object)
    result[:] = values
    missing = _missing(array)
    if missing is not None:
        result[missing] = None
    return result


def _booleans(array: Array) -> np.ndarray:
    values = _bits(array, 1).astype(np.float64)
    missing = _missing(array)
    if missing is not None:
        values[missing] = np.nan
    return values


def _texts(array: Array, offset_type: Any) -> np.ndarray:
    ends = _buffer(array, 1, offset_type, array.offset + array.length + 1)[array.offset:]
    last = int(ends[-1]) if len(ends) else 0
    data = ctypes.string_at(array.buffers[2], last) if last else b""
    return _with_none([data[a:b].decode() for a, b in zip(ends[:-1].tolist(), ends[1:].tolist())], array)


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
    return _with_none(texts, array)


def _decimals(array: Array, scale: int) -> np.ndarray:
    halves = _fixed_width(array, np.dtype([("low", "<u8"), ("high", "<i8")]))
    values = (halves["high"].astype(np.float64) * 2.0**64 + halves["low"]) / 10.0**scale
    missing = _missing(array)
    if missing is not None:
        values[missing] = np.nan
    return values


def _times(array: Array, width: Any, unit: str) -> np.ndarray:
    values = _fixed_width(array, width).astype(np.int64).astype(f"datetime64[{unit}]")
    missing = _missing(array)
    if missing is not None:
        values[missing] = np.datetime64("NaT")
    return values


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
        return lambda array: _numbers(array, _NUMBERS[kind])
    if kind.startswith("d:"):
        parts = kind[2:].split(",")
        if len(parts) == 3 and parts[2] != "128":
            return None
        return lambda array: _decimals(array, int(parts[1]))
    if kind.startswith("ts") and kind[2] in _TIME_UNITS:
        return lambda array: _times(array, np.int64, _TIME_UNITS[kind[2]])
    return {
        "b": _booleans,
        "n": lambda array: np.full(array.length, np.nan),
        "u": lambda array: _texts(array, np.int32),
        "U": lambda array: _texts(array, np.int64),
        "vu": _text_views,
        "tdD": lambda array: _times(array, np.int32, "D"),
        "tdm": lambda array: _times(array, np.int64, "ms"),
    }.get(kind)


def _dictionary(array: Array, index_type: Any, value_reader: Callable[[Array], np.ndarray]) -> np.ndarray:
    values = value_reader(array.dictionary.contents)
    missing = _missing(array)
    codes = _fixed_width(array, index_type).astype(np.int64)
    if missing is not None:
        codes[missing] = -1
    filled = np.empty(len(values) + 1, object)
    filled[:-1] = values
    filled[-1] = None
    return filled[codes]


def has_stream(data: Any) -> bool:
    """Whether an object offers its columns as an Arrow stream."""
    return hasattr(data, "__arrow_c_stream__")


class _Columns:
    """Chunks of the wanted columns of a stream."""

    def __init__(self, schema: Schema):
        if schema.format != b"+s":
            raise TypeError("an Arrow stream of tables is needed (a struct of columns), not "
                            f"one of type {schema.format.decode()!r}")
        self.schemas = [schema.children[k].contents for k in range(schema.n_children)]
        self.names = [(child.name or b"").decode() for child in self.schemas]

    def chosen(self, wanted: Optional[Collection[str]]) -> Dict[str, int]:
        return {name: place for place, name in enumerate(self.names) if wanted is None or name in wanted}


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
        columns = _Columns(schema)
        chosen = columns.chosen(None if wanted is None else set(wanted(columns.names)))
        readers = {name: _reader(columns.schemas[place]) for name, place in chosen.items()}
        if wanted is None:
            readers = {name: reader for name, reader in readers.items() if reader is not None}
        for name, reader in readers.items():
            if reader is None:
                kind = columns.schemas[chosen[name]].format.decode()
                raise TypeError(f"{name}: the Arrow type {kind!r} is neither numbers nor text; "
                                "convert the column first")
        chunks, rows = _read_chunks(stream, {name: chosen[name] for name in readers}, readers)
        return columns.names, {name: _joined(parts) for name, parts in chunks.items()}, rows
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
