# SPDX-License-Identifier: MIT
"""Predictions, fitted values and residuals."""
from __future__ import annotations

import warnings
from typing import Any, List, Optional, Union

import numpy as np
import pandas as pd

from ._analysis import Result, analysis
from ._data import Frame, restored_labels
from ._errors import InputError, check_text, located_in
from ._estimates import Estimates
from ._words import word


class Predictions(Estimates):
    """The part of a fit that predicts."""

    def predict(
        self,
        data: Any = None,
        level: Union[str, int] = "conditional",
        interval: Optional[str] = None,
        *,
        coverage: float = 0.95,
        standard_errors: bool = False,
        new_groups: Optional[str] = None,
        seen_groups: str = "fitted",
        threads: int = 1,
    ) -> Union[pd.Series, pd.DataFrame]:
        """Predict the response.

        Parameters
        ----------
        data : DataFrame, dict of arrays, or object with ``__arrow_c_stream__``, optional
            Default: the data of the fit.
        level : {"conditional", "population", "calibrated", "marginal"}
            conditional: random effects estimated in the fit. population: random effects 0. calibrated:
            those of the groups in `data`, predicted from the rows with a measured response. marginal:
            the mean over all groups. With random effects the default needs the columns of the groups, as
            in R. 0 and 1 are nlme's numbers of population and conditional.
        interval : {"prediction", "confidence"}, optional
            Interval of a new observation, or of the mean.
        coverage : float
            Of the interval.
        standard_errors : bool
            Whether to add the standard error of what the interval is for.
        new_groups : {"population", "marginal", "missing", "error"}, optional
            What a conditional or calibrated prediction is for groups of which nothing is known. Default:
            population, with a warning that names new groups of conditional predictions.
        seen_groups : {"fitted", "new", "combined"}
            Of calibrated predictions: random effects of groups that were in the fit.
        threads : int
            0: all cores.

        Returns
        -------
        Series, or DataFrame with the columns prediction, lower, upper, se
            With the index of `data`. NaN where a predictor is missing.

        Warns
        -----
        UserWarning
            If groups are not in the fit and `new_groups` is not given.
        """
        level = self._level(level)
        if data is None:
            frame = self._own_frame("predict() without data")
        else:
            frame = self._frame_for(data, needs_response=level == "calibrated")
            if level == "conditional":
                self._check_groups(frame)
        with located_in(frame.index):
            result = analysis("predict", frame.table, fits=[self._core], level=level, coverage=coverage if interval else None,
                              interval=word("interval", interval, is_optional=True), standard_errors=standard_errors,
                              new_groups=new_groups, seen_groups=seen_groups, threads=threads)
        if new_groups is None and result.json["new_groups"]:
            warnings.warn(result.json["new_groups"], stacklevel=2)
        found = result.frame("rows", frame.rows)
        if interval is None and not standard_errors:
            return found["value"].rename(self.response)
        columns = ["value", *(["lower", "upper"] if interval else []), *(["standard_error"] if standard_errors else [])]
        return found[columns].rename(columns={"value": "prediction", "standard_error": "se"})

    def _level(self, level: Union[str, int]) -> str:
        """A level by its name, or by nlme's number where that is clear."""
        is_number = isinstance(level, (int, np.integer)) and not isinstance(level, bool)
        if is_number and level in (0, len(self._random_terms)):
            return "conditional" if level else "population"
        check_text("level", level, is_optional=False)
        return str(level)

    def get_prediction(self, data: Any = None, **options: Any) -> "Prediction":
        """Predictions with standard errors and intervals, as in statsmodels.

        Parameters
        ----------
        data, **options
            As in `predict`, without interval, coverage and standard_errors.
        """
        if data is not None:  # read once, also a stream
            data = self._frame_for(data, self._level(options.get("level", "conditional")) == "calibrated")
        return Prediction(self, data, options)

    def _check_groups(self, frame: Frame) -> None:
        for term in self._random_terms:
            for column in term["columns"]:
                if column not in frame.table.names:
                    raise InputError(f"unknown column; available: {', '.join(frame.table.names)}. Without the column of "
                                     "the groups use level='population'", column=column)

    def calibrate(self, data: Any, seen_groups: str = "new", threads: int = 1) -> pd.DataFrame:
        """Random effects of the groups in new data from their measured trees, without a refit.

        Parameters
        ----------
        data : DataFrame, dict of arrays, or object with ``__arrow_c_stream__``
            Rows without the response do not count.
        seen_groups : {"new", "fitted", "combined"}
            Groups that were in the fit: from these data alone, as in the fit, or from both.

        Returns
        -------
        DataFrame
            A row for each group: the number of measured trees, and the random effects.
        """
        frame = self._frame_for(data)
        check_text("seen_groups", seen_groups, is_optional=False)
        with located_in(frame.index):
            found = analysis("calibrate", frame.table, fits=[self._core], seen_groups=seen_groups, threads=threads).frame("groups")
        columns = self._random_terms[-1]["columns"]
        labels = list(found.pop("label"))
        if len(columns) == 1:
            labels = restored_labels(labels, frame.labels.get(columns[0]))
        return found.astype({"measured": int}).set_axis(pd.Index(labels, name="/".join(columns)), axis=0)

    def fitted(self, level: str = "conditional") -> pd.Series:
        """Fitted values of a level, "population" or "conditional", with the index of the data; NaN for skipped rows."""
        frame = self._own_frame("fitted()")
        found = self._residuals(frame)
        return frame.aligned(found.frame("rows")["fitted_" + _level(level)], found.rows, self.response)

    @property
    def fittedvalues(self) -> pd.Series:
        """`fitted` of the conditional level."""
        return self.fitted()

    @property
    def resid(self) -> pd.Series:
        """`residuals` of the conditional level: observed minus fitted."""
        return self.residuals()

    def residuals(self, kind: str = "response", level: str = "conditional") -> pd.Series:
        """Residuals with the index of the data; NaN for skipped rows.

        Parameters
        ----------
        kind : {"response", "pearson", "normalized", "marginal"}
            response: observed minus fitted. pearson: divided by the estimated standard deviation, as
            in nlme. normalized: pearson residuals made independent by their correlation. marginal: of
            the model linear around the estimates with random effects not removed; independent and
            standard normal if the model holds.
        level : {"conditional", "population"}
            Of the first two kinds.
        """
        kind = word("kind", kind, "response", "pearson", "normalized", "marginal")
        frame = self._own_frame("residuals()")
        found = self._residuals(frame)
        column = kind if kind in ("normalized", "marginal") else f"{kind}_{_level(level)}"
        return frame.aligned(found.frame("rows")[column], found.rows, f"{kind} residual")

    def _residuals(self, frame: Frame) -> Result:
        with located_in(frame.index):
            return analysis("residuals", frame.table, fits=[self._core])


def _level(level: str) -> str:
    return word("level", level, "population", "conditional")


class Prediction:
    """Predictions, as `Fit.get_prediction` returns them.

    Attributes
    ----------
    predicted_mean, se_mean : Series
        The predictions, and their standard errors, with the index of the data.
    """

    def __init__(self, fit: Predictions, data: Optional[Frame], options: dict):
        self._fit = fit
        self._data = data
        self._options = options
        columns = self._predict("confidence", 0.05)
        self.predicted_mean: pd.Series = columns["prediction"].rename("predicted_mean")
        self.se_mean: pd.Series = columns["se"].rename("se_mean")

    def _predict(self, interval: str, alpha: float) -> pd.DataFrame:
        return pd.DataFrame(self._fit.predict(self._data, interval=interval, coverage=1.0 - alpha, standard_errors=True,
                                              **self._options))

    def conf_int(self, obs: bool = False, alpha: float = 0.05) -> pd.DataFrame:
        """Limits of intervals of coverage 1 - `alpha`: of the mean, or of new observations (`obs`)."""
        return self._predict("prediction" if obs else "confidence", alpha)[["lower", "upper"]]

    def summary_frame(self, alpha: float = 0.05) -> pd.DataFrame:
        """Columns mean, mean_se, mean_ci_lower, mean_ci_upper, obs_ci_lower, obs_ci_upper."""
        limits = [self.conf_int(obs, alpha).add_prefix(prefix) for obs, prefix in ((False, "mean_ci_"), (True, "obs_ci_"))]
        return pd.concat([self.predicted_mean.rename("mean"), self.se_mean.rename("mean_se"), *limits], axis=1)
