# SPDX-License-Identifier: MIT
"""Jobs of several processes by mpirun: the same bytes on any number of them, and one that fails ends the others."""

import json
import math
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
import unittest
from pathlib import Path

from silvafit_program import PROGRAM, ProgramTest, stand_csv

MEYER = "h ~ 1.3 + a*(1 - exp(-b*dbh))"
MODULE = Path(PROGRAM).resolve().parents[1] / "lib/silvafit/silvafit_mpi.so"
# The processes share one machine, which may have fewer cores and may be run by root, such as in a container.
MPIRUN = ["mpirun", "--oversubscribe", "--allow-run-as-root", "--bind-to", "none"]
LOOPBACK = os.environ | {"OMPI_MCA_btl": "self,vader", "OMPI_MCA_plm": "isolated", "OMPI_MCA_rmaps_base_oversubscribe": "1",
                         "OMPI_MCA_oob_tcp_if_include": "lo", "OMPI_MCA_btl_vader_single_copy_mechanism": "none"}


def unequal_csv(plots=900, first_measured=0, rare_plot=None, seed=11):
    """Plots of 1 to 40 trees; heights of a Meyer curve whose limit differs between plots, and whose rate in one of them."""
    draw = random.Random(seed)
    lines = ["plot,tree,site,dbh,h"]
    for plot in range(1, plots + 1):
        limit = 25 + draw.gauss(0, 2)
        rate = 0.03 if plot == rare_plot else 0.05
        for tree in range(1, draw.randint(1, 40) + 1):
            dbh = round(draw.uniform(6, 50), 1)
            h = 1.3 + limit * (1 - math.exp(-rate * dbh)) + draw.gauss(0, 0.5)
            lines.append(f"{plot},{tree},{'wet' if plot == rare_plot else 'dry'},{dbh},{'' if plot < first_measured else f'{h:.2f}'}")
    return "\n".join(lines) + "\n"


@unittest.skipUnless(shutil.which("mpirun") and MODULE.exists(), "skipped: silvafit was built without MPI, or there is no mpirun")
class RanksTest(ProgramTest):
    def run_ranks(self, ranks, *arguments, status=0):
        done = subprocess.run([*MPIRUN, "-n", str(ranks), PROGRAM, *arguments, "--threads", "1"], cwd=self.folder,
                              env=LOOPBACK, capture_output=True, text=True, timeout=280, check=False)
        if status is not None:
            self.assertEqual(done.returncode, status, done.stderr)
        return done

    def compare(self, *arguments):
        """One process with threads, and jobs of 1, 2, 4 and 7, print the same but for times."""
        def comparable(text):
            return json.loads(re.sub(r'"seconds": *[-+.e0-9]+', '"seconds": 0', text))

        alone = comparable(self.run_program(*arguments, "--threads", "2").stdout)
        for ranks in (1, 2, 4, 7):
            with self.subTest(ranks=ranks):
                done = self.run_ranks(ranks, *arguments)
                self.assertEqual(comparable(done.stdout), alone)
        return alone

    def start_ranks(self, ranks, *arguments):
        # pylint: disable=consider-using-with
        job = subprocess.Popen([*MPIRUN, "-n", str(ranks), PROGRAM, *arguments, "--threads", "1"], cwd=self.folder, env=LOOPBACK,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(job.kill)
        return job

    def children_of(self, job, count):
        children = []
        for _ in range(200):
            time.sleep(0.1)
            children = subprocess.run(["pgrep", "-P", str(job.pid)], capture_output=True, text=True, check=False).stdout.split()
            if len(children) == count:
                break
        self.assertEqual(len(children), count)
        return children


class Ranks(RanksTest):
    def test_bootstrap(self):
        self.write("stand.csv", stand_csv())
        fit = self.compare("fit", "stand.csv", "--formula", MEYER, "--random", "a | plot", "--bootstrap", "11", "--json")
        self.assertEqual(fit["bootstrap"]["replicates"], 11)

    def test_cross_validation_with_fewer_folds_than_processes(self):
        self.write("stand.csv", stand_csv(plots=3))
        fit = self.compare("fit", "stand.csv", "--formula", MEYER, "--random", "a | plot", "--cross-validate", "leave-one-out", "--json")
        self.assertEqual(fit["cross_validation"]["folds"], 3)

    def test_models_of_the_catalogue(self):
        self.write("stand.csv", stand_csv())
        fits = self.compare("fit", "stand.csv", "--model", "all:h", "--json")
        self.assertGreater(len(fits["fits"]), 10)

    def test_study(self):
        self.write("stand.csv", stand_csv())
        options = ["study", "stand.csv", "--responses", "h", "--quiet"]
        self.run_program(*options, "--out", "alone", "--threads", "2")
        self.run_ranks(3, *options, "--out", "ranks")
        names = sorted(str(path.relative_to(self.folder / "alone")) for path in (self.folder / "alone").rglob("*.*"))
        self.assertEqual(names, sorted(str(path.relative_to(self.folder / "ranks"))
                                       for path in (self.folder / "ranks").rglob("*.*")))
        for name in names:
            # Times and the command line are in run.json; the report shows them.
            if name in ("run.json", "report.html"):
                continue
            with self.subTest(name):
                self.assertEqual((self.folder / "ranks" / name).read_bytes(), (self.folder / "alone" / name).read_bytes())

    def test_only_the_first_process_writes_and_prints(self):
        self.write("stand.csv", stand_csv())
        done = self.run_ranks(3, "fit", "stand.csv", "--formula", MEYER, "--residuals", "residuals.csv")
        self.assertEqual(done.stdout.count("AIC"), self.run_program("fit", "stand.csv", "--formula", MEYER).stdout.count("AIC"))
        self.assertEqual(len((self.folder / "residuals.csv").read_text().splitlines()), 121)

    def test_an_error_of_all_is_said_once(self):
        done = self.run_ranks(3, "fit", "missing.csv", "--formula", MEYER, status=None)
        self.assertNotEqual(done.returncode, 0)
        self.assertEqual(done.stderr.count("missing.csv"), 1, done.stderr)

    def test_an_error_of_one_ends_the_job_with_its_reason(self):
        self.write("stand.csv", stand_csv())
        # The second process sees another file.
        (self.folder / "second").mkdir()
        (self.folder / "second/stand.csv").write_text("plot,dbh,h\n1,2,\n")
        shell = 'if [ "$OMPI_COMM_WORLD_RANK" = 1 ]; then cd second; fi; exec "$@"'
        started = time.monotonic()
        done = subprocess.run([*MPIRUN, "-n", "3", "sh", "-c", shell, "sh", PROGRAM, "fit", "stand.csv", "--formula", MEYER,
                               "--bootstrap", "20", "--json", "--threads", "1"], cwd=self.folder, env=LOOPBACK,
                              capture_output=True, text=True, timeout=120, check=False)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("process 1 of 3 ends the job: ", done.stderr)
        self.assertEqual(done.stdout.strip(), "")
        self.assertLess(time.monotonic() - started, 60)

    def test_a_killed_process_ends_the_job_and_leaves_nothing(self):
        self.write("stand.csv", stand_csv(plots=40))
        job = self.start_ranks(3, "fit", "stand.csv", "--formula", MEYER, "--random", "a + b | plot", "--bootstrap", "100000", "--json",
                               "--residuals", "residuals.csv")
        children = self.children_of(job, 3)
        time.sleep(2)
        os.kill(int(children[1]), signal.SIGKILL)
        out, err = job.communicate(timeout=60)
        self.assertNotEqual(job.returncode, 0)
        self.assertIn("signal 9", err)
        self.assertEqual(out.strip(), "")
        self.assertEqual([path.name for path in self.folder.iterdir()], ["stand.csv"])


class SharedGroups(RanksTest):
    """fit --share-groups: each process has the data of its own groups."""

    MODEL = ("--formula", MEYER, "--random", "a | plot", "--method")

    def check_as_alone(self, shared, *arguments):
        """The maximum is the one that a fit without shared groups finds in another search."""
        alone = json.loads(self.run_program(*arguments, "--json").stdout)
        self.assertEqual(shared["status"], "converged", shared["verdict"])
        for key in ("n", "excluded", "response_fingerprint", "groups", "ranges", "k", "coefficients_between"):
            self.assertEqual(shared[key], alone[key], key)
        # Searches end within 1e-4 standard errors of the maximum, where the log-likelihood is lower by 1e-8.
        self.assertAlmostEqual(shared["log_likelihood"], alone["log_likelihood"], delta=1e-6)
        self.assertEqual(list(shared["fixed"]), list(alone["fixed"]))
        for name, other in alone["fixed"].items():
            own = shared["fixed"][name]
            self.assertEqual(own["df"], other["df"])
            self.assertAlmostEqual(own["estimate"], other["estimate"], delta=1e-4 * other["se"])
            # The observed information is a difference of gradients with a relative step of about 1e-5.
            self.assertAlmostEqual(own["se"], other["se"], delta=1e-4 * other["se"])
        for own, other in zip(shared["random"], alone["random"], strict=True):
            self.assertEqual(list(own["eblup"]), list(other["eblup"]))
            for label, effects in other["eblup"].items():
                for name, effect in effects.items():
                    self.assertAlmostEqual(own["eblup"][label][name], effect, delta=1e-4)
            self.assertEqual(set(own), set(other))
        for level, statistics in alone["statistics"].items():
            for name, value in statistics.items():
                self.assertAlmostEqual(shared["statistics"][level][name], value, delta=1e-6)
        for name in ("r2_marginal", "r2_conditional"):
            self.assertAlmostEqual(shared[name], alone[name], delta=1e-6)

    def test_as_on_one_process_without_sharing(self):
        self.write("stand.csv", unequal_csv())
        fit = self.compare("fit", "stand.csv", *self.MODEL, "laplace", "--share-groups", "--json")
        self.check_as_alone(fit, "fit", "stand.csv", *self.MODEL, "laplace")

    def test_sample_and_parts_without_observations(self):
        # Heights are measured in the last plots only, so that most parts have no observation; the sample is some groups of many.
        self.write("stand.csv", unequal_csv(plots=5000, first_measured=3000))
        options = ("fit", "stand.csv", *self.MODEL, "focei", "--variance", "power")
        fit = self.compare(*options, "--share-groups", "--json")
        self.assertRegex(fit["verdict"], r"Start values come from a sample of \d+ observations")
        self.check_as_alone(fit, *options)

    def test_more_processes_than_groups(self):
        self.write("stand.csv", stand_csv(plots=5))
        fit = self.compare("fit", "stand.csv", *self.MODEL, "agq", "--share-groups", "--json")
        self.check_as_alone(fit, "fit", "stand.csv", *self.MODEL, "agq")

    def test_rows_of_plots_that_are_not_contiguous(self):
        head, *rows = unequal_csv(plots=300).splitlines()
        self.write("mixed.csv", "\n".join([head, *rows[::2], *rows[1::2]]) + "\n")
        fit = self.compare("fit", "mixed.csv", *self.MODEL, "laplace", "--share-groups", "--json")
        self.check_as_alone(fit, "fit", "mixed.csv", *self.MODEL, "laplace")

    def test_factor_with_a_rare_label(self):
        # The second label is that of one plot, which every n-th plot misses.
        self.write("stand.csv", unequal_csv(plots=5000, rare_plot=1235))
        options = ("fit", "stand.csv", *self.MODEL, "laplace", "--parameter", "b ~ site")
        fit = self.compare(*options, "--share-groups", "--json")
        self.assertEqual(len(fit["fixed"]), 3)
        self.check_as_alone(fit, *options)

    def test_condition_for_rows(self):
        self.write("stand.csv", unequal_csv(plots=600))
        options = ("fit", "stand.csv", *self.MODEL, "laplace", "--where", "plot > 500")
        fit = self.compare(*options, "--share-groups", "--json")
        self.check_as_alone(fit, *options)

    def test_what_cannot_be_shared_is_an_error(self):
        self.write("stand.csv", stand_csv())
        for options, reason in ((("--method", "lb", "--random", "a | plot"), "use --method laplace"),
                                (("--method", "laplace"), "needs --random"),
                                (("--method", "laplace", "--random", "a | species/plot"), "one grouping"),
                                (("--method", "laplace", "--random", "a | nothing"), "nothing"),
                                (("--method", "laplace", "--random", "a | plot", "--bootstrap", "9"), "--bootstrap")):
            with self.subTest(reason):
                done = self.run_ranks(2, "fit", "stand.csv", "--formula", MEYER, *options, "--share-groups", status=None)
                self.assertNotEqual(done.returncode, 0)
                self.assertEqual(done.stderr.count("silvafit:"), 1, done.stderr)
                self.assertIn(reason, done.stderr)

    def test_a_killed_process_ends_the_job(self):
        self.write("stand.csv", unequal_csv(plots=5000))
        job = self.start_ranks(3, "fit", "stand.csv", "--formula", MEYER, "--random", "a + b | plot", "--method", "agq",
                               "--agq-points", "60", "--share-groups", "--json")
        children = self.children_of(job, 3)
        time.sleep(3)
        os.kill(int(children[1]), signal.SIGKILL)
        out, err = job.communicate(timeout=60)
        self.assertNotEqual(job.returncode, 0)
        self.assertIn("signal 9", err)
        self.assertEqual(out.strip(), "")


class WithoutModule(ProgramTest):
    def test_several_processes_without_mpi_are_an_error(self):
        program = self.folder / "bin/silvafit"
        program.parent.mkdir()
        shutil.copy(PROGRAM, program)
        done = subprocess.run([program, "models", "list"], env=os.environ | {"OMPI_COMM_WORLD_SIZE": "2"}, capture_output=True,
                              text=True, check=False)
        self.assertEqual(done.returncode, 2)
        self.assertIn("make mpi", done.stderr)


if __name__ == "__main__":
    sys.exit(unittest.main())
