# SPDX-License-Identifier: MIT
"""What other programs rely on in `silvafit indices` and `silvafit stand`, and indices as covariates."""

import csv
import io
import json
import math
import random
import unittest

import layer_files
from silvafit_program import ProgramTest

WINDOW = {"type": "Feature", "properties": {"plot": "1"},
          "geometry": {"type": "Polygon",
                       "coordinates": [[[0, 0], [30, 0], [30, 30], [0, 30], [0, 0]]]}}


def inventory(plots=("1",), trees=60, seed=5, strata=None):
    """Trees at random on 30 x 30 m, in coordinates of each plot."""
    draw = random.Random(seed)
    header = "plot,tree,species,x,y,dbh,h,cw" + (",stratum" if strata else "")
    lines = [header]
    for plot in plots:
        limit = 25 + draw.gauss(0, 3)
        for tree in range(1, trees + 1):
            dbh = draw.uniform(6, 40)
            h = 1.3 + limit * (1 - math.exp(-0.05 * dbh)) + draw.gauss(0, 0.5)
            line = (f"{plot},{tree},{draw.choice(['SM', 'MH'])},{draw.uniform(0, 30):.2f},"
                    f"{draw.uniform(0, 30):.2f},{dbh:.1f},{h:.2f},{draw.uniform(1, 5):.2f}")
            lines.append(line + (f",{strata[plot]}" if strata else ""))
    return "\n".join(lines) + "\n"


def rows_of(text):
    return list(csv.DictReader(io.StringIO(text)))


class Indices(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("inventory.csv", inventory())
        self.write("window.geojson", json.dumps(WINDOW))

    def indices(self, *options):
        return rows_of(self.run_program("indices", "inventory.csv", "--quiet", *options).stdout)

    def test_the_columns_keep_their_order_and_others_follow(self):
        rows = self.indices("--window", "window.geojson")
        first = ["plot", "tree", "species", "core", "W", "M", "U", "C",
                 "nn1", "nn2", "nn3", "nn4", "d1", "d2", "d3", "d4"]
        self.assertEqual(list(rows[0]), first)
        rows = self.indices("--window", "window.geojson", "--edge", "hanisch",
                            "--further", "Hegyi,BAL,T,CO")
        self.assertEqual(list(rows[0]), first + ["weight", "CO", "T", "Hegyi", "BAL"])
        for row in rows:
            self.assertEqual(float(row["weight"]) > 0, row["core"] == "1")

    def test_edge_corrections_choose_core_trees(self):
        count = {edge: sum(row["core"] == "1" for row in self.indices(
            "--window", "window.geojson", "--edge", edge))
            for edge in ("buffer", "hanisch", "torus", "none")}
        self.assertEqual(count["torus"], 60)
        self.assertEqual(count["none"], 60)
        self.assertLess(count["buffer"], 60)
        self.assertLess(count["hanisch"], 60)
        self.assertGreater(count["hanisch"], 0)

    def test_windows_in_all_formats_are_the_same(self):
        expected = self.indices("--window", "window.geojson")
        self.write("window.wkt", "POLYGON((0 0, 30 0, 30 30, 0 30, 0 0))")
        self.write("window.csv", 'plot,wkt\n1,"POLYGON((0 0, 30 0, 30 30, 0 30, 0 0))"\n')
        self.assertEqual(self.indices("--window", "window.wkt"), expected)
        self.assertEqual(self.indices("--window", "window.csv"), expected)

    def test_read_plot_by_plot_the_same_is_said(self):
        lines = inventory(plots=("1", "2", "3"), trees=9).splitlines()
        # Plot 2 is outside of its window, and some rows cannot be used.
        moved = [line if not line.startswith("2,") else
                 ",".join([*line.split(",")[:3], "500", *line.split(",")[4:]]) for line in lines]
        moved += [f"3,{tree},SM,1,{tree},-1,10,2" for tree in range(20, 27)]
        self.write("inventory.csv", "\n".join(moved) + "\n")
        for options in ((), ("--circle", "15,15,21", "--further", "Hegyi",
                             "--competition-radius", "6")):
            whole = self.run_program("indices", "inventory.csv", "--trust-units", *options)
            parts = self.run_program("indices", "inventory.csv", "--trust-units", "--stream",
                                     *options)
            self.assertEqual(parts.stdout, whole.stdout)
            self.assertEqual(parts.stderr, whole.stderr)
            self.assertIn("and 2 more", whole.stderr)
            self.assertIn("are core trees", whole.stderr)
        self.write("inventory.csv", "\n".join(line for line in moved[:1] + moved[10:19]) + "\n")
        for options in ([], ["--stream"]):
            done = self.run_program("indices", "inventory.csv", "--trust-units", "--circle",
                                    "15,15,21", "--out", "out.csv", *options, status=3)
            self.assertIn("all trees are outside the window", done.stderr)
            self.assertFalse((self.folder / "out.csv").exists())

    def test_every_plot_may_be_a_circle(self):
        self.write("inventory.csv", inventory(plots=("1", "2")))
        self.write("circles.csv", "plot,x,y,radius\n*,15,15,12\n")
        by_option = self.indices("--circle", "15,15,12")
        self.assertEqual(by_option, self.indices("--window", "circles.csv"))
        for row, tree in zip(by_option, rows_of(inventory(plots=("1", "2")))):
            distance = math.hypot(float(tree["x"]) - 15, float(tree["y"]) - 15)
            self.assertEqual(row["core"] == "1", distance <= 7)

    def test_labels_with_commas_are_kept_in_files_with_decimal_commas(self):
        self.write("inventory.csv", "plot;tree;species;x;y;dbh\n"
                   "1,2;1;A;0,5;1;20,5\n1.2;1;A;0,5;3;21,5\n1,2;2;A;2,5;1;20,5\n")
        rows = self.indices("--neighbors", "1", "--edge", "none")
        self.assertEqual([(row["plot"], row["nn1"], row["d1"]) for row in rows],
                         [("1,2", "2", "2"), ("1.2", "", ""), ("1,2", "1", "2")])

    def test_without_a_window_the_hull_is_said(self):
        done = self.run_program("indices", "inventory.csv")
        self.assertIn("no window is given; the convex hull", done.stderr)

    def test_wrong_options_are_refused(self):
        for options, word in ((["--further", "Q"], "not one of CO, T"),
                              (["--circle", "1,2"], "X,Y,RADIUS"),
                              (["--alpha", "x"], "an angle in degrees"),
                              (["--alpha", "72,OAK=60"], "unknown species 'OAK'"),
                              (["--further", "CCF"], "--open-grown")):
            done = self.run_program("indices", "inventory.csv", *options, status=2)
            self.assertIn(word, done.stderr)
        self.write("bad.wkt", "POINT(1 2)")
        self.run_program("indices", "inventory.csv", "--window", "bad.wkt", status=3)


class Stand(ProgramTest):
    def test_figures_are_those_of_the_window(self):
        self.write("inventory.csv", inventory())
        self.write("window.geojson", json.dumps(WINDOW))
        result = self.run_json("stand", "inventory.csv", "--window", "window.geojson",
                               "--further", "T")
        self.assertEqual(result["schema"], "silvafit-stand/1")
        trees = rows_of(inventory())
        basal = sum(math.pi * (float(tree["dbh"]) / 200) ** 2 for tree in trees)
        area = result["areas"][0]
        self.assertEqual((area["plot"], area["trees"]), ("1", 60))
        self.assertAlmostEqual(area["stems_per_ha"], 60 / 0.09, 9)
        self.assertAlmostEqual(area["basal_area_m2_per_ha"], basal / 0.09, 9)
        self.assertAlmostEqual(area["quadratic_mean_dbh_cm"],
                               200 * math.sqrt(basal / 60 / math.pi), 9)
        thickest = sorted(trees, key=lambda tree: (-float(tree["dbh"]), -float(tree["h"])))[:9]
        self.assertAlmostEqual(area["dominant_height_m"],
                               sum(float(tree["h"]) for tree in thickest) / 9, 9)
        self.assertGreater(area["clark_evans"]["R"], 0.6)
        self.assertEqual(result["quadrat_m"], 10)
        self.assertAlmostEqual(sum(one["all"]["importance"] for one in result["species"]), 100, 9)
        self.assertEqual(list(result["species"][0]["layers"]), ["lower", "middle", "upper"])
        self.assertEqual(sum(one["trees"] for one in result["diameters"]), 60)
        structure = result["structure"]
        self.assertIn("T", structure["all"])
        for joint in structure["joint"]:
            self.assertAlmostEqual(sum(map(sum, joint["share"])), 1, 9)
            self.assertEqual(joint["trees"], structure["all"]["core"])

    def test_strata_have_totals(self):
        strata = {"1": "A", "2": "A", "3": "B", "4": "B"}
        self.write("inventory.csv", inventory(plots=tuple(strata), strata=strata))
        result = self.run_json("stand", "inventory.csv", "--plot-area", "900", "--stratum",
                               "stratum", "--stratum-area", "A=10,B=5")
        self.assertEqual([one["stratum"] for one in result["strata"]], ["A", "B", None])
        total = result["strata"][2]
        self.assertAlmostEqual(total["stems"]["total"], 15 * 60 / 0.09, 6)
        self.assertEqual(total["area_ha"], 15)
        done = self.run_program("stand", "inventory.csv", "--stratum-area", "A=10", status=2)
        self.assertIn("--stratum", done.stderr)

    def test_plots_without_a_stratum_are_told_from_all_plots(self):
        strata = {"1": "A", "2": "all", "3": ""}
        text = inventory(plots=tuple(strata), strata={"1": "A", "2": "all", "3": " "})
        self.write("inventory.csv", text)
        options = ("stand", "inventory.csv", "--plot-area", "900", "--stratum", "stratum")
        result = self.run_json(*options)
        self.assertEqual([(one["stratum"], one["kind"], one["plots"]) for one in result["strata"]],
                         [("A", "stratum", 1), ("all", "stratum", 1), (None, "none", 1),
                          (None, "all", 3)])
        done = self.run_program(*options, "--out", "tables")
        self.assertIn("\n(none)  ", done.stdout)
        self.assertIn("plot 3 has no stratum", done.stderr)
        rows = rows_of((self.folder / "tables" / "strata.csv").read_text(encoding="utf-8"))
        self.assertEqual([(row["stratum"], row["kind"]) for row in rows],
                         [("A", "stratum"), ("all", "stratum"), ("", "none"), ("all", "all")])
        result = self.run_json(*options, "--stratum-area", "A=10,all=5")
        self.assertEqual(result["strata"][-1]["area_ha"], 15)

    def test_plots_of_dead_trees_are_empty_however_these_are_used(self):
        draw = random.Random(2)
        rows = [f"{plot},{tree},{20 + tree},{'dead' if plot > 6 else 'alive'},{draw.uniform(0, 22):.2f},{draw.uniform(0, 22):.2f}"
                for plot in range(1, 9) for tree in range(9)]
        self.write("dead.csv", "plot,tree,dbh,status,x,y\n" + "\n".join(rows) + "\n")
        # 9 trees on 0.05 ha in 6 of 8 plots.
        for how in ("leave-out", "neighbors"):
            stand = self.run_json("stand", "dead.csv", "--plot-area", "500", "--dead", how)
            self.assertEqual(len(stand["areas"]), 8)
            self.assertAlmostEqual(stand["all"]["stems_per_ha"], 135, places=6)
            self.assertFalse(any("outside" in note for note in stand["notes"]))

    def test_areas_that_change_or_contradict_are_named(self):
        rows = "".join(f"1,{tree},{year},{20 + (year - 2010) / 5}\n" for tree in range(10) for year in (2010, 2015))
        self.write("trees.csv", "plot,tree,year,dbh\n" + rows)
        self.write("plots.csv", "plot,year,area\n1,2010,500\n1,2015,250\n")
        growth = self.run_json("stand", "trees.csv", "--growth", "--plots", "plots.csv")
        self.assertTrue(any("1 plot has another area at the end of a period, which changes values per hectare without growth" in note
                            and "1 (500 m2 2010, 250 m2 2015)" in note for note in growth["notes"]))
        # All trees grow from 20 to 21 cm in five years.
        self.write("thick.csv", (self.folder / "trees.csv").read_text() + "1,90,2015,21.1\n1,91,2015,20.9\n")
        growth = self.run_json("stand", "thick.csv", "--growth", "--plot-area", "500")
        self.assertTrue(any(note.startswith("1 ingrowth tree is thicker than the smallest dbh before, 20 cm, with the largest increment, "
                                            "0.2 cm per year") and "tree 90 (21.1 cm, 2015)" in note for note in growth["notes"]))
        self.write("plots.csv", "plot,year,area,stratum\n1,2010,500,A\n1,2015,500,B\n")
        said = self.run_program("stand", "trees.csv", "--growth", "--plots", "plots.csv", status=3).stderr
        self.assertIn("plots.csv:3: stratum: the plot belongs to two strata, 'A' and 'B'", said)
        self.write("plots.csv", "plot,area\n1,500\n")
        said = self.run_program("stand", "trees.csv", "--where", "year == 2010", "--circles", "5=5,30=12", "--plots", "plots.csv").stderr
        self.assertIn("areas of the table of plots are not used: the circles have others for 1 plot, the first: "
                      "plot 1: 500 m2, its largest circle 452.389 m2", said)

    def test_windows_in_the_feet_of_the_trees_are_asked_about(self):
        # A plot of 40 x 40 m in feet, of which x and y are converted.
        draw = random.Random(3)
        rows = [f"{tree},{draw.uniform(0, 131.2):.1f},{draw.uniform(0, 131.2):.1f},{draw.uniform(8, 40):.1f}" for tree in range(60)]
        self.write("feet.csv", "tree,x (ft),y (ft),dbh\n" + "\n".join(rows) + "\n")
        self.write("feet.wkt", "POLYGON ((0 0, 131.24 0, 131.24 131.24, 0 131.24, 0 0))")
        self.write("meters.wkt", "POLYGON ((0 0, 40 0, 40 40, 0 40, 0 0))")
        done = self.run_program("stand", "feet.csv", "--window", "feet.wkt", status=3)
        self.assertIn("x and y are converted to meters (times 0.3048), but the trees lie in their windows by the numbers of the file",
                      done.stderr)
        stand = self.run_json("stand", "feet.csv", "--window", "meters.wkt")
        self.assertAlmostEqual(stand["areas"][0]["stems_per_ha"], 60 / 0.16, places=6)

    def test_tables_are_written_to_a_folder(self):
        self.write("inventory.csv", inventory())
        done = self.run_program("stand", "inventory.csv", "--circle", "15,15,21", "--out", "tables")
        self.assertIn("IV upper", done.stdout)
        names = {path.name for path in (self.folder / "tables").iterdir()}
        self.assertEqual(names, {"plots.csv", "strata.csv", "species.csv", "diameters.csv",
                                 "structure.csv", "classes.csv", "indices.csv"})
        self.run_program("stand", "inventory.csv", "--circle", "15,15,21", "--out", "tables.xlsx")
        sheets = layer_files.read_workbook(self.folder / "tables.xlsx")
        self.assertEqual({name + ".csv" for name in sheets}, names)
        trees = rows_of((self.folder / "tables" / "indices.csv").read_text(encoding="utf-8"))
        self.assertEqual(len(sheets["indices"]), 1 + len(trees))
        # The mean over core trees, by hand.
        for row in rows_of((self.folder / "tables" / "structure.csv").read_text(encoding="utf-8")):
            of = [tree for tree in trees if tree["core"] == "1" and
                  (row["kind"] == "all" or tree["species"] == row["species"])]
            self.assertEqual(int(row["core_trees"]), len(of))
            self.assertAlmostEqual(float(row["M"]), sum(float(tree["M"]) for tree in of) / len(of), places=12)

    def test_without_positions_an_area_is_asked_for(self):
        lines = [",".join(line.split(",")[:3] + line.split(",")[5:])
                 for line in inventory().splitlines()]
        self.write("inventory.csv", "\n".join(lines) + "\n")
        done = self.run_program("stand", "inventory.csv", status=2)
        self.assertIn("--plot-area", done.stderr)
        result = self.run_json("stand", "inventory.csv", "--plot-area", "900")
        self.assertIsNone(result["structure"])

    def test_an_area_in_the_file_that_is_not_used_is_said(self):
        lines = inventory().splitlines()
        self.write("inventory.csv", "\n".join([lines[0] + ",plot_area"] + [line + ",300" for line in lines[1:]]) + "\n")
        said = self.run_program("stand", "inventory.csv", "--plot-area", "900").stderr
        self.assertIn("every plot counts as 900 m2 by --plot-area; keep this, or read it from column 'plot_area' of this file", said)

    def test_a_basal_area_of_circumferences_is_said(self):
        lines = [line.split(",") for line in inventory().splitlines()]
        girths = [lines[0]] + [[*line[:5], f"{float(line[5]) * math.pi:.1f}", *line[6:]] for line in lines[1:]]
        self.write("girths.csv", "\n".join(",".join(line) for line in girths) + "\n")
        asked = "check the areas, and that dbh is the diameter in cm"
        self.assertIn(asked, self.run_program("stand", "girths.csv", "--plot-area", "900").stderr)
        self.assertNotIn(asked, self.run_program("stand", "girths.csv", "--plot-area", "900", "--columns", "dbh=dbh/pi").stderr)

    def test_a_tree_without_dbh_is_not_outside_a_window(self):
        lines = inventory().splitlines()
        self.write("inventory.csv", "\n".join([*lines, "1,99,SM,15,15,,,"]) + "\n")
        said = self.run_program("stand", "inventory.csv", "--plot-area", "900").stderr
        self.assertIn("1 tree is without dbh", said)
        self.assertNotIn("outside the windows", said)


    def test_areas_come_from_a_column_of_the_inventory(self):
        rows = ["plot,tree,species,dbh,h,PLOT_AREA"]
        rows += [f"{plot},{tree},SM,20,15,{area}" for plot, area in ((1, 500), (2, 250)) for tree in range(5)]
        self.write("inventory.csv", "\n".join(rows) + "\n")
        asked = self.run_program("stand", "inventory.csv", status=2).stderr
        self.assertIn("column 'PLOT_AREA' of this file with --plots inventory.csv; if it is in ha, with --plots-columns 'area=`PLOT_AREA`*10000'", asked)
        result = self.run_json("stand", "inventory.csv", "--plots", "inventory.csv")
        self.assertEqual([area["stems_per_ha"] for area in result["areas"]], [100, 200])
        self.write("hectares.csv", "\n".join(rows).replace(",500", ",0.05").replace(",250", ",0.025") + "\n")
        small = self.run_program("stand", "hectares.csv", "--plots", "hectares.csv", status=3).stderr
        self.assertIn("less than the 0.157 m2 of basal area of its trees", small)
        result = self.run_json("stand", "hectares.csv", "--plots", "hectares.csv", "--plots-columns", "area=PLOT_AREA*10000")
        self.assertEqual([area["stems_per_ha"] for area in result["areas"]], [100, 200])
        self.write("unit.csv", "\n".join(rows).replace("PLOT_AREA", "Plot area (ha)").replace(",500", ",0.05").replace(",250", ",0.025") + "\n")
        asked = self.run_program("stand", "unit.csv", status=2).stderr
        self.assertIn("column 'Plot area (ha)' of this file with --plots unit.csv\n", asked)
        result = self.run_json("stand", "unit.csv", "--plots", "unit.csv")
        self.assertEqual([area["stems_per_ha"] for area in result["areas"]], [100, 200])
        self.write("mixed.csv", "\n".join(rows).replace("2,4,SM,20,15,250", "2,4,SM,20,15,300") + "\n")
        self.assertIn("mixed.csv:11: area: 300 differs from 250 on line 7",
                      self.run_program("stand", "mixed.csv", "--plots", "mixed.csv", status=3).stderr)

    def test_impossible_areas_are_errors_of_all_commands(self):
        self.write("inventory.csv", inventory(plots=("1", "2")))
        self.write("plots.csv", "plot,area\n1,0.09\n2,0.09\n")
        for command in (("stand",), ("indices", "--out", "i.csv"), ("study", "--out", "study")):
            done = self.run_program(command[0], "inventory.csv", *command[1:], "--plots", "plots.csv", status=3)
            self.assertIn("m2 of basal area", done.stderr)

    def test_names_that_nothing_reads_are_refused(self):
        self.write("inventory.csv", inventory().replace("species", "sp"))
        wrong = self.run_program("stand", "inventory.csv", "--columns", "species=sp,statuss=h", "--plot-area", "900", status=2)
        self.assertIn("nothing reads a column 'statuss' here; did you mean status?", wrong.stderr)
        self.run_program("stand", "inventory.csv", "--columns", "species=sp,site=plot", "--plot-area", "900", "--stratum", "site")

    def test_factors_of_fia_are_not_left_out_when_plots_are_streamed(self):
        self.write("tree.csv", "CN,PLT_CN,INVYR,STATECD,UNITCD,COUNTYCD,PLOT,SUBP,TREE,STATUSCD,SPCD,DIA,HT,TPA_UNADJ\n"
                               "1,11,2018,44,1,7,1,1,1,1,316,10,60,6.018046\n2,11,2018,44,1,7,1,1,2,1,316,12,62,6.018046\n")
        # Two trees of 6.018046 per acre each.
        result = self.run_json("stand", "tree.csv")
        self.assertAlmostEqual(result["areas"][0]["stems_per_ha"], 2 * 6.018046 / 0.40468564224, 6)
        refused = self.run_program("stand", "tree.csv", "--stream", status=2).stderr
        self.assertIn("have factors of trees per ha", refused)

    def test_totals_of_columns_by_species_and_size_class(self):
        draw = random.Random(2)
        lines = ["plot,tree,species,dbh,vol"]
        for plot in range(1, 7):
            for tree in range(1, 1 + draw.randint(3, 9)):
                lines.append(f"{plot},{tree},{draw.choice('AB')},{draw.uniform(8, 30):.1f},{draw.uniform(0.1, 2):.3f}")
        text = "\n".join(lines) + "\n"
        self.write("inventory.csv", text)
        trees = rows_of(text)
        result = self.run_json("stand", "inventory.csv", "--plot-area", "500", "--totals", "vol", "--by", "species,dbh", "--class-width", "10")

        def mean_and_error(wanted):
            """The mean of plots of equal size and its standard error."""
            plots = [sum(float(tree["vol"]) for tree in trees if tree["plot"] == str(plot) and wanted(tree)) / 0.05 for plot in range(1, 7)]
            mean = sum(plots) / 6
            return mean, math.sqrt(sum((plot - mean) ** 2 for plot in plots) / 5 / 6)

        mean, error = mean_and_error(lambda tree: True)
        every = result["strata"][-1]["vol"]
        self.assertAlmostEqual(every["per_ha"], mean, 9)
        self.assertAlmostEqual(every["standard_error"], error, 9)
        for domain in result["domains"]:
            low, high = (float(limit) for limit in domain["of"]["dbh"].split("-"))
            mean, error = mean_and_error(lambda tree: tree["species"] == domain["of"]["species"] and low <= float(tree["dbh"]) < high)
            self.assertAlmostEqual(domain["vol"]["per_ha"], mean, 9)
            self.assertAlmostEqual(domain["vol"]["standard_error"], error, 9)
        self.assertIn("Trees by species and dbh, with standard errors", self.run_program(
            "stand", "inventory.csv", "--plot-area", "500", "--by", "species,dbh").stdout)
        wrong = self.run_program("stand", "inventory.csv", "--plot-area", "500", "--totals", "species", status=3).stderr
        self.assertIn("'species' is not a column of numbers", wrong)
        need = self.run_program("stand", "inventory.csv", "--plot-area", "500", "--finite-population", status=2).stderr
        self.assertIn("--finite-population", need)

    def test_a_thinning_is_a_table_and_a_column_of_trees(self):
        self.write("inventory.csv", "plot,tree,dbh,h,age\n1,1,10,8,50\n1,2,20,14,50\n1,3,30,18,50\n1,4,40,22,50\n")
        thinned = ("stand", "inventory.csv", "--plot-area", "100", "--thinning", "below=15")
        result = self.run_json(*thinned)["thinning"]["all"]
        # pi/4 (0.3^2 + 0.4^2) m2 on 100 m2 remain.
        self.assertAlmostEqual(result["after"]["basal_area_m2_per_ha"], math.pi / 4 * 25, 9)
        self.assertEqual((result["before"]["trees"], result["removed"]["trees"]), (4, 2))
        self.run_program(*thinned, "--out", "out")
        trees = rows_of((self.folder / "out" / "trees.csv").read_text(encoding="utf-8"))
        self.assertEqual([tree["removed"] for tree in trees], ["1", "1", "0", "0"])
        self.assertIn("Thinning: before, removed trees, after", self.run_program(*thinned).stdout)
        self.run_program(*thinned, "--report", "thinned.html")
        page = (self.folder / "thinned.html").read_text(encoding="utf-8")
        tables = json.loads(page.split('id="report-data">', 1)[1].split("</script>", 1)[0])["stand"]["tables"]
        table = next(one for one in tables if one["name"] == "thinning")
        row = dict(zip((column["name"] for column in table["columns"]), table["rows"][-1]))
        self.assertAlmostEqual(row["basal_area_per_ha_after"], result["after"]["basal_area_m2_per_ha"], 9)
        self.assertAlmostEqual(row["basal_area_per_ha_removed"], result["removed"]["basal_area_m2_per_ha"], 9)
        # The thickest tree of 100 m2 is dominant; the R package forester has 23.4545712788 m for 15 m at 50 years.
        site = self.run_json("stand", "inventory.csv", "--plot-area", "100", "--columns", "h=h*15/22", "--site-index",
                             "elfving-kiviste-1997")["sites"][0]
        self.assertAlmostEqual(site["site_index_m"], 23.4545712788, 8)
        wrong = self.run_program(*thinned[:4], "--thinning", "most", status=2).stderr
        self.assertIn("--thinning", wrong)

    def test_a_site_index_has_ages_and_the_species_of_its_curve(self):
        def site_of(ages, species="Fagus sylvatica"):
            rows = [f"1,{k},{species},{10 + 2*k},{10 + k},{age}" for k, age in enumerate(ages)]
            self.write("aged.csv", "\n".join(["plot,tree,species,dbh,h,age", *rows]) + "\n")
            return ("stand", "aged.csv", "--plot-area", "100", "--site-index", "elfving-kiviste-1997")

        notes = self.run_json(*site_of([50, 50, 50]))["notes"]
        self.assertTrue(any("the curve was made for Pinus sylvestris" in note and "Fagus sylvatica" in note for note in notes), notes)
        notes = self.run_json(*site_of([50, 50, 50], "Scots pine"))["notes"]
        self.assertFalse(any("the curve was made for" in note for note in notes), notes)
        for code in ("-99", "0"):
            self.assertIn(f"{code} is no age", self.run_program(*site_of([50, code, 50]), status=3).stderr)
        # The curve's data end at 80 years.
        outside = self.run_json(*site_of([90, 90, 90]))
        self.assertIsNone(outside["sites"][0]["site_index_m"])

    def test_what_no_tree_has_is_missing_and_codes_are_asked_about(self):
        rows = [f"{plot},{tree},B,{10 + plot + 0.7*tree:.1f},{9 + 0.5*tree:.1f},{0.1 + 0.013*tree:.3f}" for plot in (1, 2) for tree in range(20)]
        self.write("trees.csv", "\n".join(["plot,tree,species,dbh,h,vol", *rows]) + "\n")
        command = ("stand", "trees.csv", "--plot-area", "500")
        result = self.run_json(*command, "--equations", "A=taper")
        self.assertIsNone(result["strata"][-1]["volume_m3"]["per_ha"])
        self.assertIsNone(result["strata"][-1]["volume_m3"]["standard_error"])
        self.assertIn("no tree has the species 'a' of --equations", self.run_program(*command, "--equations", "A=taper").stderr)
        for column, code in (("vol", "-999"), ("h", "99"), ("dbh", "999")):
            place = {"dbh": 3, "h": 4, "vol": 5}[column]
            changed = [",".join([*row.split(",")[:place], code, *row.split(",")[place + 1:]]) if k % 10 == 3 else row for k, row in enumerate(rows)]
            self.write("trees.csv", "\n".join(["plot,tree,species,dbh,h,vol", *changed]) + "\n")
            error = self.run_program(*command, "--totals", "vol", status=3).stderr
            self.assertIn(f"{column}: the value {code} in 4 rows may be a code of missing values", error)
            self.assertIn(f"--missing {code}", error)
            self.run_program(*command, "--totals", "vol", "--missing", code)
            self.run_program(*command, "--totals", "vol", "--trust-units")

    def test_the_report_has_the_stand_table_and_curves(self):
        self.write("inventory.csv", inventory(plots=("1", "2", "3")))
        self.run_program("stand", "inventory.csv", "--plot-area", "900", "--report", "stand.html")
        page = (self.folder / "stand.html").read_text(encoding="utf-8")
        data = json.loads(page.split('id="report-data">', 1)[1].split("</script>", 1)[0])
        self.assertEqual(data["title"], "Stand tables of 3 plots")
        table = data["stand"]["tables"][0]
        whole = self.run_json("stand", "inventory.csv", "--plot-area", "900")["strata"][-1]["stems"]
        stems = [column["name"] for column in table["columns"]].index("stems_per_ha")
        self.assertEqual(table["rows"][0][stems], f"{round(whole['per_ha'])} \u00b1 {whole['standard_error']:.0f}")
        for curve in data["stand"]["curves"]:
            # A spreadsheet computes the heights of the curve.
            for dbh, h in list(zip(curve["dbh"], curve["h"]))[::10]:
                self.assertAlmostEqual(eval(curve["formula"][1:].replace("A2", repr(dbh)).replace("^", "**")), h, 3)
        self.assertEqual(len(data["stand"]["curves"]), 2)

    def test_importance_values_of_stand_and_study_are_one(self):
        text = inventory(trees=90)
        self.write("inventory.csv", text)
        self.write("window.geojson", json.dumps(WINDOW))
        trees = rows_of(text)

        def importance(species):
            """Mean of the shares of stems, of basal area, and of the 10 m quadrats in which species occur."""
            quadrats = {(tree["species"], min(int(float(tree["x"]) // 10), 2), min(int(float(tree["y"]) // 10), 2)) for tree in trees}
            own = [tree for tree in trees if tree["species"] == species]
            shares = (len(own) / len(trees),
                      sum(quadrat[0] == species for quadrat in quadrats) / len(quadrats),
                      sum(float(tree["dbh"]) ** 2 for tree in own) / sum(float(tree["dbh"]) ** 2 for tree in trees))
            return 100 * sum(shares) / 3

        stand = self.run_json("stand", "inventory.csv", "--window", "window.geojson")
        self.run_program("study", "inventory.csv", "--window", "window.geojson", "--minimum-trees", "20", "--out", "study", "--quiet")
        table = rows_of((self.folder / "study" / "tables" / "species.csv").read_text(encoding="utf-8"))
        of_study = {row["species"]: float(row["importance"]) for row in table}
        for one in stand["species"]:
            self.assertAlmostEqual(one["all"]["importance"], importance(one["species"]), 9)
            self.assertAlmostEqual(of_study[one["species"]], importance(one["species"]), 9)
        note = (self.folder / "study" / "tables" / "species.md").read_text(encoding="utf-8").splitlines()[0]
        self.assertIn("quadrats of 10 m", note)
        text = self.run_program("stand", "inventory.csv", "--window", "window.geojson").stdout
        self.assertIn("frequency from quadrats of 10 m", text)


class Covariates(ProgramTest):
    def test_an_index_is_a_covariate_by_name(self):
        self.write("inventory.csv", inventory(plots=("1", "2", "3")))
        arguments = ["fit", "inventory.csv", "--formula", "h ~ 1.3 + a*(1 - exp(-b*dbh))",
                     "--parameter", "b ~ 1 + BAL"]
        computed = self.run_json(*arguments, "--columns", "BAL=BAL")
        self.assertTrue(computed["converged"])
        # The same from a file that has the column.
        indices = rows_of(self.run_program(
            "indices", "inventory.csv", "--quiet", "--further", "BAL").stdout)
        lines = inventory(plots=("1", "2", "3")).splitlines()
        joined = [lines[0] + ",BAL"] + [
            f"{line},{row['BAL']}" for line, row in zip(lines[1:], indices)]
        self.write("inventory.csv", "\n".join(joined) + "\n")
        given = self.run_json(*arguments)
        self.assertEqual(computed["fixed"], given["fixed"])

    def test_a_response_is_no_covariate_of_itself_and_a_measure_no_group(self):
        self.write("inventory.csv", inventory(plots=("1", "2", "3")))
        study = ("study", "inventory.csv", "--out", "study", "--responses", "h", "--edge", "none")
        done = self.run_program(*study, "--covariates", "M,h", status=2)
        self.assertIn("'h' is a response and cannot be its own covariate", done.stderr)
        done = self.run_program(*study, "--group", "dbh", status=2)
        self.assertIn("use 'dbh' as a number", done.stderr)

    def test_a_study_takes_further_indices(self):
        self.write("inventory.csv", inventory(plots=("1", "2", "3", "4", "5"), trees=120))
        self.run_program("study", "inventory.csv", "--out", "study", "--responses", "h",
                         "--covariates", "C,BAL,stems_per_ha", "--quiet")
        with open(self.folder / "study" / "predictions.csv", encoding="utf-8") as file:
            header = file.readline().strip().split(",")
        for name in ("C", "BAL", "stems_per_ha"):
            self.assertIn(name, header)
        with open(self.folder / "study" / "tables" / "covariates.csv", encoding="utf-8") as file:
            self.assertIn("BAL", file.read())


if __name__ == "__main__":
    unittest.main()
