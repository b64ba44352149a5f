# SPDX-License-Identifier: MIT
"""The examples of docs/large-inventories.md run with GNU parallel, Snakemake and Slurm, and give the bytes of one run."""

import os
import shutil
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

from pages import blocks

SOURCE = Path(__file__).resolve().parents[2]
PROGRAM = Path(os.environ["SILVAFIT_PROGRAM"])
PAGE = SOURCE / "docs/large-inventories.md"
INVENTORY = "examples/fir-mixed/inventory.csv"

SLURM_CONF = """\
ClusterName=test
SlurmctldHost=localhost(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/none
CredType=cred/none
SlurmctldPort=16817
SlurmdPort=16818
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
SwitchType=switch/none
MpiDefault=none
NodeName=localhost NodeAddr=127.0.0.1 CPUs={cpus} RealMemory=3000 State=UNKNOWN
PartitionName=all Nodes=localhost Default=YES MaxTime=INFINITE State=UP
"""


def block(language):
    """The block of the page in this language."""
    found = ["\n".join(lines) + "\n" for _, name, lines, _ in blocks(PAGE.read_text(encoding="utf-8")) if name == language]
    if len(found) != 1:
        raise ValueError(f"{PAGE} has {len(found)} blocks of {language}")
    return found[0]


class BatchSystems(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="silvafit-batch-")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        (self.folder / "bin").mkdir()
        (self.folder / "bin/silvafit").symlink_to(PROGRAM)
        shutil.copytree(SOURCE / "examples/fir-mixed", self.folder / "examples/fir-mixed")
        self.environment = os.environ | {"PATH": f"{self.folder}/bin:{os.environ['PATH']}", "HOME": str(self.folder)}

    def need(self, *programs):
        for program in programs:
            if shutil.which(program, path=self.environment["PATH"] + ":/usr/sbin") is None:
                self.skipTest(f"{program} is not installed")

    def run_shell(self, text, check=True):
        done = subprocess.run(["bash", "-e", "-o", "pipefail", "-c", text], cwd=self.folder, env=self.environment,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=240, check=False)
        if check:
            self.assertEqual(done.returncode, 0, f"{text}\n{done.stdout}")
        return done.stdout

    def plan(self):
        self.run_shell(f"silvafit tiles plan {INVENTORY} --size 50 --halo 25 --out tiles")

    def check_result(self):
        self.run_shell(f"silvafit indices {INVENTORY} --per stand --edge none --out whole.csv")
        whole = (self.folder / "whole.csv").read_bytes()
        self.assertEqual(whole.count(b"\n"), 4896)
        self.assertTrue(whole == (self.folder / "indices.csv").read_bytes(), "the bytes differ from those of one run")

    def test_gnu_parallel(self):
        self.need("parallel")
        self.plan()
        self.run_shell(block("parallel"))
        self.check_result()

    def test_snakemake(self):
        self.need("snakemake")
        (self.folder / "Snakefile").write_text(block("python"), encoding="utf-8")
        self.run_shell("snakemake --cores all")
        self.check_result()
        # Nothing is left to do; a result that is gone is made again.
        self.assertIn("Nothing to be done", self.run_shell("snakemake --cores all"))

    def start_slurm(self):
        slurm = self.folder / "slurm"
        for name in ("state", "spool"):
            (slurm / name).mkdir(parents=True)
        conf = slurm / "slurm.conf"
        conf.write_text(SLURM_CONF.format(folder=slurm, cpus=os.cpu_count()), encoding="utf-8")
        self.environment |= {"SLURM_CONF": str(conf), "PATH": self.environment["PATH"] + ":/usr/sbin"}
        for daemon in (["slurmctld", "-D"], ["slurmd", "-D", "-N", "localhost"]):
            with open(slurm / f"{daemon[0]}.log", "wb") as log:
                # pylint: disable=consider-using-with
                process = subprocess.Popen(daemon, env=self.environment, stdout=log, stderr=log)
            self.addCleanup(process.wait)
            self.addCleanup(process.kill)
        for _ in range(60):
            if "idle" in self.run_shell("sinfo", check=False):
                return
            time.sleep(0.5)
        self.skipTest("the daemons of Slurm do not start here: " +
                      (slurm / "slurmctld.log").read_text(encoding="utf-8")[-300:] +
                      (slurm / "slurmd.log").read_text(encoding="utf-8")[-300:])

    def test_slurm(self):
        self.need("sbatch", "slurmctld", "slurmd")
        if os.geteuid() != 0:
            self.skipTest("the daemons of Slurm need root")
        self.plan()
        self.start_slurm()
        # The page's limit of memory is more than the whole machine of the test may have.
        (self.folder / "tiles.sbatch").write_text(block("slurm").replace("--mem=2G", "--mem=500M"), encoding="utf-8")
        self.run_shell("sbatch --wait --array=1-$(ls tiles/tiles | wc -l) tiles.sbatch")
        # One tile is lost: merge names it, and it is submitted again.
        lost = sorted((self.folder / "tiles/indices").iterdir())[3]
        lost.unlink()
        said = self.run_shell("silvafit tiles merge tiles indices --out indices.csv", check=False)
        self.assertIn(lost.stem, said)
        number = said.split("no result of indices: ")[1].split()[0]
        self.run_shell(f"sbatch --wait --array={number} tiles.sbatch")
        self.run_shell("silvafit tiles merge tiles indices --out indices.csv")
        self.check_result()


if __name__ == "__main__":
    unittest.main()
