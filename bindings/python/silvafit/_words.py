# SPDX-License-Identifier: MIT
"""Words of other packages for values of arguments. The names themselves are those of the libraries, whose errors list them."""
from __future__ import annotations

from typing import Any, Dict, List

from ._errors import UsageError, check_text

#: Further choices of settings, by list: nlme's words of a method.
FURTHER_CHOICES: Dict[str, Dict[str, List[str]]] = {"fit": {"method": ["ML", "REML"]}}

_WORDS: Dict[str, Dict[str, str]] = {
    "interval": {"mean": "confidence", "obs": "prediction"},  # statsmodels
    "kind": {"raw": "response", "standardized": "pearson"},  # nlme
    "covariance": {"unstructured": "general", "pdSymm": "general", "pdDiag": "diagonal", "pdIdent": "identity", "pdCompSymm": "compound-symmetry"},
}


def word(name: str, value: Any, *known: str, is_optional: bool = False) -> Any:
    """The value of an argument in our words.

    Parameters
    ----------
    known : str
        What there is, where the libraries do not check it.
    """
    check_text(name, value, is_optional)
    value = _WORDS.get(name, {}).get(value, value)
    if known and value not in known:
        raise UsageError(f"unknown value '{value}'; available: {', '.join(map(repr, known))}", column=name)
    return value
