# SPDX-License-Identifier: MIT
"""Analyses of an inventory: structural units, stand tables, imputation, studies, libraries."""
from __future__ import annotations

import os
import pathlib
from typing import Any, Dict, List, Mapping, Optional, Tuple, Union

import numpy as np
import pandas as pd

from . import _core, _location
from ._analysis import Result, analysis
from ._data import Frame, frame_of, has_geometry, source_of
from ._errors import UsageError, check_text, path_text
from ._fit import Fit
from ._listener import Listener
from ._predictions import coverage_of
from ._settings import takes
from ._summary import Shown
from ._windows import window_arguments

Path = Union[str, os.PathLike]

#: Analyses whose setting `plots` is a table; in those of trees in 3D it has the names of plots.
_WITH_TABLE_OF_PLOTS = ("structural_units", "stand_summary", "stand_growth", "study")


def _index_of(frame: Optional[Frame], rows: Any) -> pd.Index:
    """Labels of the rows that a result has."""
    places = np.asarray(rows, dtype=np.intp)
    return pd.Index(places) if frame is None or frame.index is None else frame.index[places]


def _run(
    name: str, trees: Any, settings: Dict[str, Any], *, window: Any = None, progress: Optional[bool] = False, **further: Any,
) -> Tuple[Result, Optional[Frame], List[str]]:
    """An analysis of trees, their frame, and the notes."""
    source = source_of(trees)
    if getattr(trees, "crs", None) and getattr(window, "crs", None) and trees.crs != window.crs:
        raise UsageError("trees and window have different coordinate reference systems; use window.to_crs(trees.crs)", column="window")
    settings = {**settings, **window_arguments(window)}
    has_table = name in _WITH_TABLE_OF_PLOTS and not isinstance(settings.get("plots"), (str, os.PathLike, type(None)))
    plots = frame_of(settings.pop("plots")).table if has_table else None
    with Listener(progress) as listener:
        found = analysis(name, source, listener=listener, plots=plots, settings=settings, **further)
    return found, source if isinstance(source, Frame) else None, listener.notes


@takes("units", "reading", "sampling")
def structural_units(
    trees: Any, window: Any = None, *, threads: int = 0, progress: Optional[bool] = None, **settings: Any,
) -> pd.DataFrame:
    """Compute the structural indices of every tree: W, M, U, C and further ones.

    Parameters
    ----------
    trees : DataFrame, dict of arrays, GeoDataFrame of points, or path of a CSV file
        Columns plot, tree, species, x, y [m], dbh [cm], and if measured h, hcb, cw [m] and crown radii;
        usual other names and units are recognized (docs/inventory.md).
    window : path, shapely polygon, or GeoDataFrame with a column plot, optional
        The area in which all trees were measured. Default: the convex hull of each plot.
    **settings
        Of structural units, the table and sampled plots (docs/settings.md). plots is a DataFrame or path; circles may be {7: 4, 30: 12}.

    Returns
    -------
    DataFrame
        The inventory with our names, core, W, M, U, C and the further indices, then all other columns of
        a DataFrame, with the index of `trees`; of a GeoDataFrame again one. A column of `trees` with the name
        of a new one and other values is an error. Rows that cannot be used are not in it, with a warning.
        ``attrs`` has notes and the means (summary).
    """
    found, frame, notes = _run("structural_units", trees, settings, window=window, progress=progress, threads=threads)
    units = found.frame("units", _index_of(frame, found.rows))
    _refuse_replaced(trees, units.iloc[:, list(units.columns).index("core"):], found.rows)
    result = _with_own_columns(units, trees, found.rows)
    result.attrs.update(summary=found.json, notes=notes)
    return result


class Stand(Shown):
    """Stand tables, as `stand_summary` returns them.

    Attributes
    ----------
    plots, species, diameters : DataFrame
        Figures of each plot and of all, of each species, and of each diameter class.
    tables : dict of str to DataFrame
        All tables, also strata and classes (joint distributions of two indices).
    summary : dict
        The JSON of ``silvafit stand`` (docs/stand.md).
    notes : list of str
        What was recognized and assumed.
    """

    def __init__(self, found: Result, notes: List[str]):
        self.tables: Dict[str, pd.DataFrame] = {name: found.frame(name) for name in found.tables}
        self.plots, self.species, self.diameters = (self.tables[name] for name in ("plots", "species", "diameters"))
        self.summary: dict = found.json
        self.notes = notes

    def _shown(self) -> pd.DataFrame:
        return self.plots


@takes("stand", "units", "reading", "sampling", "equations")
def stand_summary(trees: Any, window: Any = None, *, threads: int = 0, **settings: Any) -> Stand:
    """Compute stand tables: stems and basal area per hectare, dominant height, species, diameters.

    Parameters
    ----------
    trees, window
        As in `structural_units`.
    **settings
        Of stand figures, structural units, the table, sampled plots and equations (docs/settings.md). equations may be {"A": "taper"}.
    """
    found, _, notes = _run("stand_summary", trees, settings, window=window, threads=threads)
    return Stand(found, notes)


@takes("stand", "units", "reading", "sampling", "equations")
def stand_growth(trees: Any, window: Any = None, *, threads: int = 0, **settings: Any) -> Dict[str, pd.DataFrame]:
    """Compute growth between repeated measurements: increments, ingrowth, mortality and cut.

    Parameters
    ----------
    trees : DataFrame, dict of arrays, or path of a CSV file
        A row for each tree and time, with a column year or date; a column of the status says which
        trees are dead or cut (docs/plots.md).
    window
        As in `structural_units`.
    **settings
        As in `stand_summary`.

    Returns
    -------
    dict of str to DataFrame
        growth_trees, growth_plots and growth_strata. The ``attrs`` of each have the notes and the JSON
        of ``silvafit stand --growth`` (summary).
    """
    found, _, notes = _run("stand_growth", trees, settings, window=window, threads=threads)
    tables = {name: found.frame(name) for name in found.tables}
    for table in tables.values():
        table.attrs.update(summary=found.json, notes=notes)
    return tables


@takes("imputation", "reading")
def impute(trees: Any, response: str = "h", *, seed: int = 1, threads: int = 0, **settings: Any) -> pd.DataFrame:
    """Fill in a response that was measured on some trees only.

    Parameters
    ----------
    trees : DataFrame, dict of arrays, or path of a CSV file
    response : str
    **settings
        Of imputation and the table (docs/settings.md).

    Returns
    -------
    DataFrame
        The trees, with the response filled in, under its name in them, and the columns ``h_source`` (measured,
        imputed, missing), ``h_level`` (plot, stand, population), ``h_flag``, and with ``coverage`` ``h_lower``
        and ``h_upper``; of a dict these columns
        only. ``attrs["models"]`` has the fits by label as JSON, which `Fit.from_json` reads.
    """
    found, frame, notes = _run("impute", trees, settings, response=response, seed=seed, threads=threads,
                               catalogue=_location.catalogue())
    columns = found.frame("columns", _index_of(frame, found.rows))
    # Texts of a file that are all empty would be missing values.
    is_file = "rows" in found.tables
    if is_file:
        result = found.frame("rows").assign(**{name: columns[name].to_numpy() for name in columns})
    else:
        result = _with_columns(trees, columns, found.rows)
    result.attrs.update(models={label: core.to_json() for label, core in found.fits},
                        summary=found.json["sentences"], notes=notes)
    return result


def _with_own_columns(result: pd.DataFrame, trees: Any, rows: Any) -> pd.DataFrame:
    """A result with the columns of a DataFrame that it lacks; of a GeoDataFrame one with its geometry."""
    if not isinstance(trees, pd.DataFrame):
        return result
    own = trees.iloc[np.asarray(rows, dtype=np.intp)]
    further = [name for name in own.columns if str(name) not in result.columns]
    joined = pd.concat([result.set_axis(own.index, axis=0), own[further]], axis=1)
    return type(trees)(joined, geometry=trees.geometry.name, crs=trees.crs) if has_geometry(trees) else pd.DataFrame(joined)


def _refuse_replaced(trees: Any, columns: pd.DataFrame, rows: np.ndarray) -> None:
    """Columns of a DataFrame are not replaced by results with other values."""
    for name in columns.columns.intersection(getattr(trees, "columns", ())):
        if not np.allclose(pd.to_numeric(trees[name].iloc[rows], errors="coerce"), columns[name], rtol=1e-8, atol=0.0, equal_nan=True):
            raise UsageError("the data have a column of this name with other values, which the result would replace; rename or remove it",
                             column=str(name))


def _with_columns(trees: Any, columns: pd.DataFrame, rows: Any) -> pd.DataFrame:
    """A DataFrame with columns of a result, by the places of its rows; for other data the result alone."""
    if not isinstance(trees, pd.DataFrame):
        return columns
    result = trees.copy()
    places = np.asarray(rows, dtype=np.intp)
    for name in columns.columns:
        values = columns[name].to_numpy()
        if name in result.columns:
            column = result[name].to_numpy(np.float64, na_value=np.nan).copy()
        else:
            column = np.full(len(result), None, dtype=object) if values.dtype == object else np.full(len(result), np.nan)
        column[places] = values
        result[name] = column
    return result


class Library(Shown):
    """Models by species and response, for prediction; as `read_library` and `study` return them.

    Attributes
    ----------
    models : DataFrame
        For each model: species, response, unit, role, and its `Fit`.
    """

    def __init__(self, core: Any):
        self._core = core

    @classmethod
    def of(cls, *fits: Fit) -> "Library":
        """A library of fits, each for the left side of its formula and any species."""
        return cls(_core.Library.of([one._core for one in fits]))

    @property
    def models(self) -> pd.DataFrame:
        rows = [{**one, "species": one["species"] or None, "fit": Fit(one["fit"])} for one in self._core.models()]
        return pd.DataFrame(rows, columns=["species", "response", "unit", "role", "fit"])

    def fit(self, response: str, species: Optional[str] = None, role: Optional[str] = None) -> Fit:
        """The only model of a response, a species and a role."""
        for name, value in (("response", response), ("species", species), ("role", role)):
            check_text(name, value, is_optional=name != "response")
        found = [one for one in self._core.models() if one["response"] == response
                 and (species is None or one["species"] == species) and (role is None or one["role"] == role)]
        if len(found) == 1:
            return Fit(found[0]["fit"])
        known = ", ".join(f"{one['species']} {one['response']} {one['role']}" for one in self._core.models())
        raise UsageError(f"{len(found)} models match; available: {known}")

    @takes("predictions", "reading", "equations")
    def predict(
        self, trees: Any, level: str = "population", interval: Optional[str] = None, *, coverage: Optional[float] = None, threads: int = 0, **settings: Any,
    ) -> pd.DataFrame:
        """Predict every response with the model of each tree's species.

        Parameters
        ----------
        trees : DataFrame, dict of arrays, or path of a CSV file
        level, interval, coverage
            As in `Fit.predict`.
        **settings
            Of predictions, the table and equations (docs/settings.md). ``columns={"C": "C"}`` computes an index as in the study.

        Returns
        -------
        DataFrame
            ``h_pred``, with an interval ``h_lower`` and ``h_upper``, ..., those of equations such as
            ``volume_m3``, and ``flag``, with the index of `trees`. Rows of dead trees are not in it.
        """
        found, frame, notes = _run("predict_library", trees, settings, level=level, interval=interval, threads=threads,
                                   coverage=coverage_of(interval, coverage), library=self._core, catalogue=_location.catalogue())
        result = found.frame("columns", _index_of(frame, found.rows))
        result.attrs["notes"] = notes
        return result

    def to_json(self, path: Optional[Path] = None) -> Optional[str]:
        """The library as JSON (docs/json.md), as text or into a file."""
        if path is None:
            return self._core.to_json()
        self._core.write(path_text("path", path))
        return None

    def __getstate__(self) -> dict:
        return {"json": self._core.to_json()}

    def __setstate__(self, state: dict) -> None:
        self._core = _core.Library.from_json(state["json"])

    def _shown(self) -> pd.DataFrame:
        models = self.models
        models["model"] = [one.model or one.formula for one in models.pop("fit")]
        return models


def read_library(name_or_file: Path) -> Library:
    """Read a model library: ``library.json`` of a study, a fit as JSON, or a published one by name.

    Parameters
    ----------
    name_or_file : path or str
        Such as ``"study/library.json"`` or ``"shanxia-2023"``.
    """
    return Library(_core.Library.read(path_text("name_or_file", name_or_file), _location.models_directory()))


class Study(Shown):
    """A study, as `study` returns it.

    Attributes
    ----------
    results : DataFrame
        For each species and response: n, model, covariates, random, variance, R2, verdict, doubts, ...
    library : Library
        The chosen models.
    predictions : DataFrame
        The inventory with the predictions of the chosen models, with the index and all columns of the trees.
    notes : list of str
        What was recognized and assumed.
    out, report : pathlib.Path or None
        The folder of the files, and the report page in it.
    """

    def __init__(self, found: Result, frame: Optional[Frame], trees: Any, out: Optional[Path], notes: List[str]):
        self.summary: dict = found.json
        self.results = pd.DataFrame(self.summary["results"])
        self.library = Library(found.library)
        self.predictions = _with_own_columns(found.frame("predictions", _index_of(frame, found.rows)), trees, found.rows)
        self.notes = notes
        self.out = pathlib.Path(out) if out else None
        self.report = self.out / "report.html" if self.out else None

    def _note(self) -> str:
        return f"Report: {self.report}" if self.report else ""

    def _shown(self) -> pd.DataFrame:
        columns = ["species", "response", "n", "model", "covariates", "random", "variance", "r2_ols", "r2_nlme",
                   "sound"]
        return self.results[[name for name in columns if name in self.results.columns]]


@takes("study", "reading", "rows", "units", "sampling")
def study(
    trees: Any,
    out: Optional[Path] = None,
    *,
    settings: Union[Path, Mapping[str, Any], None] = None,
    window: Any = None,
    threads: int = 0,
    progress: Optional[bool] = None,
    **options: Any,
) -> Study:
    """Run a study: base models, structural covariates and mixed effects for each species and response.

    Parameters
    ----------
    trees : DataFrame, dict of arrays, GeoDataFrame of points, or path of a CSV file
        As in `structural_units`.
    out : path, optional
        Folder for the report, tables and library; default: no files.
    settings : path or dict, optional
        A study.json, or its keys as a dict (docs/study.md); `options` have priority.
    window : path, shapely polygon, or GeoDataFrame, optional
    **options
        Keys of study.json; plots and circles also as in `structural_units`.

    Returns
    -------
    Study
    """
    call = _call(out, settings, window, options)
    if isinstance(settings, Mapping):
        options, settings = {**settings, **options}, None
    if out is not None:
        _location.page("report.html")
    found, frame, notes = _run("study", trees, options, window=window, progress=progress, threads=threads, config=settings, out=out,
                               call=call, catalogue=_location.catalogue())
    return Study(found, frame, trees, out, notes)


def _call(out: Optional[Path], settings: Any, window: Any, options: Dict[str, Any]) -> str:
    """The call for the report, which shows how to repeat a study."""
    def text_of(value: Any) -> str:
        if hasattr(value, "geom_type"):  # polygons
            return "..."
        return repr(os.fspath(value) if isinstance(value, os.PathLike) else value)

    given = {"out": out, "settings": settings, "window": window, **options}
    texts = [f"{name}={text_of(value)}" for name, value in given.items() if value is not None]
    return f"silvafit.study({', '.join(['trees', *texts])})"
