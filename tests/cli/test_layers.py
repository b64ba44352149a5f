# SPDX-License-Identifier: MIT
"""GIS layers and databases in and out: the same trees as a CSV file, in each format and coordinate system."""

import csv
import io
import json
import math
import os
import random
import shutil
import sqlite3
import subprocess
import unittest
import xml.etree.ElementTree as xml
from pathlib import Path

import layer_files
from silvafit_program import ProgramTest, stand_csv
from test_grow import read_glb

# A corner in zone 33 of UTM, where 1 m of the grid is 0.9996 to 1.0001 m on the ground.
EAST, NORTH = 512300.0, 5412700.0


def trees_csv(plots=4, trees=25, seed=5):
    """Square plots of 20 m, 100 m apart."""
    draw = random.Random(seed)
    lines = ["plot,tree,species,x,y,dbh,h,hcb,cw"]
    for plot in range(1, plots + 1):
        for tree in range(1, trees + 1):
            x = EAST + 100 * plot + draw.uniform(0, 20)
            y = NORTH + draw.uniform(0, 20)
            dbh = draw.uniform(8, 50)
            h = 1.3 + 28 * (1 - math.exp(-0.05 * dbh)) + draw.gauss(0, 0.5)
            lines.append(f"{plot:02d},{tree},{draw.choice(['SM', 'OF', 'BI'])},{x:.3f},{y:.3f},{dbh:.1f},{h:.1f},"
                         f"{0.4 * h:.1f},{1 + dbh / 10:.1f}")
    return "\n".join(lines) + "\n"


def plot_polygons(plots=4, margin=1.0):
    """Rings around the plots of trees_csv, by plot."""
    rings = {}
    for plot in range(1, plots + 1):
        low_x, low_y = EAST + 100 * plot - margin, NORTH - margin
        high_x, high_y = low_x + 20 + 2 * margin, low_y + 20 + 2 * margin
        rings[f"{plot:02d}"] = [(low_x, low_y), (high_x, low_y), (high_x, high_y), (low_x, high_y), (low_x, low_y)]
    return rings


def wkt_of(ring):
    return "POLYGON ((" + ", ".join(f"{x} {y}" for x, y in ring) + "))"


class LayerTest(ProgramTest):
    def setUp(self):
        super().setUp()
        if layer_files.gdal_of_program() is None:
            self.skipTest("built without GDAL")
        if not layer_files.has("ogr2ogr"):
            self.skipTest("ogr2ogr is missing")
        self.write("trees.csv", trees_csv())

    def layer(self, name, *options, source="trees.csv", typed=True, system="EPSG:32633"):
        """The trees as a layer of points."""
        assigned = "-s_srs" if "-t_srs" in options else "-a_srs"
        detect = ("-oo", "AUTODETECT_TYPE=YES") if typed else ()
        layer_files.ogr2ogr(self.folder / name, self.folder / source, "-oo", "X_POSSIBLE_NAMES=x", "-oo",
                            "Y_POSSIBLE_NAMES=y", *detect, assigned, system, *options)
        return name

    def windows(self, name, *options):
        assigned = "-s_srs" if "-t_srs" in options else "-a_srs"
        lines = ["plot_id,wkt"] + [f'{int(plot)},"{wkt_of(ring)}"' for plot, ring in plot_polygons().items()]
        self.write("plots.csv", "\n".join(lines) + "\n")
        layer_files.ogr2ogr(self.folder / name, self.folder / "plots.csv", "-oo", "GEOM_POSSIBLE_NAMES=wkt",
                            "-oo", "KEEP_GEOM_COLUMNS=NO", assigned, "EPSG:32633", "-nlt", "POLYGON", *options)
        return name

    def indices(self, name, *arguments, status=0):
        done = self.run_program("indices", name, "--buffer", "2", *arguments, status=status)
        return list(csv.DictReader(io.StringIO(done.stdout))), done.stderr

    def assert_same_units(self, units, others, tolerance=1e-6):
        """Labels and neighbors are equal, numbers are within a tolerance: 1e-6 m is the precision of projections."""
        self.assertEqual(len(units), len(others))
        for left, right in zip(units, others):
            for name, value in left.items():
                try:
                    self.assertAlmostEqual(float(value), float(right[name]), delta=tolerance, msg=name)
                except ValueError:
                    self.assertEqual(value, right[name], name)


class Reading(LayerTest):
    def test_formats(self):
        plain, _ = self.indices("trees.csv")
        for name in ("a.gpkg", "a.shp", "a.fgb", "a.sqlite", "a.db"):
            with self.subTest(name):
                driver = ("-f", "SQLite", "-dsco", "SPATIALITE=NO") if name == "a.db" else ()
                self.layer(name, *driver, typed=name != "a.sqlite")
                # FlatGeobuf orders its rows by place, not as the file has them.
                units, said = self.indices(name, "--excluded", "excluded.csv")
                key = lambda row: (row["plot"], int(row["tree"]))
                plot = lambda row: {**row, "plot": f"{int(row['plot']):02d}"}
                self.assert_same_units(sorted(map(plot, units), key=key), plain)
                self.assertNotIn("rows skipped", said)
        self.assertTrue((self.folder / "a.prj").exists())

    def test_geographic_and_distorting_systems_are_projected(self):
        plain, _ = self.indices("trees.csv")
        for name, system, words in (
                ("degrees.gpkg", "EPSG:4326", "coordinates in longitude and latitude are projected to EPSG:32633"),
                ("degrees.geojson", "EPSG:4326", "coordinates in longitude and latitude are projected to EPSG:32633"),
                # Web Mercator stretches by 1 / cos(48.9 degrees) = 1.52.
                ("web.gpkg", "EPSG:3857", "coordinates in EPSG:3857, which changes lengths by 52 % there, are projected "
                                          "to EPSG:32633")):
            with self.subTest(name):
                self.layer(name, "-t_srs", system)
                units, said = self.indices(name)
                self.assertIn(words, said)
                # GeoJSON has 7 decimals of a degree: 1 cm.
                plot = lambda row: {**row, "plot": f"{int(row['plot']):02d}"}
                self.assert_same_units(map_list(plot, units), plain, 0.02 if name.endswith("json") else 1e-5)

    def test_feet_become_meters(self):
        # In US survey feet, the grid of North Carolina.
        foot = 1200 / 3937
        lines = trees_csv().splitlines()
        self.write("feet.csv", "\n".join([lines[0], *(in_feet(line, foot) for line in lines[1:])]) + "\n")
        self.layer("feet.gpkg", source="feet.csv", system="EPSG:2264")
        plain, _ = self.indices("trees.csv")
        units, said = self.indices("feet.gpkg")
        self.assertIn("coordinates are converted to m from the unit of EPSG:2264: US survey foot", said)
        plot = lambda row: {**row, "plot": f"{int(row['plot']):02d}"}
        # The file has 0.0001 feet.
        self.assert_same_units(map_list(plot, units), plain, 1e-4)

    def test_layer_without_a_system(self):
        self.layer("a.gpkg", system="NONE")
        _, said = self.indices("a.gpkg")
        self.assertIn("the layer has no coordinate reference system; its coordinates are used as meters", said)

    def test_wrong_system(self):
        self.layer("a.gpkg", system="EPSG:4326")
        _, said = self.indices("a.gpkg", status=3)
        self.assertIn("are not degrees, but the layer's coordinate reference system is EPSG:4326; correct the system", said)

    def test_windows(self):
        self.layer("forest.gpkg", "-nln", "trees")
        self.windows("forest.gpkg", "-update", "-nln", "plots")
        self.windows("degrees.shp", "-t_srs", "EPSG:4326")
        lines = ["plot,wkt"] + [f'{int(plot)},"{wkt_of(ring)}"' for plot, ring in plot_polygons().items()]
        self.write("windows.csv", "\n".join(lines) + "\n")
        expected, _ = self.indices("forest.gpkg", "--layer", "trees", "--window", "windows.csv")
        self.assertIn("1", {unit["core"] for unit in expected})
        for arguments in (("--layer", "trees", "--window", "forest.gpkg"),
                          ("--layer", "trees", "--window", "forest.gpkg", "--window-layer", "plots"),
                          ("--layer", "trees", "--window", "degrees.shp")):
            units, said = self.indices("forest.gpkg", *arguments)
            self.assert_same_units(units, expected)
        self.assertIn("degrees.shp: coordinates are converted from EPSG:4326 to EPSG:32633", said)
        # The trees are a CSV file: --layer is that of the windows.
        self.write("numbers.csv", trees_csv().replace("\n0", "\n"))
        units, _ = self.indices("numbers.csv", "--window", "forest.gpkg", "--layer", "plots")
        self.assert_same_units(units, expected)
        _, said = self.indices("forest.gpkg", status=3)
        self.assertIn("forest.gpkg: has several layers; choose one with --layer NAME: 'trees' (points, 100 rows), "
                      "'plots' (polygons, 4 rows)", said)

    def test_texts_that_are_numbers(self):
        # ogr2ogr makes texts of all columns of a CSV file.
        self.layer("texts.gpkg", typed=False)
        formula = ("--formula", "h ~ 1.3 + a*(1 - exp(-b*dbh))")
        fits = [self.run_json("fit", name, *formula) for name in ("texts.gpkg", "trees.csv")]
        self.assertEqual(fits[0]["n"], 100)
        self.assertEqual(fits[0]["fixed"], fits[1]["fixed"])
        units, _ = self.indices("texts.gpkg")
        self.assertEqual(units[0]["plot"], "01")

    def test_values_of_databases(self):
        layer_files.write_sqlite(self.folder / "a.sqlite", [
            ("trees", "plot TEXT, tree INTEGER PRIMARY KEY, record INTEGER, alive BOOLEAN, day DATE, dbh FLOAT, h REAL",
             [("07", 11, 2 ** 60 + 1, 1, "2024-05-06", 20.5, 18.0), ("07", 12, 5, 0, None, 30.25, None),
              ("07", 13, None, 1, "1969-12-31", 12.3, 9.5)])])
        self.write("library.json", json.dumps(self.run_json("fit", "trees.csv", "--model", "M4")))
        self.run_program("predict", "library.json", "a.sqlite", "--out", "out.csv")
        with open(self.folder / "out.csv", encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([row["plot"] for row in rows], ["07"] * 3)
        self.assertEqual([row["tree"] for row in rows], ["11", "12", "13"])
        self.assertEqual([row["record"] for row in rows], [str(2 ** 60 + 1), "5", ""])
        self.assertEqual([row["day"] for row in rows], ["2024-05-06", "", "1969-12-31"])
        self.assertEqual([row["dbh"] for row in rows], ["20.5", "30.25", "12.3"])

    def test_databases_keep_what_their_columns_are_not_declared_for(self):
        # SQLite stores any value in any column; GDAL takes types from declarations or first rows.
        rows = [("A", i + 1, dbh) for i, dbh in enumerate([10, 11.7, 12.7, 13.9])]
        layer_files.write_sqlite(self.folder / "a.sqlite", [
            ("whole", "plot TEXT, tree INTEGER, dbh INTEGER", rows), ("any", "plot TEXT, tree INTEGER, dbh ANY", rows),
            ("yes", "plot TEXT, tree INTEGER, dbh BOOLEAN", rows), ("day", "plot TEXT, tree INTEGER, dbh DATE", rows)])
        base = ("stand", "a.sqlite", "--plot-area", "100", "--json")
        query = 'select plot, tree, dbh + 0 as dbh from "whole";'
        for choice in (["--layer", "whole"], ["--layer", "any"], ["--layer", "yes"], ["--sql", query]):
            with self.subTest(choice):
                plot = self.run_json(*base, *choice)["areas"][0]
                self.assertAlmostEqual(plot["basal_area_m2_per_ha"], 100 * sum(math.pi / 4e4 * d * d for _, _, d in rows))
        layer_files.write_sqlite(self.folder / "b.sqlite", [
            ("trees", "plot TEXT, tree INTEGER, dbh REAL, note TEXT", [("A", 1, 10.5, ""), ("A", 2, "11,7", "")]),
            ("marked", "plot TEXT, tree INTEGER, dbh REAL", [("A", 1, 10.5), ("A", 2, "12.5m")])])
        error = self.run_program("stand", "b.sqlite", "--layer", "trees", "--plot-area", "100", status=3).stderr
        self.assertIn("'11,7'", error)
        error = self.run_program("stand", "b.sqlite", "--layer", "marked", "--plot-area", "100").stderr
        self.assertIn("'12.5m' is not a number", error)

    def test_values_larger_than_their_database_are_refused(self):
        with sqlite3.connect(self.folder / "a.sqlite") as base:
            base.execute("create view trees as select '1' plot, 1 tree, 10.0 dbh, hex(zeroblob(400000000)) note")
        error = self.run_program("stand", "a.sqlite", "--plot-area", "100", status=3).stderr
        self.assertIn("too big", error)

    def test_databases_in_utf16(self):
        with sqlite3.connect(self.folder / "a.sqlite") as base:
            base.execute("pragma encoding = 'UTF-16'")
            base.execute("create table trees (plot text, tree integer, species text, dbh real)")
            base.execute("insert into trees values ('Ä', 1, 'Kiefer', 20.5)")
        plot = self.run_json("stand", "a.sqlite", "--plot-area", "100", "--json")["areas"][0]
        self.assertEqual(plot["plot"], "Ä")

    def test_sqlite_in_the_layout_of_fia(self):
        # Columns and units of FIA's tables PLOT and TREE; inches, feet, degrees from north.
        draw = random.Random(8)
        plots = [(f"10{k}", 37, 21, k, 2019) for k in range(1, 4)]
        trees = []
        for plot in plots:
            for number in range(1, 13):
                trees.append((plot[0], 1, number, draw.choice([1, 1, 1, 2]), draw.choice([131, 802]),
                              round(draw.uniform(5, 20), 1), draw.randint(30, 90), draw.randint(0, 359),
                              round(draw.uniform(1, 24), 1)))
        layer_files.write_sqlite(self.folder / "FIADB_NC.db", [
            ("PLOT", "CN VARCHAR(34), STATECD INTEGER, COUNTYCD INTEGER, PLOT INTEGER, INVYR INTEGER", plots),
            ("TREE", "PLT_CN VARCHAR(34), SUBP INTEGER, TREE INTEGER, STATUSCD INTEGER, SPCD INTEGER, DIA FLOAT, "
                     "HT INTEGER, AZIMUTH INTEGER, DIST FLOAT", trees)])
        lines = ["plot,tree,species,dbh,h,x,y"]
        for plt_cn, _, number, status, spcd, dia, height, azimuth, dist in trees:
            if status == 1:
                angle = math.radians(azimuth)
                lines.append(f"{plt_cn[2:]},{number},{spcd},{dia * 2.54!r},{height * 0.3048!r},"
                             f"{dist * 0.3048 * math.sin(angle)!r},{dist * 0.3048 * math.cos(angle)!r}")
        self.write("metric.csv", "\n".join(lines) + "\n")
        query = ("select p.plot, t.tree, t.spcd, t.dia, t.ht, t.azimuth, t.dist from tree t join plot p "
                 "on t.plt_cn = p.cn where t.statuscd = 1 and p.invyr = 2019 order by p.plot, t.tree")
        columns = ("plot=PLOT,tree=TREE,species=SPCD,dbh=DIA*2.54,h=HT*0.3048,x=DIST*0.3048*sin(AZIMUTH*pi/180),"
                   "y=DIST*0.3048*cos(AZIMUTH*pi/180)").replace("pi", repr(math.pi))
        circle = ("--circle", "0,0,7.32")
        units, _ = self.indices("FIADB_NC.db", "--sql", query, "--columns", columns, *circle)
        expected, _ = self.indices("metric.csv", *circle)
        self.assert_same_units(units, expected)

    def test_mistakes(self):
        self.layer("a.gpkg", "-nln", "trees")
        (self.folder / "broken.gpkg").write_bytes(b"SQLite format 3\0" + bytes(900))
        (self.folder / "broken.shp").write_bytes(b"\0\0\x27\x0a" + bytes(20))
        (self.folder / "folder.gpkg").mkdir()
        mixed = {"type": "FeatureCollection", "features": [
            {"type": "Feature", "properties": {"dbh": 20}, "geometry": {"type": "Point", "coordinates": [15.1, 48.9]}},
            {"type": "Feature", "properties": {"dbh": 21},
             "geometry": {"type": "LineString", "coordinates": [[15.1, 48.9], [15.2, 48.9]]}}]}
        self.write("mixed.geojson", json.dumps(mixed))
        layer_files.write_sqlite(self.folder / "plain.sqlite", [("trees", "plot, tree, dbh REAL", [(1, 1, 20.0)])])
        for arguments, status, words in (
                (("a.gpkg", "--layer", "forest"), 3, "a.gpkg: unknown layer 'forest'; available: 'trees' (points, 100 rows)"),
                (("a.gpkg", "--sql", "select dbhh from trees"), 3, "a.gpkg: the query of --sql failed: no such column: dbhh; available: 'trees'"),
                (("a.gpkg", "--sql", "select * from forest"), 3, "the query of --sql failed: no such table: forest; available: 'trees'"),
                (("a.gpkg", "--sql", "delete from trees"), 2, "--sql: must be one query that begins with select or with"),
                (("a.gpkg", "--sql", "select 1; drop table trees"), 2, "--sql: must be one query"),
                (("a.gpkg", "--sql", "select * from '/vsicurl/http://localhost/a.shp'.a"), 2, "--sql: names a file of a network"),
                (("https://localhost/a.gpkg",), 3, "is a file of a network or an archive; save it on this computer, or add --allow-network"),
                (("/vsizip/a.zip/a.gpkg",), 3, "is a file of a network or an archive"),
                (("trees.csv", "--layer", "trees"), 2, "--layer: a CSV file has no layers"),
                (("broken.gpkg",), 3, "broken.gpkg: is not a GeoPackage, or is damaged"),
                (("broken.shp",), 3, "with the files beside it that end in .shx and .dbf"),
                (("folder.gpkg",), 3, "folder.gpkg: is a folder; a file is needed"),
                (("mixed.geojson",), 3, "mixed.geojson:2: the geometry is a line, but others are points"),
                (("plain.sqlite",), 3, "x"),
                (("trees.csv", "--window", "a.gpkg"), 3, "has no layer of polygons, or of points with a column radius; available: 'trees' (points, 100 rows)"),
                (("a.gpkg", "--stream"), 2, "only CSV files can be read plot by plot")):
            with self.subTest(arguments):
                _, said = self.indices(*arguments, status=status)
                self.assertIn(words, said)
                for word in ("GDAL", "sqlite3_", "ERROR", "ExecuteSQL"):
                    self.assertNotIn(word, said)

    def test_other_commands(self):
        self.layer("a.gpkg", "-nln", "trees")
        self.run_program("stand", "a.gpkg")
        self.run_program("view", "a.gpkg", "--out", "view.html", "--no-open")
        self.run_program("grow", "a.gpkg", "--plot", "1", "--scene", "scene.glb")
        self.run_program("impute", "a.gpkg", "--response", "h")
        done = self.run_json("study", "a.gpkg", "--out", "results", "--responses", "h", "--edge", "none", "--minimum-trees", "20",
                             "--workbook", "all.gpkg")
        self.assertEqual(done["schema"], "silvafit-study/1")
        header = (self.folder / "results/predictions.csv").read_text(encoding="utf-8").splitlines()[0]
        with sqlite3.connect(self.folder / "all.gpkg") as database:
            names = [row[1] for row in database.execute("pragma table_info(trees)")]
        self.assertEqual(set(names) - {"fid", "geom"}, set(header.split(",")))


def map_list(function, rows):
    return [function(row) for row in rows]


def hull_area(points):
    """Area of the convex hull, by Andrew's monotone chain (1979)."""
    def chain(points):
        hull = []
        for point in points:
            while len(hull) > 1 and cross(hull[-2], hull[-1], point) <= 0:
                hull.pop()
            hull.append(point)
        return hull[:-1]

    def cross(a, b, c):
        return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])

    # Near the origin, so that products of coordinates keep their digits.
    low_x, low_y = min(points)[0], min(point[1] for point in points)
    points = sorted((x - low_x, y - low_y) for x, y in points)
    hull = chain(points) + chain(points[::-1])
    return sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(hull, hull[1:] + hull[:1])) / 2


def in_feet(line, foot):
    """The position on the grid of North Carolina, EPSG:2264."""
    fields = line.split(",")
    fields[3] = f"{(float(fields[3]) - EAST + 640000) / foot:.4f}"
    fields[4] = f"{(float(fields[4]) - NORTH + 200000) / foot:.4f}"
    return ",".join(fields)


class Writing(LayerTest):
    def test_trees_and_plots_of_indices(self):
        self.layer("a.gpkg", "-nln", "trees")
        self.run_program("indices", "a.gpkg", "--buffer", "2", "--out", "out.gpkg")
        expected, _ = self.indices("a.gpkg")
        with sqlite3.connect(self.folder / "out.gpkg") as database:
            database.row_factory = sqlite3.Row
            trees = [dict(row) for row in database.execute("select * from trees order by fid")]
            plots = [dict(row) for row in database.execute("select * from plots order by fid")]
            styles = {row["f_table_name"]: row for row in database.execute("select * from layer_styles")}
            systems = [row[0] for row in database.execute("select srs_id from gpkg_geometry_columns")]
        self.assertEqual(systems, [32633, 32633])
        for tree, unit in zip(trees, expected):
            self.assertEqual((str(tree["plot"]), str(tree["tree"]), tree["species"], str(tree["core"])),
                             (unit["plot"], unit["tree"], unit["species"], unit["core"]))
            for index in ("W", "M", "U"):
                self.assertEqual(tree[index], float(unit[index]) if unit[index] else None)
        self.assertEqual([plot["plot"] for plot in plots], ["1", "2", "3", "4"])
        self.assertEqual({plot["trees"] for plot in plots}, {25})
        for plot in plots:
            self.assertAlmostEqual(plot["area_m2"], hull_area([(tree["x"], tree["y"]) for tree in trees
                                                               if str(tree["plot"]) == plot["plot"]]), delta=1e-6)
        # Styles that QGIS applies by itself, with a category for each species and one for others.
        self.assertEqual(set(styles), {"trees", "plots"})
        self.assertEqual({styles[name]["useAsDefault"] for name in styles}, {1})
        style = xml.fromstring(styles["trees"]["styleQML"])
        categories = [node.get("value") for node in style.iter("category")]
        self.assertEqual(sorted(categories), ["", "BI", "OF", "SM"])
        self.assertEqual(len(list(style.iter("symbol"))), 4)
        # GDAL's own program reads the layers and their system.
        seen = subprocess.run(["ogrinfo", "-ro", "-al", "-so", "out.gpkg"], cwd=self.folder, capture_output=True, text=True, check=True).stdout
        layers = {part.splitlines()[0].strip(): part for part in seen.split("Layer name: ")[1:]}
        for name, kind, count in (("trees", "Point", 100), ("plots", "Multi Polygon", 4)):
            self.assertIn(f"Geometry: {kind}\nFeature Count: {count}\n", layers[name])
            self.assertIn('ID["EPSG",32633]', layers[name])
        # The points are where the trees were.
        again, _ = self.indices("out.gpkg", "--layer", "trees")
        self.assert_same_units(again, expected)
        # Same input, same bytes.
        self.run_program("indices", "a.gpkg", "--buffer", "2", "--out", "again.gpkg")
        self.assertEqual((self.folder / "out.gpkg").read_bytes(), (self.folder / "again.gpkg").read_bytes())

    def test_coordinates_of_feet_are_written_in_feet(self):
        foot = 1200 / 3937
        lines = trees_csv().splitlines()
        self.write("feet.csv", "\n".join([lines[0], *(in_feet(line, foot) for line in lines[1:])]) + "\n")
        self.layer("feet.gpkg", source="feet.csv", system="EPSG:2264")
        self.run_program("indices", "feet.gpkg", "--out", "out.gpkg")
        extents = []
        for name in ("feet.gpkg", "out.gpkg"):
            with sqlite3.connect(self.folder / name) as database:
                extents.append(database.execute("select min_x, min_y, max_x, max_y from gpkg_contents where "
                                                "data_type = 'features' and table_name != 'plots'").fetchone())
        for left, right in zip(*extents):
            self.assertAlmostEqual(left, right, delta=1e-6)

    def test_predictions_and_imputed_values(self):
        self.write("library.json", json.dumps(self.run_json("fit", "trees.csv", "--model", "M4")))
        self.layer("a.gpkg")
        self.run_program("predict", "library.json", "a.gpkg", "--out", "out.fgb")
        self.run_program("predict", "library.json", "trees.csv", "--out", "csv.gpkg")
        predicted = self.run_program("predict", "library.json", "trees.csv").stdout
        rows = list(csv.DictReader(io.StringIO(predicted)))
        with sqlite3.connect(self.folder / "csv.gpkg") as database:
            written = database.execute("select plot, h_pred, geom is not null from trees order by fid").fetchall()
        self.assertEqual(written, [(row["plot"], float(row["h_pred"]), 1) for row in rows])
        layer_files.ogr2ogr("-f", "CSV", self.folder / "back.csv", self.folder / "out.fgb")
        with open(self.folder / "back.csv", encoding="utf-8", newline="") as file:
            back = list(csv.DictReader(file))
        self.assertEqual(sorted(float(row["h_pred"]) for row in back),
                         sorted(float(row["h_pred"]) for row in rows))
        self.run_program("impute", "trees.csv", "--response", "h", "--out", "filled.xlsx")
        self.assertTrue((self.folder / "filled.xlsx").stat().st_size > 1000)

    def test_failures_leave_the_file_as_it_was(self):
        self.write("out.gpkg", "kept")
        self.write("bad.csv", "plot,tree,dbh\n1,1,20\n")
        self.run_program("indices", "bad.csv", "--out", "out.gpkg", status=3)
        self.assertEqual((self.folder / "out.gpkg").read_text(encoding="utf-8"), "kept")
        self.layer("a.gpkg")
        said = self.run_program("indices", "a.gpkg", "--out", "a.gpkg", status=2).stderr
        self.assertIn("the input would be overwritten", said)
        self.assertEqual([path.name for path in self.folder.iterdir() if path.name.startswith(".")], [])

    @unittest.skipUnless(layer_files.has_openpyxl(), "openpyxl is missing")
    def test_tables_of_a_study_as_a_workbook(self):
        self.write("stand.csv", stand_csv())
        self.run_program("study", "stand.csv", "--out", "results", "--responses", "h", "--workbook", "tables.xlsx",
                         "--covariates", "C")
        sheets = layer_files.read_workbook(self.folder / "tables.xlsx")
        files = sorted(path.stem for path in (self.folder / "results").rglob("*.csv"))
        self.assertEqual(sorted(sheets), files)
        with open(self.folder / "results/predictions.csv", encoding="utf-8", newline="") as file:
            rows = list(csv.reader(file))
        self.assertEqual([str(cell) for cell in sheets["predictions"][0]], rows[0])
        self.assertEqual(len(sheets["predictions"]), len(rows))
        self.assertEqual(sheets["predictions"][1][0], "01")


class Terrain(LayerTest):
    """Trees on a terrain model: a plane with a step, as an ASCII grid and as a GeoTIFF."""

    def setUp(self):
        super().setUp()
        if not layer_files.has("gdal_translate"):
            self.skipTest("gdal_translate is missing")
        # Cells of 0.5 m, with centers from 99.75 m west of plot 1 on.
        west, south, columns, rows = EAST + 95, NORTH - 10, 60, 80
        lines = [f"ncols {columns}", f"nrows {rows}", f"xllcorner {west}", f"yllcorner {south}", "cellsize 0.5",
                 "NODATA_value -9999"]
        for row in reversed(range(rows)):
            lines.append(" ".join(f"{self.elevation(west + 0.5 * column + 0.25, south + 0.5 * row + 0.25):.6f}"
                                  for column in range(columns)))
        self.write("terrain.asc", "\n".join(lines) + "\n")

    @staticmethod
    def elevation(x, y):
        """Of a plane, on which bilinear values are exact."""
        return 400 + 0.2 * (x - EAST) - 0.1 * (y - NORTH)

    def translate(self, file, *options):
        subprocess.run(["gdal_translate", "-q", *options, str(self.folder / "terrain.asc"), str(self.folder / file)],
                       check=True, capture_output=True)
        return file

    def feet_of(self, *options):
        """Height above the plane at each tree of plot 1, and the number of points of the ground."""
        done = self.run_program("grow", "trees.csv", "--plot", "01", "--scene", "out.glb", "--plain", "--lod", "3", *options)
        gltf, _ = read_glb(self.folder / "out.glb")
        origin = gltf["scenes"][0]["extras"]["origin"] if "extras" in gltf["scenes"][0] else {"x": 0, "y": 0, "z": 0}
        feet = []
        for node in gltf["nodes"]:
            if node["name"] == "ground":
                attributes = gltf["meshes"][node["mesh"]]["primitives"][0]["attributes"]
                points = gltf["accessors"][attributes["POSITION"]]["count"]
                continue
            x, y, z = node["translation"]
            feet.append(y + origin["z"] - self.elevation(x + origin["x"], origin["y"] - z))
        return feet, points, done.stderr

    def test_trees_and_ground_follow_the_terrain(self):
        for file in ("terrain.asc", self.translate("terrain.tif", "-a_srs", "EPSG:32633")):
            feet, points, said = self.feet_of("--terrain", file)
            self.assertEqual(len(feet), 25)
            # Translations are written to a millimeter, and values of the raster have 24 bits.
            for foot in feet:
                self.assertAlmostEqual(foot, 0, delta=2e-3)
            # The box of the stems with 2 m around it, of at most 24 m, has cells of half a meter.
            self.assertGreater(points, 1000)
            self.assertIn(f"note: elevations are those of {file}; 75 trees are outside of it", said)
        _, without, _ = self.feet_of()
        self.assertLess(without, 40)
        self.run_program("view", "trees.csv", "--plot", "01", "--terrain", "terrain.asc", "--out", "view.html")
        page = (self.folder / "view.html").read_text(encoding="utf-8")
        data = json.loads(page.split('id="view-data">', 1)[1].split("</script>", 1)[0])
        # Of 20 x 20 m from 100 m east of the corner on: 418 to 424 m.
        self.assertTrue(all(418 <= z <= 424 for z in data["trees"]["z"]))

    def test_terrains_that_cannot_be_used_are_errors(self):
        def said(file, *options):
            return self.run_program("grow", "trees.csv", "--scene", "out.glb", "--terrain", file, *options, status=3).stderr
        self.assertIn("the terrain is in degrees; convert it", said(self.translate("d.tif", "-a_srs", "EPSG:4326")))
        self.assertIn("not a GeoTIFF or an ASCII grid", said("trees.csv"))
        self.assertIn("has 2 bands; a terrain has one", said(self.translate("b.tif", "-b", "1", "-b", "1")))
        feet = self.translate("feet.tif", "-a_srs", "EPSG:2264")
        self.assertIn("the coordinates of the terrain are not in meters", said(feet))
        lines = (self.folder / "terrain.asc").read_text(encoding="utf-8").splitlines()
        self.write("code.asc", "\n".join([*lines[:6], "-32768 " + lines[6].split(" ", 1)[1], *lines[7:]]) + "\n")
        self.assertIn("-32768 m is no elevation; if it means an unknown one, say so with gdal_translate -a_nodata -32768",
                      said("code.asc"))
        away = self.translate("away.tif", "-a_ullr", "0", "10", "10", "0")
        self.assertIn("no tree is on the terrain away.tif, whose x is 0.1 to 9.9", said(away))
        layer_files.ogr2ogr("-f", "GPKG", self.folder / "trees.gpkg", self.folder / "trees.csv", "-oo",
                            "X_POSSIBLE_NAMES=x", "-oo", "Y_POSSIBLE_NAMES=y", "-a_srs", "EPSG:32633")
        other = self.translate("other.tif", "-a_srs", "EPSG:32632")
        done = self.run_program("grow", "trees.gpkg", "--scene", "out.glb", "--terrain", other, status=3)
        self.assertIn("the coordinate reference system of the terrain is not EPSG:32633, that of the trees", done.stderr)
        done = self.run_program("grow", "trees.csv", "--out", "folder", "--terrain", "terrain.asc", status=2)
        self.assertIn("--terrain", done.stderr)


class Database(LayerTest):
    """A PostGIS server of its own, on the loopback address, as long as the tests take."""

    def setUp(self):
        super().setUp()
        bins = sorted(Path("/usr/lib/postgresql").glob("*/bin"))
        if not bins or not list(Path("/usr/share/postgresql").glob("*/extension/postgis.control")):
            self.skipTest("PostGIS is missing")
        self.bin = bins[-1]
        # The server refuses to run as root.
        self.user = ["runuser", "-u", "postgres", "--"] if os.geteuid() == 0 else []
        self.data = self.folder / "server"
        self.data.mkdir()
        os.chmod(self.folder, 0o755)
        if self.user:
            shutil.chown(self.data, "postgres")
        self.port = 40000 + os.getpid() % 20000
        self.server("initdb", "-D", self.data, "-A", "trust", "-U", "forester", "--no-sync")
        self.server("pg_ctl", "-D", self.data, "-w", "-l", self.data / "log", "-o",
                    f"-p {self.port} -c listen_addresses=127.0.0.1 -c unix_socket_directories= -c fsync=off", "start")
        self.addCleanup(self.server, "pg_ctl", "-D", self.data, "-m", "immediate", "stop")
        self.address = f"host=127.0.0.1 port={self.port} user=forester dbname=postgres"
        self.query("create extension postgis")
        layer_files.ogr2ogr("-f", "PostgreSQL", "PG:" + self.address, self.folder / "trees.csv", "-oo",
                            "X_POSSIBLE_NAMES=x", "-oo", "Y_POSSIBLE_NAMES=y", "-a_srs", "EPSG:32633", "-nln", "trees",
                            "-oo", "AUTODETECT_TYPE=YES", "-oo", "KEEP_GEOM_COLUMNS=NO")

    def server(self, program, *arguments):
        subprocess.run([*self.user, self.bin / program, *map(str, arguments)], check=True, capture_output=True,
                       cwd=self.data, timeout=120)

    def query(self, sql):
        done = subprocess.run([self.bin / "psql", "-Atc", sql, self.address], check=True, capture_output=True, text=True)
        return done.stdout.strip()

    def test_postgis(self):
        expected, _ = self.indices("trees.csv")
        plot = lambda row: {**row, "plot": f"{int(row['plot']):02d}"}
        units, _ = self.indices("PG:" + self.address)
        self.assert_same_units(map_list(plot, units), expected)
        query = "select plot, tree, species, dbh, h, hcb, cw, st_transform(wkb_geometry, 4326) as geom from trees order by ogc_fid"
        units, said = self.indices("PG:" + self.address, "--sql", query)
        self.assertIn("are projected to EPSG:32633", said)
        self.assert_same_units(map_list(plot, units), expected, 1e-5)
        # Queries cannot change the database.
        _, said = self.indices("PG:" + self.address, "--sql",
                               "with gone as (delete from trees returning *) select * from gone", status=3)
        self.assertIn("the query of --sql failed", said)
        self.assertEqual(self.query("select count(*) from trees"), "100")
        _, said = self.indices("PG:" + self.address, "--sql", "select dbhh from trees", status=3)
        self.assertIn('the query of --sql failed: column "dbhh" does not exist; available: ', said)
        # Passwords are not shown.
        _, said = self.indices(f"PG:{self.address} password=secret", "--layer", "forest", status=3)
        self.assertIn("password=...: unknown layer 'forest'", said)
        self.assertNotIn("secret", said)
        _, said = self.indices(f"PG:host=127.0.0.1 port={self.port} dbname=nothing user=forester", status=3)
        self.assertIn('the database cannot be opened: ', said)
        self.assertIn('database "nothing" does not exist', said)


if __name__ == "__main__":
    unittest.main()
