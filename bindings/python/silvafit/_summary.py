# SPDX-License-Identifier: MIT
"""Fits as text, which is that of the program."""
from __future__ import annotations

import html


class Summary:
    """A summary: its text when printed, also in a notebook."""

    def __init__(self, text: str):
        self.text = text

    def __str__(self) -> str:
        return self.text

    __repr__ = __str__

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(self.text)}</pre>"
