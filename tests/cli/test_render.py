# SPDX-License-Identifier: MIT
"""Pictures: what the program draws, of which size, and what it refuses."""

import json
import struct
import unittest

from silvafit_program import ProgramTest

TREES = "plot,tree,species,x,y,dbh,h,hcb,cw\n1,1,SM,0,0,25.9,18.5,7.5,4.2\n1,2,MH,5,3,18,13,4,4\n"


class Pictures(ProgramTest):
    def setUp(self):
        super().setUp()
        if "not in this build" in self.run_program("--help").stdout:
            self.skipTest("built without Embree or libpng")
        self.write("trees.csv", TREES)
        self.run_program("grow", "trees.csv", "--scene", "stand.glb", "--quiet")

    def render(self, *arguments, status=0):
        return self.run_program("render", *arguments, "--size", "60x40", "--samples", "2",
                                "--quiet", status=status)

    def size(self, name):
        header = (self.folder / name).read_bytes()[:24]
        self.assertEqual(header[:8], b"\x89PNG\r\n\x1a\n")
        return struct.unpack(">II", header[16:24])

    def write_triangle(self, name, scale):
        """A triangle that its node's matrix scales."""
        matrix = [scale[0], 0, 0, 0, 0, scale[1], 0, 0, 0, 0, scale[2], 0, 0, 0, 0, 1]
        text = json.dumps({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0, "matrix": matrix}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
            "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36}],
        }).encode()
        text += b" " * (-len(text) % 4)
        body = (struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", 36, b"BIN\0")
                + struct.pack("<9f", 0, 0, 0, 1, 1, 0, 0, 1, 1))
        (self.folder / name).write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body)

    def test_a_picture_has_the_size_and_the_same_bytes_for_any_number_of_threads(self):
        self.render("stand.glb", "--out", "one.png", "--threads", "1")
        self.render("stand.glb", "--out", "two.png", "--threads", "2")
        self.assertEqual(self.size("one.png"), (60, 40))
        self.assertEqual((self.folder / "one.png").read_bytes(),
                         (self.folder / "two.png").read_bytes())

    def test_several_models_make_a_contact_sheet(self):
        self.render("stand.glb", "stand.glb", "stand.glb", "--columns", "2", "--out", "sheet.png")
        self.assertEqual(self.size("sheet.png"), (2 * 60 + 4, 2 * 40 + 4))

    def test_a_transparent_picture_has_opacities(self):
        self.render("stand.glb", "--transparent", "--out", "clear.png")
        self.render("stand.glb", "--out", "plain.png")
        kinds = [(self.folder / name).read_bytes()[25] for name in ("clear.png", "plain.png")]
        self.assertEqual(kinds, [6, 2])  # PNG's color types: with opacity, without
        self.render("stand.glb", "--transparent", "--eye", "1,-4", "--out", "clear.png", status=2)

    def test_a_walk_has_a_picture_for_each_place(self):
        self.write("walk.csv", "east,north,azimuth\n1,-4,0\n1,-4,20\n")
        self.render("stand.glb", "--path", "walk.csv", "--out", "walk.png")
        frames = [(self.folder / f"walk-00{i}.png").read_bytes() for i in range(2)]
        self.render("stand.glb", "--eye", "1,-4", "--look", "0", "--out", "eye.png")
        self.assertEqual((self.folder / "eye.png").read_bytes(), frames[0])
        self.render("stand.glb", "--eye", "1,-4,1.7", "--bare", "--out", "bare.png")
        self.assertNotIn((self.folder / "bare.png").read_bytes(), frames)
        outside = self.run_program("render", "stand.glb", "--eye", "500,0", "--out", "far.png",
                                   "--size", "9x9", "--samples", "1")
        self.assertIn("is outside of the scene, which reaches from", outside.stderr)
        self.write("bad.csv", "east,north\n1,2\n")
        self.write("typo.csv", "east,north,azimuth,elevtion\n1,2,3,4\n")
        for arguments, status, said in ((("--path", "bad.csv"), 3, "azimuth"),
                                        (("--bare",), 2, "--bare"),
                                        (("--eye", "nan,0"), 2, "the place of the eye must be three numbers"),
                                        (("--eye", "1e38,0"), 2, "the place of the eye must be three numbers"),
                                        (("--look", "20"), 2, "--look"),
                                        (("--path", "typo.csv"), 3, "elevtion: the frames of a walk have no such column"),
                                        (("--eye", "1,-4", "--zoom", "2"), 2, "--zoom"),
                                        (("--eye", "1,-4", "--camera", "10,10"), 2, "--camera"),
                                        (("--eye", "1,-4", "--no-ground"), 2, "--no-ground"),
                                        (("--eye", "1,-4,-3"), 2, "3 m below the ground"),
                                        (("--eye", "1,2", "--target", "1,2,3"), 2, "--target"),
                                        (("--eye", "1"), 2, "--eye")):
            done = self.render("stand.glb", "--out", "no.png", *arguments, status=status)
            self.assertIn(said, done.stderr)

    def test_a_turntable_numbers_its_pictures(self):
        self.render("stand.glb", "--turntable", "3", "--out", "turn.png")
        frames = [(self.folder / f"turn-00{i}.png").read_bytes() for i in range(3)]
        self.assertEqual(len(set(frames)), 3)

    def test_the_sun_of_a_moment_needs_a_place(self):
        error = self.render("stand.glb", "--out", "x.png", "--date", "2023-06-21T15:00+08:00",
                            status=2).stderr
        self.assertIn("--place", error)
        self.render("stand.glb", "--out", "x.png", "--date", "2023-06-21T15:00+08:00",
                    "--place", "27.5,114.6")

    def test_at_night_nothing_is_drawn(self):
        error = self.render("stand.glb", "--out", "x.png", "--date", "2023-06-21T01:00+08:00",
                            "--place", "26,117", status=2).stderr
        # 48 minutes (12 degrees) past the local midnight, the sun 23.44 degrees north of the equator:
        # sin(26) sin(23.44) - cos(26) cos(23.44) cos(12) = sin(-39.2).
        self.assertRegex(error, r"the sun is 39\.[0-4] degrees below the horizon")
        self.render("stand.glb", "--out", "x.png", "--sun", "100,-5", status=2)
        self.assertFalse((self.folder / "x.png").exists())
        self.render("stand.glb", "--out", "x.png", "--sun", "100,0.5")

    def test_options_that_do_nothing_are_refused(self):
        for arguments in (("--sun", "10,10", "--date", "2023-06-21T12:00+08:00", "--place", "26,117"),
                          ("--place", "26,117"),
                          ("--turntable", "0"),
                          ("--columns", "2")):
            self.render("stand.glb", "--out", "x.png", *arguments, status=2)

    def test_cameras_that_are_too_far_away_are_errors(self):
        for arguments in (("--target", "1e30,0,0"), ("--target", "0,0,-1e300"), ("--zoom", "1e-300")):
            self.assertIn("the camera, or its target", self.render("stand.glb", "--out", "x.png", *arguments, status=2).stderr)
        self.assertFalse((self.folder / "x.png").exists())

    def test_other_files_are_told_what_can_be_drawn(self):
        self.run_program("grow", "trees.csv", "--scene", "s.obj", "--quiet")
        for name in ("s.obj", "trees.csv"):
            self.assertIn(f"{name}: not a GLB or glTF scene",
                          self.render(name, "--out", "x.png", status=3).stderr)

    def test_what_cannot_be_drawn_is_refused(self):
        self.write("broken.glb", "glTF but not really")
        error = self.render("broken.glb", "--out", "x.png", status=3).stderr
        self.assertIn("broken.glb", error)
        for scale in ([0, 0, 0], [1, 0, 1]):
            self.write_triangle("flat.glb", scale)
            error = self.render("flat.glb", "--out", "x.png", status=3).stderr
            self.assertIn("flat.glb: ", error)
        self.run_program("render", "stand.glb", "--out", "x.png", "--size", "0x10", status=2)
        self.run_program("render", "stand.glb", "--out", "x.png", "--sun", "south", status=2)
        self.assertFalse((self.folder / "x.png").exists())
        error = self.render("stand.glb", "--out", "x.jpg", status=2).stderr
        self.assertIn(".png", error)
        self.assertFalse((self.folder / "x.jpg").exists())


if __name__ == "__main__":
    unittest.main()
