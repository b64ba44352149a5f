# SPDX-License-Identifier: MIT
"""Exceptions and warnings. A message says what is wrong, where, and what to do."""
from __future__ import annotations

import contextlib
import os
import pathlib
import re
import sys
import warnings
from typing import Any, Iterator, Optional, Union

import numpy as np

_PACKAGE = str(pathlib.Path(__file__).parent)
_LINE = re.compile(r"\bline (\d+)\b")


def check_text(name: str, value: Any, is_optional: bool = True) -> None:
    """Refuses what is no text; None is an absent argument."""
    if not isinstance(value, str) and not (is_optional and value is None):
        raise UsageError(f"{value!r} is not a text", column=name)


def path_text(name: str, value: Any) -> str:
    """A path as text."""
    text = value if isinstance(value, str) else os.fspath(value) if isinstance(value, os.PathLike) else None
    check_text(name, text if isinstance(text, str) else value, is_optional=False)
    return str(text)


def check_number(name: str, value: Any) -> None:
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise UsageError(f"{value!r} is not a number", column=name)


def coverage_of_alpha(alpha: Any) -> float:
    """The coverage of intervals of an alpha as in statsmodels, which is easily mistaken for the coverage."""
    check_number("alpha", alpha)
    if 0.5 < alpha < 1.0:
        warn(f"alpha={alpha:g} is a coverage of {100 * (1 - alpha):g} %; for {100 * alpha:g} % use alpha={1 - alpha:g}")
    return 1.0 - float(alpha)


class Error(Exception):
    """Base of all errors of silvafit.

    Attributes
    ----------
    message : str
        The problem and the remedy, without the place.
    column : str or None
        Column of the data, or name of an argument.
    row : object
        Label of the row in the index of the data (of data without an index its number from 0), or None.
    line : int or None
        Line in a file, or number of the row from 1.
    file, plot, tree, model : str or None
        Further parts of the place.
    position : int or None
        Column in the text of a formula, from 1.
    """

    def __init__(self, message: str, **place: Any):
        self.message = message
        self.column: Optional[str] = place.get("column")
        self.row: Any = place.get("row")
        self.line: Optional[int] = place.get("line")
        self.file: Optional[str] = place.get("file")
        self.plot: Optional[str] = place.get("plot")
        self.tree: Optional[str] = place.get("tree")
        self.model: Optional[str] = place.get("model")
        self.position: Optional[int] = place.get("position")
        super().__init__(self.message)

    def __str__(self) -> str:
        text = self.message
        if self.column:
            text = f"{self.column}: {text}"
        if self.file:
            text = f"{self.file}:{self.line}: {text}" if self.line else f"{self.file}: {text}"
        elif self.row is not None:
            text = f"row {self.row!r}: {text}"
        of = ((word, getattr(self, word)) for word in ("plot", "tree", "model"))
        subject = ", ".join(f"{word} {value}" for word, value in of if value)
        return f"{text} ({subject})" if subject else text

    def __reduce__(self) -> tuple:
        return _restored, (type(self), self.message, self.__dict__)


def _restored(kind: type, message: str, attributes: dict) -> Error:
    error = kind(message)
    error.__dict__.update(attributes)
    return error


class UsageError(Error, ValueError):
    """An argument cannot be used: an unknown name, a value out of range."""


class FormulaError(UsageError):
    """A formula or another text of a model cannot be read."""


class InputError(Error, ValueError):
    """The data or the content of a file cannot be used."""


class DomainError(InputError):
    """A value is outside the range where a model is defined."""


class NumericalError(Error, ArithmeticError):
    """No result exists, or it cannot be computed with the required precision."""


class GeometryError(Error, ValueError):
    """A tree, a mesh or a window is not valid."""


class FileError(Error, OSError):
    """The system could not read or write a file."""

    # OSError formats messages from an error number, which there is not.
    __str__ = Error.__str__


#: By the kinds of the libraries.
KINDS = {"formula": FormulaError, "usage": UsageError, "domain": DomainError, "input": InputError, "numerical": NumericalError,
         "geometry": GeometryError, "io": FileError, "other": Error}


class SilvafitWarning(UserWarning):
    """What was left out or is in doubt: rows, models, predictions, names and units of the data. Base of all warnings."""


class ConvergenceWarning(SilvafitWarning):
    """A fit did not converge, or is a boundary (singular) fit.

    Attributes
    ----------
    status : str
        ``Fit.status``, such as ``"no_maximum"``.
    """

    def __init__(self, message: str, status: str = ""):
        self.status = status
        super().__init__(message, status)

    def __str__(self) -> str:
        return f"{self.args[0]} (status: {self.status})"


def warn(warning: Union[str, SilvafitWarning]) -> None:
    """Warns at the line that called the package."""
    frame, level = sys._getframe(1), 2
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_PACKAGE):
        frame, level = frame.f_back, level + 1
    warnings.warn(warning, SilvafitWarning, stacklevel=level)


def warn_of(fit: Any) -> None:
    """Warns unless a fit converged inside its range, and of doubts about its names and its response."""
    if fit.status not in ("converged", "perfect_fit", "published"):
        warn(ConvergenceWarning(fit.verdict, fit.status))
    elif fit.status != "published" and fit._core.has_doubts:
        warn(fit.verdict)


def with_labels(text: str, index: Any) -> str:
    """A message of the libraries, where lines of data in memory are rows of their index (None: a file)."""
    if index is None:
        return text

    def label(match: Any) -> str:
        number = int(match.group(1))
        return f"row {index[number - 1]!r}" if number <= len(index) else match.group(0)

    return _LINE.sub(label, text)


@contextlib.contextmanager
def located_in(index: Any) -> Iterator[None]:
    """Errors inside name rows by the labels of an index (None: a file)."""
    try:
        yield
    except Error as error:
        if index is not None and not error.file:
            error.message = with_labels(error.message, index)
            if error.line and error.line <= len(index):
                error.row = index[error.line - 1]
        raise
