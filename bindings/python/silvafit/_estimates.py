# SPDX-License-Identifier: MIT
"""What a fit is, what it estimated, and its data."""
from __future__ import annotations

import dataclasses
import functools
import json
from typing import Any, Callable, Dict, Iterable, List, Optional, Tuple, TypeVar, Union, cast

import numpy as np
import pandas as pd

from . import _core
from ._data import Frame, data_frame, frame_of, restored_labels
from ._errors import UsageError, located_in, warn

#: What indices need of an inventory.
_INVENTORY = ("plot", "tree", "species", "x", "y", "dbh", "h", "cw", "cr_e", "cr_w", "cr_s", "cr_n")

Value = TypeVar("Value")


def model_frame(data: Any, texts: List[str], mentioned: List[str], response: str) -> Frame:
    """The mentioned columns, and what is computed of others: the response if it is an expression, and
    structural indices (C, W, ...) that the data lack, if they have positions."""
    computed: List[str] = []

    def choose(names: List[str]) -> List[str]:
        computed.extend(_core.structure_names(texts, names))
        wanted = {*mentioned, *(_INVENTORY if computed else ())}
        return [name for name in names if name in wanted]

    frame = frame_of(data, choose)
    if not computed and response in ("", *frame.table.names):
        return frame
    with located_in(frame.rows):
        table, notes = _core.with_computed(frame.table, computed, response)
    for note in notes:
        warn(note)
    keep = [(name, column) for name, column in table.columns() if name in {*mentioned, response}]
    return dataclasses.replace(frame, table=_core.table(table.rows, keep))


def random_terms(json: Dict[str, Any]) -> List[Dict[str, Any]]:
    """The random effects in the JSON of a fit: a term for each grouping, the coarser first.

    Each has the name of its group, `columns`, `names` of the effects, `form` and `covariance`, `labels` (joined ones),
    `effects` (groups x effects), their conditional standard errors `se` (None if they are not known), and whether it is `crossed`.
    """
    terms: List[Dict[str, Any]] = []
    columns: List[str] = []
    for name, term in zip(json["groups"], json["random"]):
        columns = [*term.get("within", columns), term["group"]]
        terms.append({"group": name, "columns": columns, "names": term["effects"], "form": term["form"], "labels": list(term["eblup"]),
                      "covariance": np.array(term["covariance"], float), "effects": _matrix(term["eblup"], term["effects"]),
                      "se": _matrix(term["eblup_se"], term["effects"]) if "eblup_se" in term else None, "crossed": "within" in term})
    return terms


def _labels_by_column(labels: Iterable[str], columns: int) -> List[List[str]]:
    """The parts of joined labels, in which slashes of the coarser groups are escaped."""
    parts = [label.split("/", columns - 1) for label in labels]
    return [[one[k].replace("%2F", "/") if k + 1 < columns else one[k] for one in parts] for k in range(columns)]


def group_index(labels: Iterable[str], columns: List[str], known: Dict[str, Any]) -> pd.Index:
    """Joined labels of groups as an index of their columns, in the types of the data."""
    own = [restored_labels(texts, known.get(column)) for column, texts in zip(columns, _labels_by_column(labels, len(columns)))]
    if len(own) == 1:
        return pd.Index(own[0], name=columns[0], tupleize_cols=False)
    return pd.MultiIndex.from_arrays(own, names=columns)


def _matrix(groups: Dict[str, Dict[str, float]], effects: List[str]) -> np.ndarray:
    """Values by group and effect; null is NaN."""
    return np.array([list(one.values()) for one in groups.values()], float).reshape(-1, len(effects))


def _value(key: str, kind: Callable[[Any], Value], meaning: str) -> Value:
    """An element of the JSON of a fit (docs/json.md) as a read-only attribute; a number that is missing is NaN."""
    def get(self: Estimates) -> Any:
        value = self._json[key]
        return value if value is not None or kind is str else kind("nan" if kind is float else 0)

    get.__doc__ = meaning
    get.__annotations__["return"] = kind
    return cast(Value, property(get))


class Estimates:
    """The part of a fit that needs no computation."""

    def __init__(self, core: Any, frame: Optional[Frame] = None, arguments: Optional[dict] = None):
        self._core = core
        self._frame = frame
        self._arguments = arguments or {}  # of fit(), for update() and refits

    @functools.cached_property
    def _json(self) -> Dict[str, Any]:
        return json.loads(self._core.to_json())

    @functools.cached_property
    def _random_terms(self) -> List[Dict[str, Any]]:
        return random_terms(self._json)

    # What the model is.

    formula = _value("formula", str, "The formula.")
    model = _value("model", str, "Id in the catalogue, or None.")
    method = _value("method", str, "The method: ols, gnls, lb, foce, focei, laplace or agq.")
    reml = _value("reml", bool, "Whether it is a fit by restricted maximum likelihood.")

    @property
    def parameters(self) -> Dict[str, str]:
        """Linear sub-models, such as ``{"b": "1 + C"}``."""
        return dict(self._json["parameters"])

    @property
    def random(self) -> Optional[str]:
        """The random effects, ``"a + b | plot"``, or None."""
        return self._core.random_text or None

    @property
    def variance(self) -> str:
        """The variance function, ``"none"`` for a constant variance."""
        return self._core.variance

    @property
    def correlation(self) -> str:
        """The correlation of the residuals, such as ``"car1(age)"``; ``"none"`` if they are independent."""
        return self._json.get("correlation", {}).get("structure", "none")

    @property
    def response(self) -> str:
        """The response: a column, or an expression such as ``"log(h)"``."""
        return self._core.response

    # How it was fitted.

    converged = _value("converged", bool, "Whether the fit reached a maximum; otherwise do not use its estimates.")
    status = _value("status", str, 'How the fit ended: ``"converged"``, ``"boundary"``, ``"no_maximum"``, ... (docs/json.md).')

    @property
    def verdict(self) -> str:
        """The convergence message: whether and why the fit converged, or what failed and what to try."""
        return self._core.verdict

    @property
    def evidence(self) -> pd.DataFrame:
        """The findings behind the verdict: kind, term, value."""
        return pd.DataFrame(self._json["evidence"]["findings"], columns=["kind", "term", "value"]).astype({"value": float})

    @property
    def optima(self) -> pd.DataFrame:
        """All maxima of the likelihood that were found, the reported one first."""
        found = pd.DataFrame([{**one, **one["fixed"]} for one in self._json.get("optima", [])]).drop(columns="fixed", errors="ignore")
        return found.astype({name: float for name in found.columns if name != "origin"})

    # Estimates.

    @property
    def coefficients(self) -> pd.DataFrame:
        """Estimate, standard error, degrees of freedom, t and p of each coefficient."""
        return pd.DataFrame.from_dict(self._json["fixed"], "index", float, ["estimate", "se", "df", "t", "p"])

    @property
    def fixed_effects(self) -> pd.Series:
        """Estimates of the coefficients."""
        return self.coefficients["estimate"]

    params = fe_params = fixed_effects

    @property
    def standard_errors(self) -> pd.Series:
        """Standard errors of the coefficients."""
        return self.coefficients["se"]

    bse = bse_fe = standard_errors

    @property
    def tvalues(self) -> pd.Series:
        """t values of the coefficients."""
        return self.coefficients["t"]

    @property
    def pvalues(self) -> pd.Series:
        """p values of the coefficients, two-sided."""
        return self.coefficients["p"]

    @property
    def covariance(self) -> pd.DataFrame:
        """Covariance matrix of the coefficients."""
        names = list(self._json["fixed"])
        return pd.DataFrame(self._json["fixed_covariance"], names, names, float)

    def cov_params(self) -> pd.DataFrame:
        """`covariance` by statsmodels' name."""
        return self.covariance

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
    def group_coefficients(self) -> Union[pd.DataFrame, Dict[str, pd.DataFrame]]:
        """Coefficients of each group, the sum of fixed and random effects, as coef() of nlme has them.

        With several groupings a dict; the groups of the finer one have the effects of the coarser, too. With
        crossed groupings, as coef() of lme4 has them, only their own.
        """
        found: List[Tuple[str, pd.DataFrame]] = []
        outer = pd.DataFrame()
        for term in self._random_terms:
            effects = pd.DataFrame(term["effects"], self._groups_of(term), term["names"])
            effects = effects.reindex(columns=self.fixed_effects.index, fill_value=0.0)
            if found and not term["crossed"]:
                effects += outer.loc[effects.index.get_level_values(0)].to_numpy()
            found.append((term["group"], effects + self.fixed_effects))
            outer = effects
        return one_or_dict(found)

    @property
    def random_covariance(self) -> Union[pd.DataFrame, Dict[str, pd.DataFrame]]:
        """Covariance matrix of the random effects; with several groupings a dict."""
        found = [(term["group"], pd.DataFrame(term["covariance"], term["names"], term["names"]))
                 for term in self._random_terms]
        return one_or_dict(found)

    cov_re = random_covariance

    @property
    def variance_components(self) -> pd.Series:
        """Standard deviations and correlations of random effects, parameters of the variance function, sigma."""
        pairs = [(name, value) for name, value in self._core.parameter_values if name not in self._json["fixed"]]
        return pd.Series([value for _, value in pairs], [name for name, _ in pairs], name="estimate")

    @property
    def derived(self) -> pd.DataFrame:
        """The functions of the coefficients that ``fit(derive={"h30": "..."})`` named: expression, estimate, se, df."""
        found = self._json.get("derived", {})
        return pd.DataFrame(list(found.values()), list(found), ["expression", "estimate", "se", "df"])

    sigma = _value("sigma", float, "Residual standard deviation, the factor of the variance function.")

    @property
    def scale(self) -> float:
        """The square of sigma."""
        return self.sigma**2

    def _of_terms(self, what: str) -> Union[pd.DataFrame, Dict[str, pd.DataFrame]]:
        found = []
        for term in self._random_terms:
            if term[what] is None:
                raise UsageError("the file that this fit is from does not have standard errors of random effects")
            found.append((term["group"], pd.DataFrame(term[what], self._groups_of(term), term["names"])))
        return one_or_dict(found)

    def _groups_of(self, term: dict) -> pd.Index:
        return group_index(term["labels"], term["columns"], self._frame.labels if self._frame is not None else {})

    # Numbers on the whole fit.

    nobs = _value("n", int, "Number of rows used.")
    excluded = _value("excluded", int, "Number of rows skipped because a value is missing.")
    loglik = llf = _value("log_likelihood", float, "Log-likelihood.")
    parameter_count = _value("k", int, "Number of estimated parameters, with variances and sigma.")
    aic = _value("aic", float, "Akaike's information criterion.")
    aicc = _value("aicc", float, "AIC with the correction for small samples.")
    bic = _value("bic", float, "Bayesian information criterion with n observations.")
    bic_groups = _value("bic_groups", float, "BIC with the number of independent groups; NaN without random effects.")

    @property
    def groups(self) -> Dict[str, int]:
        """Number of groups by column."""
        return {term["group"]: len(term["labels"]) for term in self._random_terms}

    @property
    def df_model(self) -> int:
        """Number of estimated coefficients; with a coefficient of the intercept statsmodels' least squares have one less."""
        return int(self.standard_errors.notna().sum())

    @property
    def df_resid(self) -> int:
        """Number of rows less that of the estimated coefficients."""
        return self.nobs - self.df_model

    @property
    def statistics(self) -> pd.DataFrame:
        """R2, mean error, RMSE and MAE of the population and, with random effects, conditional level."""
        return pd.DataFrame({level: values for level, values in self._json["statistics"].items() if values}).T.astype(float)

    @property
    def r2(self) -> pd.Series:
        """Proportions of variance explained by fixed (marginal), and fixed and random effects (conditional)."""
        return pd.Series({level: self._json[f"r2_{level}"] for level in ("marginal", "conditional")}, dtype=float)

    @property
    def rsquared(self) -> float:
        """R2 of `fittedvalues`: 1 - sum of squared residuals / sum of squares around the mean."""
        return float(self.statistics["r2"].iloc[-1])

    # Data.

    @property
    def data(self) -> Optional[pd.DataFrame]:
        """The columns of the data that the model uses, or None for a fit from a file."""
        return None if self._frame is None else data_frame(self._frame.table, self._frame.rows, self._frame.labels, are_data=True)

    def _frame_for(self, data: Any, needs_response: bool = True) -> Frame:
        columns = list(self._core.columns)
        if needs_response:
            columns += self._core.response_columns
        texts = [f"{name} ~ {text}" for name, text in self.parameters.items()]
        frame = model_frame(data, texts, columns, self.response if needs_response else "")
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


def one_or_dict(found: List[Tuple[str, pd.DataFrame]]) -> Union[pd.DataFrame, Dict[str, pd.DataFrame]]:
    if not found:
        return pd.DataFrame()
    return found[0][1] if len(found) == 1 else dict(found)
