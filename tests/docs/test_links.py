# SPDX-License-Identifier: MIT
"""Links between the pages lead to files and headings that exist, in the checkout as on the site."""

import re
import sys
import unittest
from functools import cache
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
PAGES = [SOURCE / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")]
PAGES += sorted((SOURCE / "docs").rglob("*.md")) + sorted((SOURCE / "examples").glob("*/README.md"))
# What `make docs` writes beside the pages.
ONLY_ON_THE_SITE = {SOURCE / "docs/api/index.html"}


def prose(text):
    """A page without its blocks of code."""
    return re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)


def links(text):
    """(text of the link, target) of links and pictures."""
    return re.findall(r"\[([^\]]*)\]\(([^)\s]+)\)", re.sub(r"`[^`]*`", "`code`", prose(text)))


@cache
def anchors(page):
    """The anchors of a page's headings, as git forges and the site make them."""
    found = {}
    for heading in re.findall(r"^#+ +(.+)$", prose(page.read_text(encoding="utf-8")), re.MULTILINE):
        slug = re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-")
        found[slug] = found.get(slug, 0) + 1
    return {f"{slug}-{i}" if i else slug for slug, count in found.items() for i in range(count)}


def broken(page, target):
    """What is wrong with a link, or nothing."""
    if re.match(r"[a-z]+:", target):
        return ""
    name, _, anchor = target.partition("#")
    file = (page.parent / name).resolve() if name else page
    if not file.exists():
        return "" if file in ONLY_ON_THE_SITE else "there is no such file"
    if anchor and anchor not in anchors(file):
        return "there is no such heading"
    return ""


class Links(unittest.TestCase):
    def test_every_link_leads_somewhere(self):
        count = 0
        faults = []
        for page in PAGES:
            for _, target in links(page.read_text(encoding="utf-8")):
                count += 1
                fault = broken(page, target)
                if fault:
                    faults.append(f"{page.relative_to(SOURCE)}: {target}: {fault}")
        print(f"{count} links of {len(PAGES)} pages", file=sys.stderr)
        self.assertEqual(faults, [])
        self.assertGreater(count, 100)

    def test_every_page_can_be_reached_from_the_home_page(self):
        reached, left = set(), [SOURCE / "docs/index.md"]
        while left:
            page = left.pop()
            reached.add(page)
            for _, target in links(page.read_text(encoding="utf-8")):
                file = (page.parent / target.partition("#")[0]).resolve()
                if file.suffix == ".md" and file.exists() and file not in reached and file not in left:
                    left.append(file)
        missing = {page for page in PAGES if page.parent == SOURCE / "docs"} - reached
        self.assertEqual(sorted(page.name for page in missing), [])

    def test_every_picture_is_shown_somewhere(self):
        shown = {(page.parent / target).resolve() for page in PAGES
                 for _, target in links(page.read_text(encoding="utf-8"))}
        pictures = {file for file in (SOURCE / "docs/pictures").rglob("*") if file.is_file()}
        self.assertEqual(sorted(picture.name for picture in pictures - shown), [])


if __name__ == "__main__":
    unittest.main()
