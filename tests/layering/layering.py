#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Holds the sources to the order of the libraries: layering.py ROOT prints each breach and fails if there is one.

A library includes headers of itself and of the libraries below it only, and so do the folders within a library. Its public headers show nothing
but the standard library, Eigen, the names (not the classes) of nlohmann-json, and our own public headers:
what else it is built with stays its own business. Texts of libraries name settings by keys in backquotes, which the
front ends replace (setting_names.hpp). Code for one operating system stands in the folders of libbase that are named
after it. Headers have no `using namespace`, and every source says its licence on top.
"""

import os
import pathlib
import re
import sys

MAY_INCLUDE = {
    "base": set(),
    "data": {"base"},
    "source": {"base", "data"},
    "fit": {"base", "data"},
    "stand": {"base", "data"},
    "tree": {"base", "data"},
    "render": {"base", "data", "tree"},
    "study": {"base", "data", "fit", "stand", "tree"},
}

# The folders below src of a library, lowest first: a file includes files of its own folder and of the folders above
# it in this list. A public header belongs to the folder of the source of the same name. Tests may include everything.
FOLDERS = {
    "data": ["json", "table", "expression", "program", "columns", "settings"],
    "fit": ["text", "variance", "correlation", "model", "verdict", "optimization", "result", "conditional_modes", "likelihood", "least_squares",
            "mixed_effects", "lindstrom_bates", "marginal_likelihood", "optimum_search", "fit_model", "inference",
            "prediction", "resampling", "shared_fit", "summary"],
    "stand": ["trees", "windows", "units", "sampling", "figures", "growth"],
    "tree": ["morphology", "pictures", "catalogue", "segments", "mesh", "fitted", "iterated_functions", "lsystem", "bamboo",
             "builders", "impostors", "stand", "files"],
    "study": ["simulation", "catalogue", "study", "library", "prediction", "report", "view", "workflow", "fronts"],
}

# Tests, benchmarks and fuzzers run on Linux only.
MAY_KNOW_SYSTEMS = re.compile(r"libbase/src/(posix|linux|windows)/|(tests|bench)/")
SYSTEM_HEADER = re.compile(r"(sys/|net/|arpa/|(unistd|fcntl|dlfcn|signal|spawn|malloc|poll|pthread|termios|io|windows|shellapi)\.h$)")
SYSTEM_NAME = re.compile(r"\b(_WIN32|_WIN64|__MINGW\w+|__linux__|__APPLE__|__GLIBC__|__unix__)\b|\"/proc/")

# Texts of libraries: options of the program, and settings in backquotes, `buffer` or `edge=torus`.
TEXT = re.compile(r'"(?:[^"\\]|\\.)*"')
OPTION = re.compile(r"(?<![\w-])--[a-z]")
SETTING = re.compile(r"`([a-z_]+)[`=]")
# The lists of settings, whose helps the program prints, and the source that adds other settings and writes options.
SETTING_LISTS = ["libfit/include/silvafit/fit/setting_list.hpp",
                 *(f"libstudy/include/silvafit/study/{name}setting_list.hpp" for name in ("", "analysis_", "grow_"))]
SETTING_NAMES = "libstudy/src/study/setting_names.cpp"

LICENCE = re.compile(r"(//|#|/\*|<!--) SPDX-License-Identifier: MIT")
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]')
USING_NAMESPACE = re.compile(r"^\s*using\s+namespace\b")
STANDARD_HEADER = re.compile(r"[a-z0-9_]+")
SOURCE_SUFFIXES = {".cpp", ".hpp", ".cmake", ".py", ".js", ".mjs"}


def sources(root):
    """Every source below root, without build trees, npm's packages and hidden folders."""
    for folder, subfolders, files in os.walk(root):
        subfolders[:] = sorted(
            name for name in subfolders
            if name != "node_modules" and not name.startswith(".")
            and not (pathlib.Path(folder) == root and re.fullmatch(r"build(-.*)?", name)))
        for name in sorted(files):
            path = pathlib.Path(folder, name)
            if path.suffix in SOURCE_SUFFIXES or name == "CMakeLists.txt":
                yield path


def library_of(path):
    """The library whose folder a source is in: "fit" for libfit/..., None outside of all libraries."""
    top = path.parts[0]
    return top[3:] if top.startswith("lib") and len(path.parts) > 1 else None


def is_public_header(path):
    return library_of(path) is not None and path.parts[1] == "include"


def breach_of_include(path, header):
    """What is wrong with a source including a header, or None."""
    library = library_of(path)
    if header.startswith("silvafit/"):
        other = header.split("/")[1]
        if library is not None and other != library and other not in MAY_INCLUDE[library]:
            return f"lib{library} must not know lib{other} ({header})"
        return None
    if is_public_header(path):
        allowed = (STANDARD_HEADER.fullmatch(header) or header.startswith("Eigen/")
                   or header == "nlohmann/json_fwd.hpp")
        return None if allowed else f"a public header must not show {header}"
    if library is not None and header.startswith("CLI/"):
        return f"only the program reads command lines ({header})"
    return None


def is_test(path):
    return "_test" in path.stem or path.parts[2:3] == ("test_support",)


def folder_of(path):
    """The folder below src of a library's file, None for files elsewhere."""
    in_folder = library_of(path) in FOLDERS and path.parts[1] == "src" and len(path.parts) > 3
    return path.parts[2] if in_folder else None


def folders_of_headers(root):
    """The folder of each header of the libraries in FOLDERS, by the name that it is included by."""
    folders = {}
    for library in FOLDERS:
        for file in pathlib.Path(root, f"lib{library}", "src").rglob("*.?pp"):
            path = file.relative_to(root)
            if folder_of(path) is None or is_test(path):
                continue
            own = "/".join(path.parts[2:])
            public = f"silvafit/{library}/{path.stem}.hpp"
            if path.suffix == ".hpp":
                folders[(library, own)] = path.parts[2]
            elif pathlib.Path(root, f"lib{library}", "include", public).exists() and (library, own) not in folders:
                folders[(library, public)] = path.parts[2]
    return folders


def breach_of_folders(path, header, folders):
    """What is wrong with the folder of a header that a library's source includes, or None."""
    library, folder = library_of(path), folder_of(path)
    if folder is None or is_test(path):
        return None
    order = FOLDERS[library]
    if folder not in order:
        return f"the folder {folder} has no place in the order of lib{library}"
    other = folders.get((library, header), folder)
    if order.index(other) > order.index(folder):
        return f"{folder} must not know {other} ({header})"
    return None


def breach_of_systems(path, line, header):
    """The operating system that a line knows of and must not, or None."""
    if MAY_KNOW_SYSTEMS.match(str(path)) or is_test(path):
        return None
    name = SYSTEM_NAME.search(line)
    if header is not None and SYSTEM_HEADER.match(header):
        return f"only base/system.hpp knows the system ({header})"
    return f"only base/system.hpp knows the system ({name[0]})" if name else None


def known_settings(root):
    """The keys that messages may name."""
    lists, names = ("".join((root / name).read_text(encoding="utf-8") for name in files if (root / name).exists())
                    for files in (SETTING_LISTS, [SETTING_NAMES]))
    return set(re.findall(r'Setting\(\s*"([a-z_]+)"', lists)) | set(re.findall(r'"([a-z_]+)"', names.partition("kFunctions")[0]))


def breach_of_messages(path, line, settings):
    """An option, or an unknown setting, in a text of a library, or None."""
    if library_of(path) is None or is_test(path) or str(path) in {*SETTING_LISTS, SETTING_NAMES} or line.lstrip().startswith("//"):
        return None
    texts = " ".join(TEXT.findall(line.replace("'\"'", "")))
    if OPTION.search(texts):
        return "a message of a library names settings by keys in backquotes, not by options"
    unknown = next((key for key in SETTING.findall(texts) if key not in settings), None)
    return f"`{unknown}` in backquotes is no known setting" if unknown else None


def breaches(root):
    """All breaches below root, each as "path:line: what"."""
    root = pathlib.Path(root)
    found = []
    folders = folders_of_headers(root)
    settings = known_settings(root)
    for file in sources(root):
        path = file.relative_to(root)
        lines = file.read_text(encoding="utf-8").splitlines()
        library = library_of(path)
        if library is not None and library not in MAY_INCLUDE:
            found.append(f"{path}:1: lib{library} has no place in the order of the libraries")
            continue
        head = lines[1:2] if lines and lines[0].startswith("#!") else lines[:1]
        if not (head and LICENCE.match(head[0])):
            found.append(f"{path}:1: the first line is not the SPDX line")
        if path.suffix not in {".cpp", ".hpp"}:
            continue
        for number, line in enumerate(lines, start=1):
            include = INCLUDE.match(line)
            what = None
            if include:
                what = breach_of_include(path, include[1]) or breach_of_folders(path, include[1], folders)
            what = what or breach_of_systems(path, line, include[1] if include else None)
            what = what or breach_of_messages(path, line, settings)
            if path.suffix == ".hpp" and USING_NAMESPACE.match(line):
                what = "a header must not say `using namespace`"
            if what:
                found.append(f"{path}:{number}: {what}")
    return found


if __name__ == "__main__":
    all_breaches = breaches(sys.argv[1])
    print("\n".join(all_breaches))
    sys.exit(1 if all_breaches else 0)
