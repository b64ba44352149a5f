# SPDX-License-Identifier: MIT
"""The page on formulas names every function that a formula can call."""

import re
import unittest
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]


class Functions(unittest.TestCase):
    def test_all_are_on_the_page(self):
        source = (SOURCE / "libdata/src/expression/operation.cpp").read_text(encoding="utf-8")
        names = re.findall(r'Function\{"(\w+)"', source)
        page = (SOURCE / "docs/formula-language.md").read_text(encoding="utf-8")
        self.assertGreater(len(names), 20)
        for name in names:
            with self.subTest(name):
                self.assertIn(f"`{name}(", page)


if __name__ == "__main__":
    unittest.main()
