# SPDX-License-Identifier: MIT
"""Reads the folder of a study, and computes from its predictions what its tables ought to say."""

import csv
import json
import math
import os
import subprocess
from pathlib import Path

EXAMPLE = Path(os.environ["SILVAFIT_EXAMPLE"])
TABLES = ("species", "candidates", "covariates", "random_effects", "variance_functions", "estimates",
          "variance_components", "statistics", "gains", "level_tests",
          "rejected", "plots_left_out", "residual_variogram",
          "coefficients", "variance_and_fit", "plot_effects")
# Level and prediction in statistics.csv, and the column of predictions.csv behind it.
PREDICTIONS = {("ols", "population"): "ols",
               ("nlme", "population"): "population",
               ("nlme", "conditional"): "conditional"}


def read_csv(path):
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


class StudyFolder:
    def __init__(self, folder):
        self.folder = Path(folder)
        self.library = json.loads(self.text("library.json"))
        self.run = json.loads(self.text("run.json"))
        self.predictions = read_csv(self.folder / "predictions.csv")
        self.excluded = read_csv(self.folder / "excluded.csv")
        self.tables = {name: read_csv(self.folder / "tables" / f"{name}.csv") for name in TABLES}
        page = self.text("report.html")
        data = page.split('id="report-data">', 1)[1].split("</script>", 1)[0]
        self.report = json.loads(data)

    def text(self, name):
        return (self.folder / name).read_text(encoding="utf-8")

    def files(self):
        return {str(path.relative_to(self.folder)): path.read_bytes()
                for path in self.folder.rglob("*") if path.is_file()}

    def fits(self):
        """Every fit of the library by (species, response, role)."""
        return {(model["species"], model["response"], model["role"]): model["fit"]
                for model in self.library["models"]}

    def table(self, name, species, response):
        return [row for row in self.tables[name]
                if row["species"] == species and row["response"] == response]

    def pairs(self, species, response, prediction):
        """Observed and predicted values of the trees that the study fitted."""
        needed = [response, "dbh"] + [name for name in "WMCU" if name in self.predictions[0]]
        if response == "hcb":
            needed.append("h")
        return [(float(row[response]), float(row[f"{response}_{prediction}"]))
                for row in self.predictions
                if row["species"] == species and row.get("core", "1") == "1"
                and all(row[name] for name in needed)]


def statistics_of(pairs):
    """R2, mean error, RMSE and MAE as Wang et al. 2023 (Forests 14, 639) define them."""
    count = len(pairs)
    errors = [observed - predicted for observed, predicted in pairs]
    mean_error = math.fsum(errors) / count
    mean = math.fsum(observed for observed, _ in pairs) / count
    spread = math.fsum((error - mean_error) ** 2 for error in errors) / (count - 1)
    total = math.fsum((observed - mean) ** 2 for observed, _ in pairs)
    return {"r2": 1 - math.fsum(error ** 2 for error in errors) / total,
            "mean_error": mean_error,
            "rmse": math.sqrt(mean_error ** 2 + spread),
            "mae": math.fsum(abs(error) for error in errors) / count}


def run_node(script, *arguments, timeout=120):
    """Runs a script of the build tree; gives exit status and both outputs."""
    return subprocess.run([os.environ["SILVAFIT_NODE"], os.environ[script], *map(str, arguments)],
                          capture_output=True, text=True, timeout=timeout, check=False)
