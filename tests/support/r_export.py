# SPDX-License-Identifier: MIT
"""Data frames of the R package lmfor as `write.csv` leaves them: row names in a column without a name, names in quotes."""

import csv
from pathlib import Path

DATA = Path(__file__).resolve().parents[1] / "reference" / "data-gpl"
# The order of lmfor's manual. Columns that our copy lacks, which no test reads, are NA.
COLUMNS = {"spati.csv": ("plot X Y N G V Dg Hg Tg Hdom maos kuos kanro puunro pl xk yk d h t dk X2b id1 id2").split()}


def number(text):
    """15 significant digits at most, as R writes them; NA stays."""
    return text if text in ("", "NA") else f"{float(text):.15g}"


def write_as_r_does(name, target):
    """Writes a data set of DATA, such as spati.csv."""
    with open(DATA / name, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    columns = COLUMNS.get(name, list(rows[0]))
    with open(target, "w", encoding="utf-8") as file:
        file.write(",".join(f'"{column}"' for column in ["", *columns]) + "\n")
        for i, row in enumerate(rows, 1):
            row["kanro"] = row["plot"]
            file.write(",".join([f'"{i}"', *(number(row.get(column, "NA")) for column in columns)]) + "\n")
