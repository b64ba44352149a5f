# SPDX-License-Identifier: MIT
"""The notebook of the documentation runs without an error, and shows what it says."""
import json
import os
import pathlib
import subprocess
import sys

import pytest

import silvafit as sf


def test_the_notebook_runs(source, tmp_path):
    pytest.importorskip("nbconvert")
    pytest.importorskip("ipykernel")
    notebook = source / "examples/python/height-curves.ipynb"
    environment = dict(os.environ, PYTHONPATH=str(pathlib.Path(sf.__file__).parents[1]), SILVAFIT_SOURCE=str(source), JUPYTER_DATA_DIR=str(tmp_path / "data"),
                       IPYTHONDIR=str(tmp_path / "ipython"), MPLBACKEND="module://matplotlib_inline.backend_inline",
                       JUPYTER_ALLOW_INSECURE_WRITES="1")
    # A kernel of this interpreter, whatever kernels the machine has.
    subprocess.run([sys.executable, "-m", "ipykernel", "install", "--prefix", str(tmp_path / "prefix")], check=True,
                   capture_output=True)
    environment["JUPYTER_PATH"] = str(tmp_path / "prefix/share/jupyter")
    done = subprocess.run(
        [sys.executable, "-m", "nbconvert", "--to", "notebook", "--execute", "--output-dir", str(tmp_path),
         "--ExecutePreprocessor.timeout=600", str(notebook)], env=environment, capture_output=True, text=True,
        check=False)
    assert done.returncode == 0, done.stderr[-3000:]
    cells = json.loads((tmp_path / "height-curves.ipynb").read_text())["cells"]
    shown = ["".join("".join(data) for output in cell.get("outputs", ()) for data in output.get("data", {}).values())
             for cell in cells]
    everything = "\n".join(shown)
    assert "Converged after" in everything
    assert "<iframe srcdoc=" in everything and "image/png" in json.dumps(cells)
    assert "akaike_weight" in everything and "calibrated_upper" in everything
