# SPDX-License-Identifier: MIT
"""The extension (bindings/python/src). The modules of the package give its results their types; use these."""
from typing import Any

__version__: str

def __getattr__(name: str) -> Any: ...
