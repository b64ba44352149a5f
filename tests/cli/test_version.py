# SPDX-License-Identifier: MIT
"""--version: the version in the first line, then how the program was built."""

import json
import re
import shutil
import subprocess
import unittest
from pathlib import Path

from silvafit_program import ProgramTest

SOURCE = Path(__file__).resolve().parents[2]


def git(folder, *arguments):
    return subprocess.run(["git", "-C", folder, *arguments], capture_output=True, text=True, check=False)


def found(file, pattern):
    return re.search(pattern, (SOURCE / file).read_text(encoding="utf-8"), re.MULTILINE).group(1)


class Version(ProgramTest):
    def test_the_first_line_is_the_version_of_the_project(self):
        version = found("CMakeLists.txt", r"project\(silvafit VERSION (\S+)")
        printed = self.run_program("--version").stdout
        self.assertEqual(printed.splitlines()[0], f"silvafit {version}")
        # Formats that need a copy of it.
        self.assertEqual(found("bindings/r/DESCRIPTION", r"^Version: (\S+)"), version)
        self.assertEqual(found("CITATION.cff", r"^version: (\S+)"), version)
        self.assertEqual(found("debian/changelog", r"^silvafit \((\S+)\)"), version)

    def test_json_says_the_same(self):
        printed = self.run_program("--version").stdout
        for order in (["--version", "--json"], ["--json", "--version"]):
            build = json.loads(self.run_program(*order).stdout)
            self.assertEqual(build["schema"], "silvafit-version/1")
            self.assertIn(f"silvafit {build['silvafit']}\n", printed)
            for key in ("compiler", "build_type", "vector_instructions"):
                self.assertRegex(printed, rf"(?m)^{key.replace('_', ' ')} +{re.escape(build[key])}$")

    def test_a_build_from_a_checkout_names_one_of_its_revisions(self):
        revision = self.run_json("--version")["revision"]
        if revision is None:
            self.skipTest("the program was not built from a git checkout")
        # Not always the present one: somebody may have committed since the program was built.
        self.assertRegex(revision, "^[0-9a-f]{12}( with changes)?$")
        self.assertEqual(git(SOURCE, "cat-file", "-e", f"{revision[:12]}^{{commit}}").returncode, 0)

    def test_json_needs_version_where_there_is_no_command(self):
        self.assertIn("--version", self.run_program("--json", "models", status=2).stderr)


@unittest.skipUnless(shutil.which("git") and shutil.which("cmake"), "git or cmake is not installed")
class Revision(ProgramTest):
    def setUp(self):
        super().setUp()
        self.source = self.folder / "source"
        self.source.mkdir()
        (self.source / "file").write_text("one\n", encoding="utf-8")

    def commit(self):
        git(self.folder, "init", "--quiet", self.source)
        git(self.source, "add", "file")
        done = git(self.source, "-c", "user.name=A", "-c", "user.email=a@example.org", "commit", "-m", "One")
        self.assertEqual(done.returncode, 0, done.stderr)
        return git(self.source, "rev-parse", "--short=12", "HEAD").stdout.strip()

    def revision(self, source):
        header = self.folder / "revision.hpp"
        subprocess.run(
            ["cmake", f"-DSOURCE={source}", f"-DHEADER={header}", "-P", SOURCE / "cmake/revision.cmake"], check=True
        )
        return re.search(r'SILVAFIT_REVISION "(.*)"', header.read_text(encoding="utf-8")).group(1)

    def test_it_is_the_last_commit_and_says_whether_files_differ(self):
        head = self.commit()
        self.assertEqual(self.revision(self.source), head)
        (self.source / "file").write_text("two\n", encoding="utf-8")
        self.assertEqual(self.revision(self.source), f"{head} with changes")

    def test_there_is_none_outside_of_a_checkout_and_inside_of_another_one(self):
        self.assertEqual(self.revision(self.source), "")
        self.commit()
        (self.source / "unpacked").mkdir()
        self.assertEqual(self.revision(self.source / "unpacked"), "")


if __name__ == "__main__":
    unittest.main()
