# SPDX-License-Identifier: MIT
"""Data and paths of the tests. SILVAFIT_SOURCE is the checkout, SILVAFIT_PROGRAM the built program."""
import os
import pathlib
import subprocess

import pandas as pd
import pytest

import silvafit as sf

SOURCE = pathlib.Path(os.environ.get("SILVAFIT_SOURCE", pathlib.Path(__file__).parents[3]))
FORMULA = "h ~ 1.3 + a*(1 - exp(-b*dbh))"


@pytest.fixture(scope="session")
def source():
    return SOURCE


@pytest.fixture(scope="session")
def program():
    """Runs the built program; tests that need it are skipped where it is not built."""
    path = pathlib.Path(os.environ.get("SILVAFIT_PROGRAM", SOURCE / "build/bin/silvafit"))
    if not path.is_file():
        pytest.skip("the program is not built")

    def run(*arguments):
        done = subprocess.run([str(path), *map(str, arguments)], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


@pytest.fixture(scope="session")
def stands_file(source):
    return source / "tests/reference/data/stands.csv"


@pytest.fixture(scope="session")
def stands(stands_file):
    return pd.read_csv(stands_file)


@pytest.fixture(scope="session")
def inventory(source):
    return pd.read_csv(source / "examples/fir-mixed/inventory.csv")


@pytest.fixture(scope="session")
def mixed(stands):
    return sf.fit(FORMULA, stands, random="a + b | plot", variance="power")
