# SPDX-License-Identifier: MIT
"""How results are shown: fits as the text of the program, others as their main table."""
from __future__ import annotations

import html

import pandas as pd


class Shown:
    """A result that is shown as a table, also in a notebook."""

    def _shown(self) -> pd.DataFrame:
        raise NotImplementedError

    def _note(self) -> str:
        """A line beside the table."""
        return ""

    def __repr__(self) -> str:
        return "\n".join(filter(None, [repr(self._shown()), self._note()]))

    def _repr_html_(self) -> str:
        return self._shown().to_html() + (f"<p>{html.escape(self._note())}</p>" if self._note() else "")


class Summary:
    """A summary: its text when printed, also in a notebook."""

    def __init__(self, text: str):
        self.text = text

    def __str__(self) -> str:
        return self.text

    __repr__ = __str__

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(self.text)}</pre>"
