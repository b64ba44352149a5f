# SPDX-License-Identifier: MIT
"""Jobs of several processes by mpirun: the same bytes on any number of them, and one that fails ends the others."""

import json
import os
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


@unittest.skipUnless(shutil.which("mpirun") and MODULE.exists(), "skipped: silvafit was built without MPI, or there is no mpirun")
class Ranks(ProgramTest):
    def run_ranks(self, ranks, *arguments, status=0):
        done = subprocess.run([*MPIRUN, "-n", str(ranks), PROGRAM, *arguments, "--threads", "1"], cwd=self.folder,
                              env=LOOPBACK, capture_output=True, text=True, timeout=280, check=False)
        if status is not None:
            self.assertEqual(done.returncode, status, done.stderr)
        return done

    def compare(self, *arguments):
        """One process with threads, and jobs of 1, 2 and 4, print the same but for times."""
        def comparable(text):
            return json.loads(re.sub(r'"seconds": *[-+.e0-9]+', '"seconds": 0', text))

        alone = comparable(self.run_program(*arguments, "--threads", "2").stdout)
        for ranks in (1, 2, 4):
            with self.subTest(ranks=ranks):
                done = self.run_ranks(ranks, *arguments)
                self.assertEqual(comparable(done.stdout), alone)
        return alone

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
        # pylint: disable=consider-using-with
        job = subprocess.Popen([*MPIRUN, "-n", "3", PROGRAM, "fit", "stand.csv", "--formula", MEYER, "--random", "a + b | plot",
                                "--bootstrap", "100000", "--json", "--residuals", "residuals.csv", "--threads", "1"],
                               cwd=self.folder, env=LOOPBACK, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(job.kill)
        children = []
        for _ in range(200):
            time.sleep(0.1)
            children = subprocess.run(["pgrep", "-P", str(job.pid)], capture_output=True, text=True, check=False).stdout.split()
            if len(children) == 3:
                break
        self.assertEqual(len(children), 3)
        time.sleep(2)
        os.kill(int(children[1]), signal.SIGKILL)
        out, err = job.communicate(timeout=60)
        self.assertNotEqual(job.returncode, 0)
        self.assertIn("signal 9", err)
        self.assertEqual(out.strip(), "")
        self.assertEqual([path.name for path in self.folder.iterdir()], ["stand.csv"])


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
