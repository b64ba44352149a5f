# SPDX-License-Identifier: MIT
"""Changes of inputs that keep their structure: tables, JSON, GLB scenes, grammars, formulas and single values."""

import copy
import csv
import io
import json
import re
import sqlite3
import struct
import tempfile
import zipfile
import zlib

NUMBERS = ["0", "-0", "1", "-1", "0.5", "1e-300", "-1e-320", "1e9", "1e15", "1e300", "1e308", "-1e308", "1e999", "nan", "inf",
           "-inf", "2147483648", "99999999999999999999", "0x10", "1,5", "1e", "+-1", ".", "1e-9", "360", "1000", "65536"]
TEXTS = ["", " ", "NA", "-", "001", "1", "SM", "sm", "SM ", "=1+1", "@A1", "+x", "-x", "'=1", "'", '"', "a,b", "a;b", "a\nb", "a\tb",
         "\x1b[2J", "\u202eoak", "\u2066x\u2069", "\u00e9\u4e91\U0001f332", "../../up", "/etc/passwd", "CON", ".", "..", "a/b",
         "x" * 300, "<script>alert(1)</script>", "</script>", "%s%n", "${HOME}", "`id`", "[", "*", "\\", "{{=<% %>=}}", "#2", "1#2",
         "null", "true", "2020-13-45", "0|1", "a~b", "%", "\x7f", "\x00"]


def value(draw):
    """A number or a text that nobody would write."""
    return draw.choice(draw.choice([NUMBERS, TEXTS]))


def some(draw, items, most=3):
    """A few of the items, not none."""
    return draw.sample(items, min(len(items), draw.randint(1, most)))


def of_bytes(draw, data):
    """Bytes changed, cut or repeated anywhere."""
    data = bytearray(data)
    for _ in range(draw.randint(1, 8)):
        if not data:
            break
        at = draw.randrange(len(data))
        kind = draw.randrange(4)
        if kind == 0:
            data[at] = draw.randrange(256)
        elif kind == 1:
            del data[at:at + draw.choice([1, 4, 100, len(data)])]
        elif kind == 2:
            data[at:at] = data[at:at + draw.choice([1, 16, 500])]
        else:
            data[at:at] = draw.choice([b"\xff", b"\0", b"\n", b'"', b",", b"{", b"]", b"\xef\xbb\xbf"])
    return bytes(data)


# Tables.

def _cells(draw, rows):
    for _ in range(draw.choice([1, 3, 20])):
        row = draw.choice(rows)
        if row:
            row[draw.randrange(len(row))] = value(draw)


def _column(draw, rows):
    """All values of a column: odd, the same, multiplied, or those of another column."""
    at, other = (draw.randrange(len(rows[0])) for _ in range(2))
    kind, constant, factor = draw.randrange(5), value(draw), 10.0 ** draw.choice([-300, -9, -3, -2, -1, 1, 2, 3, 9, 300])
    for row in rows[1:]:
        if max(at, other) >= len(row):
            continue
        if kind == 0:
            row[at] = value(draw)
        elif kind == 1:
            row[at] = constant
        elif kind == 2:
            row[at] = row[other]
        elif kind == 3:
            row[at] = ""
        else:
            try:
                row[at] = repr(float(row[at]) * factor)
            except ValueError:
                row[at] = constant


def _header(draw, rows):
    names = ["plot", "tree", "species", "x", "y", "z", "dbh", "h", "hcb", "cw", "status", "year", "stand", "W", "core", "h_population"]
    rows[0][draw.randrange(len(rows[0]))] = draw.choice([value(draw), draw.choice(names)])


def _rows(draw, rows):
    kind = draw.randrange(6)
    if kind == 0:
        del rows[1 + draw.randrange(max(1, len(rows) - 1)):]
    elif kind == 1:
        rows[1:] = rows[1:] * draw.choice([2, 3, 20])
    elif kind == 2:
        body = rows[1:]
        draw.shuffle(body)
        rows[1:] = body
    elif kind == 3:
        rows[2:] = []
    elif kind == 4:
        rows.insert(draw.randrange(len(rows) + 1), [value(draw)] * draw.choice([0, 1, len(rows[0]), len(rows[0]) + 1]))
    else:
        rows.insert(0, ["A title"])


def _fields(draw, rows):
    """Columns without a field, or with one more."""
    at, is_longer = draw.randrange(len(rows[0])), draw.random() < 0.3
    for row in rows if draw.random() < 0.7 else [draw.choice(rows)]:
        if is_longer:
            row.insert(at, row[at] if at < len(row) else "")
        elif at < len(row):
            del row[at]


def of_table(draw, data):
    """A CSV file with odd cells, columns, headers, rows or separators."""
    rows = list(csv.reader(io.StringIO(data.decode("utf-8"))))
    for _ in range(draw.randint(1, 3)):
        draw.choice([_cells, _cells, _column, _column, _header, _rows, _fields])(draw, rows)
        rows = [row for row in rows if row] or [["plot"]]
    text = io.StringIO()
    csv.writer(text, delimiter=draw.choice([","] * 8 + [";", "\t"]), lineterminator=draw.choice(["\n"] * 4 + ["\r\n", "\r"]),
               quoting=draw.choice([csv.QUOTE_MINIMAL] * 4 + [csv.QUOTE_ALL])).writerows(rows)
    data = text.getvalue().encode("utf-8", "surrogatepass")
    return of_bytes(draw, data) if draw.random() < 0.1 else data


# JSON.

def _places(tree, path=()):
    yield path
    if isinstance(tree, dict):
        for key in tree:
            yield from _places(tree[key], (*path, key))
    elif isinstance(tree, list):
        for i, item in enumerate(tree):
            yield from _places(item, (*path, i))


def _other(draw, old, tree, places):
    kind = draw.randrange(7)
    if kind == 0 and isinstance(old, (int, float)) and not isinstance(old, bool):
        return draw.choice([-old, old * 1e9, old * 1e-9, old + 1, 1e308, -1, 0, 0.5, 10**30])
    if kind == 1 and isinstance(old, list):
        return draw.choice([[], old * 2, old[:1], old[::-1], [old]])
    if kind == 2:
        part = tree
        for step in draw.choice(places):
            part = part[step]
        return copy.deepcopy(part)
    if kind == 3:
        return draw.choice([None, True, [], {}, "", -1, 1e300, [[]], {"a": 1}])
    if kind == 4 and isinstance(old, str):
        return of_text(draw, old)
    if kind == 5:
        nested = old
        for _ in range(draw.choice([1, 10, 300])):
            nested = [nested]
        return nested
    return draw.choice(TEXTS) if isinstance(old, str) else draw.choice([0, -1, 1e9, 1e-9, 2**31, 2**53, 0.1])


def of_tree(draw, tree):
    """A JSON value in which some parts are others, gone or renamed."""
    tree = copy.deepcopy(tree)
    for _ in range(draw.choice([1, 1, 2, 4])):
        places = [path for path in _places(tree) if path]
        if not places:
            break
        *above, last = draw.choice(places)
        parent = tree
        for step in above:
            parent = parent[step]
        kind = draw.randrange(8)
        if kind == 0:
            del parent[last]
        elif kind == 1 and isinstance(parent, dict):
            parent[draw.choice([*parent, value(draw)])] = parent.pop(last)
        else:
            parent[last] = _other(draw, parent[last], tree, places)
    return tree


def of_json(draw, data):
    """A JSON file with other parts, sometimes with other bytes."""
    data = json.dumps(of_tree(draw, json.loads(data))).encode("utf-8", "replace")
    return of_bytes(draw, data) if draw.random() < 0.1 else data


def of_glb(draw, data):
    """A GLB scene with other JSON, other binary data or other lengths."""
    if draw.random() < 0.25:
        return of_bytes(draw, data)
    size = struct.unpack_from("<I", data, 12)[0]
    text, rest = data[20:20 + size], bytearray(data[20 + size:])
    if draw.random() < 0.8:
        text = json.dumps(of_tree(draw, json.loads(text))).encode("utf-8", "replace")
    else:
        for _ in range(draw.choice([1, 10, 1000])):
            at = draw.randrange(8, len(rest) - 4)
            rest[at:at + 4] = draw.choice([struct.pack("<f", draw.choice([0, 1e38, -1e38, float("nan"), float("inf")])),
                                           struct.pack("<I", draw.randrange(2**32))])
    text += b" " * (-len(text) % 4)
    whole = 20 + len(text) + len(rest)
    if draw.random() < 0.1:
        whole = draw.randrange(2**32)
    return b"glTF" + struct.pack("<III", 2, whole, len(text)) + b"JSON" + text + bytes(rest)


# Grammars, formulas and other texts of tokens.

TOKEN = re.compile(r"\d+(?:\.\d+)?(?:e[+-]?\d+)?|\w+|\s+|.", re.DOTALL)


def of_text(draw, text):
    """Tokens that are others, gone, repeated or swapped."""
    tokens = TOKEN.findall(text) or [""]
    for _ in range(draw.choice([1, 1, 2, 5])):
        at, kind = draw.randrange(len(tokens)), draw.randrange(6)
        if kind == 0:
            tokens[at] = ""
        elif kind == 1:
            tokens[at] = tokens[at] * draw.choice([2, 5, 200])
        elif kind == 2:
            tokens[at] = draw.choice(tokens)
        elif kind == 3:
            other = draw.randrange(len(tokens))
            tokens[at], tokens[other] = tokens[other], tokens[at]
        elif tokens[at][:1].isdigit():
            tokens[at] = draw.choice(NUMBERS)
        else:
            tokens[at] = draw.choice(["(", ")", "[", "]", "+", "-", "*", "/", "^", "~", "|", ",", ":", "=", "<", "&", "!", "1", " ",
                                      value(draw)])
    return "".join(tokens)


def of_grammar(draw, data):
    """A grammar with other lines or tokens."""
    lines = data.decode("utf-8").splitlines()
    if draw.random() < 0.4:
        at = draw.randrange(len(lines))
        lines[at:at + 1] = draw.choice([[], [lines[at]] * 2, [draw.choice(lines)], [value(draw)]])
    return of_text(draw, "\n".join(lines) + "\n").encode("utf-8", "replace")


# Workbooks and layers.

def of_workbook(draw, data):
    """Cells, tags or bytes of parts of a workbook; or bytes of the archive."""
    if draw.random() < 0.2:
        return of_bytes(draw, data)
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        parts = {name: archive.read(name) for name in archive.namelist()}
    sheets = [name for name in parts if name.endswith(".xml")]
    for name in some(draw, sheets, 2):
        text = parts[name].decode("utf-8")
        kind = draw.randrange(5)
        if kind == 0:
            parts[name] = of_bytes(draw, parts[name])
            continue
        if kind == 1:  # the contents of elements
            text = _replaced(draw, text, r">[^<>]+<", lambda: f">{value(draw)}<")
        elif kind == 2:  # attributes: types of cells, references, numbers of styles
            text = _replaced(draw, text, r'"[^"]*"', lambda: f'"{value(draw)}"')
        elif kind == 3:  # an element twice
            text = re.sub(r"<(c|row|si|sheet)\b.*?</\1>", lambda found: found.group(0) * 2, text, count=draw.randint(1, 3))
        else:
            text = text[:draw.randrange(len(text) + 1)]
        parts[name] = text.encode("utf-8", "replace")
    if draw.random() < 0.1:
        parts.pop(draw.choice(sorted(parts)))
    changed = io.BytesIO()
    with zipfile.ZipFile(changed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, part in parts.items():
            archive.writestr(name, part)
    return changed.getvalue()


def _replaced(draw, text, pattern, new):
    """Some places that match a pattern have other text."""
    places = [found.span() for found in re.finditer(pattern, text)]
    for begin, end in sorted(some(draw, places, 5) if places else [], reverse=True):
        text = text[:begin] + new() + text[end:]
    return text


def of_layers(draw, data):
    """Cells, columns, geometries or metadata of a GeoPackage; or bytes of the file."""
    if draw.random() < 0.3:
        return of_bytes(draw, data)
    with tempfile.NamedTemporaryFile(suffix=".gpkg") as file:
        file.write(data)
        file.flush()
        base = sqlite3.connect(file.name)
        # The triggers of the spatial index call functions that only GDAL has.
        for (name,) in base.execute("select name from sqlite_master where type = 'trigger'").fetchall():
            base.execute(f'drop trigger "{name}"')
        tables = [name for (name,) in base.execute("select name from sqlite_master where type = 'table'") if not name.startswith("rtree")]
        for table in some(draw, sorted(tables)):
            _of_database_table(draw, base, table)
        base.commit()
        base.close()
        file.seek(0)
        return file.read()


def _of_database_table(draw, base, table):
    columns = [row[1] for row in base.execute(f'pragma table_info("{table}")')]
    for column in some(draw, columns, 2):
        kind = draw.randrange(4)
        content = [value(draw), zlib.compress(b"x" * 100), of_bytes(draw, b"GP\0\1" + b"\0" * 30), None, 10.0 ** draw.randint(-300, 300)]
        try:
            if kind == 0:
                base.execute(f'update "{table}" set "{column}" = ?', (draw.choice(content),))
            elif kind == 1:
                base.execute(f'alter table "{table}" rename column "{column}" to "{value(draw).replace(chr(34), "")}"')
            elif kind == 2:
                base.execute(f'delete from "{table}" where rowid % 3 = {draw.randrange(3)}')
            else:
                base.execute(f'update "{table}" set "{column}" = ? where rowid % 7 = {draw.randrange(7)}', (draw.choice(content),))
        except (sqlite3.Error, OverflowError, ValueError):
            pass  # the change breaks a rule of the database
