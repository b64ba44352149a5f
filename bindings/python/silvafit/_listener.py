# SPDX-License-Identifier: MIT
"""What analyses say while they run: notes by ``logging``, progress by tqdm if it is installed."""
from __future__ import annotations

import logging
import sys
from typing import Any, List, Optional

from ._errors import with_labels

logger = logging.getLogger("silvafit")


def _bar_class(progress: Optional[bool]) -> Any:
    """tqdm's class; None: no bar is wanted, or tqdm is not installed."""
    if progress is False or (progress is None and not sys.stderr.isatty()):
        return None
    try:
        from tqdm.auto import tqdm
    except ImportError:
        if progress:
            raise
        return None
    return tqdm


class Listener:
    """Gets the messages of a piece of work.

    Parameters
    ----------
    progress : bool, optional
        Whether to show a bar; None: if standard error is a terminal and tqdm is installed.
    """

    def __init__(self, progress: Optional[bool] = False):
        self.notes: List[str] = []
        self.index: Any = None  #: of data in memory, whose rows notes name
        self._bar_class = _bar_class(progress)
        self._bar: Any = None

    def __call__(self, kind: str, text: str, done: int, total: int) -> None:
        if kind == "note":
            text = with_labels(text, self.index)
            self.notes.append(text)
            logger.info("%s", text)
        elif kind == "line":
            print(text, file=sys.stderr)
        elif self._bar_class is not None:
            self._show(text, done, total)

    def _show(self, stage: str, done: int, total: int) -> None:
        if self._bar is None or self._bar.desc != f"{stage}: ":
            self.close()
            self._bar = self._bar_class(total=total)
            self._bar.set_description(stage, refresh=False)
        self._bar.total = total
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()
        self._bar = None

    def __enter__(self) -> "Listener":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()
