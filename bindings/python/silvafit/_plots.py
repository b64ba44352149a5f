# SPDX-License-Identifier: MIT
"""Plots of fits with matplotlib."""
from __future__ import annotations

import inspect
from statistics import NormalDist
from typing import TYPE_CHECKING, Any, Callable, Dict, List, Optional, Sequence

import numpy as np
import pandas as pd

from ._data import text_of
from ._errors import UsageError
from ._words import word

if TYPE_CHECKING:
    from ._fit import Fit

_POINTS_OF_CURVE = 100
_MOST_CURVES = 12


def plot(fit: "Fit", kind: str, ax: Any, **options: Any) -> Any:
    """Draws one of the kinds on axes, which are made if there are none."""
    drawers: Dict[str, Callable[..., None]] = {"curves": _curves, "residuals": _residuals, "qq": _qq, "random": _random}
    kind = word("kind", kind, *drawers)
    _check_options(kind, drawers[kind], options)
    if ax is None:
        import matplotlib.pyplot as plt

        _, ax = plt.subplots()
    drawers[kind](fit, ax, **options)
    return ax


def _check_options(kind: str, drawer: Callable[..., None], options: Dict[str, Any]) -> None:
    known = list(inspect.signature(drawer).parameters)[2:]
    for name in options:
        if name not in known:
            raise UsageError(f"unknown argument of the plot '{kind}'; available: {', '.join(known)}", column=name)


def _horizontal(fit: "Fit", data: pd.DataFrame, x: Optional[str]) -> str:
    """The column of the horizontal axis: the first predictor that is a number."""
    if x is not None:
        if x not in data.columns:
            raise UsageError(f"unknown column '{x}'; available: {', '.join(data.columns)}", column="x")
        return x
    for name in fit._core.predictors:
        if name in data.columns and pd.api.types.is_numeric_dtype(data[name]):
            return name
    raise UsageError("the model has no numeric predictor to draw curves over", column="kind")


def _grid(data: pd.DataFrame, x: str) -> pd.DataFrame:
    """Rows along x; other predictors have their median, or the commonest text."""
    columns = {}
    for name in data.columns:
        values = data[name]
        typical = values.median() if pd.api.types.is_numeric_dtype(values) else values.mode().iloc[0]
        columns[name] = [typical] * _POINTS_OF_CURVE
    grid = pd.DataFrame(columns)
    grid[x] = np.linspace(data[x].min(), data[x].max(), _POINTS_OF_CURVE)
    return grid


def _chosen_groups(data: pd.DataFrame, columns: List[str], groups: Optional[Sequence[Any]]) -> pd.DataFrame:
    """One row for each group to draw: those that are named, or the largest."""
    sizes = data.groupby(columns, sort=False).size().sort_values(ascending=False, kind="stable")
    chosen = sizes.index[:_MOST_CURVES].to_frame(index=False)
    if groups is None:
        return chosen.sort_values(columns).reset_index(drop=True)
    every = sizes.index.to_frame(index=False)
    wanted = {"/".join(map(str, group)) if isinstance(group, tuple) else str(group) for group in groups}
    labels = every[columns].apply(lambda column: column.map(text_of)).agg("/".join, axis=1)
    found = every[labels.isin(wanted)]
    if len(found) < len(wanted):
        missing = sorted(wanted - set(labels))
        raise UsageError(f"unknown group '{missing[0]}'", column="groups")
    return found


def _curves(fit: "Fit", ax: Any, x: Optional[str] = None, groups: Optional[Sequence[Any]] = None) -> None:
    fit._own_frame("plot()")
    data = pd.DataFrame(fit.data).dropna()
    x = _horizontal(fit, data, x)
    terms = fit._random_terms
    drawn = data
    if terms:
        columns = terms[-1]["columns"]
        chosen = _chosen_groups(data, columns, groups)
        drawn = data.merge(chosen, on=columns)
        for number, group in enumerate(chosen.itertuples(index=False)):
            _draw_group(fit, ax, data, x, dict(zip(columns, group)), f"C{number % 10}")
    else:
        ax.plot(drawn[x], drawn[fit.response], ".", color="0.6", alpha=0.6)
    grid = _grid(drawn, x)
    ax.plot(grid[x], fit.predict(grid, level="population"), color="black", linewidth=2, label="population")
    ax.set(xlabel=x, ylabel=fit.response, title=fit.formula)
    ax.legend(fontsize="small", title=" / ".join(terms[-1]["columns"]) if terms else None)


def _draw_group(fit: "Fit", ax: Any, data: pd.DataFrame, x: str, group: dict, color: str) -> None:
    own = data[np.logical_and.reduce([data[name] == value for name, value in group.items()])]
    grid = _grid(own, x)
    ax.plot(own[x], own[fit.response], ".", color=color, alpha=0.5, markersize=4)
    label = " / ".join(text_of(value) for value in group.values())
    ax.plot(grid[x], fit.predict(grid, level="conditional"), color=color, label=label)


def _residuals(fit: "Fit", ax: Any, residual: str = "pearson", level: str = "conditional") -> None:
    ax.axhline(0.0, color="0.5", linewidth=1)
    ax.plot(fit.fitted(level), fit.residuals(residual, level), ".", alpha=0.6)
    ax.set(xlabel=f"fitted {fit.response} ({level})", ylabel=f"{residual} residual", title=fit.formula)


def _effects(values: Any, effect: Optional[str]) -> pd.Series:
    """One effect of the finest grouping; by default the first."""
    table = list(values.values())[-1] if isinstance(values, dict) else values
    if table.empty:
        raise UsageError("the model has no random effects", column="kind")
    if effect is not None and effect not in table.columns:
        raise UsageError(f"unknown effect '{effect}'; available: {', '.join(table.columns)}", column="effect")
    return table[effect or table.columns[0]]


def _qq(fit: "Fit", ax: Any, residual: str = "normalized", level: str = "conditional",
        effect: Optional[str] = None) -> None:
    values = fit.residuals(residual, level).dropna() if effect is None else _effects(fit.random_effects, effect)
    count = len(values)
    # The plotting positions of R's ppoints(), which are those of Blom for few points.
    offset = 0.375 if count <= 10 else 0.5
    quantile = NormalDist().inv_cdf
    places = np.array([quantile((k + 1 - offset) / (count + 1 - 2 * offset)) for k in range(count)])
    low, high = np.quantile(values, [0.25, 0.75])
    ax.plot(places, np.sort(values), ".", alpha=0.6)
    ax.plot(places, (low + high) / 2.0 + places * (high - low) / (2.0 * quantile(0.75)), color="0.5", linewidth=1)
    name = f"{residual} residual" if effect is None else f"random effect of {effect}"
    ax.set(xlabel="normal quantile", ylabel=name, title=fit.formula)


def _random(fit: "Fit", ax: Any, effect: Optional[str] = None) -> None:
    ordered = _effects(fit.random_effects, effect).sort_values()
    places = np.arange(len(ordered))
    half = 1.959963984540054 * _effects(fit.random_standard_errors, effect).reindex(ordered.index)
    ax.axvline(0.0, color="0.5", linewidth=1)
    ax.errorbar(ordered, places, xerr=half, fmt="o", markersize=4, linewidth=1)
    ax.set(xlabel=f"random effect of {ordered.name}, with 95 % interval",
           ylabel=" / ".join(map(str, ordered.index.names)), title=fit.formula)
    if len(ordered) <= 60:
        ax.set_yticks(places, [" / ".join(map(str, label)) if isinstance(label, tuple) else str(label)
                               for label in ordered.index], fontsize="small")
