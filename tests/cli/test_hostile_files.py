# SPDX-License-Identifier: MIT
"""Files that are damaged, that request endless work, or that would reach networks and other files."""

import http.server
import json
import sqlite3
import subprocess
import threading
import unittest
import zipfile

import layer_files
from silvafit_program import PROGRAM, ProgramTest

RELATIONS = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
SHEETS = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
PACKAGE = "http://schemas.openxmlformats.org/package/2006/"
FIT = ("--formula", "dbh ~ a + b*tree")


def sheet(rows, more=""):
    """The XML of a sheet of numbers and texts."""
    text = ""
    for i, row in enumerate(rows, start=1):
        cells = ""
        for k, value in enumerate(row):
            name = f"{chr(65 + k)}{i}"
            cells += (f'<c r="{name}" t="inlineStr"><is><t>{value}</t></is></c>' if isinstance(value, str)
                      else f'<c r="{name}"><v>{value}</v></c>')
        text += f'<row r="{i}">{cells}</row>'
    return f'<?xml version="1.0"?><worksheet xmlns="{SHEETS}"><sheetData>{text}{more}</sheetData></worksheet>'


def write_xlsx(path, xml):
    """A workbook with one sheet, whose XML need not be valid."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as book:
        kind = "application/vnd.openxmlformats-officedocument.spreadsheetml"
        book.writestr("[Content_Types].xml", f'<Types xmlns="{PACKAGE}content-types"><Default Extension="rels" ContentType='
                                             '"application/vnd.openxmlformats-package.relationships+xml"/><Override PartName="/xl/workbook.xml" '
                                             f'ContentType="{kind}.sheet.main+xml"/><Override PartName="/xl/worksheets/sheet1.xml" '
                                             f'ContentType="{kind}.worksheet+xml"/></Types>')
        book.writestr("_rels/.rels", f'<Relationships xmlns="{PACKAGE}relationships"><Relationship Id="r1" '
                                     f'Type="{RELATIONS}/officeDocument" Target="xl/workbook.xml"/></Relationships>')
        book.writestr("xl/workbook.xml", f'<workbook xmlns="{SHEETS}" xmlns:r="{RELATIONS}"><sheets><sheet name="S" '
                                         'sheetId="1" r:id="r1"/></sheets></workbook>')
        book.writestr("xl/_rels/workbook.xml.rels", f'<Relationships xmlns="{PACKAGE}relationships"><Relationship Id="r1" '
                                                    f'Type="{RELATIONS}/worksheet" Target="worksheets/sheet1.xml"/></Relationships>')
        book.writestr("xl/worksheets/sheet1.xml", xml)


def ods_rows(rows):
    return "".join(f'<table:table-row{repeat}>{cells}</table:table-row>' for repeat, cells in rows)


def ods_cells(*values):
    return "".join(f'<table:table-cell office:value-type="string"><text:p>{value}</text:p></table:table-cell>' if isinstance(value, str)
                   else f'<table:table-cell office:value-type="float" office:value="{value}"/>' for value in values)


def write_ods(path, rows):
    names = " ".join(f'xmlns:{short}="urn:oasis:names:tc:opendocument:xmlns:{short}:1.0"' for short in ("office", "table", "text"))
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as book:
        book.writestr("mimetype", "application/vnd.oasis.opendocument.spreadsheet", zipfile.ZIP_STORED)
        book.writestr("content.xml", f'<?xml version="1.0"?><office:document-content {names}><office:body><office:spreadsheet>'
                                     f'<table:table table:name="S">{ods_rows(rows)}</table:table></office:spreadsheet></office:body>'
                                     "</office:document-content>")


class HostileTest(ProgramTest):
    def refused(self, words, *arguments, status=3):
        said = self.run_program("fit", *arguments, *FIT, status=status).stderr
        self.assertIn(words, said)
        for word in ("GDAL", "sqlite3_", "ERROR", "CPL"):
            self.assertNotIn(word, said)

    def run_any(self, *arguments):
        return subprocess.run([PROGRAM, *arguments], cwd=self.folder, capture_output=True, text=True, timeout=120, check=False)

    def count(self, name):
        return self.run_json("fit", name, *FIT)["n"]


class Workbooks(HostileTest):
    rows = [["plot", "tree", "dbh"]] + [[1, i, 10.5 + (7 * i) % 20] for i in range(300)]

    def test_whole_workbooks(self):
        write_xlsx(self.folder / "a.xlsx", sheet(self.rows))
        self.assertEqual(self.count("a.xlsx"), 300)
        body = [("", ods_cells(*row)) for row in self.rows]
        empty = '<table:table-cell table:number-columns-repeated="16384"/>'
        # LibreOffice writes empty rows up to the last possible one, in one or two parts.
        for end in ([], [(' table:number-rows-repeated="1048275"', empty)],
                    [(' table:number-rows-repeated="1048274"', empty), ("", empty)]):
            write_ods(self.folder / "a.ods", body + end)
            self.assertEqual(self.count("a.ods"), 300)

    def test_cut_sheets(self):
        whole = sheet(self.rows)
        for share in (0.3, 0.6, 0.95):
            write_xlsx(self.folder / "a.xlsx", whole[:int(share * len(whole))])
            self.refused("the workbook is damaged: the XML of xl/worksheets/sheet1.xml is broken at byte", "a.xlsx")
        write_xlsx(self.folder / "a.xlsx", whole.replace('<row r="200">', '<row r="200"', 1))
        self.refused("the workbook is damaged: the XML of xl/worksheets/sheet1.xml is broken at byte", "a.xlsx")

    def test_changed_bytes_never_change_the_rows_silently(self):
        write_xlsx(self.folder / "a.xlsx", sheet(self.rows))
        whole = self.run_json("fit", "a.xlsx", *FIT)
        data = (self.folder / "a.xlsx").read_bytes()
        refused = 0
        for at in range(150, len(data), len(data) // 40):
            (self.folder / "b.xlsx").write_bytes(data[:at] + bytes([data[at] ^ 0x10]) + data[at + 1:])
            done = self.run_any("fit", "b.xlsx", "--json", *FIT)
            if done.returncode == 0:
                self.assertEqual(json.loads(done.stdout)["fixed"], whole["fixed"], at)
            else:
                self.assertEqual(done.returncode, 3, (at, done.stderr))
                refused += 1
        self.assertGreater(refused, 20)

    def test_rows_behind_a_gap(self):
        empty = '<table:table-cell table:number-columns-repeated="16384"/>'
        write_ods(self.folder / "a.ods", [("", ods_cells(*row)) for row in self.rows[:200]] +
                  [(' table:number-rows-repeated="20000"', empty)] + [("", ods_cells(*row)) for row in self.rows[200:]])
        self.refused("a.ods (sheet S):20201: the cell A20201 is far from the others", "a.ods")

    def test_cells_far_away(self):
        for more in ('<row r="1048576"><c r="A1048576"><v>1</v></c></row>', '<row r="400"><c r="XFD400"><v>1</v></c></row>'):
            write_xlsx(self.folder / "a.xlsx", sheet(self.rows, more))
            self.refused("is far from the others; delete the cells that are far from the table", "a.xlsx")
        many = '<row r="1">' + "".join(
            f'<c r="{column}1"><v>1</v></c>' for column in ("A", "ALL", "BXX")) + "</row>" + "".join(
            f'<row r="{i}"><c r="A{i}"><v>1</v></c></row>' for i in range(2, 30000))
        write_xlsx(self.folder / "a.xlsx", sheet([], many))
        self.refused("a sheet has 29999 rows and 2000 columns, nearly all of them without content", "a.xlsx")

    def test_archives_that_unpack_to_gigabytes(self):
        write_xlsx(self.folder / "a.xlsx", sheet(self.rows, " " * 200_000_000))
        self.refused("more than 256 times as many", "a.xlsx")

    def test_repeated_cells_of_a_small_file(self):
        cell = '<table:table-cell table:number-columns-repeated="16384" office:value-type="float" office:value="1"/>'
        formula = '<table:table-cell table:number-columns-repeated="16384" table:formula="of:=1"/>'
        long_text = f'<table:table-cell office:value-type="string"><text:p>{"a" * 30000}</text:p></table:table-cell>'
        for content in (cell, formula, long_text):
            write_ods(self.folder / "a.ods", [("", ods_cells(*row)) for row in self.rows] + [(' table:number-rows-repeated="1000000"', content)])
            self.refused("the sheet has more content than a workbook of its size should", "a.ods")
        write_ods(self.folder / "a.ods", [("", ods_cells(*row)) for row in self.rows] + [(' table:number-rows-repeated="99999999999999999999"', cell)])
        self.refused("is in a row that is repeated more often than a sheet has rows", "a.ods")
        write_ods(self.folder / "a.ods", [("", cell.replace("16384", "16385"))])
        self.refused("is repeated more often than a sheet has columns", "a.ods")
        # One long text for many cells.
        cells = "".join(f'<row r="{i}"><c r="A{i}" t="s"><v>0</v></c></row>' for i in range(2, 200000))
        self.pack(self.parts_with_strings(sheet([], cells), f'<sst xmlns="{SHEETS}"><si><t>{"a" * 30000}</t></si></sst>'))
        self.refused("the sheet has more content than a workbook of its size should", "a.xlsx")

    def parts_with_strings(self, xml, strings):
        parts = self.parts(xml)
        parts["xl/_rels/workbook.xml.rels"] = parts["xl/_rels/workbook.xml.rels"].replace(
            "</Relationships>", f'<Relationship Id="r2" Type="{RELATIONS}/sharedStrings" Target="strings.xml"/></Relationships>')
        return parts | {"xl/strings.xml": strings}

    def parts(self, xml):
        write_xlsx(self.folder / "a.xlsx", xml)
        with zipfile.ZipFile(self.folder / "a.xlsx") as book:
            return {name: book.read(name).decode("utf-8") for name in book.namelist()}

    def pack(self, parts):
        with zipfile.ZipFile(self.folder / "a.xlsx", "w", zipfile.ZIP_DEFLATED) as book:
            for name, text in parts.items():
                book.writestr(name, text)

    def test_parts_that_are_missing_or_wrong(self):
        whole = self.parts(sheet(self.rows))
        for name in ("_rels/.rels", "xl/workbook.xml", "xl/_rels/workbook.xml.rels", "xl/worksheets/sheet1.xml"):
            self.pack({key: text for key, text in whole.items() if key != name})
            self.refused(f"the workbook is damaged: its part {name} is missing", "a.xlsx")
        cells = '<row r="900"><c r="A900" {}><v>{}</v></c></row>'
        for cell, words in ((cells.format('t="s"', 0), "the cell A900 of xl/worksheets/sheet1.xml refers to a text that is missing"),
                            (cells.format("", "3x"), "the cell A900 of xl/worksheets/sheet1.xml has a value that is not a number"),
                            (cells.format('s="4"', "3"), "the cell A900 of xl/worksheets/sheet1.xml has a style that is missing"),
                            (cells.format('t="q"', "3"), "the cell A900 of xl/worksheets/sheet1.xml has an unknown type"),
                            (cells.replace("A900", "A901").format("", "3"), "has a cell 'A901' at the wrong place in row 900"),
                            (cells.replace("900", "200").format("", "3"), "has a row '200' after row 301"),
                            (cells.replace("900", "1048577").format("", "3"), "has a row '1048577' after row 301")):
            self.pack(whole | {"xl/worksheets/sheet1.xml": sheet(self.rows, cell)})
            self.refused(words, "a.xlsx")

    def test_lost_pieces_that_leave_correct_xml(self):
        whole = sheet(self.rows)
        for lost, rest in (("<v>57</v>", "57"), ('<c r="B59"><v>57</v></c>', "57")):
            self.assertIn(lost, whole)
            self.pack(self.parts(whole.replace(lost, rest, 1)))
            self.refused(" of xl/worksheets/sheet1.xml has text outside of its value", "a.xlsx")
        body = [("", ods_cells(*row)) for row in self.rows]
        for rest in ('<table:table-cell office:value-type="float" office:value="1"/><table:table-cell office:value-type="float" office:value="57">'
                     '" office:value="3</table:table-cell>', "57" + ods_cells(1, 57, 2.5)):
            write_ods(self.folder / "a.ods", body[:58] + [("", rest)] + body[59:])
            self.refused("59 of the sheet 'S' in content.xml has text outside of its paragraphs", "a.ods")
        # One text fewer, and the cells after it have the labels of others.
        cells = "".join(f'<row r="{i}"><c r="A{i}" t="s"><v>{i % 2}</v></c></row>' for i in range(400, 410))
        strings = f'<sst xmlns="{SHEETS}" count="10" uniqueCount="3"><si><t>a</t></si><si><t>b</t></si></sst>'
        self.pack(self.parts_with_strings(sheet(self.rows, cells), strings))
        self.refused("xl/strings.xml has 2 of 3 texts", "a.xlsx")

    def test_entities_are_refused(self):
        xml = sheet([["plot", "tree", "dbh"], ["&b;", 1, 2.5]])
        self.write("secret.txt", "secret")
        for kind in ('<!ENTITY b "bbb">', f'<!ENTITY b SYSTEM "file://{self.folder}/secret.txt">'):
            self.pack(self.parts(xml.replace("?>", f"?><!DOCTYPE worksheet [{kind}]>", 1)))
            self.refused("the XML of xl/worksheets/sheet1.xml is broken", "a.xlsx")

    def test_archives_that_lie(self):
        write_xlsx(self.folder / "a.xlsx", sheet(self.rows))
        data = bytearray((self.folder / "a.xlsx").read_bytes())
        # The size of the sheet in the list at the end of the archive.
        entry = data.rfind(b"xl/worksheets/sheet1.xml") - 46
        self.assertEqual(data[entry:entry + 4], b"PK\x01\x02")
        for size in (10, 5_000_000):
            data[entry + 24:entry + 28] = size.to_bytes(4, "little")
            (self.folder / "a.xlsx").write_bytes(data)
            self.refused("the workbook is damaged: xl/worksheets/sheet1.xml cannot be read", "a.xlsx")
        with zipfile.ZipFile(self.folder / "a.xlsx", "w") as book:
            book.writestr("a", "1")
            with self.assertWarns(UserWarning):
                book.writestr("a", "2")
        self.refused("the workbook is damaged: it has two parts a", "a.xlsx")


class Numbers(ProgramTest):
    def test_points_and_commas_in_one_column_or_file(self):
        head = "plot;tree;species;x;y;dbh\n"
        for rows, place in (("1;1;SM;987,5;10,5;12,5\n1;2;SM;1.001;18,5;14,5\n", "a.csv:3: x: '1.001'"),
                            ("1;1;SM;987.5;10,5;12,5\n1;2;SM;1,001;18,5;14,5\n", "a.csv:3: x: '1,001'"),
                            ("1;1;SM;987,5;10,5;12,5\n1;2;SM;1.001,5;18,5;14,5\n", "a.csv:3: x: '1.001,5'"),
                            ("1;1;SM;1.987;10,5;12,5\n1;2;SM;1.001;18,5;14,5\n", "a.csv:2: x: '1.987' can be 1987")):
            self.write("a.csv", head + rows)
            self.assertIn(place, self.run_program("indices", "a.csv", "--edge", "none", status=3).stderr)
            self.assertIn("a.csv:", self.run_program("fit", "a.csv", "--formula", "dbh ~ a + b*x", status=3).stderr)

    def test_deep_formulas(self):
        self.write("a.csv", "tree,dbh\n" + "".join(f"{i},{10 + i % 7}\n" for i in range(30)))
        for more in ("/b" * 4900, "-exp(b)" * 1400, "^b" * 150 + "*b" * 4000):
            said = self.run_program("fit", "a.csv", "--formula", f"dbh ~ 1.3 + a{more}", status=2).stderr
            self.assertIn("applies more than 1000 operations", said)

    def test_formulas_of_spreadsheets_behind_separators(self):
        text = "a;=cmd|' /C calc'!A0"
        self.write("a.csv", f'plot,tree,species,x,y,dbh\n1,1,"{text}",0,0,10\n1,2,SM,1,1,11\n1,3,SM,2,0,12\n')
        self.run_program("indices", "a.csv", "--edge", "none", "--neighbors", "2", "--out", "b.csv")
        self.assertIn("a;'=cmd", (self.folder / "b.csv").read_text())


class Server:
    """A server that counts its requests."""

    def __enter__(self):
        self.requests = []
        requests = self.requests

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                requests.append(self.path)
                self.send_error(404)

            do_HEAD = do_GET

            def log_message(self, *_):
                pass

        self.server = http.server.HTTPServer(("127.0.0.1", 0), Handler)
        threading.Thread(target=self.server.serve_forever, daemon=True).start()
        self.address = f"http://127.0.0.1:{self.server.server_port}"
        return self

    def __exit__(self, *_):
        self.server.shutdown()
        self.server.server_close()


class Databases(HostileTest):
    def setUp(self):
        super().setUp()
        if layer_files.gdal_of_program() is None:
            self.skipTest("built without GDAL")

    def database(self, name, *more):
        (self.folder / name).unlink(missing_ok=True)
        with sqlite3.connect(self.folder / name) as database:
            database.execute("CREATE TABLE trees (plot TEXT, tree INTEGER, dbh REAL)")
            database.executemany("INSERT INTO trees VALUES (1, ?, ?)", [(i, 10.5 + (7 * i) % 20) for i in range(50)])
            for statement in more:
                database.execute(statement)
        return name

    def with_virtual_table(self, name, module):
        """SQLite itself does not know the module, so that its table is written as text."""
        self.database(name, "PRAGMA writable_schema = 1",
                      f"INSERT INTO sqlite_master VALUES ('table', 'ext', 'ext', 0, 'CREATE VIRTUAL TABLE ext USING {module}')")
        return name

    def test_tables_without_geometry(self):
        self.write("trees.csv", "plot,tree,dbh\n" + "".join(f"1,{i},{10.5 + 7 * i % 20}\n" for i in range(50)))
        for options in (("SPATIALITE=NO",), ("SPATIALITE=YES",), ("METADATA=NO",)):
            name = "".join(options)[-5:] + ".sqlite"
            layer_files.ogr2ogr("-f", "SQLite", "-dsco", *options, self.folder / name, self.folder / "trees.csv",
                                "-oo", "AUTODETECT_TYPE=YES")
            self.assertEqual(self.count(name), 50, options)

    def test_virtual_tables(self):
        with Server() as server:
            for module in (f"VirtualOGR(''/vsicurl/{server.address}/a.csv'')", "VirtualText(''/etc/passwd'', ''UTF-8'')",
                           "VirtualShape(''/tmp/a'', ''UTF-8'', 4326)"):
                self.with_virtual_table("a.sqlite", module)
                self.refused(f'"ext" is a virtual table of {module.split("(")[0]}', "a.sqlite", "--layer", "trees")
            self.assertEqual(server.requests, [])

    def test_views_and_queries_with_functions(self):
        with Server() as server:
            for function in ("ogr_geocode('Oslo')",
                             "ogr_datasource_load_layers('other.shp')", "BlobFromFile('/etc/passwd')"):
                name = function.split("(")[0]
                self.database("a.sqlite", f"CREATE VIEW v AS SELECT tree, dbh, {function} AS g FROM trees")
                self.refused(f'"v" uses the function {name}', "a.sqlite", "--layer", "trees")
                self.database("a.sqlite")
                self.refused(f"the function {name} may read other files", "a.sqlite", "--sql",
                             f"select tree, dbh, {function} as g from trees", status=2)
            self.assertEqual(server.requests, [])
        self.assertEqual([path.name for path in self.folder.iterdir()], ["a.sqlite"])

    def test_queries_of_other_files(self):
        self.write("trees.csv", "plot,tree,dbh\n" + "".join(f"1,{i},{10.5 + 7 * i % 20}\n" for i in range(50)))
        for name in ("a.dbf", "secret.dbf"):
            layer_files.ogr2ogr("-f", "ESRI Shapefile", self.folder / name, self.folder / "trees.csv", "-oo", "AUTODETECT_TYPE=YES")
        self.assertEqual(self.run_json("fit", "a.dbf", "--sql", "select * from a where tree < 30", *FIT)["n"], 30)
        self.refused("no such table", "a.dbf", "--sql", f"select * from '{self.folder}/secret.dbf'.secret")

    def test_links_of_geojson(self):
        points = [{"type": "Feature", "properties": {"tree": i, "dbh": 10 + i % 7},
                   "geometry": {"type": "Point", "coordinates": [i, 2 * i]}} for i in range(30)]
        with Server() as server:
            crs = {"type": "link", "properties": {"href": f"{server.address}/crs", "type": "ogcwkt"}}
            self.write("a.geojson", json.dumps({"type": "FeatureCollection", "crs": crs, "features": points}))
            self.refused("refers to a file of a network; add --allow-network", "a.geojson")
            self.assertEqual(server.requests, [])

    def test_endless_views(self):
        counting = "WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c)"
        product = ", ".join(f"trees t{i}" for i in range(8))
        for view in (f"{counting} SELECT x AS tree, 1.5 AS dbh FROM c", f"{counting} SELECT 1 AS tree, count(*) AS dbh FROM c",
                     f"SELECT t0.tree, t0.dbh FROM {product}"):
            self.database("a.sqlite", f"CREATE VIEW v AS {view}")
            self.refused("view", "a.sqlite", "--layer", "v")

    def test_zeroed_pages(self):
        rows = "".join(f"1,{i},{10.5 + 7 * i % 20}\n" for i in range(20000))
        self.write("trees.csv", "plot,tree,dbh\n" + rows)
        layer_files.ogr2ogr(self.folder / "a.gpkg", self.folder / "trees.csv", "-oo", "AUTODETECT_TYPE=YES")
        data = (self.folder / "a.gpkg").read_bytes()
        pages = len(data) // 4096
        for page in range(pages // 2, pages, max(1, pages // 12)):
            changed = data[:4096 * page] + bytes(4096) + data[4096 * (page + 1):]
            (self.folder / "b.gpkg").write_bytes(changed)
            done = self.run_any("fit", "b.gpkg", "--json", *FIT)
            self.assertIn(done.returncode, (0, 3))
            if done.returncode == 0:
                self.assertEqual(json.loads(done.stdout)["n"], 20000)

    def test_pages_that_are_read_twice(self):
        """SQLite reads what a page holds; only a look at all pages shows that it is that of another."""
        self.database("a.sqlite", "INSERT INTO trees SELECT 2, 50*t.tree + u.tree, u.dbh FROM trees t, trees u")
        data = (self.folder / "a.sqlite").read_bytes()
        size = int.from_bytes(data[16:18], "big")
        pages = len(data) // size
        self.assertGreater(pages, 10)
        for to in range(1, pages):
            other = 3 + to % 5
            if to == other:
                continue
            page = data[size * other:size * (other + 1)]
            (self.folder / "b.sqlite").write_bytes(data[:size * to] + page + data[size * (to + 1):])
            self.refused("is damaged", "b.sqlite")
        # Rules with functions of other programs cannot be checked, which is no damage.
        self.database("a.sqlite")
        with sqlite3.connect(self.folder / "a.sqlite") as database:
            database.create_function("ST_Valid", 1, lambda value: 1, deterministic=True)
            database.execute("CREATE TABLE rules (a REAL NOT NULL CHECK (ST_Valid(a)))")
            database.execute("INSERT INTO rules VALUES (2)")
        self.assertEqual(self.run_json("fit", "a.sqlite", "--layer", "trees", *FIT)["n"], 50)


if __name__ == "__main__":
    unittest.main()
