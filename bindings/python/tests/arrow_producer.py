# SPDX-License-Identifier: MIT
"""A table that offers ``__arrow_c_stream__`` by Arrow's C data interface, made with ctypes alone.

It stands in for polars, pyarrow and DuckDB, written from the specification.
"""
import ctypes

import numpy as np
import pandas as pd

from silvafit._arrow import Array, Schema, Stream

_NUMBERS = {"g": np.float64, "f": np.float32, "i": np.int32, "l": np.int64, "s": np.int16}


def _bitmap(flags):
    return np.packbits(np.asarray(flags, bool), bitorder="little")


def _text_buffers(texts, kind):
    encoded = [(text or "").encode() for text in texts]
    if kind == "vu":
        views = np.zeros(len(encoded), "V16")
        long = b""
        for row, data in enumerate(encoded):
            head = np.int32(len(data)).tobytes()
            if len(data) <= 12:
                views[row] = head + data.ljust(12, b"\0")
            else:
                views[row] = head + data[:4] + np.int32(0).tobytes() + np.int32(len(long)).tobytes()
                long += data
        return [views, np.frombuffer(long + b"\0", np.uint8)]
    ends = np.cumsum([0, *map(len, encoded)]).astype(np.int32 if kind == "u" else np.int64)
    return [ends, np.frombuffer(b"".join(encoded) + b"\0", np.uint8)]


class ArrowTable:
    """Columns of a DataFrame as an Arrow stream.

    Parameters
    ----------
    text : {"u", "U", "vu", "dictionary"}
        How text is stored.
    numbers : str
        The format of numbers; "d:P,S" for 128 bit decimals.
    chunks : int
    offset : int
        Values in front of each array that do not belong to it.
    """

    def __init__(self, frame, text, numbers="g", chunks=1, offset=0):
        self.frame, self.text, self.numbers, self.chunks, self.offset = frame, text, numbers, chunks, offset
        self.made = self.released = 0
        self._alive = []

    def __arrow_c_stream__(self, requested_schema=None):
        parts = [part for part in np.array_split(np.arange(len(self.frame)), self.chunks)]
        todo = [self.frame.iloc[part] for part in parts]

        def get_schema(_, out):
            self._fill_schema(out.contents, b"+s", b"", [self._column_schema(name) for name in self.frame.columns])
            return 0

        def get_next(_, out):
            if not todo:
                ctypes.memset(ctypes.byref(out.contents), 0, ctypes.sizeof(Array))
                return 0
            part = todo.pop(0)
            self._fill_array(out.contents, len(part), [None], [self._column(part[name]) for name in part.columns],
                             offset=0)
            return 0

        def release(stream):
            stream.contents.release = type(stream.contents.release)()
            self.released += 1

        stream = Stream()
        stream.get_schema = Stream._fields_[0][1](get_schema)
        stream.get_next = Stream._fields_[1][1](get_next)
        stream.release = Stream._fields_[3][1](release)
        self.made += 1
        self._alive.append(stream)
        return _capsule(stream)

    def _format(self, name):
        values = self.frame[name]
        if values.dtype == bool:
            return "b"
        if pd.api.types.is_numeric_dtype(values):
            return self.numbers
        return self.text

    def _column_schema(self, name):
        kind = self._format(name)
        schema = Schema()
        if kind == "dictionary":
            values = Schema()
            self._fill_schema(values, b"u", b"", [])
            self._fill_schema(schema, b"i", name.encode(), [])
            schema.dictionary = ctypes.pointer(values)
        else:
            self._fill_schema(schema, kind.encode(), name.encode(), [])
        return schema

    def _column(self, values):
        """The values as an array, behind `offset` others."""
        kind = self._format(values.name)
        values = pd.concat([values.iloc[:1].repeat(self.offset), values])
        missing = values.isna().to_numpy()
        buffers = [_bitmap(~missing) if missing.any() else None]
        array = Array()
        if kind == "b":
            buffers.append(_bitmap(values))
        elif kind == "dictionary":
            codes, unique = pd.factorize(values)
            buffers.append(codes.astype(np.int32))
            words = Array()
            self._fill_array(words, len(unique), [None, *_text_buffers(list(unique), "u")], [], offset=0)
            array.dictionary = ctypes.pointer(words)
        elif kind in ("u", "U", "vu"):
            buffers += _text_buffers([None if gone else text for text, gone in zip(values, missing)], kind)
        elif kind.startswith("d:"):
            scale = int(kind.split(",")[1])
            whole = [int(round(value * 10**scale)) for value in values.fillna(0.0)]
            buffers.append(np.frombuffer(b"".join(v.to_bytes(16, "little", signed=True) for v in whole), np.uint8))
        else:
            buffers.append(np.ascontiguousarray(values.fillna(0), _NUMBERS[kind]))
        self._fill_array(array, len(values) - self.offset, buffers, [], offset=self.offset,
                         nulls=int(missing[self.offset:].sum()))
        return array

    def _fill_schema(self, schema, kind, name, children):
        def release(pointer):
            pointer.contents.release = type(pointer.contents.release)()
            self.released += 1

        schema.format, schema.name = kind, name
        schema.n_children = len(children)
        pointers = (ctypes.POINTER(Schema) * max(1, len(children)))(*map(ctypes.pointer, children))
        schema.children = ctypes.cast(pointers, type(schema.children))
        schema.release = Schema._fields_[7][1](release)
        if kind == b"+s":
            self.made += 1
        self._alive += [schema, children, pointers, kind, name, schema.release]

    def _fill_array(self, array, length, buffers, children, offset, nulls=0):
        def release(pointer):
            pointer.contents.release = type(pointer.contents.release)()
            self.released += 1

        addresses = (ctypes.c_void_p * len(buffers))(
            *[None if buffer is None else buffer.ctypes.data for buffer in buffers])
        pointers = (ctypes.POINTER(Array) * max(1, len(children)))(*map(ctypes.pointer, children))
        array.length, array.null_count, array.offset = length, nulls, offset
        array.n_buffers, array.n_children = len(buffers), len(children)
        array.buffers = ctypes.cast(addresses, type(array.buffers))
        array.children = ctypes.cast(pointers, type(array.children))
        array.release = Array._fields_[8][1](release)
        if children:
            self.made += 1
        self._alive += [array, buffers, addresses, children, pointers, array.release]


_DESTRUCTOR = ctypes.CFUNCTYPE(None, ctypes.c_void_p)


@_DESTRUCTOR
def _destroy(capsule):
    pointer = ctypes.pythonapi.PyCapsule_GetPointer
    pointer.restype, pointer.argtypes = ctypes.c_void_p, [ctypes.c_void_p, ctypes.c_char_p]
    stream = Stream.from_address(pointer(capsule, b"arrow_array_stream"))
    pointer.argtypes = [ctypes.py_object, ctypes.c_char_p]
    if stream.release:
        stream.release(ctypes.byref(stream))


def _capsule(stream):
    new = ctypes.pythonapi.PyCapsule_New
    new.restype, new.argtypes = ctypes.py_object, [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p]
    return new(ctypes.addressof(stream), b"arrow_array_stream", ctypes.cast(_destroy, ctypes.c_void_p))
