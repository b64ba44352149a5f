# SPDX-License-Identifier: MIT
"""Files that the pages speak of by name and that a reader would have: each is made when a command asks for it."""

import re
import shlex
import shutil
import sys
import threading
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[1] / "support"))
from r_export import write_as_r_does

EXAMPLE = "examples/fir-mixed/inventory.csv"
CURVE = "--formula 'h ~ 1.3 + a*(1 - exp(-b*dbh))' --where 'species == \"BHN\"' --json"
PLOT = f"silvafit grow {EXAMPLE} --plot 1 --lod 3 --quiet"
PAIR = "silvafit grow examples/segment-trees/trees-10-and-13.csv --lod 3 --quiet"
STUDY = f"silvafit study {EXAMPLE} --quiet --out"

# The ten rectangles of the example, which its README describes.
PLOTS = r"""awk 'BEGIN { printf "{\"type\": \"FeatureCollection\", \"features\": ["
  for (plot = 1; plot <= 10; plot++) {
    x = plot == 1 ? 100 : (plot - 2) % 3 * 100; y = plot == 1 ? 0 : 50 + int((plot - 2) / 3) * 50
    printf "%s{\"type\": \"Feature\", \"properties\": {\"plot\": \"%d\"}, \"geometry\": {\"type\": \"Polygon\", ", (plot > 1 ? "," : ""), plot
    printf "\"coordinates\": [[[%d,%d],[%d,%d],[%d,%d],[%d,%d],[%d,%d]]]}}", x, y, x + 100, y, x + 100, y + 50, x, y + 50, x, y
  } print "]}" }' > plots.geojson"""

# Name of the file: what makes it in a folder that has a link to the examples.
MADE_BY = {
    # With the columns that pages map to ours.
    "inventory.csv": f"awk -F, -v OFS=, '{{ print $0, NR == 1 ? \"BHD,H_dm\" : $7 OFS 10 * $8 }}' {EXAMPLE} > inventory.csv",
    # Firs with their structural units.
    "trees.csv": f"silvafit indices {EXAMPLE} --quiet --out units.csv && paste -d, {EXAMPLE} <(cut -d, -f 5-8 units.csv) "
                 "| awk -F, 'NR == 1 || $3 == \"SM\"' > trees.csv",
    # A plot that no fit has seen, with every fourth height measured.
    "new.csv": f"awk -F, -v OFS=, 'NR == 1 || $1 == 1 {{ if (NR > 1) {{ $1 = \"new\"; if (NR % 4) $8 = \"\" }} print }}' "
               f"{EXAMPLE} > new.csv",
    # Three plots with every fourth height measured.
    "heights.csv": f"awk -F, -v OFS=, 'NR == 1 || $1 < 4 {{ if (NR > 1 && NR % 4) $8 = \"\"; print }}' {EXAMPLE} > heights.csv",
    # Circles around the centers of the plots.
    "circles.csv": f"""awk -F, -v OFS=, 'NR > 1 {{
      $4 -= 50 + ($1 == 1 ? 100 : ($1 - 2) % 3 * 100); $5 -= 25 + ($1 == 1 ? 0 : 50 + int(($1 - 2) / 3) * 50)
      if ($4 * $4 + $5 * $5 > 144) next }} {{ print }}' {EXAMPLE} > circles.csv""",
    "plots.geojson": PLOTS,
    "plots.csv": """awk 'BEGIN { print "plot,area,stratum"; for (p = 1; p <= 10; p++) print p ",5000," (p < 6 ? "a" : "b") }' > plots.csv""",
    "one.json": f"silvafit fit {EXAMPLE} {CURVE} > one.json",
    "two.json": f"silvafit fit {EXAMPLE} {CURVE} --random 'a | plot' > two.json",
    "three.json": f"silvafit fit {EXAMPLE} {CURVE} --random 'a + b | plot' > three.json",
    "one/library.json": f"{STUDY} one",
    "other/library.json": f"{STUDY} other --criterion bic",
    "predictions.csv": f"{STUDY} a-study && cp a-study/predictions.csv predictions.csv",
    "library.json": f"{STUDY} a-study && cp a-study/library.json library.json",
    "stand.glb": f"{PLOT} --scene stand.glb",
    "tree.glb": "silvafit grow examples/segment-trees/tree-1.csv --lod 2 --quiet --scene tree.glb",
    "own.lsys": r"printf 'axiom: A(1)\niterations: 5\nA(l) -> F(l)[&(50)A(l*0.7)]/(137)A(l*0.9)\n' > own.lsys",
    "a.glb": f"{PAIR} --scene a.glb",
    "b.glb": f"{PAIR} --scene b.glb",
    "c.glb": f"{PAIR} --scene c.glb",
}

# Data that the pages let a reader take from R packages.
FROM_R = ("spati.csv", "alsTree.csv")

WRITES = re.compile(r"--(out|scene|truth|init|html|residuals|excluded)$")


def file_names(command):
    """The words of a command that may be files which it reads."""
    try:
        words = shlex.split(command, comments=True)
    except ValueError:
        return []
    follows = [""] + words[:-1]
    return [word for before, word in zip(follows, words) if not WRITES.search(before) and before != ">"]


class Reader:
    """Somebody who has all these files, in a folder from which every page gets those that it needs."""

    def __init__(self, folder, run):
        """`run` runs a command in the folder, which has a link to the examples."""
        self.folder = folder
        self.run = run
        self.lock = threading.Lock()

    def provide(self, command, page_folder):
        """Gives a page's folder what the command needs and it lacks."""
        for name in file_names(command):
            if (page_folder / name).exists():
                continue
            if name in FROM_R:
                write_as_r_does(name, page_folder / name)
            elif name in MADE_BY:
                with self.lock:
                    if not (self.folder / name).exists():
                        self.run(MADE_BY[name])
                (page_folder / name).parent.mkdir(exist_ok=True)
                shutil.copy(self.folder / name, page_folder / name)
