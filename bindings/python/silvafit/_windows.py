# SPDX-License-Identifier: MIT
"""Windows: files, polygons of shapely, and frames of geopandas, as texts."""
from __future__ import annotations

import os
from typing import Any

import pandas as pd

from ._data import check_projected, text_of
from ._errors import UsageError


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
    is_frame = hasattr(window, "crs") and hasattr(window, "geometry")
    if is_frame:
        check_projected(window.geometry)
    shapes = list(window.geometry) if is_frame else [window]
    for shape in shapes:
        if getattr(shape, "geom_type", None) not in ("Polygon", "MultiPolygon"):
            raise UsageError(f"a window is a Polygon or a MultiPolygon, not {getattr(shape, 'geom_type', type(shape).__name__)}",
                             column="window")
    from shapely import wkt  # the polygons are of it

    windows = {"wkt": [wkt.dumps(shape, output_dimension=2) for shape in shapes]}
    if is_frame and "plot" in getattr(window, "columns", ()):
        windows["plot"] = [None if pd.isna(plot) else text_of(plot) for plot in window["plot"]]
    return {"windows": windows}
