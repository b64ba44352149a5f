# SPDX-License-Identifier: MIT
"""The code of docs/python.md runs, block after block."""
import re
import warnings

import pytest

import silvafit as sf


def test_the_code_of_the_page_runs(source, monkeypatch, capsys):
    matplotlib = pytest.importorskip("matplotlib")
    pytest.importorskip("sklearn")
    matplotlib.use("Agg")
    monkeypatch.chdir(source)
    text = (source / "docs/python.md").read_text(encoding="utf-8")
    blocks = re.findall(r"^```python\n(.*?)^```", text, flags=re.S | re.M)
    assert len(blocks) > 8
    names = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", sf.ConvergenceWarning)
        for block in blocks:
            exec(compile(block, "docs/python.md", "exec"), names)  # noqa: S102
    printed = capsys.readouterr().out
    assert "Converged after" in printed
    assert "h: " in printed and "above breast height" in printed
    matplotlib.pyplot.close("all")
