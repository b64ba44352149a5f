# SPDX-License-Identifier: MIT
"""What other programs rely on in `silvafit fit`."""

import csv
import io
import json
import math
import pathlib
import re
import unittest

from silvafit_program import ProgramTest, stand_csv

MEYER = "h ~ 1.3 + a*(1 - exp(-b*dbh))"
# y = 1 + 2x with errors -1, 1, 1, -1: slope and intercept stay, SSE = 4.
LINE = "x,y\n1,2\n2,6\n3,8\n4,8\n"


def kinds_csv():
    """Trees of three species in two zones, without random numbers, so that R can have the same."""
    rows = ["x,z,species,zone,y"]
    for i in range(24):
        x, z = 10 + 7 * i % 24, (0.5, 1, 2, 0.25)[i % 4]
        species, zone = ("fir", "oak", "elm")[i % 3], 1 + i // 3 % 2
        y = 3 + 0.5 * x + (2 - 0.1 * x if species == "oak" else 0) + (zone if species == "elm" else 0) + math.sin(7 * i * i)
        rows.append(f"{x},{z},{species},{zone},{y!r}")
    return "\n".join(rows) + "\n"


class SubModels(ProgramTest):
    """What the right side of --parameter means, beside lm() of R 4.2.2 on the same data:

    i <- 0:23
    d <- data.frame(x = 10 + (7*i) %% 24, z = c(0.5, 1, 2, 0.25)[i %% 4 + 1], species = c("fir", "oak", "elm")[i %% 3 + 1],
                    zone = 1 + (i %/% 3) %% 2)
    d$y <- 3 + 0.5*d$x + ifelse(d$species == "oak", 2 - 0.1*d$x, 0) + d$zone*(d$species == "elm") + sin(7*i*i)
    """

    def fit(self, right_side, *arguments, status=0):
        self.write("kinds.csv", kinds_csv())
        return self.run_json("fit", "kinds.csv", "--formula", "y ~ a", "--parameter", "a ~ " + right_side, *arguments,
                             status=status)

    def test_likelihoods_are_those_of_lm(self):
        # logLik(lm(y ~ right side, d)) and length(coef())
        for right_side, likelihood, coefficients in (
                ("species*x", -21.6892503578, 6),
                ("0 + species + x:species", -21.6892503578, 6),
                ("x + species:factor(zone) - 1", -21.3225790245, 7),
                ("(species + factor(zone) + x)^2", -20.4308120762, 10),
                ("log(x)*z", -32.3849264354, 4),
                ("x*z - z", -29.9633791732, 3),
        ):
            with self.subTest(right_side):
                fit = self.fit(right_side)
                # R printed ten decimals.
                self.assertAlmostEqual(fit["log_likelihood"], likelihood, 8)
                self.assertEqual(len(fit["fixed"]), coefficients)

    def test_contrasts_are_to_the_first_level(self):
        fixed = self.fit("species*x")["fixed"]
        # coef(lm(y ~ species*x, d))
        for name, value in (("a", 4.6076409629124), ('a:(species == "fir")', -1.7289067921835),
                            ('a:(species == "oak")', -0.6725591939605), ("a:x", 0.4958830196653),
                            ('a:(species == "fir"):x', 0.0225340319820), ('a:(species == "oak"):x', -0.0253469644087)):
            self.assertAlmostEqual(fixed[name]["estimate"], value, 9)

    def test_coefficients_of_products_and_levels_can_be_named(self):
        fit = self.fit("species*x", "--fix", 'a:(species == "fir"):x=0', "--start", 'a:(species == "oak")=1,a:x=0.5')
        self.assertEqual(fit["fixed"]['a:(species == "fir"):x']["estimate"], 0)
        self.assertIsNone(fit["fixed"]['a:(species == "fir"):x']["se"])

    def test_a_comma_in_a_level_is_no_end_of_a_value(self):
        self.write("kinds.csv", kinds_csv().replace("oak", '"oak, red"'))
        fit = self.run_json("fit", "kinds.csv", "--formula", "y ~ a", "--parameter", "a ~ species + min(x, 20)", "--fix",
                            'a:(species == "oak, red")=0.5,a:min(x, 20)=0.25')
        self.assertEqual(fit["fixed"]['a:(species == "oak, red")']["estimate"], 0.5)
        self.assertEqual(fit["fixed"]["a:min(x, 20)"]["estimate"], 0.25)

    def test_what_r_means_otherwise_is_refused(self):
        self.write("kinds.csv", kinds_csv())
        for right_side, message in (("x^2", "write I(x^2)"), ("x/10", "write I(x/10)"), ("x*2", "write I(x*2)"),
                                    ("x - 5", "I(x - 5)"), ("species:factor(zone)", "linearly dependent")):
            with self.subTest(right_side):
                done = self.run_program("fit", "kinds.csv", "--formula", "y ~ a", "--parameter", "a ~ " + right_side, status=2)
                self.assertIn(message, done.stderr)

    def test_codes_of_species_as_numbers_are_pointed_out(self):
        self.write("kinds.csv", kinds_csv().replace("zone", "spcd"))
        fit = ("fit", "kinds.csv", "--formula", "y ~ a", "--parameter")
        note = 'spcd is a number in "a ~ spcd + x", a slope over its codes; for a value of each species write factor(spcd)'
        self.assertIn(note, self.run_program(*fit, "a ~ spcd + x").stderr)
        self.assertNotIn("slope over its codes", self.run_program(*fit, "a ~ factor(spcd) + x").stderr)

    def test_codes_of_missing_species_are_no_level(self):
        self.write("dashes.csv", kinds_csv().replace(",oak,", ",-,"))
        self.write("others.csv", "\n".join(row for row in kinds_csv().splitlines() if ",oak," not in row) + "\n")
        model = ("--formula", "y ~ a", "--parameter", "a ~ species + x", "--json")
        done = self.run_program("fit", "dashes.csv", *model)
        self.assertEqual(json.loads(done.stdout)["fixed"], self.run_json("fit", "others.csv", *model)["fixed"])
        self.assertIn("8 rows have no species: the label is a code of a missing one", done.stderr)

    def test_heights_below_0_are_not_used(self):
        rows = stand_csv().splitlines()
        header = rows[0].split(",")
        h = header.index("h")
        wrong = [",".join([*row.split(",")[:h], "-1", *row.split(",")[h + 1:]]) if i % 6 == 0 else row
                 for i, row in enumerate(rows[1:])]
        self.write("wrong.csv", "\n".join([rows[0], *wrong]) + "\n")
        self.write("right.csv", "\n".join([rows[0], *(row for i, row in enumerate(rows[1:]) if i % 6)]) + "\n")
        model = ("--formula", "h ~ a + b*dbh", "--random", "a | plot", "--json")
        done = self.run_program("fit", "wrong.csv", *model)
        fit = json.loads(done.stdout)
        self.assertEqual(fit["fixed"], self.run_json("fit", "right.csv", *model)["fixed"])
        self.assertIn("-1 m is not above breast height, 1.3 m", done.stderr)
        self.write("fit.json", json.dumps(fit))
        done = self.run_program("predict", "fit.json", "wrong.csv", "--level", "calibrated", "--seen-groups", "new", status=3)
        self.assertIn("-1 m is not above breast height", done.stderr)

    def test_marginal_means_are_those_of_groups(self):
        self.write("kinds.csv", kinds_csv())
        fit = self.fit("species", "--means", "species")
        groups = {}
        for row in csv.DictReader(io.StringIO(kinds_csv())):
            if row["species"] and row["y"]:
                groups.setdefault(row["species"], []).append(float(row["y"]))
        means = {name: value["estimate"] for name, value in fit["derived"].items()}
        self.assertEqual(sorted(means), sorted(f"a (species {name})" for name in groups))
        for name, values in groups.items():
            self.assertAlmostEqual(means[f"a (species {name})"], sum(values) / len(values), 9)

    def test_a_slip_in_a_column_of_numbers_makes_no_factor(self):
        self.write("kinds.csv", kinds_csv().replace("\n12,", "\n12a,"))
        done = self.run_program("fit", "kinds.csv", "--formula", "y ~ a", "--parameter", "a ~ x", status=3)
        self.assertIn("x: '12a' is not a number", done.stderr)

    def test_a_level_that_the_fit_has_not_seen_has_no_prediction(self):
        fit = self.fit("species + factor(zone)")
        self.assertEqual(fit["factors"], ["species", "zone"])
        self.write("fit.json", json.dumps(fit))
        self.write("new.csv", "species,zone\noak,1\nash,1\noak,3\nelm,02\n")
        done = self.run_program("predict", "fit.json", "new.csv")
        rows = list(csv.DictReader(io.StringIO(done.stdout)))
        self.assertEqual([row["flag"] for row in rows], ["", "unknown species", "unknown zone", ""])
        self.assertEqual([row["y_pred"] == "" for row in rows], [False, True, True, False])


class RandomOnly(ProgramTest):
    def test_a_new_group_has_the_effect_of_its_measurements_around_the_fixed_value(self):
        orthodont = pathlib.Path(__file__).parents[1] / "reference/data-gpl/Orthodont.csv"
        fit = self.run_json("fit", orthodont, "--formula", "distance ~ a + u*age", "--random", "u | Subject", "--fix", "u=0.5")
        self.assertEqual(fit["fixed"]["u"]["estimate"], 0.5)
        self.assertIsNone(fit["fixed"]["u"]["se"])
        self.write("fit.json", json.dumps(fit))
        self.write("new.csv", "age,Subject,distance\n8,X,24\n10,X,25\n12,X,\n")
        done = self.run_program("predict", "fit.json", "new.csv", "--level", "calibrated")
        rows = list(csv.DictReader(io.StringIO(done.stdout)))
        # u = 0.5 + psi x'r / (sigma^2 + psi x'x), r the residuals of the mean a + 0.5 age
        a, psi = fit["fixed"]["a"]["estimate"], fit["random"][0]["covariance"][0][0]
        products = 8 * (24 - a - 4) + 10 * (25 - a - 5)
        u = 0.5 + psi * products / (fit["sigma"] ** 2 + psi * (8 ** 2 + 10 ** 2))
        self.assertAlmostEqual(float(rows[2]["distance_pred"]), a + 12 * u, 3)


class LeastSquares(ProgramTest):
    def test_a_coefficient_of_a_comparison_can_be_held(self):
        self.write("stand.csv", stand_csv())
        fit = self.run_json("fit", "stand.csv", "--formula", "h ~ a + b*dbh", "--parameter", 'a ~ 1 + (plot=="01")', "--fix",
                            'a:(plot=="01")=0.5')
        self.assertEqual(fit["fixed"]['a:(plot=="01")']["estimate"], 0.5)
        self.assertIsNone(fit["fixed"]['a:(plot=="01")']["se"])

    def test_a_line_has_the_textbook_numbers(self):
        self.write("line.csv", LINE)
        fit = self.run_json("fit", "line.csv", "--formula", "y ~ a + b*x")
        self.assertEqual(fit["schema"], "silvafit-fit/2")
        self.assertEqual((fit["method"], fit["n"], fit["excluded"]), ("ols", 4, 0))
        self.assertIs(fit["converged"], True)
        self.assertAlmostEqual(fit["fixed"]["a"]["estimate"], 1.0, 12)
        self.assertAlmostEqual(fit["fixed"]["b"]["estimate"], 2.0, 12)
        self.assertAlmostEqual(fit["sigma"], math.sqrt(4 / 2), 12)
        self.assertAlmostEqual(fit["fixed"]["b"]["se"], math.sqrt(2 / 5), 12)
        self.assertEqual(fit["fixed"]["b"]["df"], 2)
        t = 2 / math.sqrt(2 / 5)
        self.assertAlmostEqual(fit["fixed"]["b"]["t"], t, 12)
        self.assertAlmostEqual(fit["fixed"]["b"]["p"], 1 - t / math.sqrt(2 + t * t), 12)
        log_likelihood = -2 * (math.log(2 * math.pi * 4 / 4) + 1)
        self.assertAlmostEqual(fit["log_likelihood"], log_likelihood, 12)
        self.assertEqual(fit["k"], 3)
        self.assertAlmostEqual(fit["aic"], -2 * log_likelihood + 6, 12)
        self.assertAlmostEqual(fit["bic"], -2 * log_likelihood + 3 * math.log(4), 12)
        self.assertAlmostEqual(fit["statistics"]["population"]["r2"], 1 - 4 / 24, 12)
        self.assertAlmostEqual(fit["statistics"]["population"]["rmse"], math.sqrt(4 / 3), 12)
        self.assertAlmostEqual(fit["statistics"]["population"]["mae"], 1.0, 12)
        self.assertIsNone(fit["statistics"]["conditional"])
        self.assertEqual(fit["random"], [])
        self.assertEqual(fit["ranges"], {"x": [1, 4]})

    def test_rows_with_missing_values_are_counted(self):
        self.write("line.csv", LINE + "5,\n,7\n6,NA\n")
        fit = self.run_json("fit", "line.csv", "--formula", "y ~ a + b*x")
        self.assertEqual((fit["n"], fit["excluded"]), (4, 3))

    def test_conditions_and_columns_choose_the_data(self):
        self.write("line.csv", "X10,y,kind\n10,2,A\n20,6,A\n30,8,A\n40,8,A\n50,99,B\n")
        fit = self.run_json("fit", "line.csv", "--formula", "y ~ a + b*x",
                            "--columns", "x=X10/10", "--where", 'kind == "A"')
        self.assertEqual(fit["n"], 4)
        self.assertAlmostEqual(fit["fixed"]["b"]["estimate"], 2.0, 12)

    def test_start_values_do_not_change_the_answer(self):
        self.write("stand.csv", stand_csv())
        without = self.run_json("fit", "stand.csv", "--formula", MEYER)
        given = self.run_json("fit", "stand.csv", "--formula", MEYER, "--start", "a=20,b=0.1")
        for name in ("a", "b"):
            self.assertAlmostEqual(without["fixed"][name]["estimate"],
                                   given["fixed"][name]["estimate"], 9)


class MixedEffects(ProgramTest):
    def fit(self, *more):
        self.write("stand.csv", stand_csv())
        return self.run_json("fit", "stand.csv", "--formula", MEYER, "--parameter", "b ~ 1 + C",
                             "--random", "a | plot", *more)

    def test_the_object_has_what_the_contract_promises(self):
        fit = self.fit()
        self.assertEqual(fit["method"], "lb")
        self.assertEqual(fit["groups"], {"plot": 6})
        self.assertEqual(fit["parameters"], {"b": "1 + C"})
        self.assertEqual(list(fit["fixed"]), ["a", "b", "b:C"])
        self.assertEqual(fit["random"][0]["effects"], ["a"])
        self.assertEqual(list(fit["random"][0]["eblup"]), ["01", "02", "03", "04", "05", "06"])
        self.assertAlmostEqual(fit["random"][0]["sd"][0] ** 2, fit["random"][0]["covariance"][0][0], 12)
        self.assertEqual(fit["k"], 5)
        self.assertEqual(fit["fixed"]["a"]["df"], 120 - 6 - 2)
        for name, value in zip(fit["fixed"], (row for row in fit["fixed_covariance"])):
            position = list(fit["fixed"]).index(name)
            self.assertAlmostEqual(fit["fixed"][name]["se"] ** 2 / value[position], 1.0, 12)
        self.assertGreater(fit["statistics"]["conditional"]["r2"],
                           fit["statistics"]["population"]["r2"])
        self.assertLess(fit["evidence"]["gradient"], 1e-6)
        self.assertEqual(fit["evidence"]["rank"], 3)

    def test_variance_functions_are_named_with_what_they_are_of(self):
        variance = self.fit("--variance", "power(dbh)")["variance"]
        self.assertEqual((variance["function"], variance["of"]), ("power", "dbh"))
        self.assertIsNone(variance["constant"])

    def test_a_variance_function_alone_is_gnls(self):
        self.write("stand.csv", stand_csv())
        fit = self.run_json("fit", "stand.csv", "--formula", MEYER, "--variance", "power")
        self.assertEqual(fit["method"], "gnls")
        self.assertEqual(fit["random"], [])
        self.assertEqual(fit["k"], 4)

    def test_threads_do_not_change_a_byte(self):
        self.write("stand.csv", stand_csv())
        arguments = ("fit", "stand.csv", "--model", "all:h", "--random", "a | plot")
        one, two = (self.run_json(*arguments, "--threads", n) for n in ("1", "2"))
        for fits in (one, two):
            for fit in fits["fits"]:
                del fit["seconds"]
        self.assertEqual(one, two)

    def test_threads_within_a_fit_do_not_change_a_byte(self):
        # More rows and plots than a thread works on at a time.
        rows = [f"{tree % 1200},{5 + tree * 7 % 31},{tree % 60 % 7 + 12 * (1 - 0.94 ** (5 + tree * 7 % 31)) + tree * 13 % 17 / 10}"
                for tree in range(12000)]
        self.write("stand.csv", "plot,dbh,h\n" + "\n".join(rows))
        fits = [("--method", "ols"), ("--variance", "power")]
        fits += [("--random", "a | plot", "--method", method) for method in ("lb", "laplace", "focei", "agq")]
        fits.append(("--random", "a | plot", "--variance", "power"))
        for more in fits:
            with self.subTest(more):
                outputs = []
                for threads in ("1", "2", "3", "7"):
                    arguments = ("fit", "stand.csv", "--formula", MEYER, *more, "--json", "--threads", threads)
                    outputs.append(re.sub(r'"seconds": [^,\n]*', "", self.run_program(*arguments).stdout))
                self.assertIn('"estimate"', outputs[0])
                for output in outputs[1:]:
                    self.assertEqual(outputs[0], output)


    def test_labels_that_recur_in_other_groups_need_a_nested_grouping(self):
        """Three sites in the same four years: crossed, unless years within sites are meant."""
        rows = ["site,yr,x,y"]
        for site in range(3):
            for year in range(4):
                for i in range(5):
                    rows.append(f"P{site},{2000 + year},{i},{1 + 0.5 * i + site * 7 % 3 + year * 5 % 4 + (i * 3 % 5) / 10}")
        self.write("crossed.csv", "\n".join(rows) + "\n")
        call = ["fit", "crossed.csv", "--formula", "y ~ a + b*x", "--random"]
        error = self.run_program(*call, "a | site; a | yr", status=2).stderr
        self.assertIn("yr recurs in every site: for yr within site", error)
        self.assertIn("write `a | site/yr`", error)
        self.assertIn("`a | site + yr`", error)
        crossed = self.run_json(*call, "a | site + yr")
        self.assertEqual(crossed["groups"], {"site": 3, "yr": 4})
        nested = self.run_json(*call, "a | site/yr")
        self.assertEqual(nested["groups"], {"site": 3, "yr": 12})
        same = self.run_json(*call, "a | site; a | site/yr")
        self.assertEqual(same["log_likelihood"], nested["log_likelihood"])


class Catalogue(ProgramTest):
    def test_one_model_by_its_id(self):
        self.write("stand.csv", stand_csv())
        fit = self.run_json("fit", "stand.csv", "--model", "M4")
        self.assertEqual((fit["model"], fit["formula"]), ("M4", MEYER))

    def test_several_models_come_in_the_order_asked_for(self):
        self.write("stand.csv", stand_csv())
        result = self.run_json("fit", "stand.csv", "--model", "M8", "--model", "M4")
        self.assertEqual([fit["model"] for fit in result["fits"]], ["M8", "M4"])

    def test_the_table_ranks_by_aic(self):
        self.write("stand.csv", stand_csv())
        lines = self.run_program("fit", "stand.csv", "--model", "all:h").stdout.splitlines()
        table = lines[1:lines.index("")] if "" in lines else lines[1:]
        criteria = [float(line.split()[2]) for line in table]
        self.assertGreater(len(criteria), 3)
        self.assertEqual(criteria, sorted(criteria))

    def test_a_value_outside_the_domain_is_bad_input(self):
        self.write("stand.csv", stand_csv() + "06,999,SM,-3,12,0\n")
        error = self.run_program("fit", "stand.csv", "--model", "M4", status=3).stderr
        self.assertIn("stand.csv:122: dbh: -3 is outside the domain of the model 0 < dbh", error)
        self.assertIn("tree 999", error)


class Failures(ProgramTest):
    def test_a_failed_fit_is_an_object_and_status_4(self):
        self.write("two.csv", "x,y\n1,2\n2,5\n")
        fit = self.run_json("fit", "two.csv", "--formula", "y ~ a + b*x + c*x^2", status=4)
        self.assertIs(fit["converged"], False)
        self.assertIn("there are 2. Use a model", fit["verdict"])
        self.assertIsNone(fit["log_likelihood"])
        self.assertIsNone(fit["fixed"]["a"]["estimate"])

    def test_what_is_no_number_is_named_with_its_place(self):
        self.write("bad.csv", "plot,tree,x,y\n1,1,1,2\n1,2,two,4\n1,3,3,6\n")
        done = self.run_program("fit", "bad.csv", "--formula", "y ~ a*x", status=3)
        self.assertEqual(done.stdout, "")
        self.assertIn("bad.csv:3: x: 'two' is not a number (plot 1, tree 2)", done.stderr)

    def test_files_that_are_not_there(self):
        error = self.run_program("fit", "none.csv", "--formula", "y ~ a*x", status=3).stderr
        self.assertIn("none.csv", error)

    def test_a_column_that_the_file_lacks_is_pointed_at(self):
        self.write("line.csv", LINE)
        cases = {
            ("--formula", "Y ~ a + b*x"): "line.csv: column 1: unknown column 'Y'",
            ("--formula", "y ~ a*x", "--random", "a | plot"): "line.csv: column 5: unknown column 'plot'",
            ("--formula", "y ~ a*x", "--where", "z > 1"): "line.csv: column 1: unknown column 'z'",
        }
        for arguments, message in cases.items():
            with self.subTest(arguments):
                done = self.run_program("fit", "line.csv", *arguments, status=3)
                self.assertIn(message, done.stderr)
                self.assertEqual(done.stdout, "")

    def test_usage_errors_point_at_what_is_wrong(self):
        self.write("line.csv", LINE)
        cases = {
            ("--formula", "y ~ a + * x"): "column 9",
            ("--formula", "y ~ x"): "nothing to estimate",
            ("--formula", "y ~ a*x", "--parameter", "q ~ 1"): "unknown parameter 'q'",
            ("--formula", "y ~ a*x", "--random", "a + q | x"): "column 5: unknown coefficient 'q'",
            ("--formula", "y ~ a*x", "--method", "magic"): "is not one of ols, gnls, lb",
            ("--formula", "y ~ a*x", "--method", "laplace"): "needs random effects",
            ("--formula", "y ~ a*x", "--method", "ols", "--reml"): "available for lb and gnls only",
            ("--formula", "y ~ a*x", "--fix", "q=1"): "unknown coefficient 'q'",
            ("--formula", "y ~ a*x", "--random", "x | x"): "'x' is a column of the data, which stands in the formula instead of a parameter",
            ("--formula", "y ~ a*x", "--start", "x=1"): "'x' is a column of the data, which stands in the formula instead of a parameter",
            ("--formula", "y ~ a*x", "--bound", "a=1"): "not a range such as 0:1",
            ("--formula", "y ~ a*x", "--method", "lb"): "needs random effects",
            ("--formula", "y ~ a*x", "--start", "a:3"): "not NAME=VALUE",
            ("--formula", "y ~ a*x", "--variance", "cubic"): "unknown variance function",
            ("--model", "M99"): "unknown model M99",
            (): "either --formula or --model",
        }
        for arguments, message in cases.items():
            with self.subTest(arguments):
                done = self.run_program("fit", "line.csv", *arguments, status=2)
                self.assertIn(message, done.stderr)
                self.assertEqual(done.stdout, "")


class CorrelatedResiduals(ProgramTest):
    """Options and errors; tests/reference compares the fits with nlme."""

    STEMS = pathlib.Path(__file__).parents[1] / "reference/data/stems.csv"
    CURVE = "h ~ a*(1 - exp(-k*age))^c"

    def rows(self, *changes):
        """The stems with other cells: (line, column, value)."""
        lines = [line.split(",") for line in self.STEMS.read_text().splitlines()]
        for line, column, value in changes:
            lines[line - 1][column] = value
        self.write("stems.csv", "".join(",".join(line) + "\n" for line in lines))

    def fit(self, correlation, *arguments, **keywords):
        return self.run_json("fit", "stems.csv", "--formula", self.CURVE, "--random", "a | tree", "--correlation", correlation,
                             *arguments, **keywords)

    def error(self, correlation, *arguments, status=3):
        return self.run_program("fit", "stems.csv", "--formula", self.CURVE, "--random", "a | tree", "--correlation", correlation,
                                *arguments, status=status).stderr

    def test_the_correlation_is_in_the_summary_and_the_file(self):
        self.rows()
        fit = self.fit("car1(age)")
        # nlme 3.1-162: logLik -305.0805, phi 0.889807, standard error of k 0.00138956
        self.assertAlmostEqual(fit["log_likelihood"], -305.0805, 3)
        self.assertEqual(fit["correlation"]["structure"], "car1(age)")
        self.assertAlmostEqual(fit["correlation"]["parameters"]["phi"], 0.889807, 4)
        self.assertAlmostEqual(fit["fixed"]["k"]["se"], 0.00138956, 6)
        text = self.run_program("fit", "stems.csv", "--formula", self.CURVE, "--random", "a | tree", "--correlation", "car1(age)").stdout
        self.assertIn("correlation of the residuals: car1(age)", text)
        self.assertRegex(text, r"sigma [0-9.]+, phi 0\.8898")

    def test_numbers_of_trees_that_recur_in_other_plots_are_named(self):
        rows = [f"{plot},{tree},{year},{10 + plot + tree / 2 + year / 3 + (plot * tree * year) % 7 / 50}"
                for plot in range(1, 5) for tree in range(1, 6) for year in range(5)]
        self.write("recur.csv", "plot,tree,year,dbh\n" + "\n".join(rows) + "\n")
        fit = ("fit", "recur.csv", "--formula", "dbh ~ a + b*year", "--random")
        alone = self.run_program(*fit, "a | tree")
        self.assertIn("5 labels of the column tree occur in several values of plot (1): each is one group here; if it "
                      "is another tree in each of them, group by plot/tree", alone.stderr.replace("`", ""))
        self.assertNotIn("in several values", self.run_program(*fit, "a | plot/tree").stderr)

    def test_labels_within_coarser_groups_do_not_recur(self):
        rows = [f"{site},{plot},{site}{plot},{x},{x + plot + (plot * x) % 7 / 5}"
                for site in ("W", "N") for plot in range(1, 6) for x in range(4)]
        self.write("nested.csv", "site,plot,name,x,y\n" + "\n".join(rows) + "\n")
        fit = ("fit", "nested.csv", "--formula", "y ~ a + b*x", "--random")
        for nested in ("a | site:plot", "a | site/plot"):
            self.assertNotIn("in several values", self.run_program(*fit, nested).stderr)
        self.assertIn("in several values", self.run_program(*fit, "a | plot").stderr)

    def test_labels_of_sub_models_that_differ_in_case_are_named(self):
        rows = [f"{label},{x},{x + (k * x) % 7 / 5}" for k, label in enumerate(("lo", "LO", "hi")) for x in range(1, 9)]
        self.write("cases.csv", "f,x,y\n" + "\n".join(rows) + "\n")
        message = self.run_program("fit", "cases.csv", "--formula", "y ~ a + b*x", "--parameter", "a ~ f").stderr
        self.assertIn("'lo' and 'LO'", message)
        self.assertEqual(message.count("compared as text"), 1)

    def test_a_time_that_is_repeated_or_missing_is_an_error_with_group_and_row(self):
        self.rows((3, 1, "4"))
        message = self.error("car1(age)")
        for part in ("stems.csv:3", "age", "4 is repeated in group T00 (line 2 has it, too)"):
            self.assertIn(part, message)
        lines = self.STEMS.read_text().splitlines()
        year = [lines[0] + ",year"] + [line + f",{k % 7 + 0.5 if k == 9 else k}" for k, line in enumerate(lines[1:])]
        self.write("stems.csv", "\n".join(year) + "\n")
        self.assertIn("2.5 in group T00 is not an integer", self.error("ar1(year)"))
        year[4] = year[4].rsplit(",", 1)[0] + ","
        self.write("stems.csv", "\n".join(year) + "\n")
        message = self.error("car1(year)")
        self.assertIn("stems.csv:5", message)
        self.assertIn("no value in a row of group T00", message)

    def test_what_has_no_correlation_is_refused(self):
        self.rows()
        self.assertIn("use gnls", self.run_program("fit", "stems.csv", "--formula", self.CURVE, "--correlation", "ar1(age | tree)",
                                                   "--method", "ols", status=2).stderr)
        self.assertIn("year", self.error("car1(year)"))
        self.assertIn("unknown correlation 'ar7'", self.error("ar7", status=2))

    def test_compound_symmetry_beside_a_random_intercept_is_not_identifiable(self):
        self.rows()
        out = self.run_program("fit", "stems.csv", "--formula", "h ~ b0 + b1*age", "--random", "b0 | tree", "--correlation", "compound-symmetry",
                               status=4).stdout
        self.assertIn("not identifiable", out)
        self.assertIn("rho", out)

    def test_measured_neighbors_improve_a_prediction(self):
        # Every other height is hidden; those above and below it in age are known. By theory the error is sigma sqrt((1 - r^2)/(1 + r^2)) with r = phi^2, half of sigma.
        self.rows()
        lines = self.STEMS.read_text().splitlines()
        hidden = [line.split(",") for line in lines]
        for k in range(2, len(hidden), 2):
            hidden[k][2] = ""
        self.write("hidden.csv", "".join(",".join(line) + "\n" for line in hidden))
        truth = [float(line.split(",")[2]) for line in lines[1:]]
        errors = {}
        for name, correlation in (("independent", "none"), ("car1", "car1(age)")):
            self.write("fit.json", json.dumps(self.run_json("fit", "hidden.csv", "--formula", self.CURVE, "--random", "a | tree", "--correlation", correlation)))
            output = self.run_program("predict", "fit.json", "hidden.csv", "--level", "calibrated").stdout
            values = [float(row["h_pred"]) for row in csv.DictReader(io.StringIO(output))]
            errors[name] = math.sqrt(sum((values[k] - truth[k]) ** 2 for k in range(1, len(truth), 2)) / (len(truth) // 2))
        self.assertLess(errors["car1"], 0.65 * errors["independent"])

    def test_measured_neighbors_improve_a_prediction_without_random_effects(self):
        # Of an AR(1), only the row before informs the one after it: a + b t + phi (y - a - b t).
        rows = [(g, t, 5 + 0.3 * t + 2 * math.sin(1.7 * g + 0.6 * t) + 0.2 * ((7 * t + 3 * g) % 5)) for g in range(6) for t in range(1, 13)]
        self.write("series.csv", "g,t,y\n" + "".join(f"{g},{t},{y!r}\n" for g, t, y in rows))
        fit = self.run_json("fit", "series.csv", "--formula", "y ~ a + b*t", "--correlation", "ar1(t | g)")
        self.write("series.json", json.dumps(fit))
        a, b = (fit["fixed"][name]["estimate"] for name in "ab")
        phi = fit["correlation"]["parameters"]["phi"]
        self.write("next.csv", "g,t,y\nnew,3,8.5\nnew,4,\n")
        arguments = ("predict", "series.json", "next.csv", "--level", "calibrated")
        row = list(csv.DictReader(io.StringIO(self.run_program(*arguments, "--digits", "12").stdout)))[1]
        self.assertAlmostEqual(float(row["y_pred"]), a + 4 * b + phi * (8.5 - a - 3 * b), delta=1e-8)
        self.assertEqual(row["y_trees"], "1")
        # A group may lie in several parts of a file; without groups all rows do.
        self.write("all.json", json.dumps(self.run_json("fit", "series.csv", "--where", "g == 0", "--formula", "y ~ a + b*t", "--correlation", "ar1(t)")))
        error = self.run_program("predict", "all.json", "next.csv", "--level", "calibrated", "--stream", status=2).stderr
        self.assertIn("cannot be read in parts", error)


if __name__ == "__main__":
    unittest.main()
