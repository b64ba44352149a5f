# SPDX-License-Identifier: MIT
"""Signatures and docstrings of functions that have settings, from the lists of the libraries."""
from __future__ import annotations

import ast
import inspect
import pathlib
import textwrap
from typing import Any, Callable, List, Tuple, TypeVar

from . import _core
from ._words import FURTHER_CHOICES

Function = TypeVar("Function", bound=Callable[..., Any])
#: What the package takes besides the texts and files of the libraries.
_TYPES = {"plots": "Any", "equations": "Union[str, Sequence[str], Mapping[str, str]]",
          "circles": "Union[Sequence[str], Mapping[float, float]]", "lod": "Union[int, Sequence[int]]",
          "covariance": "Union[str, Sequence[str]]", "start": "Union[Mapping[str, float], Series]"}

#: Arguments that mean the same in all functions.
_COMMON = {"threads": "threads : int\n    0: all cores. Results do not depend on it.", "seed": "seed : int\n    Of the random numbers.",
           "progress": "progress : bool, optional\n    Show a bar (tqdm); None: on a terminal."}


def _annotation(key: str, kind: str, preset: Any, choices: List[str]) -> str:
    kind = _TYPES.get(key, f"Literal[{', '.join(map(repr, choices))}]" if choices else kind)
    return f"Optional[{kind}]" if preset in (None, "") and kind != "Any" else kind


def _described(setting: Tuple[Any, ...]) -> str:
    key, kind, preset, choices, meaning = setting
    kind = "{" + ", ".join(f'"{choice}"' for choice in choices) + "}" if choices else _TYPES.get(key, kind)
    default = "optional" if preset in (None, "") else f"default {preset!r}"
    return f"{key} : {kind}, {default}\n" + textwrap.fill(f"{meaning}.", 110, initial_indent="    ", subsequent_indent="    ",
                                                          break_on_hyphens=False)


def takes(*lists: str) -> Callable[[Function], Function]:
    """Gives a function with ``**settings`` the arguments of lists, which its signature, help and editors then show."""

    def decorated(function: Function) -> Function:
        signature = inspect.signature(function)
        *own, last = signature.parameters.values()
        names = {one.name for one in own}
        settings = [(*one[:3], one[3] + FURTHER_CHOICES.get(name, {}).get(one[0], []), one[4])
                    for name in lists for one in _core.settings(name) if one[0] not in names]
        keyword = inspect.Parameter.KEYWORD_ONLY
        further = [inspect.Parameter(one[0], keyword, default=one[2] if one[2] != "" else None, annotation=_annotation(*one[:4]))
                   for one in settings]
        setattr(function, "__signature__", signature.replace(parameters=own + further))
        head, tail = (inspect.getdoc(function) or "").split(f"**{last.name}\n", 1)
        rest = tail.split("\n\n", 1)
        common = [text for name, text in _COMMON.items() if name in names]
        function.__doc__ = "\n".join([head.rstrip(), *common, *map(_described, settings)]) + "".join(f"\n\n{part}" for part in rest[1:])
        return function

    return decorated


def type_declarations() -> str:
    """`__init__.pyi`, for editors and type checkers: the names of the package, with the whole signatures of functions."""
    import silvafit

    functions = {name: function for name in silvafit.__all__
                 if hasattr(function := getattr(silvafit, name), "__signature__")}
    module = ast.parse((pathlib.Path(__file__).parent / "__init__.py").read_text(encoding="utf-8"))
    for node in module.body:
        if isinstance(node, ast.ImportFrom):
            node.names = [one for one in node.names if one.name not in functions]
    module.body = [node for node in module.body if not isinstance(node, ast.ImportFrom) or node.names]
    parts = [ast.unparse(module), "from typing import Any, Dict, Literal, Mapping, Optional, Sequence, Tuple, Union\n"
             "import pandas as pd\nfrom pandas import Series\nfrom ._fit import Parameters\nfrom ._studies import Path"]
    parts += [f"def {name}{inspect.signature(function)}:\n" + textwrap.indent(f'r"""{function.__doc__}"""', "    ")
              for name, function in functions.items()]
    return "\n".join(parts) + "\n"
