# SPDX-License-Identifier: MIT
"""Makes workbooks, GIS layers and databases from rows, with Debian's openpyxl, GDAL and LibreOffice."""

import csv
import json
import shutil
import sqlite3
import subprocess

from silvafit_program import PROGRAM

# Debian's modules belong to its own Python.
DEBIAN_PYTHON = "/usr/bin/python3"

WRITE_WORKBOOK = """
import json, sys, datetime, openpyxl
request = json.load(sys.stdin)
workbook = openpyxl.Workbook()
workbook.remove(workbook.active)
for name, rows in request["sheets"]:
    sheet = workbook.create_sheet(name)
    for row in rows:
        sheet.append(row)
    for cells in request["merged"]:
        sheet.merge_cells(cells)
    for cell in request["dates"]:
        sheet[cell].number_format = "dd.mm.yyyy"
workbook.save(request["path"])
"""

READ_WORKBOOK = """
import json, sys, openpyxl
workbook = openpyxl.load_workbook(sys.argv[1])
print(json.dumps({sheet.title: [[cell.value for cell in row] for row in sheet.iter_rows()] for sheet in workbook}))
"""


def has_openpyxl():
    return subprocess.run([DEBIAN_PYTHON, "-c", "import openpyxl"], capture_output=True, check=False).returncode == 0


def gdal_of_program():
    """The version of GDAL that the program was built with, or None."""
    done = subprocess.run([PROGRAM, "--version", "--json"], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)["gdal"]


def as_cell(text):
    """A field of a CSV file as somebody types it into a sheet: numbers become numbers."""
    try:
        number = float(text)
    except ValueError:
        return text or None
    return int(number) if number.is_integer() and "." not in text else number


def rows_of_csv(path, delimiter=","):
    with open(path, encoding="utf-8-sig", newline="") as file:
        return [[as_cell(field) for field in row] for row in csv.reader(file, delimiter=delimiter)]


def write_workbook(path, sheets, merged=(), dates=()):
    """sheets: pairs of a name and rows; merged: ranges such as A2:A5; dates: cells that get a format of dates."""
    request = {"path": str(path), "sheets": sheets, "merged": list(merged), "dates": list(dates)}
    subprocess.run([DEBIAN_PYTHON, "-c", WRITE_WORKBOOK], input=json.dumps(request), text=True, check=True)


def read_workbook(path):
    done = subprocess.run([DEBIAN_PYTHON, "-c", READ_WORKBOOK, str(path)], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def ogr2ogr(*arguments):
    subprocess.run(["ogr2ogr", *map(str, arguments)], check=True, capture_output=True)


def convert_with_libreoffice(path, ending):
    """The workbook in another format, beside it."""
    subprocess.run(
        ["soffice", f"-env:UserInstallation=file://{path.parent}/office", "--headless", "--convert-to", ending,
         "--outdir", str(path.parent), str(path)],
        check=True, capture_output=True, timeout=120)
    return path.with_suffix("." + ending)


def has(command):
    return shutil.which(command) is not None


def write_sqlite(path, tables):
    """tables: a name, the columns as SQL, and the rows."""
    with sqlite3.connect(path) as database:
        for name, columns, rows in tables:
            database.execute(f"CREATE TABLE {name} ({columns})")
            database.executemany(f"INSERT INTO {name} VALUES ({','.join('?' * len(rows[0]))})", rows)
