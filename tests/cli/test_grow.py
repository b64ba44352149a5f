# SPDX-License-Identifier: MIT
"""What other programs rely on in `silvafit grow`; GLB files are measured with a reader of our own here."""

import json
import math
import struct
import unittest
from pathlib import Path

from silvafit_program import ProgramTest

PAPER = Path(__file__).resolve().parents[2] / "examples" / "segment-trees"

INVENTORY = """plot,tree,species,x,y,z,dbh,h,hcb,cw,cr_e,cr_w,cr_s,cr_n
01,1,SM,10,20,100,24,20.2,5.8,4.25,2.1,2.5,1.5,2.4
01,2,MH,14,23,101,18.5,12.4,3.1,5,,,,
02,1,XX,50,20,99,30.2,15,2.5,8,3,4,5,4
02,2,SM,52,20,99,,15,2.5,4,2,2,2,2
02,3,SM,55,20,99,20,15,15.5,4,2,2,2,2
"""


GROWTH = """year,plot,tree,species,x,y,dbh,h,hcb,cw
2021,1,1,SM,0,0,12,10,3,3
2021,1,2,MH,6,0,11,9,2,3
2022,1,1,SM,0,0,13,11,3,3
2022,1,2,MH,6,0,12,9.5,2,3
2022,1,2,MH,6,0,12,9.6,2,3
2023,1,1,SM,0,0,14,12,3,3.2
2023,1,3,SM,3,4,8,7,2,2
,1,4,SM,3,4,8,7,2,2
"""


def read_glb(path):
    data = path.read_bytes()
    magic, version, size = struct.unpack_from("<4sII", data)
    assert (magic, version, size) == (b"glTF", 2, len(data))
    length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20 : 20 + length]), data[20 + length + 8 :]


def vertices_of(gltf, binary, mesh):
    """Vertices of a mesh by part."""
    parts = {}
    for primitive in mesh["primitives"]:
        part = primitive["extras"]["part"]
        accessor = gltf["accessors"][primitive["attributes"]["POSITION"]]
        view = gltf["bufferViews"][accessor["bufferView"]]
        at = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        floats = struct.unpack_from(f"<{3 * accessor['count']}f", binary, at)
        parts[part] = list(zip(floats[0::3], floats[1::3], floats[2::3]))
    return parts


def section_area(corners):
    corners = sorted(corners, key=lambda corner: math.atan2(corner[1], corner[0]))
    following = corners[1:] + corners[:1]
    return abs(sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(corners, following))) / 2


def values_of(gltf, binary, number):
    """The numbers of an accessor that is not packed."""
    accessor = gltf["accessors"][number]
    view = gltf["bufferViews"][accessor["bufferView"]]
    at = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    each = {"SCALAR": 1, "VEC3": 3}[accessor["type"]]
    kind = {5126: "f", 5125: "I", 5123: "H"}[accessor["componentType"]]
    return struct.unpack_from(f"<{each * accessor['count']}{kind}", binary, at)


def stem_area(gltf, binary, mesh, height):
    """Area of the stem's section at a height: the triangles' cuts with the plane (Green)."""
    stem = next(p for p in mesh["primitives"] if p["extras"]["part"] == "stem")
    floats = values_of(gltf, binary, stem["attributes"]["POSITION"])
    corners = list(zip(floats[0::3], floats[1::3], floats[2::3]))
    indices = values_of(gltf, binary, stem["indices"])
    doubled = 0.0
    for triangle in zip(indices[0::3], indices[1::3], indices[2::3]):
        ends = {}
        for k in range(3):
            a, b = corners[triangle[k]], corners[triangle[(k + 1) % 3]]
            if (a[1] < height) != (b[1] < height):
                part = (height - a[1]) / (b[1] - a[1])
                ends[a[1] < height] = (a[0] + part * (b[0] - a[0]), a[2] + part * (b[2] - a[2]))
        if ends:
            doubled += ends[False][0] * ends[True][1] - ends[False][1] * ends[True][0]
    return abs(doubled) / 2


def parts_of_shared(gltf, binary, mesh):
    """Vertices by part of a shared model, whose wood is one primitive: connected pieces that touch the ground are its stem."""
    wood = next(p for p in mesh["primitives"] if p["extras"]["part"] == "stem")
    parts = vertices_of(gltf, binary, mesh)
    corners = parts["stem"]
    indices = values_of(gltf, binary, wood["indices"])
    above = list(range(len(corners)))

    def root(i):
        while above[i] != i:
            above[i] = above[above[i]]
            i = above[i]
        return i

    for a, b, c in zip(indices[0::3], indices[1::3], indices[2::3]):
        above[root(b)] = above[root(c)] = root(a)
    grounded = {root(i) for i, (_, y, _) in enumerate(corners) if y == 0}
    parts["stem"] = [corner for i, corner in enumerate(corners) if root(i) in grounded]
    parts["branches"] = [corner for i, corner in enumerate(corners) if root(i) not in grounded]
    return parts


class Grow(ProgramTest):
    def measure(self, mesh_parts):
        stem = mesh_parts["stem"]
        crown = mesh_parts["branches"] + mesh_parts["foliage"]
        ring = [(x, z) for x, y, z in stem if abs(y - 1.3) < 1e-6]
        return {
            "h": max(y for _, y, _ in stem + crown),
            "hcb": min(y for _, y, _ in crown),
            "dbh": 200 * math.sqrt(section_area(ring) / math.pi),
            "e": max(x for x, _, z in crown if abs(z) < 0.005 * abs(x)),
            "n": max(-z for x, _, z in crown if abs(x) < 0.005 * abs(z)),
        }

    def test_scene_has_the_measured_trees_at_their_places(self):
        self.write("in.csv", INVENTORY)
        result = self.run_json("grow", "in.csv", "--scene", "out.glb")
        self.assertEqual([(t["plot"], t["tree"]) for t in result["trees"]],
                         [("01", "1"), ("01", "2"), ("02", "1")])
        gltf, binary = read_glb(self.folder / "out.glb")
        self.assertEqual([n["name"] for n in gltf["nodes"]], ["01-1", "01-2", "02-1", "ground"])
        self.assertEqual(gltf["nodes"][1]["translation"], [14, 101, -23])
        wanted = [(20.2, 5.8, 24, 2.1, 2.4), (12.4, 3.1, 18.5, 2.5, 2.5), (15, 2.5, 30.2, 3, 4)]
        for node, tree, (h, hcb, dbh, east, north) in zip(gltf["nodes"], result["trees"], wanted):
            seen = self.measure(vertices_of(gltf, binary, gltf["meshes"][node["mesh"]]))
            for name, value, margin in (("h", h, 0.01), ("hcb", hcb, 0.01), ("dbh", dbh, 0.1)):
                self.assertAlmostEqual(seen[name], value, delta=margin)
                self.assertAlmostEqual(tree[name], value, delta=margin)
                self.assertAlmostEqual(node["extras"][name], value, delta=margin)
            for name, value in (("e", east), ("n", north)):
                self.assertAlmostEqual(seen[name], value, delta=0.01)
                self.assertAlmostEqual(tree["radii"][name], value, delta=0.01)

    def test_presets_follow_the_species_and_guesses_are_named(self):
        self.write("in.csv", INVENTORY)
        trees = self.run_json("grow", "in.csv", "--scene", "out.glb")["trees"]
        self.assertEqual([t["preset"] for t in trees],
                         ["cunninghamia-lanceolata", "schima-superba", "generic-broadleaf"])
        notes = [[note["about"] for note in tree["notes"]] for tree in trees]
        self.assertEqual(notes, [["hc"], ["hc", "radii"], ["hc", "preset"]])
        trees = self.run_json("grow", "in.csv", "--preset", "generic-conifer", "--out", "d")["trees"]
        self.assertEqual({t["preset"] for t in trees}, {"generic-conifer"})

    def test_rows_that_cannot_be_used_are_named(self):
        self.write("in.csv", INVENTORY)
        done = self.run_program("grow", "in.csv", "--scene", "out.glb")
        self.assertIn("in.csv:5: dbh: ", done.stderr)
        self.assertIn("in.csv:6: hcb: ", done.stderr)
        left_out = self.run_json("grow", "in.csv", "--scene", "out.glb")["left_out"]
        self.assertEqual([(r["line"], r["column"]) for r in left_out], [(5, "dbh"), (6, "hcb")])
        self.write("none.csv", "plot,tree,dbh,h,hcb,cw\n1,1,10,8,9,3\n")
        self.run_program("grow", "none.csv", "--out", "none", status=3)
        self.assertFalse((self.folder / "none").exists())

    def test_one_file_a_tree_with_names_that_stay_in_the_folder(self):
        self.write("in.csv", "plot,tree,dbh,h,hcb,cw\n1,../../x,10,8,2,3\n.,a b,12,9,2,3\n")
        result = self.run_json("grow", "in.csv", "--out", "trees")
        files = sorted(path.name for path in (self.folder / "trees").iterdir())
        self.assertEqual(files, ["%2E-a%20b.glb", "1-..%2F..%2Fx.glb"])
        for tree in result["trees"]:
            path = self.folder / tree["file"]
            self.assertEqual(path.stat().st_size, tree["bytes"])
            self.assertEqual(read_glb(path)[0]["nodes"][0].get("translation", [0, 0, 0]), [0, 0, 0])

    def test_no_file_takes_the_name_of_another(self):
        numbers = ("2", "2-lod1", "A", "a", "x" * 300, "x" * 299 + "y")
        rows = "".join(f"1,{number},10,8,2,3\n" for number in numbers)
        self.write("in.csv", "plot,tree,dbh,h,hcb,cw\n" + rows)
        result = self.run_json("grow", "in.csv", "--out", "trees", "--lod", "2,3")
        files = [Path(tree["file"]).name for tree in result["trees"]]
        self.assertEqual(len(files), 2 * len(numbers))
        # Also where file systems do not tell capitals from small letters.
        self.assertEqual(len({name.lower() for name in files}), len(files))
        self.assertEqual({path.name for path in (self.folder / "trees").iterdir()}, set(files))
        for tree in result["trees"]:
            self.assertEqual((self.folder / tree["file"]).stat().st_size, tree["bytes"])

    def test_threads_do_not_change_the_bytes_and_the_seed_does(self):
        self.write("in.csv", INVENTORY)
        def bytes_with(*options):
            self.run_program("grow", "in.csv", "--scene", "out.glb", *options)
            return (self.folder / "out.glb").read_bytes()
        first = bytes_with("--threads", "1")
        self.assertEqual(first, bytes_with("--threads", "4"))
        self.assertNotEqual(first, bytes_with("--seed", "2"))

    def test_predictions_and_other_column_names(self):
        self.write("in.csv", "plot,tree,D,h,h_population,hcb_population,cw_population\n"
                             "1,1,205,,14.5,6,3.5\n")
        result = self.run_json("grow", "in.csv", "--use", "population", "--columns", "dbh=D/10",
                               "--out", "trees")
        self.assertAlmostEqual(result["trees"][0]["h"], 14.5, delta=0.01)
        self.assertAlmostEqual(result["trees"][0]["dbh"], 20.5, delta=0.1)
        done = self.run_program("grow", "in.csv", "--use", "conditional", "--columns", "dbh=D/10",
                                "--out", "trees", status=3)
        self.assertIn("h_conditional", done.stderr)

    def test_columns_are_spelled_as_in_the_header(self):
        self.write("in.csv", "plot,tree,BHD [cm],H.m,crown base,cw\n01,1,20.5,15.5,n.v.,4\n"
                             "01,2,20.5,15.5,5,4\n")
        columns = "h=H.m,hcb=crown base,dbh="
        result = self.run_json("grow", "in.csv", "--columns", columns + "BHD [cm]", "--out", "d")
        self.assertAlmostEqual(result["trees"][0]["dbh"], 20.5, delta=0.1)
        self.assertEqual([(row["column"], row["tree"]) for row in result["left_out"]],
                         [("crown base", "1")])
        halved = self.run_json("grow", "in.csv", "--columns", columns + "`BHD [cm]`/min(2, 3)",
                               "--out", "d")
        self.assertAlmostEqual(halved["trees"][0]["dbh"], 10.25, delta=0.1)
        for wrong, said, status in (("BHD [cm]/2", "write `BHD [cm]`, in backquotes", 2),
                                    ("BHD [mm]", "unknown column", 2),
                                    ("BHD [cm],dbh=H.m", "'dbh' is given twice", 2),
                                    ("BHD", "unknown column 'BHD'", 3)):
            error = self.run_program("grow", "in.csv", "--columns", columns + wrong, "--out", "d",
                                     status=status).stderr
            self.assertIn(said, error)

    def test_usual_names_are_found_as_in_inventories(self):
        self.write("in.csv", "plot_id,tree_id,spp,x_m,y_m,dbh_cm,height,hcb_m,cw_m\n"
                             "07,1,SM,0,0,20,15,5,3\n")
        done = self.run_program("grow", "in.csv", "--scene", "s.glb", "--json")
        self.assertIn("note: plot is read from column plot_id, tree from tree_id, species from spp, x from x_m, y from y_m, "
                      "dbh from dbh_cm, h from height, hcb from hcb_m, cw from cw_m\n", done.stderr)
        tree, = json.loads(done.stdout)["trees"]
        self.assertEqual((tree["plot"], tree["species"], round(tree["h"], 2)), ("07", "SM", 15))
        self.assertEqual(self.run_program("grow", "in.csv", "--scene", "s.glb", "--quiet").stderr, "")
        self.write("two.csv", "plot,tree,dbh,hauteur,height,hcb,cw\n1,1,20,15,16,5,3\n")
        refused = self.run_program("grow", "two.csv", "--out", "d", status=2).stderr
        self.assertIn("'hauteur' and 'height' could both be h", refused)
        self.run_program("grow", "two.csv", "--columns", "h=height", "--out", "d")

    def test_names_of_our_own_go_before_usual_ones(self):
        self.write("in.csv", "plot,tree,dbh,height,h_population,hcb,hcb_population,cw,cw_population\n"
                             "1,1,20,18,14.5,5,6,3,3.5\n")
        grow = ("grow", "in.csv", "--out", "d", "--use")
        self.assertAlmostEqual(self.run_json(*grow, "population")["trees"][0]["h"], 14.5, delta=0.01)
        self.assertAlmostEqual(self.run_json(*grow, "observed")["trees"][0]["h"], 18, delta=0.01)

    def test_plots_that_lie_on_each_other_are_said(self):
        rows = [f"{plot},{i},SM,{10 * (i % 2)},{10 * (i // 2)},20,15,5,3"
                for plot in ("01", "02") for i in range(4)]
        self.write("in.csv", "plot,tree,species,x,y,dbh,h,hcb,cw\n" + "\n".join(rows) + "\n")
        grow = ("grow", "in.csv", "--lod", "3")
        self.assertIn("plots 01 and 02 cover each other", self.run_program(*grow, "--scene", "s.glb").stderr)
        for alone in (("--scene", "s.glb", "--plot", "02"), ("--out", "d"),
                      ("--scene", "s.glb", "--quiet")):
            self.assertNotIn("each other", self.run_program(*grow, *alone).stderr)

    def test_what_was_written_is_named(self):
        self.write("in.csv", GROWTH)
        grow = ("grow", "in.csv", "--by", "year", "--lod")
        done = self.run_program(*grow, "3", "--scene", "stand.glb")
        first, *files = done.stdout.splitlines()
        self.assertRegex(first, r"^3 trees at 3 times, [0-9.]+ s:$")
        self.assertEqual([line.split(" triangles")[0].rsplit(", ", 1)[0] for line in files],
                         [f"  stand-{year}.glb: 2 trees" for year in (2021, 2022, 2023)])
        for name in ("stand-2021.glb", "stand-2022.glb", "stand-2023.glb"):
            self.assertTrue((self.folder / name).exists())
        self.assertIn("3 trees have measurements that are missing", done.stderr)
        self.write("one.csv", GROWTH.splitlines()[0] + "\n" + GROWTH.splitlines()[1] + "\n")
        done = self.run_program("grow", "one.csv", "--lod", "2,3", "--scene", "s.glb")
        first, *files = done.stdout.splitlines()
        self.assertRegex(first, r"^1 tree, [0-9.]+ s:$")
        scenes = self.run_json("grow", "one.csv", "--lod", "2,3", "--scene", "s.glb")["scenes"]
        self.assertEqual(files, [f"  {scene['file']}: 1 tree, {scene['triangles']} triangles"
                                 for scene in scenes])
        self.assertEqual([scene["file"] for scene in scenes], ["s-lod2.glb", "s-lod3.glb"])
        self.assertIn("1 tree has measurements that are missing", done.stderr)
        folders = self.run_program("grow", "one.csv", "--lod", "0,3", "--out", "d").stdout.splitlines()
        self.assertEqual([line.split(": ")[0] for line in folders[1:]], ["  d", "  d (*-lod3.glb)"])
        self.assertEqual(len(list((self.folder / "d").glob("*-lod3.glb"))), 1)

    def test_quiet_does_not_name_rows_that_are_left_out(self):
        self.write("in.csv", INVENTORY)
        self.assertEqual(self.run_program("grow", "in.csv", "--out", "d", "--quiet").stderr, "")

    def test_what_is_missing_is_named(self):
        self.write("in.csv", "plot,tree,dbh,h,hcb,cw,h_population,hcb_population,cw_population\n"
                             "01,1,20,15,5,3,14,5,3\n01,2,20,15,5,3,,5,3\n")
        done = self.run_program("grow", "in.csv", "--use", "population", "--out", "d")
        self.assertIn("in.csv:3: h_population: is missing", done.stderr)
        done = self.run_program("grow", "in.csv", "--plot", "Z", "--out", "d", status=3)
        self.assertIn("in.csv: no trees in plot Z; the only plot is 01\n", done.stderr)
        done = self.run_program("grow", "in.csv", "--scene", "s.glb", "--out", "d", status=2)
        self.assertIn("use one of the two", done.stderr)

    def test_a_folder_with_the_name_of_a_model(self):
        self.write("in.csv", INVENTORY)
        for name in ("stand.glb", "stand.ply"):
            done = self.run_program("grow", "in.csv", "--out", name, status=2)
            self.assertIn(f"--scene {name}", done.stderr)
            self.assertFalse((self.folder / name).exists())

    def test_plots_whose_names_have_commas(self):
        text = "plot,tree,species,dbh,h,hcb,cw\n\"B, north\",1,SM,20,15,5,3\nC,2,SM,20,15,5,3\n\"D, \"\"old\"\"\",3,SM,20,15,5,3\n"
        self.write("commas.csv", text)
        grown = self.run_json("grow", "commas.csv", "--out", "d", "--plot", 'C,"B, north"')
        self.assertEqual(sorted(tree["plot"] for tree in grown["trees"]), ["B, north", "C"])
        grown = self.run_json("grow", "commas.csv", "--out", "e", "--plot", '"D, ""old"""')
        self.assertEqual([tree["plot"] for tree in grown["trees"]], ['D, "old"'])
        error = self.run_program("grow", "commas.csv", "--out", "f", "--plot", "B, north", status=3).stderr
        self.assertIn('no trees in plot B; available: "B, north", C, ', error)

    def test_impostors_are_small_and_have_the_measurements(self):
        self.write("in.csv", INVENTORY)
        result = self.run_json("grow", "in.csv", "--scene", "far.glb", "--lod", "4", "--ground", "none")
        gltf, binary = read_glb(self.folder / "far.glb")
        self.assertEqual(len(result["trees"]), len(gltf["meshes"]))
        for tree, mesh in zip(result["trees"], gltf["meshes"]):
            self.assertLess(tree["triangles"], 200)
            crown = vertices_of(gltf, binary, mesh)["foliage"]
            self.assertAlmostEqual(max(y for _, y, _ in crown), tree["h"], delta=0.01)
            self.assertAlmostEqual(min(y for _, y, _ in crown), tree["hcb"], delta=0.01)
            self.assertAlmostEqual(max(x for x, _, _ in crown), tree["radii"]["e"], delta=0.01)
            self.assertAlmostEqual(max(z for _, _, z in crown), tree["radii"]["s"], delta=0.01)
        # Pictures only, no bark; trees of similar crowns share them.
        self.assertLessEqual(len(gltf["images"]), len(result["trees"]))
        names = {material["name"].rsplit("-", 1)[1] for material in gltf["materials"]}
        self.assertEqual(names, {"bark", "leaf"})

        alone = self.run_json("grow", "in.csv", "--out", "alone", "--lod", "4")
        for one, other in zip(alone["trees"], result["trees"]):
            for key in ("h", "hcb", "dbh", "radii", "triangles"):
                self.assertEqual(one[key], other[key])

        shared = self.run_json("grow", "in.csv", "--scene", "s.glb", "--lod", "4", "--share", "--instancing", "--compress")
        self.assertLess(shared["shared"]["worst_error_cm"]["dbh"], 0.15)

    def test_wrong_usage_has_status_2(self):
        self.write("in.csv", INVENTORY)
        for arguments in (["in.csv"],
                          ["in.csv", "--out", "d", "--scene", "s.glb"],
                          ["in.csv", "--out", "d", "--format", "fbx"],
                          ["in.csv", "--scene", "s.xyz"],
                          ["in.csv", "--scene", "s.glb", "--format", "obj"],
                          ["in.csv", "--out", "d", "--lod", "9"],
                          ["in.csv", "--out", "d", "--lod", "4", "--plain"],
                          ["in.csv", "--scene", "s.ply", "--lod", "0,4"],
                          ["in.csv", "--scene", "s.glb", "--lod", "4", "--resolve-overlaps"],
                          ["in.csv", "--out", "d", "--lod", "4", "--unfitted", "--builder", "ifs"],
                          ["in.csv", "--out", "d", "--share"],
                          ["in.csv", "--scene", "s.glb", "--instancing"],
                          ["in.csv", "--scene", "s.obj", "--compress"],
                          ["in.csv", "--scene", "s.glb", "--share", "--resolve-overlaps"],
                          ["in.csv", "--scene", "s.glb", "--share", "--models", "0"],
                          ["in.csv", "--scene", "s.glb", "--models", "3"],
                          ["in.csv", "--scene", "s.glb", "--seconds", "3"],
                          ["in.csv", "--scene", "s.glb", "--ascii"],
                          ["in.csv", "--out", "d", "--ground", "flat"],
                          ["in.csv", "--out", "d", "--use", "best"],
                          ["in.csv", "--out", "d", "--preset", "oak"],
                          ["in.csv", "--out", "d", "--columns", "h"]):
            self.run_program("grow", *arguments, status=2)
        self.run_program("grow", "in.csv", "--out", "d", "--plot", "7", status=3)
        self.run_program("grow", "missing.csv", "--out", "d", status=3)

    def test_overlaps_are_resolved_in_scenes_and_single_files(self):
        stand = str(PAPER / "trees-10-and-13.csv")
        result = self.run_json("grow", stand, "--scene", "stand.glb", "--resolve-overlaps")
        pair, = result["overlaps"]
        self.assertEqual((pair["weaker"]["tree"], pair["stronger"]["tree"]), ("10", "13"))
        # The paper's figures; its radii are those of the compass, ours those of the line between.
        self.assertAlmostEqual(pair["distance"], 2.69, delta=0.005)
        self.assertAlmostEqual(pair["facing_radii"], 3.4, delta=0.005)
        self.assertAlmostEqual(pair["ct"], 0.940, delta=0.002)
        self.assertAlmostEqual(pair["removed"]["stronger"], pair["ct"] * pair["removed"]["weaker"], delta=1)
        gltf, binary = read_glb(self.folder / "stand.glb")
        wanted = {"10": (19.1, 8, 24, 1.6, 1.4), "13": (21, 5.2, 25, 1.4, 1.7)}
        for tree, node in zip(result["trees"], gltf["nodes"]):
            self.assertTrue(0 < tree["removed_share"] < 0.5)
            self.assertAlmostEqual(node["extras"]["removed_share"], tree["removed_share"])
            h, hcb, dbh, east, north = wanted[tree["tree"]]
            seen = self.measure(vertices_of(gltf, binary, gltf["meshes"][node["mesh"]]))
            for name, value, margin in (("h", h, 0.01), ("hcb", hcb, 0.01), ("dbh", dbh, 0.1),
                                        ("e", east, 0.01), ("n", north, 0.01)):
                self.assertAlmostEqual(seen[name], value, delta=margin)
        single = self.run_json("grow", stand, "--out", "trees", "--resolve-overlaps")
        self.assertEqual([t["removed_share"] for t in single["trees"]],
                         [t["removed_share"] for t in result["trees"]])
        whole = self.run_json("grow", stand, "--out", "whole")
        self.assertNotIn("removed_share", whole["trees"][0])

    def test_overlaps_depend_neither_on_order_nor_on_threads(self):
        lines = (PAPER / "trees-10-and-13.csv").read_text().splitlines()
        self.write("forwards.csv", "\n".join(lines) + "\n")
        self.write("backwards.csv", "\n".join([lines[0]] + lines[:0:-1]) + "\n")
        self.run_program("grow", "forwards.csv", "--out", "a", "--resolve-overlaps", "--threads", "1")
        self.run_program("grow", "backwards.csv", "--out", "b", "--resolve-overlaps", "--threads", "4")
        for name in ("paper-10.glb", "paper-13.glb"):
            self.assertEqual((self.folder / "a" / name).read_bytes(),
                             (self.folder / "b" / name).read_bytes())

    def test_formats_follow_the_ending_or_the_option(self):
        self.write("in.csv", INVENTORY)
        for ending, begins in (("gltf", b"{"), ("obj", b"# silvafit"), ("ply", b"ply\nformat binary")):
            result = self.run_json("grow", "in.csv", "--scene", f"s.{ending}")
            self.assertEqual((self.folder / f"s.{ending}").read_bytes()[: len(begins)], begins)
            self.assertGreaterEqual(result["scenes"][0]["bytes"],
                                    (self.folder / f"s.{ending}").stat().st_size)
        self.assertTrue((self.folder / "s.bin").exists() and (self.folder / "s.mtl").exists())
        self.run_program("grow", "in.csv", "--scene", "t.ply", "--ascii")
        self.assertIn(b"format ascii", (self.folder / "t.ply").read_bytes()[:40])
        self.run_program("grow", "in.csv", "--out", "d", "--format", "obj")
        self.assertEqual(len(list((self.folder / "d").glob("*.obj"))), 3)
        leftovers = [p.name for p in self.folder.rglob("*") if p.suffix in (".part", ".spool")]
        self.assertEqual(leftovers, [])

    def test_ground_runs_through_the_feet_or_is_flat_or_missing(self):
        self.write("in.csv", INVENTORY)
        def ground_heights(option):
            self.run_program("grow", "in.csv", "--scene", "g.glb", "--ground", option)
            gltf, binary = read_glb(self.folder / "g.glb")
            found = [n for n in gltf["nodes"] if n["name"] == "ground"]
            if not found:
                return None
            vertices = vertices_of(gltf, binary, gltf["meshes"][found[0]["mesh"]])["ground"]
            return {(round(x), round(-z)): y for x, y, z in vertices}
        heights = ground_heights("stems")
        self.assertEqual([heights[p] for p in ((10, 20), (14, 23), (50, 20))], [100, 101, 99])
        self.assertEqual(set(ground_heights("flat").values()), {99})
        self.assertIsNone(ground_heights("none"))

    def test_levels_of_detail_are_files_of_their_own(self):
        self.write("in.csv", INVENTORY)
        result = self.run_json("grow", "in.csv", "--scene", "s.glb", "--lod", "0,2")
        self.assertEqual([Path(f["file"]).name for f in result["scenes"]], ["s.glb", "s-lod2.glb"])
        fine = [t for t in result["trees"] if t["level"] == 0]
        coarse = [t for t in result["trees"] if t["level"] == 2]
        for one, other in zip(fine, coarse):
            self.assertEqual(one["surface_error_cm"], 0)
            self.assertGreater(other["surface_error_cm"], 0)
            self.assertLess(other["triangles"], one["triangles"])
            for name in ("h", "hcb", "dbh", "cw"):
                self.assertAlmostEqual(one[name], other[name], delta=0.1 if name == "dbh" else 0.01)

    def test_shared_models_keep_height_and_width_and_say_what_is_off(self):
        rows = [f"1,{i},SM,{3 * (i % 20)},{3 * (i // 20)},0,{10 + i % 17},{8 + i % 11},{2 + i % 4},"
                f"{2 + 0.1 * (i % 23)}" for i in range(400)]
        self.write("in.csv", "plot,tree,species,x,y,z,dbh,h,hcb,cw\n" + "\n".join(rows) + "\n")
        result = self.run_json("grow", "in.csv", "--scene", "s.glb", "--share", "--models", "10", "--plain")
        self.assertEqual(result["shared"]["models"], 10)
        gltf, binary = read_glb(self.folder / "s.glb")
        self.assertEqual(len(gltf["meshes"]), 11)
        trees = [n for n in gltf["nodes"] if n["name"] != "ground"]
        self.assertEqual(len(trees), 400)
        for i in range(0, 400, 37):
            mesh = gltf["meshes"][trees[i]["mesh"]]
            # One draw for the wood and one for the foliage.
            self.assertEqual([p["extras"]["part"] for p in mesh["primitives"]], ["stem", "foliage"])
            seen = self.measure(parts_of_shared(gltf, binary, mesh))
            stretch = trees[i].get("scale", [1, 1, 1])
            self.assertAlmostEqual(seen["h"] * stretch[1], 8 + i % 11, delta=0.02)
            off = abs(seen["hcb"] * stretch[1] - (2 + i % 4)) * 100
            # Models are right to 1 cm, and stretched by up to twice.
            self.assertAlmostEqual(off, result["trees"][i]["error_cm"]["hcb"], delta=2.5)
        packed = self.run_json("grow", "in.csv", "--scene", "p.glb", "--share", "--models", "10",
                               "--instancing", "--compress", "--plain")
        self.assertLess(packed["scenes"][0]["bytes"], result["scenes"][0]["bytes"] / 3)
        self.assertEqual(sorted(read_glb(self.folder / "p.glb")[0]["extensionsRequired"]),
                         ["EXT_mesh_gpu_instancing", "EXT_meshopt_compression", "KHR_mesh_quantization"])

    def test_the_error_of_shared_stems_is_that_of_the_written_mesh(self):
        rows = [f"1,{i},SM,{3 * (i % 10)},{3 * (i // 10)},0,{10 + 3 * (i % 17)},{8 + 2 * (i % 11)},"
                f"{2 + i % 4},{2 + 0.1 * (i % 23)}" for i in range(100)]
        self.write("in.csv", "plot,tree,species,x,y,z,dbh,h,hcb,cw\n" + "\n".join(rows) + "\n")
        result = self.run_json("grow", "in.csv", "--scene", "s.glb", "--share", "--models", "6",
                               "--lod", "3")
        gltf, binary = read_glb(self.folder / "s.glb")
        worst = 0.0
        for i, tree in enumerate(result["trees"]):
            node = gltf["nodes"][i]
            east, up, south = node.get("scale", [1, 1, 1])
            area = east * south * stem_area(gltf, binary, gltf["meshes"][node["mesh"]], 1.3 / up)
            off = abs(200 * math.sqrt(area / math.pi) - (10 + 3 * (i % 17)))
            # Scales and coordinates in the file are floats.
            self.assertAlmostEqual(tree["error_cm"]["dbh"], off, delta=0.001)
            worst = max(worst, off)
        self.assertGreater(worst, 1)
        self.assertAlmostEqual(result["shared"]["worst_error_cm"]["dbh"], worst, delta=0.001)

    def test_animations_that_files_cannot_hold_are_refused(self):
        animate = ("--by", "year", "--animate", "--scene", "a.glb")
        self.write("in.csv", GROWTH)
        done = self.run_program("grow", "in.csv", *animate, "--seconds", "1e39", status=2)
        self.assertIn("fewer --seconds", done.stderr)
        for first, second, third in (("0", "1e39", "2e39"), ("0", "1000000000", "1000000001"),
                                     # Unix seconds, a year apart
                                     ("1609459200", "1640995200", "1672531200")):
            table = GROWTH
            for year, time in (("2021", first), ("2022", second), ("2023", third)):
                table = table.replace(year + ",", time + ",")
            self.write("far.csv", table)
            self.run_program("grow", "far.csv", *animate, status=2)
            self.assertFalse((self.folder / "a.glb").exists())

    def test_crown_measurements_that_are_not_used_are_said(self):
        self.write("in.csv", "plot,tree,dbh,h,hcb,cw,cr_e,cr_w,cr_s,cr_n\n"
                             "1,1,10,8,2,,2,2,2,\n1,2,10,8,2,4,1,,,\n1,3,10,8,2,10,1,1,1,1\n"
                             "1,4,10,8,2,2.1,1,1,1,1\n")
        result = self.run_json("grow", "in.csv", "--out", "d")
        # The first tree has neither four radii nor a width, which is assumed.
        self.assertEqual(result["left_out"], [])
        notes = [{note["about"]: note["text"] for note in tree["notes"]} for tree in result["trees"]]
        self.assertIn("not all four", notes[1]["radii"])
        self.assertIn("10 m not used: the four crown radii give 2 m", notes[2]["cw"])
        self.assertNotIn("cw", notes[3])

    def test_a_diameter_is_enough(self):
        self.write("in.csv", "Baum-Nr,BHD\n1,20\n2,40\n3,\n")
        result = self.run_json("grow", "in.csv", "--out", "d")
        first, second = result["trees"]
        # 1.3 + (20/5.3)^2 and 1.3 + (40/9.1)^2
        self.assertAlmostEqual(first["h"], 15.540, places=3)
        self.assertAlmostEqual(second["h"], 20.6213, places=3)
        self.assertAlmostEqual(second["hcb"], 10.3107, places=3)
        self.assertAlmostEqual(second["cw"], 7.0, places=9)
        self.assertEqual((first["plot"], first["tree"]), ("1", "1"))
        self.assertEqual(len(result["left_out"]), 1)
        said = self.run_program("grow", "in.csv", "--out", "d").stderr
        self.assertIn("not measured, and assumed for the picture: h of 2 trees: 1.3 + dbh^2/(0.19*dbh + 1.5)^2", said)
        self.write("some.csv", "plot,tree,dbh,h\n1,1,20,18\n1,2,40,\n")
        heights = [tree["h"] for tree in self.run_json("grow", "some.csv", "--out", "e")["trees"]]
        self.assertEqual(heights[0], 18)
        self.assertAlmostEqual(heights[1], 20.6213, places=3)
        # What was measured of a tree is not contradicted, and each tree says what was not.
        self.write("part.csv", "plot,tree,x,y,dbh,h,hcb,cr_e,cr_w,cr_s\n1,1,0,0,20,,16,4,3,5\n1,2,9,0,20,15,5,,,\n")
        odd, plain = self.run_json("grow", "part.csv", "--scene", "p.GLB")["trees"]
        for name, value in (("h", 32), ("hcb", 16), ("cw", 8)):
            self.assertAlmostEqual(odd[name], value, delta=0.01)
        for tree, sizes in ((odd, "h, cw"), (plain, "cw")):
            self.assertIn({"about": "sizes", "text": f"{sizes} not measured: assumed for the picture"}, tree["notes"])

    def test_a_text_in_a_measure_concerns_its_tree_only(self):
        head = "plot,tree,species,x,y,dbh,h,hcb,cw,cr_e,cr_w\n1,1,Fagus,0,0,20,,5,,1,2\n"
        rows = {"dbh": "1,2,Fagus,9,0,dead,18,5,4,,\n", "h": "1,2,Fagus,9,0,20,18 m,5,4,,\n", "cr_e": "1,2,Fagus,9,0,20,18,5,4,n.m.,\n"}
        alone = self.sizes(head)
        # Twice the mean of the two radii, and the curve of docs/trees.md at 20 cm.
        self.assertAlmostEqual(alone["cw"], 3.0, delta=0.01)
        self.assertAlmostEqual(alone["h"], 1.3 + 400 / 5.3**2, delta=0.01)
        for column, row in rows.items():
            with self.subTest(column=column):
                self.assertEqual(self.sizes(head + row), alone)
                self.assertIn(f"{column}: ", self.notes)

    def sizes(self, text):
        """The drawn height and width of the only tree."""
        self.write("text.csv", text)
        result = self.run_program("grow", "text.csv", "--scene", "text.glb", "--json")
        self.notes = result.stderr
        (tree,) = json.loads(result.stdout)["trees"]
        return {name: tree[name] for name in ("h", "hcb", "cw")}

    def test_tables_of_national_inventories_are_drawn_by_their_own_codes(self):
        # The subplot of FIA is a part of the tree's label, and of its position: subplot 2 is 120 ft north.
        self.write("fia.csv", "CN,PLT_CN,INVYR,STATECD,UNITCD,COUNTYCD,PLOT,SUBP,TREE,AZIMUTH,DIST,STATUSCD,SPCD,DIA,HT,TPA_UNADJ\n"
                              "1,100,2015,23,1,1,5,1,1,90,10,1,12,8,50,6.018\n2,100,2015,23,1,1,5,2,1,90,10,1,316,9,55,6.018\n")
        trees = self.run_json("grow", "fia.csv", "--scene", "fia.glb")["trees"]
        self.assertEqual([tree["preset"] for tree in trees], ["abies", "acer"])
        gltf, _ = read_glb(self.folder / "fia.glb")
        places = [node["translation"] for node in gltf["nodes"] if node["name"] != "ground"]
        self.assertAlmostEqual(places[1][0] - places[0][0], 0, places=5)
        self.assertAlmostEqual(places[0][2] - places[1][2], 120 * 0.3048, places=5)
        # Code 100 of Germany's BWI is a beech, and no pine.
        self.write("bwi.csv", "Tnr;Enr;Bnr;Ba;Azi;Hori;Bhd;Hoehe\n1;1;1;100;100;500;300;220\n1;1;2;10;200;600;320;240\n")
        done = self.run_program("grow", "bwi.csv", "--scene", "bwi.glb", "--json")
        self.assertEqual({tree["preset"] for tree in json.loads(done.stdout)["trees"]}, {"generic-broadleaf"})
        self.assertIn('No preset lists the species "10", "100"', done.stderr)

    def test_azimuths_beyond_a_circle_are_asked_about(self):
        self.write("in.csv", "plot,tree,species,azimut,distance,dbh,h\n1,1,Picea abies,0,5,20,15\n"
                   "1,2,Picea abies,100,5,20,15\n1,3,Picea abies,390,5,20,15\n")
        done = self.run_program("grow", "in.csv", "--scene", "a.glb", status=3)
        self.assertIn("in.csv:4: azimut: the azimuth 390 is not from 0 to 360", done.stderr)
        self.assertIn("--columns azimuth=azimut*0.9", done.stderr)
        self.run_program("grow", "in.csv", "--scene", "a.glb", "--columns", "azimuth=azimut*0.9")
        gltf, _ = read_glb(self.folder / "a.glb")
        places = [node["translation"] for node in gltf["nodes"] if node["name"] != "ground"]
        # 390 gon are 351 degrees; y of glTF is up, and z south.
        angle = math.radians(351)
        for (x, _, z), (east, north) in zip(places, ((0, 5), (5, 0), (5 * math.sin(angle), 5 * math.cos(angle)))):
            self.assertAlmostEqual(x, east, delta=1e-4)
            self.assertAlmostEqual(-z, north, delta=1e-4)

    def test_predictions_are_drawn_where_they_are_asked_for(self):
        self.write("pred.csv", "plot,tree,x,y,dbh,h_pred,hcb_pred,cw_pred\n1,1,0,0,20,9.5,3,2\n")
        drawn = self.run_json("grow", "pred.csv", "--scene", "p.glb", "--use", "pred")["trees"][0]
        for name, value in (("h", 9.5), ("hcb", 3), ("cw", 2)):
            self.assertAlmostEqual(drawn[name], value, delta=0.01)
        said = self.run_program("grow", "pred.csv", "--scene", "p.glb").stderr
        self.assertIn("the predictions of h_pred and others are not drawn; use --use pred", said)

    def test_positions_that_are_no_meters_are_refused(self):
        rows = "".join(f"1,{i},{7.1 + i * 1e-5},{46.2 + (i % 5) * 1e-5},20,15,5,4\n" for i in range(30))
        self.write("in.csv", "plot,tree,x,y,dbh,h,hcb,cw\n" + rows)
        for command in (("grow", "in.csv", "--scene", "s.glb"), ("view", "in.csv", "--out", "v.html")):
            said = self.run_program(*command, status=3).stderr
            self.assertIn("they should be meters (and not in degrees or kilometers)", said)
        self.run_program("grow", "in.csv", "--scene", "s.glb", "--lod", "3", "--trust-units")

    def test_files_beside_a_scene_are_not_overwritten(self):
        self.write("in.csv", INVENTORY)
        for scene, manifest in (("s.gltf", "s.bin"), ("s.obj", "s.mtl")):
            said = self.run_program("grow", "in.csv", "--scene", scene, "--manifest", manifest, status=2).stderr
            self.assertIn("a file beside --scene", said)
        self.run_program("grow", "in.csv", "--scene", "s.glb", "--manifest", "s.xlsx", status=2)

    def test_dead_trees_are_snags_stumps_and_logs(self):
        self.write("in.csv", "plot,tree,x,y,dbh,h,hcb,cw,status,DECAYCD\n1,1,0,0,30,20,8,4,alive,\n1,2,5,0,28,14,6,4,dead,4\n"
                             "1,3,9,0,40,22,9,6,felled,\n1,4,0,9,33,19,9,5,windthrown,\n1,5,9,9,22,15,7,3,dead,7\n")
        living = self.run_json("grow", "in.csv", "--scene", "living.glb")
        self.assertEqual([tree["tree"] for tree in living["trees"]], ["1"])
        drawn = self.run_json("grow", "in.csv", "--scene", "all.glb", "--dead-wood", "--columns", "decay=DECAYCD")
        self.assertEqual([tree["tree"] for tree in drawn["trees"]], ["1", "2", "3", "4"])
        self.assertEqual([(row["tree"], row["column"]) for row in drawn["left_out"]], [("5", "DECAYCD")])
        gltf, binary = read_glb(self.folder / "all.glb")
        def highest(name):
            mesh = gltf["meshes"][next(node["mesh"] for node in gltf["nodes"] if node.get("name") == name)]
            parts = vertices_of(gltf, binary, mesh)
            return mesh, set(parts), max(y for corners in parts.values() for _, y, _ in corners)
        snag, parts, top = highest("1-2")
        self.assertEqual(parts, {"stem"})
        self.assertAlmostEqual(top, 14, delta=1e-5)
        self.assertAlmostEqual(200 * math.sqrt(stem_area(gltf, binary, snag, 1.3) / math.pi), 28, delta=0.001)
        self.assertAlmostEqual(highest("1-3")[2], 0.3, delta=1e-6)
        self.assertLess(highest("1-4")[2], 1.5)
        refused = self.run_program("grow", "in.csv", "--scene", "a.glb", "--dead-wood", "--share", status=2).stderr
        self.assertIn("--dead-wood draws wood without crowns", refused)
        # Each file says what is left of its trees, and contradictions are refused.
        notes = [note["text"] for tree in drawn["trees"] for note in tree["notes"] if note["about"] == "remains"]
        self.assertEqual(notes, ["drawn as a snag", "drawn as a stump", "drawn as a log"])
        refused = self.run_program("grow", "in.csv", "--scene", "a.glb", "--dead-wood", "--dead", "include", status=2).stderr
        self.assertIn("--dead-wood: has no effect with --dead include", refused)
        self.write("rem.csv", "plot,tree,x,y,dbh,h,hcb,cw,remains\n1,1,0,0,20,18,5,4,Stump\n1,2,5,0,20,18,5,4,hollow\n1,3,9,0,20,18,5,4,\n")
        own = self.run_json("grow", "rem.csv", "--scene", "a.glb", "--dead-wood")
        self.assertEqual([tree["tree"] for tree in own["trees"]], ["1", "3"])
        self.assertEqual(own["left_out"][0]["reason"], "'hollow' is not snag, stump, log or living")

    def test_the_ground_of_wide_scenes_stays_at_the_feet(self):
        rows = "".join(f"1,{i},{x},0,{z},10,8,2,3\n"
                       for i, (x, z) in enumerate(((0, 0), (5000, 100.13), (10000, 200.41))))
        self.write("in.csv", "plot,tree,x,y,z,dbh,h,hcb,cw\n" + rows)
        self.run_program("grow", "in.csv", "--scene", "s.glb", "--quantize")
        gltf, binary = read_glb(self.folder / "s.glb")
        node = next(node for node in gltf["nodes"] if node["name"] == "ground")
        ground = gltf["meshes"][node["mesh"]]["primitives"][0]["attributes"]["POSITION"]
        self.assertEqual(gltf["accessors"][ground]["componentType"], 5126)
        floats = values_of(gltf, binary, ground)
        up = node.get("scale", [1, 1, 1])[1]
        heights = [up * y + node.get("translation", [0, 0, 0])[1] for y in floats[1::3]]
        origin = gltf["scenes"][0].get("extras", {}).get("origin", {}).get("z", 0)
        for foot in (0, 100.13, 200.41):
            self.assertLess(min(abs(height + origin - foot) for height in heights), 0.001)

    def test_times_become_scenes_of_their_own(self):
        self.write("in.csv", GROWTH)
        result = self.run_json("grow", "in.csv", "--by", "year", "--scene", "stand.glb")
        self.assertEqual(result["by"], "year")
        self.assertEqual([Path(s["file"]).name for s in result["scenes"]],
                         ["stand-2021.glb", "stand-2022.glb", "stand-2023.glb"])
        self.assertEqual([(t["moment"], t["tree"], round(t["h"], 3)) for t in result["trees"]],
                         [("2021", "1", 10), ("2021", "2", 9), ("2022", "1", 11), ("2022", "2", 9.5),
                          ("2023", "1", 12), ("2023", "3", 7)])
        # The last row has no year; the fifth repeats a tree of its year.
        self.assertEqual([row["line"] for row in result["left_out"]], [9, 6])
        names = []
        grounds = set()
        for year in (2021, 2022, 2023):
            gltf, binary = read_glb(self.folder / f"stand-{year}.glb")
            names.append([node["name"] for node in gltf["nodes"]])
            ground = gltf["meshes"][gltf["nodes"][-1]["mesh"]]["primitives"][0]["attributes"]
            grounds.add(json.dumps(gltf["accessors"][ground["POSITION"]]["max"]))
        self.assertEqual(names, [["1-1", "1-2", "ground"]] * 2 + [["1-1", "1-3", "ground"]])
        # One ground under the trees of all years.
        self.assertEqual(len(grounds), 1)
        self.run_program("grow", "in.csv", "--by", "year", "--out", "alone")
        self.assertEqual(sorted(str(p.relative_to(self.folder / "alone"))
                                for p in (self.folder / "alone").glob("*/*")),
                         ["2021/1-1.glb", "2021/1-2.glb", "2022/1-1.glb", "2022/1-2.glb",
                          "2023/1-1.glb", "2023/1-3.glb"])

    def test_one_scene_shows_the_growth(self):
        self.write("in.csv", GROWTH)
        result = self.run_json("grow", "in.csv", "--by", "year", "--animate", "--seconds", "2",
                               "--scene", "growth.glb")
        self.assertEqual(len(result["trees"]), 6)
        self.assertEqual(len(result["scenes"]), 1)
        gltf, binary = read_glb(self.folder / "growth.glb")
        roots = [gltf["nodes"][i] for i in gltf["scenes"][0]["nodes"]]
        self.assertEqual([root["name"] for root in roots], ["1-1", "1-2", "1-3", "ground"])
        self.assertEqual([gltf["nodes"][i]["name"] for i in roots[0]["children"]],
                         ["1-1@2021", "1-1@2022", "1-1@2023"])
        self.assertAlmostEqual(roots[0]["extras"]["h"], 12, delta=0.01)
        inputs = {sampler["input"] for sampler in gltf["animations"][0]["samplers"]}
        self.assertEqual(gltf["animations"][0]["extras"]["times"],
                         [{"name": "2021", "time": 0.0}, {"name": "2022", "time": 2.0},
                          {"name": "2023", "time": 4.0}])
        # Three years of two seconds each.
        self.assertEqual({gltf["accessors"][i]["max"][0] for i in inputs} - {2, 4}, {6})

    def test_times_that_cannot_be_shown_are_refused(self):
        self.write("in.csv", GROWTH)
        for arguments in (("--animate", "--scene", "a.glb"),
                          ("--by", "year", "--animate", "--out", "a"),
                          ("--by", "year", "--animate", "--scene", "a.obj"),
                          ("--by", "year", "--animate", "--scene", "a.glb", "--lod", "0,1"),
                          ("--by", "year", "--share", "--scene", "a.glb")):
            self.run_program("grow", "in.csv", *arguments, status=2)
        done = self.run_program("grow", "in.csv", "--by", "month", "--scene", "a.glb", status=3)
        self.assertIn("in.csv:1: month", done.stderr)
        self.write("long.csv", GROWTH.replace("2021", "spring" + "x" * 300))
        done = self.run_program("grow", "long.csv", "--by", "year", "--scene", "a.glb", status=3)
        self.assertIn("too long for a file name", done.stderr)

    def test_bamboo_has_what_was_measured_of_its_culm(self):
        rows = "plot,tree,species,x,y,dbh,h,hcb,cw,bend_deg,bend_azimuth_deg,internodes\n"
        rows += "1,1,Phyllostachys edulis,0,0,10,14,8,2.6,1.5,90,50\n"
        rows += "1,2,Phyllostachys edulis,5,0,10,14,8,2.6,75,90,50\n"
        self.write("in.csv", rows)
        result = self.run_json("grow", "in.csv", "--builder", "bamboo", "--scene", "out.glb")
        self.assertEqual(len(result["trees"]), 1)
        self.assertIn("75 is outside", result["left_out"][0]["reason"])
        self.assertEqual(result["left_out"][0]["column"], "bend_deg")
        gltf, binary = read_glb(self.folder / "out.glb")
        seen = self.measure(vertices_of(gltf, binary, gltf["meshes"][0]))
        self.assertAlmostEqual(seen["h"], 14, delta=0.01)
        self.assertAlmostEqual(seen["hcb"], 8, delta=0.01)
        self.assertAlmostEqual(seen["dbh"], 10, delta=0.1)
        self.assertAlmostEqual(seen["e"], 1.3, delta=0.01)
        # Bent to the east by half of 1.5 degrees over the 6 m of the crown.
        tip = max(vertices_of(gltf, binary, gltf["meshes"][0])["stem"], key=lambda corner: corner[1])
        self.assertAlmostEqual(tip[0], 6 * math.tan(math.radians(0.75)), delta=0.001)


if __name__ == "__main__":
    unittest.main()
