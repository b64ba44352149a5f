# SPDX-License-Identifier: MIT
"""What must hold after every run, whatever its inputs were."""

import csv
import hashlib
import io
import json
import re
import struct

DOCUMENTED = {0, 2, 3, 4, 5}
OUT_OF_MEMORY = re.compile(r"^silvafit: out of memory", re.MULTILINE)
# Words of libraries and of C++ that mean nothing to a forester.
FOREIGN = re.compile(r"internal error|terminate called|what\(\)|std::|json\.exception|nlohmann|\bceres\b|glog|\btbb\b|Eigen|embree|\[rt\]|"
                     r"Boost|CLI::|basic_string|_M_|\bstod\b|\bstoi\b|bad_alloc|fmt::|Assertion|filesystem error|regex_error|"
                     r"^[WEIF]\d{4} ", re.MULTILINE | re.IGNORECASE)
CONTROLS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]")


def contents(folder):
    """The files below a folder with fingerprints of their bytes."""
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else "folder"
            for path in sorted(folder.rglob("*"))}


def _table(data):
    text = data.decode("utf-8")
    rows = list(csv.reader(io.StringIO(text, newline=""), strict=True))
    assert text.endswith("\n"), "no line end at the end"
    assert len({len(row) for row in rows if row}) == 1, "rows of different lengths"


def _glb(data):
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data)), "a header of other data"
    json.loads(data[20:20 + struct.unpack_from("<I", data, 12)[0]])


def _html(data):
    text = data.decode("utf-8")
    assert text.rstrip().endswith("</html>"), "no end"
    part = re.search(r'<script type="application/json"[^>]*>(.*?)</script>', text, re.DOTALL)
    json.loads(part.group(1))
    assert len(re.findall("<script", text.split(part.group(0))[0])) == 0, "a script before the data"


def _png(data):
    assert data.startswith(b"\x89PNG\r\n\x1a\n") and data.endswith(b"IEND\xaeB`\x82"), "cut"


def _tex(data):
    text = data.decode("utf-8")
    assert text.count(r"\begin{") == text.count(r"\end{"), "an environment without an end"
    assert not re.search(r"\\\\\s*[*\[]", text), "a row that belongs to the end of the one before"


WHOLE = {".csv": _table, ".json": json.loads, ".gltf": json.loads, ".glb": _glb, ".html": _html, ".png": _png, ".tex": _tex}


def _settings(data):
    """study --init writes comments into its JSON."""
    assert data.rstrip().endswith(b"}"), "cut"


def broken_files(folder):
    """What is wrong with the files of a folder."""
    for path in folder.rglob("*"):
        if path.is_dir():
            continue
        if path.suffix in (".part", ".spool"):
            yield f"a temporary file is left: {path.name!r}"
            continue
        check = _settings if path.name == "study.json" else WHOLE.get(path.suffix, lambda data: data)
        try:
            check(path.read_bytes())
        except Exception as error:  # whatever a reader of the format says
            yield f"{path.name!r} is not whole: {error!r}"


def faults(words, status, stdout, stderr, folder, before):
    """What a run did that it must not, in words; empty if all is well."""
    found = []
    said = stderr.decode("utf-8", "replace")
    is_out_of_memory = status == 1 and OUT_OF_MEMORY.search(said)
    if status < 0:
        found.append(f"ended by signal {-status}")
    elif status not in DOCUMENTED and not is_out_of_memory:
        found.append(f"exit status {status}")
    if status != 0 and "silvafit: " not in said and "--json" not in words:
        found.append("failed without a message")
    if foreign := FOREIGN.search(said):
        found.append(f"foreign words: {foreign.group(0)!r}")
    if control := CONTROLS.search(said):
        found.append(f"a raw control character on standard error: {control.group(0)!r}")
    after = contents(folder)
    changed = [name for name in {*before, *after} if before.get(name) != after.get(name) and name.split("/")[0] != "out"]
    if changed:
        found.append(f"written outside of the results: {sorted(changed)[:3]}")
    if status == 0 and "--json" in words:
        try:
            json.loads(stdout)
        except ValueError as error:
            found.append(f"standard output is not JSON: {error}")
    return found + list(broken_files(folder / "out"))
