# SPDX-License-Identifier: MIT
"""Mixed-effects models as estimators of scikit-learn."""
from __future__ import annotations

import re
from typing import Any, List, Mapping, Optional

import numpy as np
import pandas as pd
from sklearn.base import BaseEstimator, RegressorMixin
from sklearn.utils import validation
from sklearn.utils.validation import check_consistent_length, check_is_fitted, column_or_1d

from ._errors import UsageError
from ._fit import Parameters, response_name
from ._fit import fit as _fit

__all__ = ["MixedRegressor"]


class MixedRegressor(RegressorMixin, BaseEstimator):
    """A nonlinear mixed-effects model as a regressor.

    Groups are a column of X that `random` names (``"a | plot"``), or the argument `groups` of `fit` and
    `predict`. Predictions for groups that were in the fit have their random effects; others are those of
    the population, or calibrated from measured trees. A prediction without the groups is an error, unless
    ``level="population"`` asks for random effects 0.

    Parameters
    ----------
    formula : str, optional
        Such as ``"h ~ 1.3 + a*(1 - exp(-b*dbh))"``, with the columns of X by name (x0, x1, ... for
        arrays), or the id of a model of the catalogue, ``"M4"``; the name on the left side is y. For a function
        of y, such as its logarithm, use ``sklearn.compose.TransformedTargetRegressor``.
        Default: a linear model of all columns, with the coefficients intercept, b0, b1, ... of x0, x1, ...
    random : str, optional
        Random effects, ``"a + b | plot"``, or ``"a + b"`` for those of `groups`. Default: the intercept of
        the linear model if there are groups, else none.
    parameters, covariance, variance, correlation, method, reml, start, starts, hold, bounds, threads
        As in `silvafit.fit`.
    level : {"conditional", "population", "calibrated", "marginal"}
        Of predictions. calibrated: also groups that were not in the fit have random effects, predicted from
        the trees that `measured` has values of.
    measured : str, optional
        Column of X with the response where it was measured, NaN elsewhere, for ``level="calibrated"``. A
        fit does not read it.

    Attributes
    ----------
    fit_ : silvafit.Fit
        The fit: summary, random effects, intervals, plots.
    n_features_in_, feature_names_in_
        As in scikit-learn.

    Examples
    --------
    >>> from sklearn.model_selection import GroupKFold, cross_val_score
    >>> model = MixedRegressor("h ~ 1.3 + a*(1 - exp(-b*dbh))", random="a | plot")
    >>> cross_val_score(model, trees[["dbh", "plot"]], trees["h"],
    ...                 groups=trees["plot"], cv=GroupKFold(5))                  # doctest: +SKIP
    """

    #: Column of the argument `groups`.
    _GROUP = "group"

    def __init__(
        self,
        formula: Optional[str] = None,
        random: Optional[str] = None,
        parameters: Parameters = None,
        covariance: Optional[str] = None,
        variance: Optional[str] = None,
        correlation: Optional[str] = None,
        method: Optional[str] = None,
        reml: Optional[bool] = None,
        start: Optional[Mapping[str, float]] = None,
        starts: int = 0,
        hold: Optional[Mapping[str, float]] = None,
        bounds: Optional[Mapping[str, Any]] = None,
        level: str = "conditional",
        measured: Optional[str] = None,
        threads: int = 1,
    ):
        self.formula = formula
        self.random = random
        self.parameters = parameters
        self.covariance = covariance
        self.variance = variance
        self.correlation = correlation
        self.method = method
        self.reml = reml
        self.start = start
        self.starts = starts
        self.hold = hold
        self.bounds = bounds
        self.level = level
        self.measured = measured
        self.threads = threads

    def fit(self, X: Any, y: Any, groups: Any = None) -> "MixedRegressor":
        """Fit the model.

        Parameters
        ----------
        X : DataFrame or array of shape (n, features)
        y : array of shape (n,)
        groups : array of shape (n,), optional
            The group of each row.
        """
        table, y = self._training_data(X, y)
        formula = self._formula(table)
        left = response_name(formula)
        if "~" in formula and not re.fullmatch(r"`[^`]*`|[\w.]+", formula.partition("~")[0].strip()):
            raise UsageError(f"the left side is y, a name, not {left}; for a function of y use "
                             "sklearn.compose.TransformedTargetRegressor", column="formula")
        table = self._with_groups(table.drop(columns=[self.measured] if self.measured else []), groups)
        table[left] = y
        self.fit_ = _fit(
            formula, table, random=self._random(groups), parameters=self.parameters, covariance=self.covariance,
            variance=self.variance, correlation=self.correlation, method=self.method, reml=self.reml, start=self.start, starts=self.starts,
            hold=self.hold, bounds=self.bounds, threads=self.threads)
        return self

    def predict(self, X: Any, groups: Any = None) -> np.ndarray:
        """Predict, with random effects where the group of a row is known.

        Parameters
        ----------
        X : DataFrame or array of shape (n, features)
        groups : array of shape (n,), optional

        Returns
        -------
        array of shape (n,)
        """
        check_is_fitted(self)
        table = self._with_groups(self._table(X, reset=False), groups)
        needed = {column for term in self.fit_._random_terms for column in term["columns"]}
        if self.level in ("conditional", "calibrated") and not needed <= set(table.columns):
            raise UsageError(f"predictions of the level {self.level} need the groups: a column {' and '.join(sorted(needed))}, "
                             "or predict(X, groups=...); level='population' has random effects 0", column="groups")
        if self.level == "calibrated":
            table = self._with_response(table)
        # Groups that are not in the fit are what cross-validation over groups asks for.
        return self.fit_.predict(table, level=self.level, new_groups="population", threads=self.threads).to_numpy()

    def _with_response(self, table: pd.DataFrame) -> pd.DataFrame:
        """The table with what was measured as response."""
        if self.measured is None or self.measured not in table.columns:
            raise UsageError("calibration needs the name of a column of X with the response where it was measured, such "
                             "as measured='h_measured'", column="measured")
        return table.assign(**{self.fit_.response: table[self.measured]})

    def _training_data(self, X: Any, y: Any) -> tuple:
        if self.formula is None:
            X, y = _validated(self, X, y, y_numeric=True, dtype=np.float64, ensure_min_samples=2)
            return self._numbered(X), y
        table = self._table(X, reset=True)
        y = column_or_1d(y, warn=True).astype(np.float64)
        check_consistent_length(table, y)
        return table, y

    def _table(self, X: Any, reset: bool) -> pd.DataFrame:
        """The columns of X by name; with the default formula numbers under x0, x1, ..."""
        if self.formula is None or not isinstance(X, pd.DataFrame):
            return self._numbered(_validated(self, X, dtype=np.float64, reset=reset))
        _check_names(self, X, reset)
        return X.copy()

    @staticmethod
    def _numbered(X: np.ndarray) -> pd.DataFrame:
        return pd.DataFrame(X, columns=[f"x{k}" for k in range(X.shape[1])])

    def _with_groups(self, table: pd.DataFrame, groups: Any) -> pd.DataFrame:
        if groups is None:
            return table
        check_consistent_length(table, groups)
        if self._GROUP in table.columns:
            raise UsageError(f"a feature is called {self._GROUP}, as the column of `groups`; rename it, or name the groups in `random`, "
                             "such as random='a | plot'", column="groups")
        values = groups.array if isinstance(groups, (pd.Series, pd.Index)) else groups
        return table.assign(**{self._GROUP: values})

    def _formula(self, table: pd.DataFrame) -> str:
        if self.formula is not None:
            return self.formula
        slopes: List[str] = [f"b{k}*x{k}" for k in range(table.shape[1])]
        return "y ~ " + " + ".join(["intercept", *slopes])

    def _random(self, groups: Any) -> Optional[str]:
        if self.random is not None and "|" in self.random:
            if groups is not None:
                raise UsageError(f"random names its groups, {self.random}; omit one of them", column="groups")
            return self.random
        if self.random is not None and groups is not None:
            return f"{self.random} | {self._GROUP}"
        if self.random is not None:
            raise UsageError("random effects need groups: fit(X, y, groups=...), or a column of X, such as "
                             f"random='{self.random} | plot'", column="groups")
        if groups is None:
            return None
        if self.formula is None:
            return f"intercept | {self._GROUP}"
        raise UsageError("with groups, say which coefficients vary between them, such as random='a'", column="random")


# scikit-learn 1.6 made functions of these methods.
def _validated(estimator: Any, X: Any, *y: Any, **options: Any) -> Any:
    if hasattr(validation, "validate_data"):
        return validation.validate_data(estimator, X, *y, **options)
    return estimator._validate_data(X, *y, **options)


def _check_names(estimator: Any, X: pd.DataFrame, reset: bool) -> None:
    if hasattr(validation, "validate_data"):
        validation.validate_data(estimator, X, reset=reset, skip_check_array=True)
    else:
        estimator._check_feature_names(X, reset=reset)
        estimator._check_n_features(X, reset=reset)
