# SPDX-License-Identifier: MIT
"""The scorecard (bench/scorecard): its cases, its judgement of results, and one fit through its driver."""

import dataclasses
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(SOURCE / "bench" / "scorecard"))

import degenerate  # noqa: E402
import drawn  # noqa: E402
import fitting  # noqa: E402
import inventories  # noqa: E402
import scorecard  # noqa: E402
import summary  # noqa: E402

PROGRAM = os.environ["SILVAFIT_PROGRAM"]


class Scorecard(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="silvafit-scorecard-")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def cases(self, *families, seed=1):
        return {case.name: case for family in families for case in scorecard.FAMILIES[family](self.folder, seed)}

    def test_every_case_has_a_name_of_its_own_and_its_file(self):
        counts = {family: len(self.cases(family)) for family in scorecard.FAMILIES}
        every = self.cases(*scorecard.FAMILIES)
        self.assertEqual(len(every), sum(counts.values()))
        self.assertEqual((counts["spati"], counts["books"], counts["near-singular"]), (147, 51, 500))
        self.assertEqual([name for name, case in every.items() if not case.data.exists()], [])

    def test_nlme_converged_as_often_as_recorded(self):
        self.assertEqual(sum(case.nlme is not None for case in self.cases("spati").values()), 128)
        self.assertEqual(sum(case.nlme is not None for case in self.cases("books").values()), 48)

    def test_a_seed_draws_the_same_files_and_another_seed_others(self):
        def texts(seed):
            return [case.data.read_text() for name, case in self.cases("biexp", seed=seed).items() if "given" not in name]

        one = texts(1)
        self.assertEqual(texts(1), one)
        self.assertNotEqual(texts(2), one)

    def test_designs_of_inventories_have_the_wanted_number_of_trees(self):
        for kind in inventories.KINDS:
            design = inventories.design_of(kind, drawn.stream(1, kind, 1))
            area = sum((plot["x1"] - plot["x0"]) * (plot["y1"] - plot["y0"]) for plot in design["plots"]) / 1e4
            trees = area * sum(one["density"] for one in design["species"])
            self.assertAlmostEqual(trees / inventories.TREES, 1, delta=0.01)

    def test_a_fit_from_the_truth_reaches_nlme_and_is_not_listed(self):
        case = self.cases("biexp")["biexp-given-01"]
        result = fitting.fit(PROGRAM, case, "lb", 30, case.starts["the truth"])
        self.assertTrue(result.converged, result.verdict)
        # nlme's own tolerance leaves some hundredths.
        self.assertAlmostEqual(result.log_likelihood, case.nlme, delta=summary.TOLERANCE)
        score = summary.Score([result], {case.name: case}, {})
        self.assertEqual(summary.bad_cases(score), [])

    def test_fits_reach_maxima_that_few_starts_lead_to(self):
        best = summary.read_best()
        cases = self.cases("spati", "emax", "books")
        for name, method in (("Wafer-2", "lb"), ("hossfeldIV-3-0", "focei"), ("gomperz-3-1", "laplace"), ("korf-3-2", "focei"), ("emax-S3-09", "focei")):
            with self.subTest(case=name, method=method):
                result = fitting.fit(PROGRAM, cases[name], method, 60)
                self.assertTrue(result.converged, result.verdict)
                self.assertGreater(result.log_likelihood, best[name, method][0] - summary.TOLERANCE)

    def test_a_start_only_adds_to_what_is_tried(self):
        case = dataclasses.replace(self.cases("spati")["weibull-3-0"], variance="exponential")
        free = fitting.fit(PROGRAM, case, "focei", 60)
        for start in ("a=20,b=0.03,c=1", "a=15,b=0.001,c=2.5"):
            with self.subTest(start=start):
                result = fitting.fit(PROGRAM, case, "focei", 60, start)
                self.assertAlmostEqual(result.log_likelihood, free.log_likelihood, delta=summary.TOLERANCE)

    def test_a_fit_below_the_best_known_is_listed_only_if_it_is_called_converged(self):
        best = {("x", "laplace"): (-10.0, "start: the truth")}
        low = fitting.Result("fol", "x", "laplace", log_likelihood=-12.5, converged=True)
        self.assertEqual(summary.bad_cases(summary.Score([low], {}, best))[0][-1], "2.500")
        low.converged = False
        self.assertEqual(summary.bad_cases(summary.Score([low], {}, best)), [])

    def test_other_units_must_give_the_same_fit(self):
        base = fitting.Result("degenerate", "base", "lb", log_likelihood=-5.0, converged=True, estimates={"se(b)": 2.0})
        other = fitting.Result("degenerate", "mm", "lb", log_likelihood=-8.0, converged=True, estimates={"se(b)": 2.0})
        expected = degenerate.Expected(same_as="base", shift=-3.0, errors=(("b", "b"),))
        self.assertEqual(expected.judge(other, base), "sound")
        other.estimates["se(b)"] = 1e-6
        self.assertIn("standard error of b", expected.judge(other, base))

    def test_parts_join_to_the_whole_in_its_order(self):
        def run(*arguments):
            command = [sys.executable, str(SOURCE / "bench/scorecard/scorecard.py"), "--program", PROGRAM, "--family", "biexp",
                       "--only", "biexp-(given|half)-0[1-5] lb", *arguments]
            subprocess.run(command, check=True, capture_output=True, text=True)

        def names(path):
            return [one.case for one in fitting.read(path)]

        whole, parts, joined = self.folder / "whole.csv", [self.folder / f"{k}.csv" for k in (1, 2, 3)], self.folder / "joined.csv"
        run("--out", str(whole), "--folder", str(self.folder / "data"))
        for number, path in enumerate(parts, 1):
            run("--part", f"{number}/3", "--out", str(path), "--folder", str(self.folder / f"data-{number}"))
        run("--join", *map(str, parts), "--out", str(joined))
        self.assertGreater(len(names(whole)), 3)
        self.assertEqual(names(joined), names(whole))
        self.assertEqual(sum(len(names(path)) for path in parts), len(names(whole)))
        self.assertEqual([one.log_likelihood for one in fitting.read(joined)], [one.log_likelihood for one in fitting.read(whole)])

    def test_results_come_back_from_their_file(self):
        path = self.folder / "results.csv"
        one = fitting.Result("fol", "x", "lb", -1.5, True, "yes", 0.25, 0.5, {"a": 1.0, "sd(a)": 0.5}, "Converged, as \"they\" say")
        fitting.write(path, [one])
        self.assertEqual(fitting.read(path), [one])


if __name__ == "__main__":
    unittest.main()
