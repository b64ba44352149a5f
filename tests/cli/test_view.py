# SPDX-License-Identifier: MIT
"""3D pages: what is written where, what is said, what is refused, and when a browser is opened."""

import json
import os
import pty
import subprocess
import unittest
from pathlib import Path

from silvafit_program import PROGRAM, ProgramTest

TREES = ("plot,tree,species,x,y,dbh,h,hcb,cw\n"
         "1,1,SM,0,0,25.9,18.5,7.5,4.2\n1,2,MH,5,3,18,13,4,4\n2,1,SM,20,9,18,14,4,3\n")
HOSTILE = "</script><script>alert(1)</script>"


class ViewTest(ProgramTest):
    def setUp(self):
        super().setUp()
        if not (Path(PROGRAM).parent.parent / "share/silvafit/viewer/scene.html").exists():
            self.skipTest("built without the viewer")
        self.write("trees.csv", TREES)


class Pages(ViewTest):
    def view(self, *arguments, status=0):
        small = () if arguments[0].endswith(".glb") else ("--lod", "3", "--models", "1")
        return self.run_program("view", *arguments, *small, "--no-open", status=status)

    def data(self, name):
        page = (self.folder / name).read_text(encoding="utf-8")
        return json.loads(page.split('id="view-data">', 1)[1].split("</script>", 1)[0])

    def test_a_page_lies_beside_its_file_and_the_summary_says_what_is_in_it(self):
        summary = json.loads(self.view("trees.csv", "--json").stdout)
        self.assertEqual(summary["page"], "trees.html")
        self.assertEqual((summary["trees"], summary["variants"]), (3, ["observed"]))
        self.assertEqual(summary["bytes"], (self.folder / "trees.html").stat().st_size)
        data = self.data("trees.html")
        self.assertEqual(data["title"], "trees.csv")
        self.assertEqual(data["trees"]["h"], [18.5, 13.0, 14.0])

    def test_a_page_needs_nothing_but_itself(self):
        self.view("trees.csv", "--out", "page.html")
        page = (self.folder / "page.html").read_text(encoding="utf-8")
        for tag in ("<script src", "<link rel=\"stylesheet\"", "@import"):
            self.assertNotIn(tag, page)
        self.assertIn("default-src 'none'", page)

    def test_the_same_input_gives_the_same_bytes(self):
        self.view("trees.csv", "--out", "one.html", "--threads", "1")
        self.view("trees.csv", "--out", "two.html", "--threads", "2")
        self.assertEqual((self.folder / "one.html").read_bytes(),
                         (self.folder / "two.html").read_bytes())

    def test_plots_and_columns_are_chosen(self):
        self.view("trees.csv", "--plot", "2", "--out", "plot.html")
        self.assertEqual(self.data("plot.html")["trees"]["tree"], ["1"])
        self.write("other.csv", TREES.replace("h,hcb", "height,hcb"))
        self.view("other.csv", "--columns", "h=height", "--title", "Other", "--out", "other.html")
        self.assertEqual(self.data("other.html")["title"], "Other")

    def test_columns_are_spelled_as_in_the_header_or_usual(self):
        self.write("other.csv", TREES.replace("x,y,dbh,h,hcb", "x_m,y_m,BHD [cm],height,crown base"))
        done = self.view("other.csv", "--columns", "dbh=BHD [cm],hcb=crown base")
        self.assertIn("note: x is read from column x_m, y from y_m, h from height\n", done.stderr)
        trees = self.data("other.html")["trees"]
        self.assertEqual((trees["dbh"], trees["hcb"]), ([25.9, 18.0, 18.0], [7.5, 4.0, 4.0]))
        self.assertIn("given twice",
                      self.view("trees.csv", "--columns", "dbh=dbh,dbh=h", status=2).stderr)

    def test_trees_of_shared_models_are_counted(self):
        self.run_program("grow", "trees.csv", "--scene", "s.glb", "--share", "--lod", "3", "--quiet")
        self.assertIn("3 trees without measurements", self.view("s.glb").stdout)
        (self.folder / "scene").write_bytes((self.folder / "s.glb").read_bytes())
        self.assertIn("3 trees", self.run_program("view", "scene", "--no-open").stdout)

    def test_options_without_effect_on_a_scene_are_refused(self):
        self.run_program("grow", "trees.csv", "--scene", "s.glb", "--lod", "3", "--quiet")
        for option in (("--models", "2"), ("--lod", "3"), ("--plain",), ("--season", "winter"),
                       ("--seed", "2")):
            error = self.run_program("view", "s.glb", *option, "--no-open", status=2).stderr
            self.assertIn("shown unchanged", error)
        for option in (("--plot", "1"), ("--columns", "h=h"), ("--where", "dbh > 7"),
                       ("--dead", "include"), ("--trust-units",)):
            error = self.run_program("view", "s.glb", *option, "--no-open", status=2).stderr
            self.assertIn("without a table of its trees", error)
        self.run_program("view", "s.glb", "--trees", "trees.csv", "--where", "dbh > 20", "--no-open")

    def test_other_files_are_told_what_can_be_shown(self):
        self.run_program("grow", "trees.csv", "--scene", "s.obj", "--lod", "3", "--quiet")
        self.write("library.json", '{"schema": "x",\n"models": [1, 2]}\n')
        for name in ("s.obj", "library.json"):
            error = self.view(name, status=3).stderr
            self.assertIn("not a folder of `silvafit study`, a GLB scene or a CSV table", error)

    def test_names_cannot_end_the_script_that_holds_them(self):
        self.write("hostile.csv", TREES.replace("1,2,MH", f"1,{HOSTILE},<!--MH"))
        self.view("hostile.csv", "--title", HOSTILE)
        page = (self.folder / "hostile.html").read_text(encoding="utf-8")
        self.assertNotIn(HOSTILE, page)
        self.assertNotIn("<!--MH", page)
        data = self.data("hostile.html")
        self.assertEqual(data["trees"]["tree"][1], HOSTILE)
        self.assertEqual(data["title"], HOSTILE)

    def test_a_scene_keeps_the_measurements_beside_its_trees(self):
        self.run_program("grow", "trees.csv", "--scene", "stand.glb", "--lod", "3", "--quiet")
        self.view("stand.glb")
        data = self.data("stand.html")
        self.assertEqual(data["trees"]["tree"], ["1", "2", "1"])
        # Grown trees are measured on their mesh, to 1 cm.
        self.assertAlmostEqual(data["trees"]["h"][0], 18.5, delta=0.01)
        self.assertIsNone(data["models"])

    def test_trees_that_the_scene_does_not_show_are_not_listed(self):
        self.write("years.csv", "year,plot,tree,x,y,dbh,h,hcb,cw\n2021,1,1,0,0,10,8,2,3\n"
                                "2021,1,2,5,0,10,8,2,3\n2022,1,1,0,0,11,9,2,3\n")
        self.run_program("grow", "years.csv", "--by", "year", "--animate", "--scene", "years.glb")
        # The second is gone at the last time.
        self.view("years.glb")
        self.assertEqual(self.data("years.html")["trees"]["tree"], ["1"])

    def test_the_page_is_called_one(self):
        done = self.run_program("view", "trees.csv", "--no-open", "--out", "trees.glb", status=2)
        self.assertIn(".html", done.stderr)
        self.assertFalse((self.folder / "trees.glb").exists())

    def test_instances_get_measurements_from_their_table(self):
        self.run_program("grow", "trees.csv", "--scene", "stand.glb", "--share", "--instancing",
                         "--compress", "--quiet")
        done = self.view("stand.glb")
        self.assertIn("3 trees without measurements", done.stdout)
        self.assertIn("--trees FILE.csv", done.stderr)
        summary = json.loads(self.view("stand.glb", "--json").stdout)
        self.assertEqual((summary["trees"], summary["unmeasured"]), (0, 3))
        self.view("stand.glb", "--trees", "trees.csv")
        self.assertEqual(self.data("stand.html")["trees"]["number"], [0, 1, 2])

    def test_instances_get_the_measurements_of_the_trees_at_their_places(self):
        # Plot 2 alone is numbered from 0, as plot 1 is in the table.
        self.run_program("grow", "trees.csv", "--plot", "2", "--scene", "two.glb", "--share",
                         "--instancing", "--quiet")
        self.assertIn("2 of 3 trees of the table are not in the scene",
                      self.view("two.glb", "--trees", "trees.csv").stderr)
        trees = self.data("two.html")["trees"]
        self.assertEqual(trees["number"], [None, None, 0])
        refused = self.view("two.glb", "--trees", "trees.csv", "--plot", "1", status=3)
        self.assertIn("no tree of the table has the position", refused.stderr)

    def test_trees_that_places_do_not_tell_apart_get_no_measurements(self):
        # Each plot has coordinates of its own, and a tree at 0, 0.
        self.write("own.csv", "plot,tree,species,x,y,dbh,h,hcb,cw\n1,1,SM,0,0,20,15,6,4\n"
                              "1,2,SM,4,3,22,16,6,4\n2,1,SM,0,0,12,10,4,3\n2,2,SM,8,3,13,11,4,3\n")
        grow = ("grow", "own.csv", "--lod", "3", "--share", "--instancing", "--quiet", "--scene")
        self.run_program(*grow, "two.glb", "--plot", "2")
        said = self.view("two.glb", "--trees", "own.csv").stderr
        self.assertIn("1 of 2 trees of the scene is not in the table, or not unique", said)
        self.assertEqual(self.data("two.html")["trees"]["number"], [None, None, None, 1])
        self.run_program(*grow, "all.glb")
        self.view("all.glb", "--trees", "own.csv")
        self.assertEqual(self.data("all.html")["trees"]["number"], [0, 1, 2, 3])

    def test_a_damaged_scene_is_refused(self):
        self.run_program("grow", "trees.csv", "--scene", "stand.glb", "--lod", "3", "--quiet")
        whole = (self.folder / "stand.glb").read_bytes()
        (self.folder / "half.glb").write_bytes(whole[:len(whole) // 2])
        refused = self.view("half.glb", status=3)
        self.assertIn("half.glb", refused.stderr)
        self.assertFalse((self.folder / "half.html").exists())

    def test_what_cannot_be_shown_is_refused(self):
        self.write("bare.csv", "plot,tree,x,y,dbh\n1,1,0,0,9\n")
        self.assertIn("h, hcb and cw", self.view("bare.csv", status=3).stderr)
        self.write("no.glb", "glTF")
        self.assertIn("no.glb", self.view("no.glb", status=3).stderr)
        self.write("scene.gltf", "{}")
        self.assertIn("use a .glb file", self.view("scene.gltf", status=3).stderr)
        (self.folder / "empty").mkdir()
        self.assertIn("silvafit study", self.view("empty", status=3).stderr)
        self.assertIn("nothing.csv", self.view("nothing.csv", status=3).stderr)
        self.assertIn("nothing.glb", self.view("nothing.glb", status=3).stderr)
        self.write("nowhere.csv", "plot,tree,dbh,h,hcb,cw\n1,1,9,8,4,2\n")
        self.assertIn("needs the positions of the trees", self.view("nowhere.csv", status=3).stderr)
        self.view("trees.csv", "--columns", "h", status=2)
        self.view("trees.csv", "--trees", "trees.csv", status=2)
        self.view("no.glb", "--plot", "1", status=2)
        self.run_program("view", "trees.csv", "--lod", "4", "--no-open", status=2)
        self.run_program("view", "trees.csv", "--models", "0", "--no-open", status=2)

    def test_rows_that_cannot_be_trees_are_named(self):
        self.write("odd.csv", TREES + "2,9,SM,1,1,10,1.0,0.5,2\n")
        self.assertIn("tree 9", self.view("odd.csv").stderr)
        self.assertEqual(self.view("odd.csv", "--quiet").stderr, "")

    def test_trees_of_extreme_numbers_are_named_and_the_others_shown(self):
        columns = TREES.splitlines()[0].split(",")
        for name in columns[3:]:
            for value in ("1e300", "-1e300"):
                row = dict(zip(columns, TREES.splitlines()[1].split(",")), **{name: value})
                self.write("extreme.csv", TREES.replace(TREES.splitlines()[1], ",".join(row.values())))
                self.assertIn(f"extreme.csv:2: {name}: ", self.view("extreme.csv", "--trust-units").stderr)
                self.assertEqual(self.data("extreme.html")["trees"]["h"], [13.0, 14.0])


class Desktop(ViewTest):
    """A program xdg-open that notes what it is given."""

    def setUp(self):
        super().setUp()
        opener = self.folder / "xdg-open"
        opener.write_text('#!/bin/sh\necho "$1" > "$(dirname "$0")/opened"\n', encoding="utf-8")
        opener.chmod(0o755)

    def opened(self, *arguments, display, terminal):
        environment = {**os.environ, "PATH": f"{self.folder}:{os.environ['PATH']}"}
        for name in ("DISPLAY", "WAYLAND_DISPLAY"):
            environment.pop(name, None)
        if display:
            environment["WAYLAND_DISPLAY"] = "wayland-0"
        controller, screen = pty.openpty()
        subprocess.run([PROGRAM, "view", "trees.csv", "--lod", "3", "--models", "1", *arguments],
                       cwd=self.folder, env=environment, check=True, timeout=60,
                       stdout=screen if terminal else subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL)
        os.close(screen)
        os.close(controller)
        note = self.folder / "opened"
        found = note.read_text(encoding="utf-8").strip() if note.exists() else None
        note.unlink(missing_ok=True)
        return found

    def test_a_browser_opens_where_there_is_a_desktop_and_a_person(self):
        page = str(self.folder / "trees.html")
        self.assertEqual(self.opened(display=True, terminal=True), page)
        self.assertIsNone(self.opened(display=False, terminal=True))
        self.assertIsNone(self.opened(display=True, terminal=False))
        self.assertIsNone(self.opened("--no-open", display=True, terminal=True))
        self.assertIsNone(self.opened("--json", display=True, terminal=True))


if __name__ == "__main__":
    unittest.main()
