# SPDX-License-Identifier: MIT
"""`silvafit grow --builder lsystem`: shipped grammars, and those that users write."""

import unittest

from silvafit_program import ProgramTest

TREES = """plot,tree,species,dbh,h,hcb,cw
1,1,Acer platanoides,35,15,4,9
1,2,Abies alba,28,20,4,6
1,3,unheard of,20,12,3,5
"""

GRAMMAR = """# a user's own tree
#define ratio 0.8
iterations: 6
axiom: A(1)
A(l) -> F(l) [&(60) F(l*0.7) ~L(0.3)] /(137.5) A(l*ratio)
"""


class GrowGrammar(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("in.csv", TREES)

    def grow(self, *options):
        return self.run_json("grow", "in.csv", "--builder", "lsystem", "--out", "d", *options)

    def check_measured(self, trees):
        for tree, (dbh, h, hcb, cw) in zip(trees, [(35, 15, 4, 9), (28, 20, 4, 6), (20, 12, 3, 5)]):
            self.assertAlmostEqual(tree["dbh"], dbh, delta=0.1)
            self.assertAlmostEqual(tree["h"], h, delta=0.01)
            self.assertAlmostEqual(tree["hcb"], hcb, delta=0.01)
            self.assertAlmostEqual(tree["cw"], cw, delta=0.01)

    def test_species_choose_their_grammar(self):
        trees = self.grow()["trees"]
        self.assertEqual([tree["preset"] for tree in trees], ["maple", "fir", "maple"])
        self.check_measured(trees)

    def test_presets_are_listed_and_can_be_chosen(self):
        builders = self.run_json("models", "--builders")["builders"]
        names = {b["builder"]: [preset["name"] for preset in b["presets"]] for b in builders}
        for name in names["lsystem"]:
            trees = self.grow("--preset", name)["trees"]
            self.assertEqual({tree["preset"] for tree in trees}, {name})
            self.check_measured(trees)
        self.assertLessEqual({"honda-7a", "honda-7b", "honda-7c", "honda-7d", "maple", "banyan",
                              "shrub", "fir"}, set(names["lsystem"]))

    def test_a_grammar_of_the_users_own(self):
        self.write("own.lsys", GRAMMAR)
        self.check_measured(self.grow("--grammar", "own.lsys")["trees"])
        # Plain trees have a triangle or more for each part that the grammar draws. With pictures the
        # number of shoots follows the leaf area of the preset.
        trees = self.grow("--grammar", "own.lsys", "--plain")["trees"]
        shipped = self.grow("--plain")["trees"]
        self.assertLess(trees[0]["triangles"], shipped[0]["triangles"] / 4)
        trees = self.grow("--grammar", "own.lsys", "--preset", "fir")["trees"]
        self.assertEqual({tree["preset"] for tree in trees}, {"fir"})

    def test_mistakes_in_a_grammar_have_line_and_column(self):
        self.write("bad.lsys", GRAMMAR.replace("l*ratio", "l*ration").replace("F(l) [", "F(l) "))
        done = self.run_program("grow", "in.csv", "--builder", "lsystem", "--grammar", "bad.lsys",
                                "--out", "d", status=3)
        self.assertIn("bad.lsys:5: column 36: ']' without a matching '['", done.stderr)
        self.write("hostile.lsys", "iterations: 100\naxiom: F\nF -> F[+F]F\n")
        done = self.run_program("grow", "in.csv", "--builder", "lsystem", "--grammar",
                                "hostile.lsys", "--out", "d", status=3)
        self.assertIn("hostile.lsys:3: step ", done.stderr)
        self.assertIn("exceeds 2000000 modules", done.stderr)

    def test_a_grammar_is_drawn_as_it_is(self):
        # Height and figure 7d of the paper; dbh, hcb and cw are not needed.
        self.write("heights.csv", "plot,tree,h\n7,d,12\n")
        grown = self.run_json("grow", "heights.csv", "--builder", "lsystem", "--preset", "honda-7d",
                              "--unfitted", "--out", "d")
        self.assertTrue(grown["unfitted"])
        tree = grown["trees"][0]
        self.assertAlmostEqual(tree["h"], 12, delta=0.01)
        # The first branch leaves the stem after 1 of sum(0.55^k) parts of the height, at 80 degrees
        # from the vertical: no branch hangs below its base by more than its thickness.
        self.assertAlmostEqual(tree["hcb"], 12 * 0.45 / (1 - 0.55 ** 9), delta=0.4)
        self.grow("--grammar", self.own_grammar(), "--unfitted")
        for options in (["--builder", "segment"], ["--builder", "ifs", "--share"],
                        ["--builder", "ifs", "--resolve-overlaps"]):
            done = self.run_program("grow", "in.csv", "--unfitted", *options, "--scene", "a.glb",
                                    status=2)
            self.assertIn("--unfitted", done.stderr)

    def own_grammar(self):
        self.write("own.lsys", GRAMMAR)
        return "own.lsys"

    def test_a_grammar_needs_the_builder(self):
        self.write("own.lsys", GRAMMAR)
        done = self.run_program("grow", "in.csv", "--grammar", "own.lsys", "--out", "d", status=2)
        self.assertIn("--builder lsystem", done.stderr)
        self.run_program("grow", "in.csv", "--builder", "lsystem", "--grammar", "missing.lsys",
                         "--out", "d", status=3)


if __name__ == "__main__":
    unittest.main()
