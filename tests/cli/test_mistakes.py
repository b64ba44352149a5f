# SPDX-License-Identifier: MIT
"""What the program says of slips: names that do not exist, columns a file lacks, options that would do nothing."""

import json
import random
import shutil
import unittest
from pathlib import Path

from command_line import all_commands, help_of
from silvafit_program import ProgramTest, stand_csv

EXAMPLE = Path(__file__).parents[2] / "examples" / "fir-mixed" / "inventory.csv"


def nested_csv(seed=11):
    """Heights of a power curve; the factor differs between stands, and between the plots of each."""
    draw = random.Random(seed)
    lines = ["stand,plot,tree,dbh,h"]
    for stand in range(6):
        of_stand = draw.gauss(0, 0.4)
        for plot in range(4):
            factor = 3.0 + of_stand + draw.gauss(0, 0.2)
            for tree in range(12):
                dbh = round(draw.uniform(8, 40), 1)
                h = 1.3 + factor * dbh**0.5 + draw.gauss(0, 0.4)
                lines.append(f"S{stand},P{stand}{plot},{tree},{dbh},{h:.2f}")
    return "\n".join(lines) + "\n"


class Commands(ProgramTest):
    def error(self, *arguments, status=2):
        return self.run_program(*arguments, status=status).stderr

    def test_a_command_that_does_not_exist_is_named_with_the_nearest(self):
        error = self.error("fti", "trees.csv")
        self.assertIn("unknown command 'fti'; did you mean fit?", error)
        self.assertIn("unknown command 'shwo'; did you mean show?", self.error("library", "shwo"))

    def test_without_a_near_one_all_are_listed(self):
        error = self.error("help")
        self.assertIn("unknown command 'help'. The commands are study, columns, indices, stand, tiles, fit,", error)
        for words in ((), ("library",)):
            self.assertIn("a command is needed", self.error(*words))

    def test_an_option_that_does_not_exist_is_named_with_the_nearest(self):
        self.write("trees.csv", stand_csv())
        error = self.error("fit", "trees.csv", "--model", "M4", "--parameters", "b ~ 1")
        self.assertIn("unknown option --parameters; did you mean --parameter?", error)
        error = self.error("fit", "trees.csv", "--model", "M4", "--parametr=b ~ 1")
        self.assertIn("unknown option --parametr; did you mean --parameter?", error)
        error = self.error("fit", "trees.csv", "--model", "M4", "--xyzzy")
        self.assertIn("unknown option --xyzzy; silvafit fit --help lists the options", error)
        self.assertIn("unexpected argument 'more.csv'", self.error("fit", "trees.csv", "more.csv", "--model", "M4"))
        # As in R, the formula first.
        self.assertIn("write --formula 'h ~ a + b*dbh'", self.error("fit", "trees.csv", "h ~ a + b*dbh"))
        self.assertIn("text follows the name of an option", self.error("stand", "trees.csv", "dbh > 10"))

    def test_settings_in_messages_are_options(self):
        rows = "".join(f"1,{i},{i % 9},{i % 7},{20 + i % 5},{100 * (16 + i % 5)}\n" for i in range(60))
        self.write("cm.csv", "plot,tree,x,y,dbh,h\n" + rows)
        self.assertIn("use --columns h=h/100; if it is correct, use --trust-units\n", self.error("indices", "cm.csv", status=3))
        error = self.error("indices", str(EXAMPLE), "--buffer", "1", "--further", "Hegyi", "--competition-radius", "3", status=0)
        self.assertIn("(--competition-radius is 3 m), so their Hegyi index is too small; use a --buffer of that width", error)

    def test_every_command_prints_the_version(self):
        version = self.run_program("--version").stdout
        for words in all_commands():
            with self.subTest(words):
                self.assertEqual(self.run_program(*words, "--version").stdout, version)
        self.assertEqual(json.loads(self.run_program("fit", "--version", "--json").stdout)["schema"], "silvafit-version/1")

    def test_help_says_where_to_begin(self):
        said = help_of().split("Where to begin:\n")[1].splitlines()
        self.assertEqual(len(said), 3)
        for line, command in zip(said, ("study", "view", "COMMAND --help")):
            self.assertTrue(line.startswith(f"  silvafit {command}"), line)
        self.assertNotIn("Where to begin", help_of("study"))

    def test_help_of_every_command_has_an_example(self):
        for words in all_commands():
            if words:
                with self.subTest(words):
                    self.assertIn("\nExample:\n  silvafit", self.run_program(*words, "--help").stdout)


class Values(ProgramTest):
    """Values that an option cannot have: status 2, and a line as of all other mistakes."""

    def setUp(self):
        super().setUp()
        shutil.copy(EXAMPLE, self.folder / "trees.csv")

    def refused(self, message, *arguments):
        with self.subTest(arguments):
            error = self.run_program(*arguments, status=2).stderr
            self.assertEqual(error.splitlines()[0], f"silvafit: {message}")
            self.assertEqual(len(error.splitlines()), 1, error)

    def test_counts_are_digits_and_no_numbers_below_0(self):
        indices = ("indices", "trees.csv", "--out", "i.csv")
        for option in ("--seed", "--threads", "--neighbors"):
            for value in ("-1", "1.5", "x", "0x10"):
                self.refused(f"{option}: '{value}' is not a whole number of 0 or more", *indices, option, value)
        self.refused("--minimum-trees: '-5' is not a whole number of 0 or more",
                     "study", "trees.csv", "--out", "o", "--minimum-trees", "-5")
        for option, value in (("--seed", 2**64), ("--threads", 2**40)):
            self.refused(f"{option}: {value} is too large", *indices, option, str(value))
        self.run_program(*indices, "--seed", str(2**64 - 1), "--threads", "1", "--quiet")

    def test_numbers_are_numbers(self):
        stand = ("stand", "trees.csv")
        self.refused("--quadrat: 'wide' is not a number", *stand, "--quadrat", "wide")
        self.refused("--layers: 'x' is not a number", *stand, "--layers", "10,x")
        self.refused("--dominant-trees: '-3' is not above 0", *stand, "--dominant-trees", "-3")

    def test_choices_are_listed_and_the_nearest_is_named(self):
        self.refused("shell: 'tcsh' is not one of bash, zsh, fish", "completion", "tcsh")
        self.refused("shell: 'bahs' is not one of bash, zsh, fish; did you mean bash?", "completion", "bahs")
        self.refused("--edge: 'soft' is not one of buffer, hanisch, torus, none", "indices", "trees.csv", "--edge", "soft")

    def test_what_is_left_out_is_named(self):
        self.refused("INVENTORY.csv is needed; silvafit study --help lists the options", "study")
        self.refused("--seed: needs a value; silvafit indices --help lists the options", "indices", "trees.csv", "--seed")
        self.refused("--window excludes --circle",
                     "indices", "trees.csv", "--window", "a.csv", "--circle", "0,0,1")


class Columns(ProgramTest):
    """What a file lacks is bad input wherever its name stands: status 3, the file, and the columns there are."""

    def setUp(self):
        super().setUp()
        shutil.copy(EXAMPLE, self.folder / "trees.csv")
        self.write("small.csv", "plot,tree,dbh,h\n1,1,20,15\n1,2,25,17\n")

    def lacks(self, column, *arguments, file="trees.csv"):
        with self.subTest(arguments):
            error = self.run_program(*arguments, status=3).stderr
            self.assertIn(file, error)
            self.assertRegex(error, f"(unknown|no) column '?{column}")
            self.assertIn("available: plot, ", error)

    def test_of_fits(self):
        fit = ("fit", "trees.csv", "--model", "M4")
        self.lacks("foo", *fit, "--random", "a | foo")
        self.lacks("foo", *fit, "--variance", "power(foo)")
        self.lacks("foo", *fit, "--variance", "stratum(foo)")
        self.lacks("foo", *fit, "--parameter", "b ~ 1 + foo")
        self.lacks("foo", *fit, "--where", "foo > 1")
        self.lacks("foo", *fit, "--columns", "dbh=foo")
        self.lacks("foo", "fit", "trees.csv", "--formula", "foo ~ a + b*dbh")
        self.lacks("hcb", "fit", "small.csv", "--model", "M20", file="small.csv")

    def test_of_other_commands(self):
        study = ("study", "trees.csv", "--out", "out")
        self.lacks("foo", *study, "--covariates", "foo")
        self.lacks("foo", *study, "--group", "foo")
        self.lacks("foo", *study, "--columns", "dbh=foo")
        self.lacks("hcb", "impute", "small.csv", "--response", "hcb", file="small.csv")
        self.lacks("foo", "impute", "trees.csv", "--by", "foo")
        self.lacks("foo", "impute", "trees.csv", "--group", "foo")
        self.lacks("x", "indices", "small.csv", file="small.csv")
        self.lacks("foo", "stand", "trees.csv", "--stratum", "foo")
        fit = self.run_program("fit", "trees.csv", "--formula", "h ~ 1.3 + a*cw^b", "--json").stdout
        self.write("fit.json", fit)
        self.lacks("cw", "predict", "fit.json", "small.csv", file="small.csv")

    def test_a_table_in_place_of_a_command(self):
        error = self.run_program("trees.csv", status=2).stderr
        self.assertIn("silvafit study trees.csv --out results", error)
        self.assertIn("silvafit study Bestand.xlsx", self.run_program("Bestand.xlsx", status=2).stderr)

    def test_impossible_heights_are_skipped_and_counted(self):
        heights = "\n".join(f"1,{i},{10 + i},{8 + 0.5 * i}" for i in range(1, 12))
        self.write("low.csv", f"plot,tree,dbh,h\n1,90,9,1.3\n1,91,8,0.4\n{heights}\n")
        self.write("right.csv", f"plot,tree,dbh,h\n{heights}\n")
        done = self.run_program("fit", "low.csv", "--model", "n\u00e4slund", "--json")
        self.assertIn("2 rows are skipped, the first: low.csv:2: h: 1.3 m is not above breast height", done.stderr)
        self.assertEqual(json.loads(done.stdout)["fixed"], self.run_json("fit", "right.csv", "--model", "M1")["fixed"])

    def test_a_model_of_a_configuration_that_does_not_exist(self):
        self.write("study.json", '{"candidates": {"h": ["M4", "M999"]}}')
        error = self.run_program("study", "trees.csv", "--config", "study.json", "--out", "out", status=3).stderr
        self.assertIn("study.json: candidates.h", error)
        self.assertIn("unknown model M999", error)

    def test_files_without_rows_and_files_that_are_not_there(self):
        self.write("header.csv", "plot,tree,species,dbh,h\n")
        for model in (("--model", "M1"), ("--formula", "h ~ 1.3 + a*dbh^b")):
            error = self.run_program("fit", "header.csv", *model, status=3).stderr
            self.assertIn("header.csv: there are no rows below the header", error)
        self.write("gaps.csv", "plot,tree,dbh,h\n1,1,20,\n1,2,,12\n")
        self.assertIn("gaps.csv: dbh:", self.run_program("fit", "gaps.csv", "--model", "M1", status=3).stderr)
        error = self.run_program("simulate", "nofile.json", "--out", "s.csv", status=3).stderr
        self.assertIn("nofile.json: cannot read", error)

    def test_a_study_folder_is_no_library_and_the_file_in_it_is_named(self):
        (self.folder / "study").mkdir()
        self.write("study/library.json", "{}")
        for command in (("predict", "study", "trees.csv"), ("library", "show", "study"), ("compare", "study", "study")):
            error = self.run_program(*command, status=3).stderr
            self.assertIn("study: is a folder; its library is study/library.json", error)

    def test_strata_may_be_in_any_column(self):
        by_plot = self.run_json("stand", "trees.csv", "--plot-area", "600", "--stratum", "plot")
        self.assertEqual(len(by_plot["strata"]), 1 + len(by_plot["areas"]))
        error = self.run_program("stand", "trees.csv", "--plot-area", "600", "--stratum", "species", status=3).stderr
        self.assertIn("the plot belongs to two strata,", error)


class Notes(ProgramTest):
    def test_a_coefficient_that_is_nearly_a_column_is_pointed_out(self):
        self.write("trees.csv", stand_csv())
        done = self.run_program("fit", "trees.csv", "--formula", "h ~ 1.3 + a*dhb^b", status=4)
        sentence = "dhb is not a column of the data and was taken as a parameter; did you mean the column dbh?"
        self.assertIn(sentence, done.stderr)
        self.assertEqual(done.stdout.splitlines()[1].find(sentence), 0)
        found = self.run_json("fit", "trees.csv", "--formula", "h ~ 1.3 + a*dhb^b", status=4)
        self.assertIn({"kind": "taken_as_parameter", "term": "dhb", "value": None}, found["evidence"]["findings"])
        done = self.run_program("fit", "trees.csv", "--formula", "h ~ 1.3 + a*dbh^b")
        self.assertNotIn("taken as a parameter", done.stdout + done.stderr)

    def test_formulas_of_r_are_read_or_get_a_sentence(self):
        self.write("trees.csv", stand_csv())
        by_bar = self.run_json("fit", "trees.csv", "--formula", "h ~ a + b*dbh + (1 | plot)")
        by_option = self.run_json("fit", "trees.csv", "--formula", "h ~ a + b*dbh", "--random", "a | plot")
        self.assertEqual(by_bar["log_likelihood"], by_option["log_likelihood"])
        by_expression = self.run_json("fit", "trees.csv", "--formula", "log(h) ~ a + b*dbh")
        by_column = self.run_json("fit", "trees.csv", "--formula", "log_h ~ a + b*dbh", "--columns", "log_h=log(h)")
        self.assertEqual(by_expression["log_likelihood"], by_column["log_likelihood"])
        cases = {"h ~ dbh": "h ~ b0 + b1*dbh",
                 "h ~ dbh + (1 | plot)": 'h ~ b0 + b1*dbh with --random "b0 | plot"',
                 "h ~ dbh + species": 'h ~ b0 + b1*dbh with --parameter "b0 ~ species"',
                 "h ~ SSlogis(dbh, Asym)": "SSlogis(input, Asym, xmid, scal)",
                 "cbind(h, dbh) ~ a": "a column or an expression of columns",
                 "h ~ a + b*np.log(dbh)": "write log()",
                 "h ~ SSlogis(dbh, Asym, xmid, scal) ~ Asym | plot": '--random "Asym | plot"',
                 "h ~ a + b*ln(dbh)": "write log()"}
        for formula, message in cases.items():
            with self.subTest(formula):
                self.assertIn(message, self.run_program("fit", "trees.csv", "--formula", formula, status=2).stderr)

    def test_species_that_a_library_lacks_are_pointed_out(self):
        self.write("trees.csv", "plot,tree,species,dbh,h,hcb,cw,C,M,U\n1,1,Buche,20,15,6,3,0.5,0.5,0.5\n"
                                "1,2,SM,20,15,6,3,0.5,0.5,0.5\n")
        done = self.run_program("predict", "shanxia-2023", "trees.csv", "--out", "p.csv", "--json")
        note = "1 tree is of species without a model in the library: Buche; it has models for "
        self.assertIn(f"note: {note}", done.stderr)
        self.assertIn("SM", done.stderr)
        self.assertTrue(any(text.startswith(note) for text in json.loads(done.stdout)["notes"]))

    def test_a_study_without_crown_widths_says_so_once(self):
        lines = EXAMPLE.read_text(encoding="utf-8").splitlines()
        names = lines[0].split(",")
        kept = [names.index(name) for name in ("plot", "tree", "species", "x", "y", "dbh")]
        self.write("bare.csv", "".join(",".join(line.split(",")[i] for i in kept) + "\n" for line in lines))
        error = self.run_program("study", "bare.csv", "--out", "out", status=4).stderr
        notes = [line for line in error.splitlines() if line.startswith("note: ")]
        self.assertEqual(len(notes), len(set(notes)), notes)
        self.assertEqual(sum("crown widths" in note for note in notes), 1)
        report = (self.folder / "out" / "report.html").read_text(encoding="utf-8")
        self.assertIn("skipped: no model reached this level", report)
        self.assertNotIn("Lindstrom-Bates, maximum likelihood;", report)

    def test_more_folds_than_groups_are_as_many_as_groups(self):
        self.write("trees.csv", stand_csv(plots=4))
        error = self.run_program("fit", "trees.csv", "--model", "M4", "--cross-validate", "500", "--group", "plot").stderr
        self.assertIn("note: 4 folds instead of 500: the column plot has 4 groups", error)
        error = self.run_program("fit", "trees.csv", "--model", "M4", "--cross-validate", "3", "--group", "plot").stderr
        self.assertNotIn("folds instead", error)

    def test_missing_values_are_explained(self):
        self.write("trees.csv", "plot,tree,species,x,y,dbh\n1,1,SM,0,0,n.v.\n1,2,SM,1,1,20\n1,3,SM,2,0,-\n1,4,SM,3,1,22\n")
        error = self.run_program("indices", "trees.csv", "--out", "i.csv", "--neighbors", "1").stderr
        self.assertIn("'n.v.' is not a number; leave missing values empty or write NA", error)
        self.assertIn("note: 1 tree is without dbh: neighbors of others, but not core trees", error)
        self.assertIn("note: codes read as missing values: dbh 1 (-)", error)

    def test_codes_in_columns_of_a_formula_are_missing_values(self):
        draw = random.Random(3)
        rows = [(i % 5, i / 2 + 3, round(2 + 0.4 * (i / 2 + 3) + draw.gauss(0, 1), 3), i % 7) for i in range(60)]
        text = lambda codes: "plot,d,y,age\n" + "".join(f"{p},{d},{codes.get((i, 'y'), y)},{codes.get((i, 'age'), age)}\n"
                                                       for i, (p, d, y, age) in enumerate(rows))
        fields = [(4, "y"), (9, "y"), (17, "age")]
        self.write("codes.csv", text({fields[0]: "-9999", fields[1]: "-9999.0", fields[2]: "-99999"}))
        self.write("empty.csv", text(dict.fromkeys(fields, "")))
        fit = ("--formula", "y ~ a + b*d + c*age")
        done = self.run_program("fit", "codes.csv", *fit, "--json")
        self.assertIn("note: codes read as missing values: y 2 (-9999), age 1 (-99999)", done.stderr)
        found, expected = json.loads(done.stdout), self.run_json("fit", "empty.csv", *fit)
        self.assertEqual((found["fixed"], found["excluded"]), (expected["fixed"], 3))
        self.write("fit.json", done.stdout)
        for name in ("codes", "empty"):
            self.run_program("predict", "fit.json", f"{name}.csv", "--out", f"{name}_out.csv")
        columns = [[line.split(",")[4:] for line in (self.folder / f"{name}_out.csv").read_text(encoding="utf-8").splitlines()] for name in ("codes", "empty")]
        self.assertEqual(*columns)
        # A value of -99 may be one: the result asks.
        self.write("likely.csv", text({fields[0]: "-99"}))
        self.assertTrue(self.run_json("fit", "likely.csv", *fit)["verdict"].startswith("The only value below 0 in the column y is -99, in 1 of the rows"))


class IdleOptions(ProgramTest):
    def test_options_that_would_do_nothing_are_refused(self):
        self.write("trees.csv", stand_csv())
        fit = ("fit", "trees.csv", "--model", "M4", "--random", "a | plot")
        for option, needed in ((("--measured-trees", "3"), "--cross-validate"), (("--agq-points", "5"), "--method agq"),
                               (("--level", "0.9"), "--intervals"), (("--resample", "cases"), "--bootstrap"),
                               (("--bootstrap-level", "0.9"), "--bootstrap"), (("--group", "plot"), "--bootstrap")):
            with self.subTest(option):
                error = self.run_program(*fit, *option, status=2).stderr
                self.assertIn(f"{option[0]}: has no effect without {needed}", error)
        self.run_program(*fit, "--level", "0.9", "--intervals", "wald")
        error = self.run_program("fit", "trees.csv", "--model", "M4", "--covariance", "diagonal", status=2).stderr
        self.assertIn("--covariance: has no effect without --random", error)
        error = self.run_program(*fit, "--fix", "a=20", "--start", "a=30", status=2).stderr
        self.assertIn("--start: has no effect on a, which is held", error)
        self.run_program("models", "M4", "--response", "cw", status=2)
        error = self.run_program("impute", "trees.csv", "--random", "none", "--group", "plot", status=2).stderr
        self.assertIn("--group: has no effect beside --random", error)
        self.write("line.json", self.run_program("fit", "trees.csv", "--model", "M4", "--json").stdout)
        error = self.run_program("predict", "line.json", "trees.csv", "--level", "conditional", status=2).stderr
        self.assertIn("--level: has no effect on these models, which have no random effects", error)
        error = self.run_program("study", "trees.csv", "--significance", "0.01", "--tests", "shown", "--out", "s", status=2).stderr
        self.assertIn("--significance: has no effect without --tests required", error)

    def test_options_of_predictions_and_indices_that_would_do_nothing_are_refused(self):
        # They are refused before any file is read.
        for command, option, needed in (
                (("predict", "f.json", "t.csv"), ("--interval-kind", "confidence"), "--interval or --standard-errors"),
                (("predict", "f.json", "t.csv"), ("--new-groups", "error"), "--level conditional or calibrated"),
                (("predict", "f.json", "t.csv", "--level", "conditional"), ("--seen-groups", "new"), "--level calibrated"),
                (("impute", "t.csv"), ("--minimum-trees", "5"), "--by"),
                (("indices", "t.csv", "--edge", "torus"), ("--buffer", "3"), "--edge buffer"),
                (("indices", "t.csv"), ("--competition-radius", "5"), "--further Hegyi"),
                (("indices", "t.csv"), ("--open-grown", "dbh/10"), "--further CCF")):
            with self.subTest(option):
                error = self.run_program(*command, *option, status=2).stderr
                self.assertIn(f"{option[0]}: has no effect without {needed}", error)

    def test_options_of_units_that_would_do_nothing_are_refused_by_studies_and_stand_figures(self):
        self.write("trees.csv", stand_csv())
        self.write("study.json", '{"edge": "none", "buffer": 3}')
        study = ("study", "trees.csv", "--out", "study")
        for command, option, needed in (
                (("stand", "trees.csv", "--edge", "torus"), ("--buffer", "3"), "--edge buffer"),
                (("stand", "trees.csv", "--further", "CO"), ("--competition-radius", "5"), "--further Hegyi"),
                (("stand", "trees.csv", "--further", "CO"), ("--open-grown", "dbh/10"), "--further CCF"),
                ((*study, "--edge", "none"), ("--buffer", "3"), "--edge buffer"),
                ((*study, "--config", "study.json"), ("--buffer", "3"), "--edge buffer"),
                (study, ("--competition-radius", "5"), "--further Hegyi"),
                ((*study, "--covariates", "Hegyi"), ("--open-grown", "dbh/10"), "--further CCF")):
            with self.subTest(command + option):
                error = self.run_program(*command, *option, status=2).stderr
                self.assertIn(f"{option[0]}: has no effect without {needed}", error)
        self.assertFalse((self.folder / "study").exists())
        # A covariate is a use, and so is a line in a new file.
        self.run_program("study", "trees.csv", "--edge", "none", "--buffer", "3", "--init", "new.json")
        self.assertIn('"buffer": 3', (self.folder / "new.json").read_text(encoding="utf-8"))

    def test_what_a_study_file_says_must_have_an_effect_too(self):
        self.write("trees.csv", stand_csv())
        for setting, value, needed in (("buffer", '3, "edge": "none"', "--edge buffer"),
                                       ("competition_radius", "3", "--further Hegyi"),
                                       ("open_grown", '"dbh/10"', "--further CCF"),
                                       ("smallest_dbh", "7", "--angle-count"),
                                       ("plots_columns", '{"area": "x"}', "--plots"),
                                       ("subplots", "3", "--circles"),
                                       ("slope_correction", "true", "a column slope")):
            with self.subTest(setting):
                self.write("study.json", f'{{"{setting}": {value}}}')
                error = self.run_program("study", "trees.csv", "--config", "study.json", "--out", "s", status=3).stderr
                self.assertIn(f"study.json: {setting}: has no effect without {needed}", error)
        # A default value changes nothing, as in the files of --init.
        self.write("study.json", '{"edge": "none", "buffer": 5, "subplots": 1, "covariates": [], "responses": ["h"]}')
        self.run_program("study", "trees.csv", "--config", "study.json", "--out", "s")

    def test_a_column_of_a_study_that_nothing_reads_is_refused(self):
        self.write("trees.csv", stand_csv())
        study = ("study", "trees.csv", "--responses", "h", "--covariates", "wide", "--out", "s")
        error = self.run_program(*study, "--columns", "wide=dbh/10,dhb=dbh", status=2).stderr
        self.assertIn("--columns: nothing reads a column 'dhb' here; did you mean dbh?", error)
        self.write("study.json", '{"candidates": {"h": ["h ~ 1.3 + a*wide^b"]}, "columns": {"wide": "dbh/10"}, '
                                 '"covariates": [], "responses": ["h"]}')
        self.run_program("study", "trees.csv", "--config", "study.json", "--out", "s")

    def test_options_that_growth_does_not_read_are_refused(self):
        self.write("trees.csv", "plot,tree,year,dbh,h\nA,1,2015,20,15\nA,1,2020,24,17\nA,2,2015,30,20\nA,2,2020,31,21\n")
        growth = ("stand", "trees.csv", "--growth", "--plot-area", "500")
        self.run_program(*growth)
        for option in ("--thinning below=5", "--by species", "--class-width 4", "--layers 3", "--dominant-trees 50",
                       "--quadrat 5", "--further all", "--edge none", "--buffer 3", "--neighbors 3", "--alpha 60",
                       "--per stand", "--dominance h", "--crowding facing", "--dead neighbors", "--site-index x"):
            with self.subTest(option):
                name = option.split()[0]
                error = self.run_program(*growth, *option.split(), status=2).stderr
                self.assertIn(f"{name}: has no effect on growth", error)
        for option, reason in (("--circle 0,0,5", "beside --plot-area"), ("--circles 7=4", "beside --plot-area"),
                               ("--subplot plot", "beside --plot-area"), ("--subplots 3", "without --circles"),
                               ("--slope-correction", "without a column slope"),
                               ("--post-stratified", "without strata")):
            with self.subTest(option):
                error = self.run_program(*growth, *option.split(), status=2).stderr
                self.assertIn(f"{option.split()[0]}: has no effect {reason}", error)

    def test_settings_of_plots_need_the_columns_of_their_table(self):
        self.write("trees.csv", stand_csv())
        self.write("plots.csv", "plot,area\n1,400\n")
        for command in ("stand", "indices"):
            for option in (("--slope-correction",), ("--subplots", "4")):
                with self.subTest((command, option)):
                    error = self.run_program(command, "trees.csv", "--plots", "plots.csv", *option, status=2).stderr
                    self.assertIn(f"{option[0]}: has no effect without ", error)
                    self.assertIn("in the table of --plots", error)

    def test_dead_trees_need_a_status_and_subplots_a_design(self):
        self.write("trees.csv", stand_csv())
        for command in (("stand",), ("study", "--out", "s"), ("indices",)):
            for value in ("neighbors", "include"):
                error = self.run_program(command[0], "trees.csv", *command[1:], "--dead", value, status=2).stderr
                self.assertIn("--dead: no column of the status was found; name it with --columns status=COLUMN", error)
            error = self.run_program(command[0], "trees.csv", *command[1:], "--subplot", "plot", status=2).stderr
            self.assertIn("--subplot: has no effect without --circles", error)

    def test_options_of_fits_and_roles_that_would_do_nothing_are_refused(self):
        self.write("trees.csv", stand_csv())
        fit = ("fit", "trees.csv", "--model", "M4")
        mixed = (*fit, "--random", "a | plot", "--method", "laplace")
        for command, option, needed in ((fit, "--maximum-iterations 9", "--method lb or gnls"),
                                        (mixed, "--maximum-iterations 9", "--method lb or gnls"),
                                        (fit, "--starts 2", "--random")):
            with self.subTest(option):
                error = self.run_program(*command, *option.split(), status=2).stderr
                self.assertIn(f"{option.split()[0]}: has no effect without {needed}", error)
        self.write("fit.json", self.run_program(*fit, "--json").stdout)
        error = self.run_program("predict", "fit.json", "trees.csv", "--role", "ols", status=2).stderr
        self.assertIn("--role: has no effect on this library, whose models have no roles", error)

    def test_a_name_that_is_given_twice_is_refused(self):
        self.write("trees.csv", stand_csv())
        fit = ("fit", "trees.csv", "--model", "M4")
        for option in (("--fix", "a=25,a=26"), ("--bound", "a=20:24,a=30:40"), ("--start", "a=20,a=30"),
                       ("--parameter", "a ~ species", "--parameter", "a ~ x")):
            with self.subTest(option):
                error = self.run_program(*fit, *option, status=2).stderr
                self.assertIn(f"{option[0]}: 'a' is given twice", error)
        error = self.run_program("indices", "trees.csv", "--alpha", "72,SM=60,SM=50", status=2).stderr
        self.assertIn("--alpha: 'SM' is given twice", error)
        error = self.run_program("indices", "trees.csv", "--alpha", "72,60", status=2).stderr
        self.assertIn("--alpha: two values are for all names", error)

    def test_groups_of_measured_trees_only_leave_none_to_predict(self):
        self.write("trees.csv", stand_csv())
        error = self.run_program("fit", "trees.csv", "--model", "M4", "--random", "a | plot", "--cross-validate", "2",
                                 "--measured-trees", "5000").stderr
        self.assertIn("note: no plot has more than 5000 trees", error)
        self.run_program("study", str(EXAMPLE), "--out", "fir", "--species", "SM", "--responses", "h",
                         "--covariates", "Hegyi", "--competition-radius", "5")

    def test_groups_to_leave_out_need_the_option(self):
        self.write("trees.csv", stand_csv())
        error = self.run_program("fit", "trees.csv", "--model", "M4", "--cross-validate", "5", status=2).stderr
        self.assertIn("--group plot", error)


class FitTable(ProgramTest):
    def test_nested_effects_are_shown_as_nested_and_diagonal_ones_without_correlations(self):
        self.write("nested.csv", nested_csv())
        out = self.run_program("fit", "nested.csv", "--formula", "h ~ 1.3 + a*dbh^b", "--random", "a | stand/plot").stdout
        lines = [line.strip() for line in out.splitlines() if line.strip().startswith("random:")]
        self.assertEqual(lines, ["random: a | stand, general covariance", "random: a | plot within stand, general covariance"])
        self.write("trees.csv", stand_csv())
        fit = ("fit", "trees.csv", "--model", "M4", "--random", "a + b | plot")
        self.assertIn("correlation", self.run_program(*fit).stdout)
        self.assertNotIn("correlation", self.run_program(*fit, "--covariance", "diagonal").stdout)


if __name__ == "__main__":
    unittest.main()
