# SPDX-License-Identifier: MIT
"""The package is complete: data, types and documentation."""
import ast
import inspect
import pathlib
import re
import shutil
import subprocess
import sys

import pytest

import silvafit as sf
from silvafit import _core, _location
from silvafit.sklearn import MixedRegressor

PACKAGE = pathlib.Path(sf.__file__).parent


def test_the_catalogue_and_the_pages_are_in_the_package(monkeypatch):
    monkeypatch.delenv("SILVAFIT_DATA_DIR", raising=False)
    share = _location.data_directory()
    assert share.resolve().is_relative_to(PACKAGE.resolve())
    for part in ("models/base", "models/presets", "models/published"):
        assert any((share / part).iterdir())
    assert not any(path.is_symlink() for path in share.rglob("*"))
    for page in ("report.html", "scene.html"):
        assert pathlib.Path(_location.page(page)).stat().st_size > 10000


def test_the_package_needs_no_library_that_a_linux_may_lack():
    if not (PACKAGE / "libs").is_dir():
        pytest.skip("built without patchelf")
    files = [path for path in PACKAGE.rglob("*.so*") if path.suffix != ".copyright"]
    needed = {name for path in files for name in re.findall(
        r"NEEDED.*\[(.*)\]", subprocess.run(["readelf", "-d", path], capture_output=True, text=True, check=True).stdout)}
    own = {path.name for path in (PACKAGE / "libs").iterdir()}
    # The libraries that every manylinux policy allows.
    system = {"libc.so.6", "libm.so.6", "libgcc_s.so.1", "libstdc++.so.6", "ld-linux-x86-64.so.2"}
    assert needed - own <= system
    for library in needed & own:
        assert (PACKAGE / "libs" / f"{library}.copyright").stat().st_size > 500


def test_the_type_declarations_have_every_setting_with_its_words():
    # Written by setup.py, from the lists of the libraries.
    text = (PACKAGE / "__init__.pyi").read_text(encoding="utf-8")
    declared = {node.name: node for node in ast.parse(text).body if isinstance(node, ast.FunctionDef)}
    assert set(declared) >= {"fit", "study", "structural_units", "stand_summary", "stand_growth", "impute", "grow", "view"}
    for name in set(declared) - {"models"}:
        arguments = [one.arg for one in declared[name].args.args + declared[name].args.kwonlyargs]
        assert arguments == list(inspect.signature(getattr(sf, name)).parameters), name
    assert "Literal['buffer', 'hanisch', 'torus', 'none']" in text and (PACKAGE / "py.typed").is_file()


def _documented(owner):
    members = {name: member for part in reversed(owner.__mro__) if part.__module__.startswith("silvafit")
               for name, member in vars(part).items()}
    for name, member in members.items():
        if name.startswith("_"):
            continue
        function = member.fget if isinstance(member, property) else getattr(member, "__func__", member)
        if inspect.isfunction(function):
            yield name, function


def test_everything_public_has_a_docstring_and_types():
    functions = [(name, getattr(sf, name)) for name in sf.__all__ if inspect.isfunction(getattr(sf, name))]
    for owner in (sf.Fit, sf.Prediction, sf.Library, sf.View, MixedRegressor):
        functions += _documented(owner)
    assert len(functions) > 50
    for name, function in functions:
        parameters = inspect.signature(function).parameters
        assert function.__annotations__.get("return") is not None, name
        assert all(parameter.annotation is not inspect.Parameter.empty
                   for parameter in parameters.values() if parameter.name != "self" and parameter.name != "cls"), name
        if name not in ("plots", "species", "diameters", "models"):
            assert inspect.getdoc(function), name


def test_the_types_agree(tmp_path):
    if shutil.which("mypy") is None:
        pytest.skip("mypy is not installed")
    user = tmp_path / "user.py"
    user.write_text("import silvafit as sf\n"
                    "fit = sf.fit('h ~ a', {'h': [1.0]}, bounds={'a': (0, None)})\n"
                    "sf.structural_units({}, edge='bufer')\n"
                    "fit.loglik + 1.0\n"
                    "fit.loglik.upper()\n")
    done = subprocess.run(["mypy", "--python-executable", sys.executable, "--ignore-missing-imports", "--cache-dir",
                           str(tmp_path / "cache"), str(PACKAGE), str(user)], capture_output=True, text=True, check=False)
    # The errors are those of the user: a word that a setting does not have, and a number taken for text.
    assert done.stdout.count("error:") == 2 and "'bufer'" in done.stdout and '"float" has no attribute "upper"' in done.stdout, done.stdout
