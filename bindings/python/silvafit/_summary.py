# SPDX-License-Identifier: MIT
"""Fits as text and as HTML."""
from __future__ import annotations

import html
from typing import TYPE_CHECKING, List, Tuple

import numpy as np
import pandas as pd

if TYPE_CHECKING:
    from ._fit import Fit

Row = Tuple[str, str]


class Summary:
    """A summary: its text when printed, tables in a notebook."""

    def __init__(self, text: str, markup: str):
        self.text = text
        self.markup = markup

    def __str__(self) -> str:
        return self.text

    __repr__ = __str__

    def _repr_html_(self) -> str:
        return self.markup


def _number(value: float, digits: int = 6) -> str:
    return "" if np.isnan(value) else f"{value:.{digits}g}"


def _model_rows(fit: "Fit") -> List[Row]:
    rows = [("Model", (f"{fit.model}: " if fit.model else "") + fit.formula)]
    rows += [("", f"{name} ~ {text}") for name, text in fit.parameters.items()]
    if fit.random:
        rows.append(("Random effects", fit.random))
    if fit.variance != "none":
        rows.append(("Variance", fit.variance))
    if fit.correlation != "none":
        rows.append(("Correlation", fit.correlation))
    groups = ", ".join(f"{count} groups of {name}" for name, count in fit.groups.items())
    rows.append(("Method", fit.method + (", REML" if fit.reml else "")))
    rows.append(("Observations", f"{fit.nobs}" + (f", {groups}" if groups else "")
                 + (f"; {fit.excluded} rows with missing values skipped" if fit.excluded else "")))
    return rows


def _quality_rows(fit: "Fit") -> List[Row]:
    rows = [("Log-likelihood", f"{_number(fit.loglik, 8)} ({fit.parameter_count} parameters), "
             f"AIC {_number(fit.aic, 8)}, BIC {_number(fit.bic, 8)}")]
    for level, values in fit.statistics.iterrows():
        rows.append((f"{level.capitalize()} level", f"R2 {_number(values['r2'], 4)}, RMSE {_number(values['rmse'], 4)}"))
    return rows


def _convergence(fit: "Fit") -> str:
    return f"{'Converged' if fit.converged else 'NOT CONVERGED'} ({fit.status}). {fit.verdict}"


def _coefficients(fit: "Fit") -> pd.DataFrame:
    table = fit.coefficients
    return pd.DataFrame({
        "estimate": [_number(value) for value in table["estimate"]],
        "se": [_number(value, 4) for value in table["se"]],
        "df": [_number(value) for value in table["df"]],
        "t": [_number(value, 4) for value in table["t"]],
        "p": [_p_value(value) for value in table["p"]],
    }, index=table.index)


def _p_value(p: float) -> str:
    if np.isnan(p):
        return ""
    return "< 1e-4" if p < 1e-4 else f"{p:.4f}"


def _components(fit: "Fit") -> pd.DataFrame:
    components = fit.variance_components
    return pd.DataFrame({"estimate": [_number(value) for value in components]}, index=components.index)


def _lines(rows: List[Row]) -> str:
    width = max(len(name) for name, _ in rows)
    return "\n".join(f"{name:<{width}}  {text}" for name, text in rows)


def summary_of(fit: "Fit") -> Summary:
    """The whole summary."""
    coefficients, components = _coefficients(fit), _components(fit)
    text = "\n\n".join([
        _lines(_model_rows(fit)),
        _convergence(fit),
        coefficients.to_string(),
        components.to_string(header=False),
        _lines(_quality_rows(fit)),
    ])
    markup = (_html_rows(_model_rows(fit)) + _html_convergence(fit) + coefficients.to_html()
              + components.to_html(header=False) + _html_rows(_quality_rows(fit)))
    return Summary(text, markup)


def fit_text(fit: "Fit") -> str:
    """The fit in few lines, as ``repr``."""
    estimates = ", ".join(f"{name} = {_number(value, 5)}" for name, value in fit.fixed_effects.items())
    return "\n".join([_lines(_model_rows(fit)), estimates, f"log-likelihood {_number(fit.loglik, 8)}",
                      _convergence(fit)])


def _html_rows(rows: List[Row]) -> str:
    cells = "".join(f"<tr><th style='text-align:left'>{html.escape(name)}</th>"
                    f"<td style='text-align:left'>{html.escape(text)}</td></tr>" for name, text in rows)
    return f"<table>{cells}</table>"


def _html_convergence(fit: "Fit") -> str:
    color = "inherit" if fit.converged else "#b00020"
    return f"<p style='color:{color}'>{html.escape(_convergence(fit))}</p>"


def fit_html(fit: "Fit") -> str:
    """The fit in a notebook."""
    return (_html_rows(_model_rows(fit)) + _html_convergence(fit) + _coefficients(fit).to_html()
            + _html_rows(_quality_rows(fit)))
