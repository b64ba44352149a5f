# SPDX-License-Identifier: MIT
"""What mkdocs does to our pages besides turning them into HTML; mkdocs.yml names this file.

The pages are written for reading in the checkout, too. Three things differ on the site: links to files outside of docs/
become their paths, pages that the navigation does not name come under More, and files of Debian packages (KaTeX), of
doxygen, of the package for R and of scripts/python-pages come along.
"""

import logging
import os
import re
from pathlib import Path

from mkdocs.structure.files import File

log = logging.getLogger("mkdocs.plugins.site_hooks")

# Of scripts/python-pages; the notebook is there only where it was run.
PYTHON_PAGES = {"python-reference.md": "Python reference", "python-notebook.md": "Python notebook"}
KATEX = Path("/usr/share/javascript/katex")
RENDER = """document.addEventListener("DOMContentLoaded", () => {
  for (const element of document.querySelectorAll(".arithmatex")) {
    renderMathInElement(element, {delimiters: [
      {left: "\\\\[", right: "\\\\]", display: true}, {left: "\\\\(", right: "\\\\)", display: false}]});
  }
});
"""

OUTSIDE = re.compile(r"\[([^\]]+)\]\(\.\./([^)#]+)(#[^)]*)?\)")
CODE_SPAN = re.compile(r"`[^`]+`")


def names_in(nav):
    """The files that a navigation names, at any depth."""
    if isinstance(nav, str):
        return {nav}
    entries = nav.values() if isinstance(nav, dict) else nav
    return {name for entry in entries for name in names_in(entry)}


def generated(config):
    """The folder of what scripts/build-site has made besides docs/."""
    return Path(config["site_dir"]).parent / "site-parts"


def on_config(config):
    # The references of the packages for R and Python, and the vignettes, if they were made.
    made = [f"r/{path.name}" for path in sorted((generated(config) / "r").glob("*.md"))]
    made += [{title: name} for name, title in PYTHON_PAGES.items() if (generated(config) / "python" / name).exists()]
    if made:
        config["nav"].append({"R and Python": made})
    pages = {str(path.relative_to(config["docs_dir"])) for path in Path(config["docs_dir"]).rglob("*.md")}
    others = sorted(pages - names_in(config["nav"]))
    if others:
        config["nav"].append({"More": others})
    return config


def on_files(files, config):
    for file in list(files):
        if file.src_path in ("Doxyfile", "api.dox"):
            files.remove(file)

    def add(path, folder):
        files.append(File(path, str(folder), config["site_dir"], use_directory_urls=False))

    parts = generated(config)
    (parts / "katex").mkdir(parents=True, exist_ok=True)
    (parts / "katex/render.js").write_text(RENDER, encoding="utf-8")
    add("katex/render.js", parts)
    for name in ("katex.min.css", "katex.min.js", "contrib/auto-render.js"):
        add(f"katex/{name}", KATEX.parent)
    for font in sorted((KATEX / "fonts").glob("*.woff2")):
        add(f"katex/fonts/{font.name}", KATEX.parent)
    for folder, base in (("api", parts), ("r", parts), ("python", parts / "python")):
        for path in sorted((parts / folder).rglob("*")):
            if path.is_file():
                add(os.path.relpath(path, base), base)
    return files


def on_page_markdown(markdown, page, config, files):
    checkout = Path(config["config_file_path"]).parent

    def path_for_link(match):
        if not (checkout / match.group(2)).exists():
            log.warning("%s: there is no %s", page.file.src_path, match.group(2))
        path = f"`{match.group(2)}`"
        return path if match.group(1) == match.group(2) else f"{match.group(1)} ({path})"

    markdown = OUTSIDE.sub(path_for_link, markdown)
    # In tables a bar inside of code is written \|; Python-Markdown would show the backslash.
    lines = [
        CODE_SPAN.sub(lambda span: span.group().replace("\\|", "|"), line) if line.startswith("|") else line
        for line in markdown.split("\n")
    ]
    return "\n".join(lines)
