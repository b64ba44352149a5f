# SPDX-License-Identifier: MIT
"""--version: the version in the first line, then how the program was built."""

import json
import re
import subprocess
import unittest
from pathlib import Path

from silvafit_program import ProgramTest

SOURCE = Path(__file__).resolve().parents[2]


def git(*arguments):
    return subprocess.run(["git", "-C", SOURCE, *arguments], capture_output=True, text=True, check=False)


class Version(ProgramTest):
    def test_the_first_line_is_the_version_of_the_project(self):
        project = (SOURCE / "CMakeLists.txt").read_text(encoding="utf-8")
        version = re.search(r"project\(silvafit VERSION (\S+)", project).group(1)
        printed = self.run_program("--version").stdout
        self.assertEqual(printed.splitlines()[0], f"silvafit {version}")

    def test_json_says_the_same(self):
        printed = self.run_program("--version").stdout
        for order in (["--version", "--json"], ["--json", "--version"]):
            build = json.loads(self.run_program(*order).stdout)
            self.assertEqual(build["schema"], "silvafit-version/1")
            self.assertIn(f"silvafit {build['silvafit']}\n", printed)
            for key in ("compiler", "build_type", "vector_instructions"):
                self.assertRegex(printed, rf"(?m)^{key.replace('_', ' ')} +{re.escape(build[key])}$")

    def test_a_build_from_a_checkout_names_its_revision(self):
        top = git("rev-parse", "--show-toplevel")
        if top.returncode != 0 or Path(top.stdout.strip()) != SOURCE:
            self.skipTest("this is no git checkout")
        head = git("rev-parse", "--short=12", "HEAD").stdout.strip()
        build = self.run_json("--version")
        self.assertRegex(build["revision"], rf"^{head}( with changes)?$")

    def test_json_needs_version_where_there_is_no_command(self):
        self.assertIn("--version", self.run_program("--json", "models", status=2).stderr)


if __name__ == "__main__":
    unittest.main()
