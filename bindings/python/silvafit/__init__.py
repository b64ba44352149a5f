# SPDX-License-Identifier: MIT
"""silvafit: nonlinear mixed-effects models, structural indices and 3D trees for forest inventories."""
from typing import Any as _Any

import pandas as _pd

from . import _location
from ._core import __version__
from ._errors import (ConvergenceWarning, DomainError, Error, FileError, FormulaError, GeometryError,
                      InputError, NumericalError, SilvafitWarning, UsageError)
from ._fit import Fit, fit
from ._inference import Bootstrap, compare
from ._predictions import Prediction
from ._studies import (Library, Stand, Study, impute, read_library, stand_growth, stand_summary,
                       structural_units, study)
from ._summary import Summary
from ._trees import View, grow, view

__all__ = [
    "Bootstrap", "ConvergenceWarning", "DomainError", "Error", "FileError", "Fit", "FormulaError", "GeometryError",
    "InputError", "Library", "NumericalError", "Prediction", "SilvafitWarning", "Stand", "Study", "Summary", "UsageError", "View", "compare", "fit",
    "grow", "impute", "models", "read_library", "stand_growth", "stand_summary", "structural_units", "study", "view",
]


def models() -> _pd.DataFrame:
    """The base models of the catalogue: id, name, response, formula, parameters, covariates."""
    return _pd.DataFrame(_location.catalogue().models()).set_index("id")


def __dir__() -> _Any:
    return [*__all__, "__version__"]
