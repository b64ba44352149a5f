# SPDX-License-Identifier: MIT
"""Trees in 3D: files, and pages that notebooks show."""
from __future__ import annotations

import html
import json
import os
import pathlib
import tempfile
import webbrowser
from typing import Any, List, Optional, Sequence, Union

from . import _core, _location
from ._data import source_of
from ._errors import located_in
from ._listener import Listener

Path = Union[str, os.PathLike]
_SCENES = (".glb", ".gltf", ".obj", ".ply")


def grow(
    trees: Any,
    out: Path,
    *,
    plots: Sequence[Any] = (),
    builder: str = "segment",
    lod: Union[int, Sequence[int]] = 0,
    seed: int = 1,
    threads: int = 0,
    progress: Optional[bool] = None,
    **options: Any,
) -> dict:
    """Grow the trees of a table as 3D models.

    Parameters
    ----------
    trees : DataFrame, dict of arrays, or path of a CSV file
        Columns plot, tree, species, dbh [cm], h, hcb, cw [m], and x, y [m] for a scene.
    out : path
        A file (.glb, .gltf, .obj, .ply) of all trees at their positions, or a folder of one file per tree.
    plots : list, optional
        Plots to grow; default: all.
    builder : {"segment", "lsystem", "ifs", "bamboo"}
    lod : int or list of int
        Level of detail, 0 (finest) to 3; several are written to separate files.
    seed, threads : int
    progress : bool, optional
        Show a bar (tqdm); None: on a terminal.
    **options
        use, format, preset, grammar, resolve_overlaps, share, models, ground, instancing, quantize,
        compress, ascii, textures, by, animate, seconds (docs/trees.md), and how the table is read.

    Returns
    -------
    dict
        What was written: the JSON of ``silvafit grow`` (docs/json.md).
    """
    source, frame = source_of(trees)
    path = pathlib.Path(out)
    target = {"scene": str(path)} if path.suffix.lower() in _SCENES else {"out": str(path)}
    keywords = {"plots": _labels(plots), "builder": builder, "lod": _levels(lod), "seed": seed,
                "threads": threads, **target, **options}
    with Listener(progress) as listener, located_in(None if frame is None else frame.rows):
        return json.loads(_core.grow(source, _location.models_directory(), keywords, listener))


def _labels(plots: Sequence[Any]) -> List[str]:
    return [str(plot) for plot in plots]


def _levels(lod: Union[int, Sequence[int]]) -> List[int]:
    return [lod] if isinstance(lod, int) else list(lod)


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


def view(
    trees: Any,
    out: Optional[Path] = None,
    *,
    plots: Sequence[Any] = (),
    title: Optional[str] = None,
    models: int = 6,
    lod: Sequence[int] = (0, 1, 2, 3),
    height: int = 600,
    seed: int = 1,
    threads: int = 0,
    **options: Any,
) -> View:
    """Make a 3D page of a stand, which a notebook shows.

    Parameters
    ----------
    trees : DataFrame, dict of arrays, GeoDataFrame of points, or path
        A table of trees with positions (x, y), the folder of a study, or a GLB scene.
    out : path, optional
        File for the page, which any browser opens; default: none.
    plots : list, optional
        Plots to show; default: all.
    title : str, optional
    models : int
        Number of models that the trees of a species preset share.
    lod : list of int
        Levels of detail in the page.
    height : int
        Height of the frame in a notebook [pixels].
    """
    source, frame = source_of(trees)
    keywords = {"plots": _labels(plots), "title": title or ("Stand" if frame is not None else None),
                "models": models, "lod": list(lod), "seed": seed, "threads": threads, **options}
    with tempfile.TemporaryDirectory() as folder, located_in(None if frame is None else frame.rows):
        path = pathlib.Path(out) if out is not None else pathlib.Path(folder) / "view.html"
        summary = _core.view(source, _location.models_directory(), _location.page("scene.html"), str(path), keywords,
                             Listener())
        text = path.read_text(encoding="utf-8")
    return View(text, None if out is None else path, json.loads(summary), height)
