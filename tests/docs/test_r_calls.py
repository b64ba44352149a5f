# SPDX-License-Identifier: MIT
"""The R calls of from-nlme.md run, and their log-likelihoods are those of the commands below them.

A block of R whose last value is a fit belongs to the first `silvafit fit` of the block of commands that follows. Where the two
are not the same likelihood, a comment before the R block says by how much ours may lie above:

    <!-- not above by more than 0.5: reason -->
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from pages import blocks, commands

SOURCE = Path(__file__).resolve().parents[2]
PAGE = SOURCE / "docs/from-nlme.md"
PROGRAM = os.environ["SILVAFIT_PROGRAM"]
ABOVE = re.compile(r"<!-- not above by more than ([\d.]+): .* -->\n+```r\n")

# nlme stops at a relative change of 1e-5 (default) of its parameters, beside the point where both of its steps stand
# still; the largest difference found on these data is a quarter of this.
TOLERANCE = 1e-3

READ = r"""
suppressPackageStartupMessages(library(nlme))
evaluate <- function(index, text) {
  value <- NULL
  capture.output(for (call in parse(text = text)) value <- eval(call, globalenv()))
  likelihood <- tryCatch(as.numeric(logLik(value)), error = function(e) NA)
  if (inherits(value, c("lme", "gls", "nls", "lm"))) cat(index, sprintf("%.10f", likelihood), "\n")
}
"""


def has_nlme():
    if not shutil.which("Rscript"):
        return False
    return subprocess.run(["Rscript", "-e", "library(nlme)"], capture_output=True, check=False).returncode == 0


def r_blocks(text):
    return [(line, "\n".join(lines)) for line, language, lines, _ in blocks(text) if language == "r"]


def allowed_above(text):
    """By line of an R block: how much ours may lie above."""
    return {text[: match.end()].count("\n") + 1: float(match.group(1)) for match in ABOVE.finditer(text)}


@unittest.skipUnless(has_nlme(), "R with nlme is not installed")
class Calls(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="silvafit-r-")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        for name in ("examples", "tests"):
            (self.folder / name).symlink_to(SOURCE / name)

    def run_in_folder(self, *arguments):
        done = subprocess.run(arguments, cwd=self.folder, capture_output=True, text=True, timeout=600, check=False)
        self.assertEqual(done.returncode, 0, f"{arguments}\n{done.stderr}")
        return done.stdout

    def likelihoods_of_r(self, pieces):
        """By line of a block: the log-likelihood of the fit that it ends with."""
        script = READ + "".join(f"evaluate({line}, {json.dumps(text)})\n" for line, text in pieces)
        (self.folder / "page.R").write_text(script, encoding="utf-8")
        printed = self.run_in_folder("Rscript", "--vanilla", "page.R")
        return {int(line): float(value) for line, value in (row.split() for row in printed.splitlines())}

    def likelihoods_of_ours(self):
        """By line: the log-likelihood of each fit, after what its block does before it."""
        found = {}
        for command in commands("page", PAGE.read_text(encoding="utf-8")):
            is_fit = command.text.startswith("silvafit fit")
            text = command.text.split(" > ")[0] + " --json --quiet" * ("--json" not in command.text) if is_fit else command.text
            if is_fit or command.text.startswith("awk"):
                environment = os.environ | {"PATH": f"{Path(PROGRAM).parent}:{os.environ['PATH']}"}
                done = subprocess.run(["bash", "-c", text], cwd=self.folder, env=environment, capture_output=True,
                                      text=True, timeout=60, check=False)
                self.assertEqual(done.returncode, 0, f"{command.text}\n{done.stderr}")
            if is_fit:
                found[command.line] = json.loads(done.stdout)["log_likelihood"]
        return found

    def test_r_and_silvafit_reach_the_same_likelihood(self):
        text = PAGE.read_text(encoding="utf-8")
        above = allowed_above(text)
        self.assertEqual(len(above), text.count("<!-- not above"))
        pieces = r_blocks(text)
        r = self.likelihoods_of_r(pieces)
        ours = self.likelihoods_of_ours()
        compared = 0
        for line, value in r.items():
            following = [piece for piece, _ in pieces if piece > line] + [10**9]
            below = [number for number in ours if line < number < following[0]]
            if not below:
                continue
            difference = ours[below[0]] - value
            with self.subTest(line=line):
                self.assertGreaterEqual(difference, -TOLERANCE)
                self.assertLessEqual(difference, above.get(line, TOLERANCE))
            compared += 1
            print(f"line {line}: R {value:.6f}, silvafit {ours[below[0]]:.6f}", file=sys.stderr)
        self.assertGreater(compared, 20)


if __name__ == "__main__":
    unittest.main()
