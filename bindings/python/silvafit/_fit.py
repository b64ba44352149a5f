# SPDX-License-Identifier: MIT
"""Fitting, and what a fit is."""
from __future__ import annotations

import contextlib
import dataclasses
import os
import pathlib
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
import pandas as pd

from . import _core, _location
from ._analysis import analysis
from ._data import Frame, frame_of
from ._errors import UsageError, check_number, check_text, path_text, warn_of
from ._estimates import model_frame
from ._inference import Inference
from ._listener import Listener
from ._predictions import Predictions
from ._settings import takes
from ._summary import Summary
from ._words import word

Parameters = Union[str, Sequence[str], Mapping[str, str], None]


def _texts(parameters: Parameters) -> List[str]:
    if parameters is None:
        return []
    if isinstance(parameters, Mapping):
        return [f"{name} ~ {text}" for name, text in parameters.items()]
    texts: List[Any] = [parameters] if isinstance(parameters, str) or not np.iterable(parameters) else list(parameters)
    for text in texts:
        check_text("parameters", text)
    return texts


@takes("model", "fit")
def fit(formula: str, data: Any, *, parameters: Parameters = None, threads: int = 1, trace: bool = False, **settings: Any) -> Fit:
    """Fit a model by least squares or with mixed effects.

    Parameters
    ----------
    formula : str
        A formula such as ``"h ~ 1.3 + a*(1 - exp(-b*dbh))"``, whose names that are no columns are
        parameters; or the id of a model of the catalogue, such as ``"M4"``. A random effect of R's lme4 is
        read as in ``"h ~ a + b*dbh + (1 | plot)"``, and a self-starting model of R as in
        ``"h ~ SSlogis(age, Asym, xmid, scal)"``. The left side is a column or an expression, ``"log(h) ~ ..."``;
        predictions are then those of the expression.
    data : DataFrame, dict of arrays, or object with ``__arrow_c_stream__``
        Rows with a missing value in a column of the model are skipped.
    parameters : str, list of str or dict, optional
        Linear sub-models of parameters, as in R: ``["b ~ 1 + C"]`` or ``{"b": "1 + C"}``. Columns of text and categories are
        factors. Structural indices that are no columns (W, M, U, C, ...) are computed from x, y and dbh.
    trace : bool
        Print the iterations on standard error.
    **settings
        Of the model and the fit (docs/settings.md). nlme's methods ML and REML stand for the default without and with `reml`.

    Returns
    -------
    Fit
        Also if the fit has not converged: see ``Fit.converged``, ``Fit.status`` and ``Fit.verdict``.

    Warns
    -----
    ConvergenceWarning
        If the fit has not converged, or is a boundary (singular) fit.
    SilvafitWarning
        If a name that was taken as a parameter may be a misspelt column, sizes of trees seem to have another
        unit, or the response has the values of another distribution, such as 0 and 1.

    Raises
    ------
    UsageError, InputError
        If an argument or the data cannot be used. The errors have the column, the row and the remedy.

    Examples
    --------
    >>> import silvafit as sf
    >>> fit = sf.fit("h ~ 1.3 + a*(1 - exp(-b*dbh))", trees, random="a + b | plot")  # doctest: +SKIP
    """
    # What this function itself passes on.
    for name in ("model", "columns", "factors", "catalogue", "knows_units"):
        if name in settings:
            raise UsageError(f"unknown argument '{name}'", column=name)
    arguments = {"formula": formula, "parameters": parameters, "threads": threads,
                 **{name: dict(value) if isinstance(value, (Mapping, pd.Series)) else value for name, value in settings.items()}}
    for name, is_optional in (("formula", False), ("random", True), ("variance", True), ("correlation", True)):
        check_text(name, arguments.get(name), is_optional)
    derive = settings.get("derive")
    if isinstance(derive, Mapping):
        arguments["derive"] = [f"{name} = {text}" for name, text in derive.items()]
    arguments["covariance"] = word("covariance", arguments.get("covariance"), is_optional=True)
    if arguments.get("method") in ("ML", "REML"):  # nlme's words
        reml = arguments["method"] == "REML"
        if arguments.get("reml") not in (None, reml):
            raise UsageError(f"is {not reml}, but method is {arguments['method']!r}; give one of them", column="reml")
        arguments.update(method=None, reml=reml)
    core, frame = _fitted(arguments, data, trace)
    made = Fit(core, frame, arguments)
    warn_of(made)
    return made


def _fitted(arguments: Dict[str, Any], data: Any, trace: bool) -> Tuple[Any, Frame]:
    model, formula = formula_of(arguments["formula"])
    keywords: Dict[str, Any] = {**arguments, "parameters": _texts(arguments["parameters"]), "model": model, "formula": None if model else formula}
    numbers, names, response = _core.uses(formula, keywords["parameters"], keywords.get("random") or "", keywords.get("variance") or "",
                                             keywords.get("correlation") or "")
    if keywords.get("means") and isinstance(data, pd.DataFrame):
        for name in numbers:
            if name in data.columns and pd.api.types.is_bool_dtype(data[name]):
                raise UsageError(f"the column {name} holds truth values; make them texts, such as \"yes\" and \"no\"", column="means")
    mentioned = list(dict.fromkeys(numbers + names + (["dbh", "h"] if model else [])))
    if isinstance(data, Frame):
        _check_kept(data, mentioned)
    # Units are compared between plots and species.
    labels = [name for name in ("plot", "species") if name not in mentioned and {"dbh", "h"} <= {*mentioned, response}]
    frame = model_frame(data, keywords["parameters"], mentioned + labels, response)
    if not set(names) <= set(frame.names):
        frame = frame_of(data)  # the message lists all columns
    with contextlib.suppress(TypeError, AttributeError):  # the libraries say what is no bound
        keywords["bounds"] = {name: [None if end is None or np.isinf(end) else end for end in ends]  # infinite ends are open
                              for name, ends in keywords.get("bounds", {}).items()}
    # A name of the formula that is no column may be a misspelt one.
    keywords.update(columns=list(dict.fromkeys([*frame.names, *frame.table.names])), trace=trace)
    catalogue = _location.catalogue() if model else None
    fitted = analysis("fit", frame, listener=Listener(), catalogue=catalogue, settings=keywords).fits[0][1]
    if not labels:
        return fitted, frame
    kept = [(name, column) for name, column in frame.table.columns() if name not in labels]
    return fitted, dataclasses.replace(frame, table=_core.table(frame.table.rows, kept))


def formula_of(text: str) -> Tuple[Optional[str], str]:
    """The id of a model of the catalogue as it is spelt there, None for a formula; and the formula."""
    if "~" in text:
        return None, text
    catalogue = _location.catalogue()
    formula = catalogue.formula(text.strip())
    return next(model["id"] for model in catalogue.models() if model["formula"] == formula), formula


def response_name(text: str) -> str:
    """The left side of a formula, or of a model of the catalogue."""
    return _core.uses(formula_of(text)[1], [], "", "", "")[2]


def _check_kept(frame: Frame, mentioned: List[str]) -> None:
    """A column that a fit has not kept would be taken as a parameter."""
    lost = [name for name in mentioned if name in frame.names and name not in frame.table.names]
    if lost:
        raise UsageError(f"the fit has kept only the columns that it uses ({', '.join(frame.table.names)}), not "
                         f"'{lost[0]}'; give the data, update(..., data=trees)", column="data")


class Fit(Predictions, Inference):
    """A fitted model, as `fit` returns it. It does not change.

    A fit keeps the columns of its data that the model uses. It can be pickled and copied. The JSON of
    `to_json` is that of the program (docs/json.md) and has no data; `with_data` attaches them again.
    The names of statsmodels (params, bse, llf, resid, conf_int, ...) are there beside ours (docs/python.md).
    """

    def with_data(self, data: Any) -> "Fit":
        """The same fit with the data that it was made of, for a fit that was read from a file."""
        frame = self._frame_for(data)
        self._residuals(frame)  # refuses other data
        return Fit(self._core, frame, self._arguments)

    def update(self, formula: Optional[str] = None, data: Any = None, **changes: Any) -> "Fit":
        """Fit again with some arguments of `silvafit.fit` changed.

        Parameters
        ----------
        formula : str, optional
        data : DataFrame, dict of arrays, or object with ``__arrow_c_stream__``, optional
            Default: the columns that this fit keeps. A model that reads further ones needs the data.
        **changes
            Such as ``random="a + b | plot"``, or ``variance=None`` for none.
        """
        arguments = {**(self._arguments or self._stored_arguments()), **changes}
        if "method" in changes and "reml" not in changes:  # ML and REML are methods, too
            arguments["reml"] = None if changes["method"] in ("ML", "REML") else arguments.get("reml")
        if formula is not None:
            arguments["formula"] = formula
        return fit(data=self._own_frame("update()") if data is None else data, **arguments)

    def _stored_arguments(self) -> dict:
        """The arguments of a fit that was read from a file, as far as they say what the model is."""
        forms = {term["form"] for term in self._random_terms} & {"diagonal", "identity", "compound-symmetry"}
        return {"formula": self.model or self.formula, "parameters": self.parameters, "random": self.random,
                "covariance": forms.pop() if len(forms) == 1 else None,
                "variance": None if self.variance == "none" else self.variance,
                "correlation": None if self.correlation == "none" else self.correlation, "method": self.method, "reml": self.reml}

    def summary(self) -> Summary:
        """The fit as text, as ``silvafit fit`` prints it."""
        return Summary(("" if self.converged else f"NOT CONVERGED ({self.status})\n") + self._core.summary)

    def plot(self, kind: str = "curves", ax: Any = None, **options: Any) -> Any:
        """Draw the fit with matplotlib.

        Parameters
        ----------
        kind : {"curves", "residuals", "qq", "random"}
            curves: data with a curve for each group and that of the population. residuals: Pearson
            residuals over fitted values. qq: normalized residuals, or random effects, over normal
            quantiles, with a line through the quartiles. random: random effects with 95 % intervals.
        ax : matplotlib Axes, optional
        **options
            curves: ``x``, the column of the horizontal axis, and ``groups``, a list of groups to draw;
            residuals and qq: ``residual``, a kind of `Fit.residuals`, and ``level``; qq and random:
            ``effect``, a name.

        Returns
        -------
        matplotlib Axes
        """
        from . import _plots

        return _plots.plot(self, kind, ax, **options)

    def to_json(self, path: Union[str, os.PathLike, None] = None, indent: int = -1) -> Optional[str]:
        """The fit as the program's JSON (docs/json.md), as text or into a file."""
        check_number("indent", indent)
        text = self._core.to_json(int(indent))
        if path is None:
            return text
        pathlib.Path(path_text("path", path)).write_text(text + "\n", encoding="utf-8")
        return None

    @classmethod
    def from_json(cls, source: Union[str, os.PathLike]) -> "Fit":
        """Read a fit from JSON text, or from a file that `to_json` or ``silvafit fit --json`` wrote."""
        text = path_text("source", source)
        if text.lstrip().startswith("{"):
            return cls(_core.Fit.from_json(text, ""))
        return cls(_core.Fit.from_json(pathlib.Path(text).read_text(encoding="utf-8"), text))

    def __getstate__(self) -> dict:
        return {"json": self._core.to_json(), "frame": None if self._frame is None else self._frame.state(),
                "arguments": self._arguments}

    def __setstate__(self, state: dict) -> None:
        self._core = _core.Fit.from_json(state["json"], "")
        self._frame = None if state["frame"] is None else Frame.restored(state["frame"])
        self._arguments = state["arguments"]

    def __copy__(self) -> "Fit":
        return Fit(self._core, self._frame, self._arguments)

    def __deepcopy__(self, memo: dict) -> "Fit":
        return self.__copy__()  # nothing in it changes

    def __repr__(self) -> str:
        return str(self.summary())

    def _repr_html_(self) -> str:
        return self.summary()._repr_html_()
