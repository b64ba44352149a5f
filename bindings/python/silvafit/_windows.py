# SPDX-License-Identifier: MIT
"""Windows: files, polygons of shapely, and frames of geopandas."""
from __future__ import annotations

import os
from typing import Any, Dict, List

import numpy as np
import pandas as pd

from ._data import check_projected
from ._errors import UsageError

#: The plot or None, and polygons: lists of rings, the outer one first.
Window = Dict[str, Any]


def _polygons(shape: Any) -> List[List[np.ndarray]]:
    kind = getattr(shape, "geom_type", None)
    if kind == "MultiPolygon":
        return [rings for part in shape.geoms for rings in _polygons(part)]
    if kind != "Polygon":
        raise UsageError(f"a window is a Polygon or a MultiPolygon, not {kind or type(shape).__name__}",
                         column="window")
    rings = [shape.exterior, *shape.interiors]
    return [[np.asarray(ring.coords, dtype=np.float64)[:, :2] for ring in rings]]


def _label(value: Any) -> str:
    return str(int(value)) if isinstance(value, (float, np.floating)) and float(value).is_integer() else str(value)


def _windows_of_frame(frame: Any) -> List[Window]:
    check_projected(frame.geometry)
    if "plot" not in frame.columns:
        return [{"polygons": [rings for shape in frame.geometry for rings in _polygons(shape)]}]
    windows: dict = {}
    for plot, shape in zip(frame["plot"], frame.geometry):
        key = None if pd.isna(plot) else _label(plot)
        windows.setdefault(key, []).extend(_polygons(shape))
    return [{"plot": plot, "polygons": polygons} for plot, polygons in windows.items()]


def window_arguments(window: Any) -> dict:
    """The keywords of the libraries for a window.

    Parameters
    ----------
    window : path, shapely Polygon or MultiPolygon, GeoDataFrame or GeoSeries, or None
        A column `plot` of a frame names the plot of each polygon.
    """
    if window is None:
        return {}
    if isinstance(window, (str, os.PathLike)):
        return {"window": os.fspath(window)}
    if hasattr(window, "crs") and hasattr(window, "geometry"):
        frame = window if isinstance(window, pd.DataFrame) else window.to_frame("geometry")
        return {"windows": _windows_of_frame(frame)}
    return {"windows": [{"polygons": _polygons(window)}]}
