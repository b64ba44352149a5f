# SPDX-License-Identifier: MIT
"""Linear restrictions of coefficients as text, ``a - 2*b = 3``."""
from __future__ import annotations

import ast
import re
from typing import List, Sequence, Tuple

import numpy as np

from ._errors import UsageError


def linear_restrictions(texts: Sequence[str], names: List[str]) -> Tuple[np.ndarray, np.ndarray]:
    """The combinations (restrictions x coefficients) and their values.

    Parameters
    ----------
    texts : list of str
        Without ``=`` a combination is compared with 0.
    names : list of str
        Of the coefficients.
    """
    found = [_difference(text, names) for text in texts]
    return np.array([one[:-1] for one in found]), np.array([-one[-1] for one in found])


def _difference(text: str, names: List[str]) -> np.ndarray:
    """The left side less the right one: a number for each coefficient, and the constant."""
    def fail(what: str) -> UsageError:
        return UsageError(f"'{text.strip()}' is no linear combination of coefficients: {what}; available: {', '.join(names)}",
                          column="r_matrix")

    # Names between backquotes become words of Python.
    quoted = re.findall("`([^`]*)`", text)
    words = {**{name: name for name in names}, **{f"_{place}": name for place, name in enumerate(quoted)}}
    plain = text
    for place, name in enumerate(quoted):
        plain = plain.replace(f"`{name}`", f"_{place}")

    def value(node: ast.AST) -> np.ndarray:
        result = np.zeros(len(names) + 1)
        if isinstance(node, ast.Constant) and isinstance(node.value, (int, float)):
            result[-1] = node.value
        elif isinstance(node, ast.Name):
            if words.get(node.id) not in names:
                raise fail(f"unknown name '{words.get(node.id, node.id)}'")
            result[names.index(words[node.id])] = 1.0
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.UAdd)):
            result = value(node.operand) * (-1.0 if isinstance(node.op, ast.USub) else 1.0)
        elif isinstance(node, ast.BinOp) and isinstance(node.op, (ast.Add, ast.Sub)):
            result = value(node.left) + value(node.right) * (1.0 if isinstance(node.op, ast.Add) else -1.0)
        elif isinstance(node, ast.BinOp) and isinstance(node.op, (ast.Mult, ast.Div)):
            left, right = value(node.left), value(node.right)
            if right[:-1].any() and (left[:-1].any() or isinstance(node.op, ast.Div)):
                raise fail("coefficients are added and multiplied by numbers only")
            if isinstance(node.op, ast.Div) and right[-1] == 0.0:
                raise fail("a division by 0")
            result = left / right[-1] if isinstance(node.op, ast.Div) else left * right[-1] if not right[:-1].any() else right * left[-1]
        else:
            raise fail("it may have +, -, * and /")
        return result

    try:
        sides = [value(ast.parse(side.strip(), mode="eval").body) for side in plain.split("=")]
    except SyntaxError:
        raise fail("it cannot be read") from None
    if len(sides) > 2:
        raise fail("it has several =")
    return sides[0] if len(sides) == 1 else sides[0] - sides[1]
