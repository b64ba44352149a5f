# SPDX-License-Identifier: MIT
"""Intervals, tests, resampling, and comparisons of fits."""
from __future__ import annotations

from typing import Any, Dict, List, Optional, Sequence, Tuple, Union

import numpy as np
import pandas as pd

from ._analysis import Result, analysis
from ._errors import UsageError, check_text, coverage_of_alpha, warn
from ._estimates import Estimates
from ._listener import Listener
from ._restrictions import linear_restrictions
from ._settings import takes
from ._summary import Shown

#: Texts, rows of numbers, or rows and values.
Restrictions = Union[str, List[str], Any]


class Inference(Estimates):
    """The part of a fit that says how certain it is."""

    def intervals(self, method: str = "wald", level: float = 0.95, threads: int = 1) -> pd.DataFrame:
        """Confidence intervals of all parameters.

        Parameters
        ----------
        method : {"wald", "profile"}
        level : float
            Confidence level.
        threads : int
            Over parameters; 0: all cores.

        Returns
        -------
        DataFrame
            Columns kind, estimate, lower, upper, note; ``attrs["likelihood"]`` says which likelihood
            is profiled. A limit that is not known is NaN, one that does not exist infinite.
        """
        frame = self._own_frame("intervals()")
        check_text("method", method, is_optional=False)
        found = analysis("intervals", frame, fits=[self._core], method=method, level=level, threads=threads)
        result = found.frame("parameters").set_index("name")
        result.attrs.update(found.json, method=method, level=level)
        return result

    def conf_int(self, alpha: float = 0.05, method: str = "wald") -> pd.DataFrame:
        """Confidence limits of the coefficients: columns 0 and 1, as in statsmodels. See `intervals`."""
        found = self.intervals(method, coverage_of_alpha(alpha))
        return found.loc[found["kind"] == "fixed", ["lower", "upper"]].set_axis([0, 1], axis=1)

    def wald_test_terms(self, sequential: bool = False) -> pd.DataFrame:
        """Wald's F tests of the terms of each parameter, given all other terms, or (`sequential`) those before.

        Returns
        -------
        DataFrame
            A row for each term; the coefficients of a factor are one. Columns statistic, p, df and df_denominator.
        """
        found = analysis("term_tests", fits=[self._core], sequential=sequential).frame("terms")
        return found.astype({"df": int}).set_index("term")[["statistic", "p", "df", "df_denominator"]]

    def t_test(self, r_matrix: Restrictions) -> pd.DataFrame:
        """Test linear combinations of coefficients one by one, by t.

        Parameters
        ----------
        r_matrix : str, list of str, array, or tuple
            As in statsmodels: ``"a = 20, b - 2*c = 0"``, where other names than words stand between backquotes; rows with a
            number for each coefficient, whose combinations are compared with 0; or a tuple of such rows and the values.

        Returns
        -------
        DataFrame
            A row for each combination: effect, value, se, df, t, p.
        """
        rows, values = self._restrictions(r_matrix)
        effect = rows @ self.fixed_effects.to_numpy()
        error = np.sqrt(np.einsum("ij,jk,ik->i", rows, self.covariance.fillna(0.0).to_numpy(), rows))
        tests = [self._joint_test(rows[k:k + 1], values[k:k + 1]) for k in range(len(rows))]
        return pd.DataFrame({"effect": effect, "value": values, "se": error, "df": [one["df_denominator"] for one in tests],
                             "t": (effect - values) / error, "p": [one["p"] for one in tests]})

    def wald_test(self, r_matrix: Restrictions) -> pd.Series:
        """Test linear combinations of coefficients together, by Wald's F; see `t_test`.

        Returns
        -------
        Series
            statistic, p, df and df_denominator.
        """
        return self._joint_test(*self._restrictions(r_matrix))

    f_test = wald_test

    def _joint_test(self, rows: np.ndarray, values: np.ndarray) -> pd.Series:
        found = analysis("term_tests", fits=[self._core], combinations=rows, values=values).frame("terms")
        return found[["statistic", "p", "df", "df_denominator"]].iloc[0].rename("test")

    def _restrictions(self, r_matrix: Restrictions) -> Tuple[np.ndarray, np.ndarray]:
        """The rows of combinations, and their values."""
        names = list(self.fixed_effects.index)
        if isinstance(r_matrix, str):
            r_matrix = r_matrix.split(",")
        if isinstance(r_matrix, list) and r_matrix and all(isinstance(one, str) for one in r_matrix):
            return linear_restrictions(r_matrix, names)
        given = r_matrix if isinstance(r_matrix, tuple) else (r_matrix, None)
        try:
            rows = np.atleast_2d(np.asarray(given[0], float))
            values = np.zeros(len(rows)) if given[1] is None else np.broadcast_to(np.asarray(given[1], float), len(rows))
        except (TypeError, ValueError):
            rows = values = np.empty((0, 0))
        if rows.ndim != 2 or rows.shape[1] != len(names) or len(rows) == 0:
            raise UsageError(f"the combinations need a number for each coefficient: {', '.join(names)}", column="r_matrix")
        return rows, values

    def simulate(self, count: int = 1, seed: int = 1) -> pd.DataFrame:
        """Draw responses from the fit on the design of its data.

        Random effects of all groups and residuals are new. The same seed gives the same values.

        Returns
        -------
        DataFrame
            With the index of the data, NaN for skipped rows, and columns 0, 1, ... `count` - 1.
        """
        if count < 1:
            raise UsageError(f"{count} is no number of simulated data sets, which is 1 or more", column="count")
        frame = self._own_frame("simulate()")
        found = analysis("simulate", frame, fits=[self._core], count=count, seed=seed)
        result = np.full((frame.table.rows, count), np.nan)
        result[found.rows] = found.frame("rows").to_numpy()
        return pd.DataFrame(result, frame.rows)

    @takes("bootstrap")
    def bootstrap(self, replicates: int = 500, resample: str = "parametric", *, seed: int = 1, threads: int = 0, progress: Optional[bool] = None,
                  **settings: Any) -> "Bootstrap":
        """Refit to resampled data, for standard errors and intervals of all parameters.

        Parameters
        ----------
        replicates : int
        resample : {"parametric", "cases"}
            Draw responses from the fit, or whole groups with replacement.
        **settings
            Of the bootstrap (docs/settings.md).
        """
        return Bootstrap(self._resampled("bootstrap", progress, settings, replicates=replicates, resample=resample, seed=seed, threads=threads))

    @takes("cross-validation")
    def cross_validate(self, folds: int = 10, *, seed: int = 1, threads: int = 0, progress: Optional[bool] = None, **settings: Any) -> pd.DataFrame:
        """Predict each group by a fit without it.

        Parameters
        ----------
        folds : int
            0: one group at a time.
        **settings
            Of cross-validation (docs/settings.md).

        Returns
        -------
        DataFrame
            Columns fold, observed, predicted and, with `measured`, calibrated, with the index of the
            data without skipped rows; ``attrs`` has the statistics (r2, mean_error, rmse, mae), the
            mean log predictive density and the folds that failed.
        """
        found = self._resampled("cross_validate", progress, settings, folds=folds, seed=seed, threads=threads)
        result = found.frame("rows", self._own_frame("cross_validate()").rows[found.rows]).astype({"fold": int}).sort_index(kind="stable")
        result.attrs.update({name: found.json[name] for name in ("population", "mean_log_density", "failed")})
        if "calibrated" in result.columns:
            result.attrs["calibrated"] = found.json["calibrated"]["statistics"]
        return result

    def _resampled(self, name: str, progress: Optional[bool], settings: Dict[str, Any], **arguments: Any) -> Result:
        frame = self._own_frame(f"{name}()")
        refit = {key: self._arguments[key] for key in ("hold", "bounds", "maximum_iterations") if self._arguments.get(key) is not None}
        with Listener(progress) as listener:
            return analysis(name, frame, fits=[self._core], listener=listener, refit=refit, settings=settings, **arguments)


class Bootstrap(Shown):
    """Results of `Fit.bootstrap`.

    Attributes
    ----------
    parameters : DataFrame
        For each parameter: estimate, replicates with a value, bias, se, and the limits of the
        percentile and basic intervals.
    values : DataFrame
        The estimates of all replicates (rows), NaN where a refit failed.
    replicates, converged : int
        Number of refits, and of those that converged.
    failures, boundary : DataFrame
        Reasons of failures, and boundary (singular) refits: reason, replicates.
    """

    def __init__(self, found: Result):
        counts = {"replicates": int}
        self.parameters = found.frame("parameters").astype(counts).set_index("name")
        self.values = found.frame("values").set_axis(self.parameters.index, axis=1)
        self.replicates: int = found.json["replicates"]
        self.converged: int = found.json["converged"]
        self.failures = found.frame("failures").astype(counts)
        self.boundary = found.frame("boundary").astype(counts)

    def _shown(self) -> pd.DataFrame:
        return self.parameters

    def _note(self) -> str:
        return f"{self.converged} of {self.replicates} replicates converged"


def compare(*fits: Estimates, names: Optional[Sequence[str]] = None) -> pd.DataFrame:
    """Compare fits by information criteria and likelihood-ratio tests.

    Parameters
    ----------
    *fits : Fit
        Two or more, to the same observations.
    names : list of str, optional
        Default: their formulas with random effects and variance function, numbered if they are equal.

    Returns
    -------
    DataFrame
        A row for each fit that converged, by number of parameters: parameters, loglik, aic, aicc, bic,
        aic_difference, akaike_weight; and the test against the row above: statistic, df, p, note.
        ``attrs["not_converged"]`` has the names of the others.

    Warns
    -----
    SilvafitWarning
        If the likelihoods cannot be compared.
    """
    for one in fits:
        if not isinstance(one, Estimates):
            raise UsageError(f"only fits can be compared, not {type(one).__name__}; give each as an argument, "
                             "compare(first, second)")
    if isinstance(names, str) or not np.iterable([] if names is None else names):
        raise UsageError(f"{names!r} is no list of names", column="names")
    labels = list(names) if names is not None else _names_of(fits)
    if len(labels) != len(fits):
        raise UsageError(f"there are {len(fits)} fits and {len(labels)} names", column="names")
    found = analysis("compare", fits=[one._core for one in fits])
    order = found.frame("fits")
    shown = [fits[number] for number in order["fit"].astype(int)]
    columns = {"parameters": "parameter_count", "loglik": "loglik", "aic": "aic", "aicc": "aicc", "bic": "bic"}
    result = pd.DataFrame({name: [getattr(one, attribute) for one in shown] for name, attribute in columns.items()})
    tests = found.frame("tests").set_index("larger")[["statistic", "df", "p", "note"]]
    result = result.join(order.drop(columns="fit")).join(tests).fillna({"note": ""})
    result.index = pd.Index([labels[number] for number in order["fit"].astype(int)], name="name")
    result.attrs["not_converged"] = [labels[number] for number in found.json["failed"]]
    if found.json["reason"]:
        warn(f"the fits cannot be compared: {found.json['reason']}")
    return result


def _names_of(fits: Sequence[Estimates]) -> List[str]:
    def name(one: Estimates) -> str:
        parts = [one.model or one.formula, *(f"{k} ~ {v}" for k, v in one.parameters.items())]
        parts += [one.random or "", "" if one.variance == "none" else one.variance,
                  "" if one.correlation == "none" else one.correlation]
        return ", ".join(part for part in parts if part)

    names = [name(one) for one in fits]
    return names if len(set(names)) == len(names) else [f"{k + 1}: {one}" for k, one in enumerate(names)]
