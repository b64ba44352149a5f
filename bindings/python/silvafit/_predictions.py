# SPDX-License-Identifier: MIT
"""Predictions, fitted values and residuals."""
from __future__ import annotations

from typing import Any, Dict, List, Optional, Union

import numpy as np
import pandas as pd

from . import _location
from ._analysis import Result, analysis
from ._data import Frame
from ._errors import InputError, UsageError, check_text, coverage_of_alpha
from ._estimates import Estimates, group_index, one_or_dict
from ._words import word


class Predictions(Estimates):
    """The part of a fit that predicts."""

    def predict(
        self,
        data: Any = None,
        level: Union[str, int] = "conditional",
        interval: Optional[str] = None,
        *,
        coverage: Optional[float] = None,
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
        coverage : float, optional
            Of the interval; default: 0.95.
        standard_errors : bool
            Whether to add the standard error of what the interval is for; without an interval of the mean, as in R.
        new_groups : {"population", "marginal", "missing", "error"}, optional
            What a conditional or calibrated prediction is for groups of which nothing is known. Default:
            population, with a warning that names these groups.
        seen_groups : {"fitted", "new", "combined"}
            Of calibrated predictions only: random effects of groups that were in the fit.
        threads : int
            0: all cores.

        Returns
        -------
        Series, or DataFrame with the columns prediction, lower, upper, se
            With the index of `data`. NaN where a predictor is missing. As in files, dbh of 0 and codes such as -9999
            are missing values in models of the catalogue, and other values outside their domain are errors.

        Warns
        -----
        SilvafitWarning
            If groups are not in the fit and `new_groups` is not given, levels of factors are not in the fit, or
            codes were read as missing values.
        """
        level = self._level(level)
        if data is None:
            frame = self._own_frame("predict() without data")
        else:
            frame = self._frame_for(data, needs_response=level == "calibrated")
            if level == "conditional":
                self._check_groups(frame)
        interval = word("interval", interval, is_optional=True)
        result = analysis("predict", frame, fits=[self._core], level=level, coverage=coverage_of(interval, coverage), interval=interval,
                          standard_errors=standard_errors, new_groups=new_groups, seen_groups=seen_groups, threads=threads,
                          catalogue=self._catalogue())
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
        for name in ("interval", "coverage", "standard_errors"):
            if name in options:
                raise UsageError("the result has intervals of any coverage, conf_int(), and standard errors, se_mean", column=name)
        if data is not None:  # read once, also a stream
            data = self._frame_for(data, self._level(options.get("level", "conditional")) == "calibrated")
        return Prediction(self, data, options)

    def _check_groups(self, frame: Frame) -> None:
        for term in self._random_terms:
            for column in term["columns"]:
                if column not in frame.table.names:
                    raise InputError(f"unknown column; available: {', '.join(frame.table.names)}. Without the column of "
                                     "the groups use level='population'", column=column)

    def calibrate(self, data: Any, seen_groups: str = "new",
                  threads: int = 1) -> Union[pd.DataFrame, Dict[str, pd.DataFrame]]:
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
            A row for each group: the number of measured trees, and the random effects. With several
            groupings a dict, as `random_effects`; of groups that the data do not have, those of the
            fit are listed, unless groups are new.
        """
        frame = self._frame_for(data)
        check_text("seen_groups", seen_groups, is_optional=False)
        found = analysis("calibrate", frame, fits=[self._core], seen_groups=seen_groups, threads=threads,
                         catalogue=self._catalogue())
        tables = []
        for number, term in enumerate(self._random_terms, 1):
            groups = found.frame(f"groups {number}").astype({"measured": int})
            index = group_index(groups.pop("label"), term["columns"], frame.labels)
            tables.append((term["group"], groups.set_axis(index, axis=0)))
        return one_or_dict(tables)

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
            Of the first two kinds only.
        """
        kind = word("kind", kind, "response", "pearson", "normalized", "marginal")
        if _level(level) != "conditional" and kind in ("normalized", "marginal"):
            raise UsageError(f"has no effect on {kind} residuals", column="level")
        frame = self._own_frame("residuals()")
        found = self._residuals(frame)
        column = kind if kind in ("normalized", "marginal") else f"{kind}_{_level(level)}"
        return frame.aligned(found.frame("rows")[column], found.rows, f"{kind} residual")

    def _residuals(self, frame: Frame) -> Result:
        return analysis("residuals", frame, fits=[self._core])

    def _catalogue(self) -> Any:
        """The base models, for a fit of one of them."""
        return _location.catalogue() if self.model else None


def coverage_of(interval: Optional[str], coverage: Optional[float]) -> Optional[float]:
    """The coverage of an interval; none without one."""
    if interval is None and coverage is not None:
        raise UsageError("is that of intervals; give `interval`, too", column="coverage")
    return 0.95 if coverage is None and interval is not None else coverage


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
        return pd.DataFrame(self._fit.predict(self._data, interval=interval, coverage=coverage_of_alpha(alpha), standard_errors=True,
                                              **self._options))

    def conf_int(self, obs: bool = False, alpha: float = 0.05) -> pd.DataFrame:
        """Limits of intervals of coverage 1 - `alpha`: of the mean, or of new observations (`obs`)."""
        return self._predict("prediction" if obs else "confidence", alpha)[["lower", "upper"]]

    def summary_frame(self, alpha: float = 0.05) -> pd.DataFrame:
        """Columns mean, mean_se, mean_ci_lower, mean_ci_upper, obs_ci_lower, obs_ci_upper."""
        limits = [self.conf_int(obs, alpha).add_prefix(prefix) for obs, prefix in ((False, "mean_ci_"), (True, "obs_ci_"))]
        return pd.concat([self.predicted_mean.rename("mean"), self.se_mean.rename("mean_se"), *limits], axis=1)
