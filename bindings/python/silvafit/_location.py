# SPDX-License-Identifier: MIT
"""Where the catalogue and the bundled pages are."""
from __future__ import annotations

import functools
import os
import pathlib
from typing import Any

from . import _core


def data_directory() -> pathlib.Path:
    """The folder with models/ and viewer/: that of the package, or SILVAFIT_DATA_DIR."""
    named = os.environ.get("SILVAFIT_DATA_DIR")
    return pathlib.Path(named) if named else pathlib.Path(__file__).parent / "share"


def models_directory() -> str:
    return str(data_directory() / "models")


@functools.lru_cache(maxsize=4)
def _catalogue_of(folder: str) -> Any:
    return _core.Catalogue(folder)


def catalogue() -> Any:
    """The base models, read once."""
    return _catalogue_of(models_directory())


def page(name: str) -> str:
    """A bundled page: report.html or scene.html."""
    from ._errors import InputError

    path = data_directory() / "viewer" / name
    if not path.is_file():
        raise InputError("the page template is not part of this package; build it with npm "
                         "(SILVAFIT_BUILD_VIEWER)", file=str(path))
    return str(path)
