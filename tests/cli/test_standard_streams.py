# SPDX-License-Identifier: MIT
"""The program with standard streams that are closed or full, as scripts, cron and disks that run full leave them."""

import subprocess
import unittest

from silvafit_program import PROGRAM, ProgramTest, stand_csv


def with_closed(stream):
    """The shell's `>&-` and `2>&-`."""
    return ["sh", "-c", f'exec "$0" "$@" {stream}>&-', PROGRAM]


class StandardStreams(ProgramTest):
    def status(self, command, *arguments, **streams):
        return subprocess.run([*command, *arguments], cwd=self.folder, timeout=120, check=False,
                              **{"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL} | streams).returncode

    def test_exit_statuses_do_not_need_standard_error(self):
        self.write("stand.csv", stand_csv())
        for arguments, status in ((["models"], 0), (["--nonsense"], 2), (["fit", "nothing.csv", "--model", "M4"], 3),
                                  (["fit", "stand.csv", "--model", "M4", "--trace"], 0)):
            with open("/dev/full", "w", encoding="utf-8") as full:
                self.assertEqual(self.status([PROGRAM], *arguments, stderr=full), status, arguments)
            self.assertEqual(self.status(with_closed(2), *arguments), status, arguments)

    def test_notes_do_not_go_into_files_in_place_of_a_closed_standard_error(self):
        self.write("stand.csv", "plot,tree,species,x,y,dbh\n" + "".join(
            f"1,{i},SM,{3 * (i % 5)},{3 * (i // 5)},{10 + i}\n" for i in range(25)) + "1,26,SM,1,1,-5\n")
        arguments = ["indices", "stand.csv", "--edge", "none"]
        self.assertIn("1 of 26 rows skipped", self.run_program(*arguments, "--out", "whole.csv").stderr)
        self.assertEqual(self.status(with_closed(2), *arguments, "--out", "other.csv"), 0)
        self.assertEqual((self.folder / "other.csv").read_bytes(), (self.folder / "whole.csv").read_bytes())

    def test_results_for_a_closed_standard_output_are_an_error(self):
        self.write("stand.csv", stand_csv())
        for arguments in (["models"], ["fit", "stand.csv", "--model", "M4", "--json"]):
            self.assertEqual(self.status(with_closed(1), *arguments), 5, arguments)


if __name__ == "__main__":
    unittest.main()
