# SPDX-License-Identifier: MIT
"""Each setting of docs/settings.md is an argument of the functions that the page names."""
import inspect
import pathlib
import re

import pytest

import silvafit as sf

PAGE = pathlib.Path(__file__).parents[3] / "docs" / "settings.md"
TREES = {"plot": [1, 1], "tree": [1, 2], "species": ["SM", "SM"], "x": [0.0, 4.0], "y": [0.0, 1.0], "dbh": [18.0, 24.0],
         "h": [14.0, 17.0]}


def sections():
    """Of each list: the functions of Python and the settings."""
    for text in PAGE.read_text(encoding="utf-8").split("\n## ")[1:]:
        functions = re.findall("`([^`]+)`", re.search("^- Python: (.*)$", text, re.MULTILINE)[1])
        yield from ((name, re.findall(r"^\| `[^`]+` \| [^|]* \| `[^`]+` \| `([^`]+)` ", text, re.MULTILINE)) for name in functions)


def function_named(name):
    found = sf
    for word in name.split("."):
        found = getattr(found, word)
    return found


def takes(name, argument, folder):
    function = function_named(name)
    parameters = inspect.signature(function).parameters
    if argument in parameters:
        return True
    if not any(one.kind is inspect.Parameter.VAR_KEYWORD for one in parameters.values()):
        return False
    given = [sf.read_library("shanxia-2023")] if name.startswith("Library") else []
    given.append(TREES)
    if "out" in parameters:
        given.append(folder / "stand.glb" if name == "grow" else folder / "out")
    try:
        # A value that no setting has: the argument is refused for its value, not for its name.
        function(*given, **{argument: -1.5 if name == "study" else 1j})
    except sf.Error as error:
        return not re.search("unknown (argument|key)", str(error))
    except TypeError:
        return True
    return True


@pytest.mark.parametrize("name, settings", sections())
def test_function_takes_each_setting(name, settings, tmp_path):
    assert settings
    assert [one for one in settings if not takes(name, one, tmp_path)] == []


def test_unknown_arguments_have_a_suggestion():
    with pytest.raises(sf.UsageError, match="did you mean fill_down"):
        sf.impute(TREES, fil_down=["plot"])
