# SPDX-License-Identifier: MIT
"""What other programs rely on in `silvafit grow`; GLB files are measured with a reader of our own here."""

import json
import math
import struct
import unittest

from silvafit_program import ProgramTest

INVENTORY = """plot,tree,species,x,y,z,dbh,h,hcb,cw,cr_e,cr_w,cr_s,cr_n
01,1,SM,10,20,100,24,20.2,5.8,4.25,2.1,2.5,1.5,2.4
01,2,MH,14,23,101,18.5,12.4,3.1,5,,,,
02,1,XX,50,20,99,30.2,15,2.5,8,3,4,5,4
02,2,SM,52,20,99,,15,2.5,4,2,2,2,2
02,3,SM,55,20,99,20,15,15.5,4,2,2,2,2
"""


def read_glb(path):
    data = path.read_bytes()
    magic, version, size = struct.unpack_from("<4sII", data)
    assert (magic, version, size) == (b"glTF", 2, len(data))
    length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20 : 20 + length]), data[20 + length + 8 :]


def vertices_of(gltf, binary, mesh):
    """Vertices of a mesh by the part that the material's name ends with."""
    parts = {}
    for primitive in mesh["primitives"]:
        part = gltf["materials"][primitive["material"]]["name"].rsplit("-", 1)[1]
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
        self.assertEqual([n["name"] for n in gltf["nodes"]], ["01-1", "01-2", "02-1"])
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

    def test_wrong_usage_has_status_2(self):
        self.write("in.csv", INVENTORY)
        for arguments in (["in.csv"],
                          ["in.csv", "--out", "d", "--scene", "s.glb"],
                          ["in.csv", "--out", "d", "--format", "obj"],
                          ["in.csv", "--out", "d", "--use", "best"],
                          ["in.csv", "--out", "d", "--preset", "oak"],
                          ["in.csv", "--out", "d", "--columns", "h"]):
            self.run_program("grow", *arguments, status=2)
        self.run_program("grow", "in.csv", "--out", "d", "--plot", "7", status=3)
        self.run_program("grow", "missing.csv", "--out", "d", status=3)


if __name__ == "__main__":
    unittest.main()
