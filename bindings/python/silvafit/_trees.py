# SPDX-License-Identifier: MIT
"""Trees in 3D: files, and pages that notebooks show."""
from __future__ import annotations

import html
import os
import pathlib
import tempfile
import webbrowser
from typing import Any, Optional

from . import _location
from ._errors import UsageError, check_text, path_text
from ._settings import takes
from ._studies import Path, _run

_SCENES = (".glb", ".gltf", ".obj", ".ply")


@takes("grow", "reading")
def grow(trees: Any, out: Path, *, seed: int = 1, threads: int = 0, progress: Optional[bool] = None, **settings: Any) -> dict:
    """Grow the trees of a table as 3D models.

    Parameters
    ----------
    trees : DataFrame, dict of arrays, or path of a CSV file
        Columns plot, tree, species, dbh [cm], h, hcb, cw [m], and x, y [m] for a scene.
    out : path
        A file (.glb, .gltf, .obj, .ply) of all trees at their positions, or a folder of one file per tree.
    **settings
        Of trees and scenes, and the table (docs/settings.md).

    Returns
    -------
    dict
        What was written: the JSON of ``silvafit grow`` (docs/json.md).
    """
    path = pathlib.Path(path_text("out", out))
    if settings.pop("scene", None) is not None:
        raise UsageError("the file of the scene is the argument out", column="scene")
    files = {"scene" if path.suffix.lower() in _SCENES else "out": str(path)}
    return _run("grow", trees, settings, progress=progress, seed=seed, threads=threads, **files)[0].json


class View:
    """A 3D page of a stand; a notebook shows it in a frame.

    Attributes
    ----------
    path : pathlib.Path or None
        The file, if one was asked for.
    html : str
        The page.
    summary : dict
        The JSON of ``silvafit view``.
    height : int
        Height of the frame [pixels].
    """

    def __init__(self, page: str, path: Optional[pathlib.Path], summary: dict, height: int):
        self.html = page
        self.path = path
        self.summary = summary
        self.height = height

    def save(self, path: Path) -> None:
        """Write the page."""
        pathlib.Path(path).write_text(self.html, encoding="utf-8")

    def open(self) -> None:
        """Show the page in the browser, from its file or a temporary one."""
        path = self.path
        if path is None:
            with tempfile.NamedTemporaryFile(prefix="silvafit-", suffix=".html", delete=False) as file:
                path = pathlib.Path(file.name)
            self.save(path)
        webbrowser.open(path.resolve().as_uri())

    def __repr__(self) -> str:
        return f"3D page of {self.summary['trees']} trees" + (f": {self.path}" if self.path else "")

    def _repr_html_(self) -> str:
        # The page is part of the notebook, so that it is shown wherever this is opened.
        return (f'<iframe srcdoc="{html.escape(self.html)}" width="100%" height="{self.height}" '
                'style="border:1px solid #ccc" title="3D view of the stand" allowfullscreen></iframe>')


@takes("view", "reading")
def view(
    trees: Any, out: Optional[Path] = None, *, title: Optional[str] = None, height: int = 600, seed: int = 1, threads: int = 0, **settings: Any,
) -> View:
    """Make a 3D page of a stand, which a notebook shows.

    Parameters
    ----------
    trees : DataFrame, dict of arrays, GeoDataFrame of points, or path
        A table of trees with positions (x, y), the folder of a study, or a GLB scene.
    out : path, optional
        File for the page, which any browser opens; default: none.
    title : str, optional
    height : int
        Height of the frame in a notebook [pixels].
    **settings
        Of the 3D page and the table (docs/settings.md).
    """
    _location.page("scene.html")
    check_text("title", title)
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(path_text("out", out)) if out is not None else pathlib.Path(folder) / "view.html"
        is_file = isinstance(trees, (str, os.PathLike))
        found, _, _ = _run("view", trees, settings, file=path, seed=seed, threads=threads, title=title or (None if is_file else "Stand"))
        text = path.read_text(encoding="utf-8")
    return View(text, None if out is None else path, found.json, height)
