#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Writes the workbooks of this folder: openpyxl (3.0) makes kinds.xlsx without values of formulas, LibreOffice (7.4) computes these and saves
computed.xlsx and computed.ods; days-1904.xlsx is of openpyxl. libsource/src/workbook/workbook_test.cpp has what they must contain."""

import datetime
import pathlib
import subprocess
import tempfile

import openpyxl
from openpyxl.utils.datetime import CALENDAR_MAC_1904

HERE = pathlib.Path(__file__).resolve().parent
HEADER = ["plot", "tree", "dbh", "twice", "day", "moment", "clock", "share", "alive", "comma", "ratio", "gone", "text"]


def make_kinds(path):
    workbook = openpyxl.Workbook()
    trees = workbook.active
    trees.title = "Trees"
    trees.append(["Compartment 12"])
    trees.append([])
    trees.append(HEADER)
    for i in range(3):
        row = 4 + i
        trees.append([["A", None, "07"][i], i + 1, [0.1 + 0.2, 33, 1e-3][i], f"=2*C{row}", datetime.date(2024, 2, 29 - i),
                      datetime.datetime(1999, 12, 31, 23, 59, 58 + i % 2), datetime.time(7, 5 + i), 0.25 * i, i != 1, f"1{i},5", f"=1/{i}", "=NA()",
                      ['said "so"; twice', " two\nlines", "_x0041_ é 木"][i]])
        for column, code in (("E", "dd.mm.yyyy"), ("F", "yyyy-mm-dd hh:mm:ss"), ("G", "hh:mm"), ("H", "0 %")):
            trees[f"{column}{row}"].number_format = code
    trees.merge_cells("A4:A5")
    trees.row_dimensions[5].hidden = True
    codes = workbook.create_sheet("Codes")
    codes.append(["code", "species"])
    codes.append([1, "fir"])
    codes.sheet_state = "hidden"
    workbook.create_sheet("Empty")
    workbook.save(path)


def make_1904(path):
    workbook = openpyxl.Workbook()
    workbook.epoch = CALENDAR_MAC_1904
    workbook.active.append(["day"])
    workbook.active.append([datetime.date(1904, 1, 2)])
    workbook.active.append([datetime.date(2024, 2, 29)])
    workbook.save(path)


def convert(path, ending, target):
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(["soffice", f"-env:UserInstallation=file://{folder}/office", "--headless", "--convert-to", ending, "--outdir", folder, path],
                       check=True, capture_output=True)
        target.write_bytes((pathlib.Path(folder) / path.with_suffix("." + ending).name).read_bytes())


if __name__ == "__main__":
    make_kinds(HERE / "kinds.xlsx")
    make_1904(HERE / "days-1904.xlsx")
    convert(HERE / "kinds.xlsx", "ods", HERE / "computed.ods")
    convert(HERE / "computed.ods", "xlsx", HERE / "computed.xlsx")
