# SPDX-License-Identifier: MIT
"""Fitting, and what a fit is."""
from __future__ import annotations

import os
import pathlib
import warnings
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
import pandas as pd

from . import _core, _location
from ._data import Frame, data_frame, frame_of, restored_labels
from ._errors import Error, InputError, UsageError, check_count, check_number, check_text, located_in, warn_of
from ._listener import Listener
from ._summary import Summary, fit_html, fit_text, summary_of

Number = Union[int, float]
Bound = Tuple[Optional[Number], Optional[Number]]
#: What indices need of an inventory.
_INVENTORY = ("plot", "tree", "species", "x", "y", "dbh", "h", "cw", "cr_e", "cr_w", "cr_s", "cr_n")


def _texts(parameters: Union[str, Sequence[str], None]) -> List[str]:
    if parameters is None:
        return []
    texts: List[Any] = [parameters] if isinstance(parameters, str) or not np.iterable(parameters) else list(parameters)
    for text in texts:
        check_text("parameters", text)
    return texts


def _has_names(names: Sequence[str], mentioned: Sequence[str]) -> List[str]:
    known = set(names)
    return [name for name in mentioned if name in known]


def _with_structure(data: Any, texts: List[str], mentioned: List[str]) -> Frame:
    """The mentioned columns, and structural indices (C, W, ...) that the data lack, if they have positions."""
    computed: List[str] = []

    def choose(names: List[str]) -> List[str]:
        computed.extend(_core.structure_names(texts, names))
        return _has_names(names, mentioned + list(_INVENTORY if computed else ()))

    frame = frame_of(data, choose)
    if not computed:
        return frame
    table, notes = _core.with_structure(frame.table, computed)
    for note in notes:
        warnings.warn(note, stacklevel=4)
    keep = [(name, column) for name, column in table.columns() if name in mentioned]
    frame.table = _core.table(frame.table.rows, keep)
    return frame


def fit(
    formula: str,
    data: Any,
    *,
    parameters: Union[str, Sequence[str], None] = None,
    random: Optional[str] = None,
    covariance: Optional[str] = None,
    variance: Optional[str] = None,
    method: Optional[str] = None,
    reml: bool = False,
    start: Optional[Mapping[str, Number]] = None,
    starts: int = 0,
    fixed: Optional[Mapping[str, Number]] = None,
    bounds: Optional[Mapping[str, Bound]] = None,
    agq_points: int = 7,
    maximum_iterations: int = 200,
    threads: int = 1,
    trace: bool = False,
) -> "Fit":
    """Fit a model by least squares or with mixed effects.

    Parameters
    ----------
    formula : str
        A formula such as ``"h ~ 1.3 + a*(1 - exp(-b*dbh))"``, whose names that are no columns are
        parameters; or the id of a model of the catalogue, such as ``"M4"``. A random effect of R's lme4 is
        read as in ``"h ~ a + b*dbh + (1 | plot)"``.
    data : DataFrame, dict of arrays, or object with ``__arrow_c_stream__``
        Rows with a missing value in a column of the model are skipped.
    parameters : str or list of str, optional
        Linear sub-models of parameters, as in R: ``["b ~ 1 + C"]``. Columns of text and categories are
        factors. Structural indices that are no columns (W, M, U, C, ...) are computed from x, y and dbh.
    random : str, optional
        Random effects: ``"a + b | plot"``; nested: ``"a | stand/plot"``, or with effects of its own for
        each grouping ``"a | stand; a + b | stand/plot"``.
    covariance : {"general", "diagonal", "identity"}, optional
        Form of the covariance matrix of the random effects.
    variance : str, optional
        Variance function of the residuals: ``"power"``, ``"exponential"``, ``"power(dbh)"``, ...
    method : {"ols", "gnls", "lb", "foce", "focei", "laplace", "agq"}, optional
        Default: lb with random effects, gnls with a variance function, else ols.
    reml : bool
        Restricted maximum likelihood (lb and gnls).
    start : dict, optional
        Start values by coefficient. Mixed fits use them in addition to their own.
    starts : int
        Number of further random starts of a mixed fit.
    fixed : dict, optional
        Coefficients that are held at a value.
    bounds : dict, optional
        Bounds (low, high) by coefficient; None for an open end.
    agq_points : int
        Quadrature points per random effect of the method agq.
    maximum_iterations : int
        Of the methods lb and gnls.
    threads : int
        0: all cores. Results do not depend on it.
    trace : bool
        Print the iterations on standard error.

    Returns
    -------
    Fit
        Also if the fit has not converged: see ``Fit.converged``, ``Fit.status`` and ``Fit.verdict``.

    Warns
    -----
    ConvergenceWarning
        If the fit has not converged, or is a boundary (singular) fit.
    UserWarning
        If a name that was taken as a parameter may be a misspelt column, or the response has the values
        of another distribution, such as 0 and 1.

    Raises
    ------
    UsageError, InputError
        If an argument or the data cannot be used. The errors have the column, the row and the remedy.

    Examples
    --------
    >>> import silvafit as sf
    >>> fit = sf.fit("h ~ 1.3 + a*(1 - exp(-b*dbh))", trees, random="a + b | plot")  # doctest: +SKIP
    """
    check_text("formula", formula, is_optional=False)
    for name, value in (("random", random), ("covariance", covariance), ("variance", variance), ("method", method)):
        check_text(name, value)
    for name, count, least in (("starts", starts, 0), ("agq_points", agq_points, 1),
                               ("maximum_iterations", maximum_iterations, 1), ("threads", threads, 0)):
        if count is not None:
            check_count(name, count, least)
    catalogue = None
    forms = None if covariance is None else [covariance] if isinstance(covariance, str) else list(covariance)
    texts: Dict[str, Any] = {"parameters": _texts(parameters), "random": random, "covariance": forms,
                             "variance": variance}
    if "~" in formula:
        texts["formula"] = formula
    else:
        catalogue = _location.catalogue()
        formula = catalogue.formula(formula.strip())
        texts["model"] = _id_of(catalogue, formula)
    options: Dict[str, Any] = {"method": method, "reml": reml, "start": start, "starts": starts, "fixed": fixed,
               "bounds": bounds, "agq_points": agq_points, "maximum_iterations": maximum_iterations,
               "threads": threads}
    options = {name: dict(value) if isinstance(value, (Mapping, pd.Series)) else value
               for name, value in options.items() if value is not None}
    mentioned = _mentioned(formula, texts)
    frame = _with_structure(data, texts["parameters"], mentioned)
    core = _run_fit(frame, data, catalogue, texts, options, trace)
    warn_of(core, stacklevel=2)
    return Fit(core, frame, options)


def _id_of(catalogue: Any, formula: str) -> str:
    return next(model["id"] for model in catalogue.models() if model["formula"] == formula)


def _mentioned(formula: str, texts: Dict[str, Any]) -> List[str]:
    numbers, names = _core.uses(formula, texts["parameters"], texts["random"] or "", texts["variance"] or "")
    inventory = ["dbh", "h"] if "model" in texts else []
    return list(dict.fromkeys(numbers + names + inventory))


def _run_fit(frame: Frame, data: Any, catalogue: Any, texts: dict, options: dict, trace: bool) -> Any:
    listener = Listener()
    # A name of the formula that is no column may be a misspelt one.
    texts = {**texts, "columns": list(dict.fromkeys([*frame.names, *frame.table.names]))}
    try:
        with located_in(frame.index):
            return _core.fit(frame.table, catalogue, texts, options, bool(trace), listener)
    except (Error, TypeError):
        if set(frame.names) <= set(frame.table.names):
            raise
    # Messages list the columns that there are: with all of them, the same error says more.
    with located_in(frame.index):
        return _core.fit(frame_of(data).table, catalogue, texts, options, bool(trace), listener)


class Fit:
    """A fitted model, as `fit` returns it. It does not change.

    A fit keeps the columns of its data that the model uses. It can be pickled and copied. The JSON of
    `to_json` is that of the program (docs/json.md) and has no data; `with_data` attaches them again.
    """

    def __init__(self, core: Any, frame: Optional[Frame] = None, options: Optional[dict] = None):
        self._core = core
        self._frame = frame
        self._options = options or {}

    # What the model is.

    @property
    def formula(self) -> str:
        """The formula."""
        return self._core.formula

    @property
    def model(self) -> Optional[str]:
        """Id in the catalogue, or None."""
        return self._core.model or None

    @property
    def parameters(self) -> Dict[str, str]:
        """Linear sub-models, such as ``{"b": "1 + C"}``."""
        return dict(self._core.sub_models)

    @property
    def random(self) -> Optional[str]:
        """The random effects, ``"a + b | plot"``, or None."""
        return self._core.random_text or None

    @property
    def variance(self) -> str:
        """The variance function, ``"none"`` for a constant variance."""
        return self._core.variance["text"]

    @property
    def method(self) -> str:
        """The method: ols, gnls, lb, foce, focei, laplace or agq."""
        return self._core.method

    @property
    def reml(self) -> bool:
        """Whether it is a fit by restricted maximum likelihood."""
        return self._core.reml

    @property
    def response(self) -> str:
        """The column of the response."""
        return self._core.response

    # How it was fitted.

    @property
    def converged(self) -> bool:
        """Whether the fit reached a maximum; otherwise do not use its estimates."""
        return self._core.converged

    @property
    def status(self) -> str:
        """How the fit ended: ``"converged"``, ``"boundary"``, ``"no_maximum"``, ... (docs/json.md)."""
        return self._core.status

    @property
    def verdict(self) -> str:
        """The convergence message: whether and why the fit converged, or what failed and what to try."""
        return self._core.verdict

    @property
    def evidence(self) -> pd.DataFrame:
        """The findings behind the verdict: kind, term, value."""
        return pd.DataFrame(self._core.evidence, columns=["kind", "term", "value"])

    @property
    def optima(self) -> pd.DataFrame:
        """All maxima of the likelihood that were found, the reported one first."""
        names = self._core.coefficient_names
        return pd.DataFrame([
            {"origin": one["origin"], "log_likelihood": one["log_likelihood"],
             "marginal_log_likelihood": one["marginal_log_likelihood"], **dict(zip(names, one["estimate"]))}
            for one in self._core.optima])

    # Estimates.

    @property
    def fixed_effects(self) -> pd.Series:
        """Estimates of the coefficients."""
        return pd.Series(self._core.estimate, self._core.coefficient_names, name="estimate")

    @property
    def standard_errors(self) -> pd.Series:
        """Standard errors of the coefficients."""
        return pd.Series(self._core.standard_errors, self._core.coefficient_names, name="se")

    @property
    def coefficients(self) -> pd.DataFrame:
        """Estimate, standard error, degrees of freedom, t and p of each coefficient."""
        core = self._core
        return pd.DataFrame({"estimate": core.estimate, "se": core.standard_errors,
                             "df": core.degrees_of_freedom, "t": core.t_values, "p": core.p_values},
                            index=core.coefficient_names)

    @property
    def covariance(self) -> pd.DataFrame:
        """Covariance matrix of the coefficients."""
        names = self._core.coefficient_names
        return pd.DataFrame(self._core.covariance, names, names)

    @property
    def random_effects(self) -> Union[pd.DataFrame, Dict[str, pd.DataFrame]]:
        """Estimated random effects (EBLUPs): a row for each group.

        With several groupings a dict by the group column, the coarser first; groups of the finer one
        have an index of all columns. Without random effects an empty DataFrame.
        """
        return self._of_terms("effects")

    @property
    def random_standard_errors(self) -> Union[pd.DataFrame, Dict[str, pd.DataFrame]]:
        """Conditional standard errors of the random effects, given the estimates; as `random_effects`."""
        return self._of_terms("se")

    @property
    def random_covariance(self) -> Union[pd.DataFrame, Dict[str, pd.DataFrame]]:
        """Covariance matrix of the random effects; with several groupings a dict."""
        found = [(term["columns"][-1], pd.DataFrame(term["covariance"], term["names"], term["names"]))
                 for term in self._core.random_terms]
        return _one_or_dict(found)

    @property
    def variance_components(self) -> pd.Series:
        """Standard deviations and correlations of random effects, parameters of the variance function, sigma."""
        names = set(self._core.coefficient_names)
        pairs = [(name, value) for name, value in self._core.parameter_values if name not in names]
        return pd.Series([value for _, value in pairs], [name for name, _ in pairs], name="estimate")

    @property
    def sigma(self) -> float:
        """Residual standard deviation, the factor of the variance function."""
        return self._core.sigma

    def _of_terms(self, what: str) -> Union[pd.DataFrame, Dict[str, pd.DataFrame]]:
        found = []
        for term in self._core.random_terms:
            if term[what] is None:
                raise UsageError("the file that this fit is from does not have standard errors of random effects")
            found.append((term["columns"][-1], pd.DataFrame(term[what], self._groups_of(term), term["names"])))
        return _one_or_dict(found)

    def _groups_of(self, term: dict) -> pd.Index:
        known = self._frame.labels if self._frame is not None else {}
        labels = [restored_labels(texts, known.get(column))
                  for column, texts in zip(term["columns"], term["labels"])]
        if len(labels) == 1:
            return pd.Index(labels[0], name=term["columns"][0], tupleize_cols=False)
        return pd.MultiIndex.from_arrays(labels, names=term["columns"])

    # Numbers on the whole fit.

    @property
    def nobs(self) -> int:
        """Number of rows used."""
        return self._core.observations

    @property
    def excluded(self) -> int:
        """Number of rows skipped because a value is missing."""
        return self._core.excluded

    @property
    def groups(self) -> Dict[str, int]:
        """Number of groups by column."""
        return {term["columns"][-1]: len(term["labels"][0]) for term in self._core.random_terms}

    @property
    def loglik(self) -> float:
        """Log-likelihood."""
        return self._core.log_likelihood

    @property
    def parameter_count(self) -> int:
        """Number of estimated parameters, with variances and sigma."""
        return self._core.parameter_count

    @property
    def aic(self) -> float:
        """Akaike's information criterion."""
        return self._core.aic

    @property
    def aicc(self) -> float:
        """AIC with the correction for small samples."""
        return self._core.aicc

    @property
    def bic(self) -> float:
        """Bayesian information criterion with n observations."""
        return self._core.bic

    @property
    def bic_groups(self) -> float:
        """BIC with the number of independent groups; NaN without random effects."""
        return self._core.bic_groups

    @property
    def statistics(self) -> pd.DataFrame:
        """R2, mean error, RMSE and MAE of the population and, with random effects, conditional level."""
        rows = {"population": self._core.population}
        if self._core.random_terms:
            rows["conditional"] = self._core.conditional
        return pd.DataFrame.from_dict(rows, orient="index")

    @property
    def r2(self) -> pd.Series:
        """Proportions of variance explained by fixed (marginal), and fixed and random effects (conditional)."""
        return pd.Series({"marginal": self._core.r2_marginal, "conditional": self._core.r2_conditional})

    # Data.

    @property
    def data(self) -> Optional[pd.DataFrame]:
        """The columns of the data that the model uses, or None for a fit from a file."""
        return None if self._frame is None else data_frame(self._frame.table, self._frame.rows, self._frame.labels)

    def with_data(self, data: Any) -> "Fit":
        """The same fit with the data that it was made of, for a fit that was read from a file."""
        return Fit(self._core, self._frame_for(data), self._options)

    def _frame_for(self, data: Any, needs_response: bool = True) -> Frame:
        columns = list(self._core.columns)
        if not needs_response:
            columns = [name for name in columns if name != self.response]
        frame = _with_structure(data, [f"{name} ~ {text}" for name, text in self._core.sub_models], columns)
        missing = [name for name in columns if name not in frame.table.names]
        return frame if not missing else self._with_all_names(frame, data)

    def _with_all_names(self, frame: Frame, data: Any) -> Frame:
        """All columns, so that messages list them."""
        try:
            return frame_of(data)
        except TypeError:
            return frame

    def _own_frame(self, what: str) -> Frame:
        if self._frame is None:
            raise UsageError(f"{what} needs the data of the fit, which was read from a file; "
                             "use fit.with_data(trees)")
        return self._frame

    # Predictions and residuals.

    def predict(
        self,
        data: Any = None,
        level: str = "conditional",
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
            the mean over all groups. The default is that of R.
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
        check_text("level", level, is_optional=False)
        if data is None:
            frame = self._own_frame("predict() without data")
        else:
            frame = self._frame_for(data, needs_response=level == "calibrated")
            if level == "conditional":
                self._check_groups(frame)
            if level == "calibrated":
                self._check_measured(frame)
        keywords = {"level": level, "interval": interval, "coverage": coverage if interval else None,
                    "standard_errors": standard_errors, "new_groups": new_groups or "population",
                    "seen_groups": seen_groups, "threads": threads}
        with located_in(frame.index):
            found = _core.predict(self._core, frame.table, keywords, None)
        if new_groups is None and level == "conditional" and self._core.random_terms:
            self._warn_of_new_groups(frame, np.asarray(found["is_new_group"], dtype=bool))
        if interval is None and not standard_errors:
            return pd.Series(found["value"], frame.rows, name=self.response)
        columns = {"prediction": found["value"]}
        if interval is not None:
            columns.update(lower=found["lower"], upper=found["upper"])
        if standard_errors:
            columns["se"] = found["standard_error"]
        return pd.DataFrame(columns, frame.rows)

    def _check_groups(self, frame: Frame) -> None:
        for term in self._core.random_terms:
            for column in term["columns"]:
                if column not in frame.table.names:
                    raise InputError(f"unknown column; available: {', '.join(frame.table.names)}. Without the column of "
                                     "the groups use level='population'", column=column)

    def _warn_of_new_groups(self, frame: Frame, is_new: np.ndarray) -> None:
        """Groups that are not in the fit have no random effects: what their predictions are is said."""
        columns = self._core.random_terms[-1]["columns"]
        table = data_frame(frame.table, labels=frame.labels)
        labels = table.loc[is_new, columns].drop_duplicates().dropna()
        if labels.empty:
            return
        names = [" / ".join(str(value) for value in row) for row in labels.itertuples(index=False)]
        shown = ", ".join(names[:5] + (["..."] if len(names) > 5 else []))
        warnings.warn(f"{int(is_new.sum())} rows are of groups that are not in the fit ({'/'.join(columns)} {shown}): their "
                      "predictions have random effects 0; new_groups has other choices", stacklevel=3)

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
        self._check_measured(frame)
        check_text("seen_groups", seen_groups, is_optional=False)
        check_count("threads", threads)
        with located_in(frame.index):
            found = _core.calibrate(self._core, frame.table, seen_groups, threads)
        term = self._core.random_terms[-1]
        labels = found["labels"]
        if len(term["columns"]) == 1:
            labels = restored_labels(labels, frame.labels.get(term["columns"][0]))
        result = pd.DataFrame(found["effects"], pd.Index(labels, name="/".join(term["columns"])), term["names"])
        result.insert(0, "measured", found["measured"])
        return result

    def _check_measured(self, frame: Frame) -> None:
        """Calibration is by the measured response, so that a missing column or text is an error."""
        values = dict(frame.table.columns()).get(self.response)
        if values is None:
            raise InputError("calibration needs this column, with NaN where it was not measured", column=self.response)
        if isinstance(values, tuple):
            if (values[0] >= 0).any():
                raise InputError("this column holds text, but calibration needs numbers", column=self.response)
        elif np.isinf(values).any():
            raise InputError("a value is infinite; use NaN where it was not measured", column=self.response)

    @property
    def fitted(self) -> pd.Series:
        """Fitted values with random effects, with the index of the data; NaN for skipped rows."""
        return self.fitted_values()

    def fitted_values(self, level: str = "conditional") -> pd.Series:
        """Fitted values of a level, "population" or "conditional"."""
        frame = self._own_frame("fitted_values()")
        found = self._residuals(frame)
        return frame.aligned(_level_of(found, level)["fitted"], found["rows"], self.response)

    def residuals(self, kind: str = "response", level: str = "conditional") -> pd.Series:
        """Residuals with the index of the data; NaN for skipped rows.

        Parameters
        ----------
        kind : {"response", "pearson", "normalized", "marginal"}
            response: observed minus fitted. pearson: divided by the estimated standard deviation, as
            in nlme. normalized: pearson residuals made independent, which they are here. marginal: of
            the model linear around the estimates with random effects not removed; independent and
            standard normal if the model holds.
        level : {"conditional", "population"}
            Of the first two kinds.
        """
        frame = self._own_frame("residuals()")
        found = self._residuals(frame)
        if kind in ("response", "pearson"):
            values = _level_of(found, level)[kind]
        elif kind in ("normalized", "marginal"):
            values = found[kind]
        else:
            raise UsageError(f"unknown value '{kind}'; available: 'response', 'pearson', 'normalized', 'marginal'",
                             column="kind")
        return frame.aligned(values, found["rows"], f"{kind} residual")

    def _residuals(self, frame: Frame) -> dict:
        with located_in(frame.index):
            return _core.residuals(self._core, frame.table)

    # Inference.

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
        check_number("level", level)
        check_count("threads", threads)
        found = _core.intervals(self._core, frame.table, {"method": method, "level": level, "threads": threads})
        columns = ["name", "kind", "estimate", "lower", "upper", "note"]
        result = pd.DataFrame(found["parameters"], columns=columns).set_index("name")
        result.attrs.update(likelihood=found["likelihood"], method=method, level=level)
        return result

    def simulate(self, count: int = 1, seed: int = 1) -> pd.DataFrame:
        """Draw responses from the fit on the design of its data.

        Random effects of all groups and residuals are new. The same seed gives the same values.

        Returns
        -------
        DataFrame
            With the index of the data, NaN for skipped rows, and columns 0, 1, ... `count` - 1.
        """
        frame = self._own_frame("simulate()")
        check_count("count", count, 1)
        check_count("seed", seed, 0, 2**63 - 1)
        rows, values = _core.simulate(self._core, frame.table, count, seed)
        result = np.full((frame.table.rows, count), np.nan)
        result[np.asarray(rows, dtype=np.intp)] = values
        return pd.DataFrame(result, frame.rows)

    def bootstrap(
        self,
        replicates: int = 500,
        resample: str = "parametric",
        *,
        level: float = 0.95,
        seed: int = 1,
        group: Optional[str] = None,
        threads: int = 0,
        progress: Optional[bool] = None,
    ) -> "Bootstrap":
        """Refit to resampled data, for standard errors and intervals of all parameters.

        Parameters
        ----------
        replicates : int
        resample : {"parametric", "cases"}
            Draw responses from the fit, or whole groups with replacement.
        level : float
            Of the intervals.
        seed : int
            Results depend on the seed, not on the number of threads.
        group : str, optional
            Column of the groups that "cases" draws; default: the coarsest of the random effects.
        threads : int
            0: all cores.
        progress : bool, optional
            Show a bar (tqdm); None: on a terminal.
        """
        frame = self._own_frame("bootstrap()")
        keywords = {"replicates": replicates, "resample": resample, "level": level, "seed": seed,
                    "group": group, "threads": threads}
        with Listener(progress) as listener, located_in(frame.index):
            return Bootstrap(_core.bootstrap(self._core, frame.table, keywords, self._refit_options(), listener))

    def cross_validate(
        self,
        folds: int = 10,
        *,
        group: Optional[str] = None,
        measured: int = 0,
        seed: int = 1,
        threads: int = 0,
        progress: Optional[bool] = None,
    ) -> pd.DataFrame:
        """Predict each group by a fit without it.

        Parameters
        ----------
        folds : int
            0: one group at a time.
        group : str, optional
            Column of the groups; default: the coarsest of the random effects.
        measured : int
            Trees of each left-out group that calibrate the predictions of its other trees.

        Returns
        -------
        DataFrame
            Columns fold, observed, predicted and, with `measured`, calibrated, with the index of the
            data without skipped rows; ``attrs`` has the statistics (r2, mean_error, rmse, mae), the
            mean log predictive density and the folds that failed.
        """
        frame = self._own_frame("cross_validate()")
        keywords = {"folds": folds, "group": group, "measured": measured, "seed": seed, "threads": threads}
        with Listener(progress) as listener, located_in(frame.index):
            found = _core.cross_validate(self._core, frame.table, keywords, self._refit_options(), listener)
        rows = frame.rows[np.asarray(found["rows"], dtype=np.intp)]
        columns = {name: found[name] for name in ("fold", "observed", "predicted")}
        if measured > 0:
            columns["calibrated"] = found["calibrated"]
        result = pd.DataFrame(columns, rows).sort_index(kind="stable")
        result.attrs.update(population=found["population"], mean_log_density=found["mean_log_density"],
                            failed=found["failed"])
        if measured > 0:
            result.attrs["calibrated"] = found["calibrated_statistics"]
        return result

    def _refit_options(self) -> dict:
        return {name: self._options[name] for name in ("fixed", "bounds", "maximum_iterations")
                if name in self._options}

    # Output.

    def summary(self) -> Summary:
        """The fit as text, and as HTML in notebooks."""
        return summary_of(self)

    def plot(self, kind: str = "curves", ax: Any = None, **options: Any) -> Any:
        """Draw the fit with matplotlib.

        Parameters
        ----------
        kind : {"curves", "residuals", "random"}
            curves: data with a curve for each group and that of the population. residuals: Pearson
            residuals over fitted values. random: random effects with 95 % intervals.
        ax : matplotlib Axes, optional
        **options
            curves: ``x``, the column of the horizontal axis, and ``groups``, a list of groups to draw;
            residuals: ``residual``, a kind of `Fit.residuals`, and ``level``; random: ``effect``, a name.

        Returns
        -------
        matplotlib Axes
        """
        from . import _plots

        return _plots.plot(self, kind, ax, **options)

    def to_json(self, path: Union[str, os.PathLike, None] = None, indent: int = -1) -> Optional[str]:
        """The fit as the program's JSON (docs/json.md), as text or into a file."""
        text = self._core.to_json(indent)
        if path is None:
            return text
        pathlib.Path(path).write_text(text + "\n", encoding="utf-8")
        return None

    @classmethod
    def from_json(cls, source: Union[str, os.PathLike]) -> "Fit":
        """Read a fit from JSON text, or from a file that `to_json` or ``silvafit fit --json`` wrote."""
        text = os.fspath(source)
        if text.lstrip().startswith("{"):
            return cls(_core.Fit.from_json(text, ""))
        return cls(_core.Fit.from_json(pathlib.Path(text).read_text(encoding="utf-8"), text))

    def __getstate__(self) -> dict:
        return {"json": self._core.to_json(), "frame": None if self._frame is None else self._frame.state(),
                "options": self._options}

    def __setstate__(self, state: dict) -> None:
        self._core = _core.Fit.from_json(state["json"], "")
        self._frame = None if state["frame"] is None else Frame.restored(state["frame"])
        self._options = state["options"]

    def __copy__(self) -> "Fit":
        return Fit(self._core, self._frame, self._options)

    def __deepcopy__(self, memo: dict) -> "Fit":
        # Nothing in it changes.
        return self.__copy__()

    def __repr__(self) -> str:
        return fit_text(self)

    def _repr_html_(self) -> str:
        return fit_html(self)


def _one_or_dict(found: List[Tuple[str, pd.DataFrame]]) -> Union[pd.DataFrame, Dict[str, pd.DataFrame]]:
    if not found:
        return pd.DataFrame()
    return found[0][1] if len(found) == 1 else dict(found)


def _level_of(residuals: dict, level: str) -> dict:
    if level not in ("population", "conditional"):
        raise UsageError(f"unknown value '{level}'; available: 'population', 'conditional'", column="level")
    return residuals[level]


class Bootstrap:
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

    def __init__(self, found: dict):
        columns = ["name", "estimate", "replicates", "bias", "se", "percentile_lower", "percentile_upper",
                   "basic_lower", "basic_upper"]
        self.parameters = pd.DataFrame(found["parameters"], columns=columns).set_index("name")
        self.values = pd.DataFrame(found["values"].T, columns=self.parameters.index)
        self.replicates: int = found["replicates"]
        self.converged: int = found["converged"]
        self.failures = pd.DataFrame(found["failures"], columns=["reason", "replicates"])
        self.boundary = pd.DataFrame(found["boundary"], columns=["reason", "replicates"])

    def __repr__(self) -> str:
        return f"{self.converged} of {self.replicates} replicates converged\n{self.parameters}"

    def _repr_html_(self) -> str:
        return (f"<p>{self.converged} of {self.replicates} replicates converged</p>"
                + self.parameters.to_html())


def compare(*fits: Fit, names: Optional[Sequence[str]] = None) -> pd.DataFrame:
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
    UserWarning
        If the likelihoods cannot be compared.
    """
    for one in fits:
        if not isinstance(one, Fit):
            raise UsageError(f"only fits can be compared, not {type(one).__name__}; give each as an argument, "
                             "compare(first, second)")
    labels = list(names) if names is not None else _names_of(fits)
    if len(labels) != len(fits):
        raise UsageError(f"there are {len(fits)} fits and {len(labels)} names", column="names")
    found = _core.compare([one._core for one in fits])
    tests = {test["larger"]: test for test in found["tests"]}
    rows = []
    for place, (number, difference, weight) in enumerate(found["fits"]):
        one, test = fits[number], tests.get(place, {})
        rows.append({"name": labels[number], "parameters": one.parameter_count, "loglik": one.loglik,
                     "aic": one.aic, "aicc": one.aicc, "bic": one.bic, "aic_difference": difference,
                     "akaike_weight": weight, "statistic": test.get("statistic", np.nan),
                     "df": test.get("df", np.nan), "p": test.get("p", np.nan),
                     "note": test.get("note") or test.get("reason", "")})
    result = pd.DataFrame(rows).set_index("name") if rows else pd.DataFrame()
    result.attrs["not_converged"] = [labels[number] for number in found["failed"]]
    if found["reason"]:
        warnings.warn(f"the fits cannot be compared: {found['reason']}", stacklevel=2)
    return result


def _names_of(fits: Sequence[Fit]) -> List[str]:
    def name(one: Fit) -> str:
        parts = [one.model or one.formula, *(f"{k} ~ {v}" for k, v in one.parameters.items())]
        parts += [one.random or "", "" if one.variance == "none" else one.variance]
        return ", ".join(part for part in parts if part)

    names = [name(one) for one in fits]
    return names if len(set(names)) == len(names) else [f"{k + 1}: {one}" for k, one in enumerate(names)]
