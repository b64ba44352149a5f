# SPDX-License-Identifier: MIT
"""Workbooks: the sheets of test_sheets.py as Excel and LibreOffice save them, and workbooks that cannot be read."""

import csv
import io
import shutil
import unittest
import zipfile
from pathlib import Path

import layer_files
from silvafit_program import ProgramTest

SHEETS = Path(__file__).parent / "sheets"
TREES = 48
DELIMITERS = {"plain": ",", "french": ",", "german": ";", "finnish": ";", "spanish": "\t", "chinese": ","}


@unittest.skipUnless(layer_files.has_openpyxl(), "openpyxl is missing")
class Workbooks(ProgramTest):
    def setUp(self):
        super().setUp()
        shutil.copy(SHEETS / "plain.csv", self.folder)

    def workbook(self, name, sheets, **options):
        layer_files.write_workbook(self.folder / name, sheets, **options)
        return name

    def rows(self, name="plain"):
        return layer_files.rows_of_csv(SHEETS / f"{name}.csv", DELIMITERS[name])

    def indices(self, name, *arguments, status=0):
        done = self.run_program("indices", name, "--buffer", "2", *arguments, status=status)
        return list(csv.DictReader(io.StringIO(done.stdout))), done.stderr

    def assert_same_units(self, name, *arguments):
        plain, _ = self.indices("plain.csv")
        rows, said = self.indices(name, *arguments)
        self.assertEqual(len(rows), TREES)
        for left, right in zip(plain, rows):
            self.assertEqual({**left, "species": ""}, {**right, "species": ""})
        return said

    def test_titles_units_and_languages(self):
        for name, delimiter in DELIMITERS.items():
            with self.subTest(name):
                # Decimal commas stay text, as in cells that are formatted as text.
                book = self.workbook(f"{name}.xlsx", [("Trees", self.rows(name)), ("Notes", [])])
                said = self.assert_same_units(book)
                as_csv, heard = self.indices(str(SHEETS / f"{name}.csv"))
                self.assertEqual(len(as_csv), TREES)
                # The same is recognized as in the CSV file.
                recognized = [line for line in heard.splitlines() if "read from column" in line]
                self.assertEqual([line for line in said.splitlines() if "read from column" in line], recognized)

    def test_messages_name_sheet_and_row(self):
        rows = self.rows()
        rows[5][5] = "thick"
        book = self.workbook("a.xlsx", [("Trees", [["Forest"], [], *rows])])
        _, said = self.indices(book)
        self.assertIn("a.xlsx (sheet Trees):8: dbh: 'thick' is not a number", said)

    def test_several_sheets(self):
        book = self.workbook("a.xlsx", [("Trees 2024", self.rows()), ("Plots", [["plot", "area"], [1, 400]])])
        _, said = self.indices(book, status=3)
        self.assertIn("a.xlsx: has several sheets; choose one with --layer NAME: 'Trees 2024' (49 rows), 'Plots' (2 rows)",
                      said)
        self.assert_same_units(book, "--layer", "Trees 2024")
        _, said = self.indices(book, "--layer", "trees", status=3)
        self.assertIn("unknown sheet 'trees'; available: 'Trees 2024'", said)
        _, said = self.indices(book, "--sql", "select * from \"Trees 2024\"", status=2)
        self.assertIn("--sql: queries are for databases and GIS layers; choose a sheet of a workbook with --layer", said)

    def test_merged_cells(self):
        rows = self.rows()
        book = self.workbook("a.xlsx", [("Trees", rows)], merged=["A2:A13"])
        self.assertIn("--fill-down plot", self.indices(book)[1])
        self.assert_same_units(book, "--fill-down", "plot")

    def test_values_as_the_sheet_shows_them(self):
        rows = self.rows()
        # Excel stores 0.1 + 0.2 as 0.30000000000000004 and shows 0.3; labels must not depend on it.
        for i, row in enumerate(rows[1:], start=1):
            row[0] = [1.1, 0.1 + 0.2, 3, "007"][(i - 1) // 12]
        units, _ = self.indices(self.workbook("a.xlsx", [("Trees", rows)]))
        self.assertEqual(sorted({row["plot"] for row in units}), ["0.3", "007", "1.1", "3"])

    def test_formulas_without_values(self):
        rows = self.rows()
        for i, row in enumerate(rows[1:], start=2):
            row[7] = f"=G{i}/2"
        _, said = self.indices(self.workbook("a.xlsx", [("Trees", rows)]), status=3)
        self.assertIn("a.xlsx (sheet Trees):2: 48 cells have formulas without a stored value (first: H2); open the workbook "
                      "in Excel or LibreOffice", said)

    def test_dates_among_numbers(self):
        rows = self.rows()
        rows[4][5] = 33.5
        units, said = self.indices(self.workbook("a.xlsx", [("Trees", rows)], dates=["F5"]))
        self.assertIn("in column F, 1 number is formatted as dates (first: F5) and cannot be read", said)
        self.assertEqual(len(units), TREES - 1)

    def test_logical_values_among_numbers(self):
        rows = self.rows()
        rows[4][5] = True
        units, said = self.indices(self.workbook("a.xlsx", [("Trees", rows)]))
        self.assertIn("'TRUE' is not a number", said)
        self.assertEqual(len(units), TREES - 1)

    def test_damaged_elements(self):
        book = self.workbook("a.xlsx", [("Trees", self.rows())])
        part = "xl/worksheets/sheet1.xml"
        with zipfile.ZipFile(self.folder / book) as file:
            parts = {name: file.read(name) for name in file.namelist()}
        for name, begin, end in (("raw", b'<row r="5"', b"</row>"), ("k", b'<c r="F5"', b"</c>"), ("w", b"<v>", b"</v>")):
            with self.subTest(name):
                before, after = parts[part].split(begin, 1)
                tag = name.encode()
                rest = begin[begin.find(b" "):] if b" " in begin else b">"
                after = after.replace(end, b"</" + tag + b">", 1)
                with zipfile.ZipFile(self.folder / "b.xlsx", "w") as file:
                    for other, text in parts.items():
                        file.writestr(other, before + b"<" + tag + rest + after if other == part else text)
                _, said = self.indices("b.xlsx", status=3)
                self.assertIn(f"has an unknown element '{name}' after the cell", said)

    def test_other_commands(self):
        book = self.workbook("a.xlsx", [("Trees", self.rows())])
        fits = [self.run_json("fit", file, "--formula", "h ~ 1.3 + a*(1 - exp(-b*dbh))") for file in (book, "plain.csv")]
        self.assertEqual(fits[0]["fixed"], fits[1]["fixed"])
        stands = [self.run_program("stand", file).stdout for file in (book, "plain.csv")]
        self.assertEqual(*stands)
        filled = self.run_program("impute", book, "--response", "h", "--formula", "h ~ a + b*dbh", "--random", "none").stdout
        self.assertEqual([row["h_source"] for row in csv.DictReader(io.StringIO(filled))], ["measured"] * TREES)

    def test_written_workbook(self):
        rows = self.rows()
        rows[1][2] = "=1+1"  # openpyxl writes a formula; as a text it comes from CSV
        text = "\n".join(",".join("" if cell is None else str(cell) for cell in row) for row in rows)
        self.write("attack.csv", text + "\n")
        self.run_program("indices", "attack.csv", "--buffer", "2", "--out", "out.xlsx")
        sheets = layer_files.read_workbook(self.folder / "out.xlsx")
        self.assertEqual(list(sheets), ["trees"])
        header, *trees = sheets["trees"]
        plain, _ = self.indices("attack.csv")
        self.assertEqual(len(trees), TREES)
        # Text, not a formula.
        self.assertEqual(trees[0][header.index("species")], "=1+1")
        with zipfile.ZipFile(self.folder / "out.xlsx") as book:
            self.assertNotIn(b"<f>", book.read("xl/worksheets/sheet1.xml"))
        for tree, unit in zip(trees, plain):
            self.assertEqual(str(tree[header.index("tree")]), unit["tree"])
            written = tree[header.index("W")]
            self.assertEqual(None if unit["W"] == "" else float(unit["W"]), written)

    def test_workbooks_that_cannot_be_read(self):
        (self.folder / "locked.xlsx").write_bytes(b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(600))
        (self.folder / "broken.xlsx").write_bytes(b"PK\x03\x04" + bytes(600))
        (self.folder / "text.xlsx").write_text("plot,tree,dbh\n1,1,20\n", encoding="utf-8")
        book = self.workbook("a.xlsx", [("Trees", self.rows())])
        (self.folder / "half.xlsx").write_bytes((self.folder / book).read_bytes()[:3000])
        self.workbook("empty.xlsx", [("Trees", [])])
        with zipfile.ZipFile(self.folder / "locked.ods", "w") as file:
            file.writestr("mimetype", "application/vnd.oasis.opendocument.spreadsheet")
            file.writestr("META-INF/manifest.xml", "<manifest:manifest><manifest:encryption-data/></manifest:manifest>")
        for name, words in (
                ("locked.xlsx", "the workbook is encrypted, or in the format of Excel 97; open it, remove the password"),
                ("locked.ods", "the workbook is encrypted; open it and save it without a password"),
                ("broken.xlsx", "is not an Excel workbook, or is damaged"),
                ("half.xlsx", "is not an Excel workbook, or is damaged"),
                ("text.xlsx", "is not an Excel workbook; save it again as .xlsx, or as CSV in UTF-8"),
                ("empty.xlsx", "contains no sheet with rows"),
                ("nothing.xlsx", "cannot read (No such file or directory)")):
            with self.subTest(name):
                _, said = self.indices(name, status=3)
                self.assertTrue(said.startswith(f"silvafit: {name}: {words}"), said)
                self.assertEqual(said.count("\n"), 1, said)

    @unittest.skipUnless(layer_files.has("soffice"), "LibreOffice is missing")
    def test_other_programs_read_what_is_written(self):
        self.run_program("indices", "plain.csv", "--buffer", "2", "--out", "out.ods")
        self.run_program("indices", "plain.csv", "--buffer", "2", "--out", "out.xlsx")
        # Texts such as the plot 01 stay texts, and numbers are the same doubles.
        sheets = layer_files.read_workbook(self.folder / "out.xlsx")
        layer_files.convert_with_libreoffice(self.folder / "out.ods", "xlsx")
        self.assertEqual(layer_files.read_workbook(self.folder / "out.xlsx"), sheets)

    @unittest.skipUnless(layer_files.has("soffice"), "LibreOffice is missing")
    def test_workbooks_of_libreoffice(self):
        self.workbook("a.xlsx", [("Trees", self.rows("french"))])
        endings = ("ods", "xls") if layer_files.gdal_of_program() else ("ods",)
        for ending in endings:
            book = layer_files.convert_with_libreoffice(self.folder / "a.xlsx", ending)
            self.assert_same_units(book.name)
        rows = self.rows()
        rows[5][5] = "thick"
        self.workbook("b.xlsx", [("Trees", [["Forest"], [], *rows])])
        for ending in endings:
            layer_files.convert_with_libreoffice(self.folder / "b.xlsx", ending)
            self.assertIn(f"b.{ending} (sheet Trees):8: dbh: 'thick' is not a number", self.indices(f"b.{ending}")[1])


if __name__ == "__main__":
    unittest.main()
