# SPDX-License-Identifier: MIT
"""The runs of an attack: a command, its inputs of which some are changed, and its options."""

import json
import random
import shutil
import subprocess
from pathlib import Path

import mutations

EXAMPLES = Path(__file__).parents[2] / "examples"
GRAMMARS = Path(__file__).parents[1] / "fuzz" / "corpus" / "grammar"

# The file of each input, and what changes it.
CHANGES = {".csv": mutations.of_table, ".json": mutations.of_json, ".geojson": mutations.of_json, ".gltf": mutations.of_json,
           ".glb": mutations.of_glb, ".lsys": mutations.of_grammar, ".xlsx": mutations.of_workbook, ".ods": mutations.of_workbook,
           ".gpkg": mutations.of_layers}

FORMULAS = ["h ~ 1.3 + a*(1 - exp(-b*dbh))", "h ~ 1.3 + a*dbh^b", "h ~ a + b*log(dbh)", "cw ~ a + b*dbh", "hcb ~ h/(1 + exp(a + b*dbh))",
            "h ~ 1.3 + ifelse(dbh > 20, a, b)*sqrt(dbh)"]
MODELS = ["M4", "M5", "M17", "M22", "M14", "all:h", "M99"]
RANDOM = ["a | plot", "a + b | plot", "b | species", "a | species; a | plot", "a + b + c | plot", "a | tree"]
COLUMNS = ["dbh=dbh/10", "h=hcb*2", "x=y,y=x", "plot=species", "cw=`cw`", "dbh=ifelse(h > 10, dbh, h)", "x=x*1e6", "tree=plot", "h=h/0"]


def write_inputs(program, folder):
    """Writes the inputs that runs change: an inventory of 240 trees and what the program makes of it."""
    folder.mkdir(parents=True)
    lines = (EXAMPLES / "fir-mixed" / "inventory.csv").read_text(encoding="utf-8").splitlines()
    body = [line for line in lines[1:] if line.split(",")[2] == "SM" and line.split(",")[0] in "12345"]
    some = [line for plot in "12345" for line in [row for row in body if row.startswith(plot + ",")][:48]]
    (folder / "inventory.csv").write_text("\n".join([lines[0], *some]) + "\n", encoding="utf-8")
    (folder / "few.csv").write_text("\n".join([lines[0], *some[:6]]) + "\n", encoding="utf-8")
    shutil.copy(EXAMPLES / "fir-mixed" / "window.geojson", folder / "window.geojson")
    design = json.loads((EXAMPLES / "fir-mixed" / "design.json").read_text(encoding="utf-8"))
    design["plots"], design["species"] = design["plots"][:2], design["species"][:2]
    (folder / "design.json").write_text(json.dumps(design), encoding="utf-8")
    for name in ("honda", "fir", "odd"):
        shutil.copy(GRAMMARS / f"{name}.lsys", folder)

    def run(*words, out=None):
        done = subprocess.run([program, *words, "--quiet"], cwd=folder, capture_output=True, check=True)
        if out:
            (folder / out).write_bytes(done.stdout)

    run("study", "inventory.csv", "--out", "study", "--edge", "none", "--minimum-trees", "40")
    for name in ("library.json", "predictions.csv", "run.json"):
        shutil.copy(folder / "study" / name, folder)
    settings = json.loads((folder / "run.json").read_text(encoding="utf-8"))["options"]
    settings["candidates"] = {"h": ["M4", "M5"], "hcb": ["M17"], "cw": ["M22"]}
    (folder / "settings.json").write_text(json.dumps(settings), encoding="utf-8")
    shutil.rmtree(folder / "study")
    for name, random_effects in (("one.json", "a | plot"), ("two.json", "a + b | plot")):
        run("fit", "inventory.csv", "--model", "M4", "--random", random_effects, "--json", out=name)
    run("grow", "few.csv", "--scene", "stand.glb", "--lod", "3")
    run("grow", "few.csv", "--scene", "packed.glb", "--lod", "3", "--share", "--models", "2", "--instancing", "--compress")
    run("grow", "few.csv", "--scene", "stand.gltf", "--lod", "3")
    # Without the module of GDAL, the commands that read these end with the message that says so.
    for name in LAYERED:
        if subprocess.run([program, "indices", "inventory.csv", "--out", name, "--quiet"], cwd=folder, capture_output=True, check=False).returncode:
            (folder / name).write_bytes(b"no GDAL")


LAYERED = ["trees.xlsx", "trees.ods", "trees.gpkg"]
LAYERS = {"--layer": ["trees", "plots", "Sheet1", "trees.csv"],
          "--sql": ["select * from trees", "select * from trees where dbh > 20", "select plot, tree, x, y, dbh, h from trees order by dbh",
                    "select count(*) from trees", "attach 'out/x.db' as x", "drop table trees"]}

# Options: name, and values that make sense; none: a flag.
COMMON = {"--threads": ["1", "2", "4"], "--seed": ["1", "7"], "--json": None, "--quiet": None}
TABLE = {"--columns": COLUMNS, "--missing": ["-9", "-88,unknown"], "--fill-down": ["plot", "plot,species"]}
INVENTORY = {"--trust-units": None, "--case-sensitive": None, "--dead": ["leave-out", "neighbors", "include"], "--alive-codes": ["1", "LI"], "--dead-codes": ["2", "x,y"], "--cut-codes": ["3"], **TABLE}
UNITS = {"--neighbors": ["1", "3", "4", "8"], "--alpha": ["72", "60,SM=80"], "--edge": ["buffer", "hanisch", "torus", "none"],
         "--buffer": ["0", "2", "5"], "--window": ["window.geojson"], "--circle": ["0,0,20", "150,25,30"], "--per": ["plot", "stand"],
         "--dominance": ["dbh", "h", "cw"], "--crowding": ["mean", "facing"], "--further": ["CO,T", "Hegyi,BAL,CCF", "BAL"],
         "--competition-radius": ["5", "10"], "--open-grown": ["0.9 + 0.22*dbh"]}
DIGITS = {"--digits": ["3", "17"]}
FIT = {"--formula": FORMULAS, "--model": MODELS, "--random": RANDOM, "--variance": ["power", "exponential", "constant-plus-power", "power(dbh)"],
       "--method": ["ols", "gnls", "lb", "foce", "focei", "laplace", "agq"]}
PLANTS = {"--plot": ["1", "1,2"], "--lod": ["3", "2,3"], "--models": ["2", "6"], **INVENTORY}

# Inputs that may be changed, words before the options, and options.
COMMANDS = {
    "study": (["inventory.csv", "settings.json", "window.geojson"], ["study", "inventory.csv", "--out", "out", "--config", "settings.json"],
              {"--species": ["SM"], "--responses": ["h", "h,cw"], "--covariates": ["C", "W,M"], "--group": ["plot", "species"],
               "--criterion": ["aic", "aicc", "bic", "cv"], "--minimum-trees": ["20", "40"], **INVENTORY, **UNITS}),
    "init": (["inventory.csv"], ["study", "inventory.csv", "--init", "out/study.json"], INVENTORY),
    "indices": (["inventory.csv", "window.geojson"], ["indices", "inventory.csv"],
                {"--out": ["out/indices.csv"], "--excluded": ["out/excluded.csv"], "--stream": None, **INVENTORY, **UNITS}),
    "stand": (["inventory.csv", "window.geojson"], ["stand", "inventory.csv"],
              {"--out": ["out"], "--layers": ["10", "5,15"], "--quadrat": ["5", "10"], "--dominant-trees": ["100"], "--class-width": ["2", "4"],
               "--plot-area": ["5000"], "--stratum": ["species", "plot"], "--stratum-area": ["SM=3"], **INVENTORY, **UNITS}),
    "fit": (["inventory.csv"], ["fit", "inventory.csv"],
            {**FIT, "--parameter": ["a ~ 1 + species", "b ~ 1 + cw"], "--covariance": ["general", "diagonal", "identity"], "--reml": None,
             "--trace": None, "--fix": ["a=30"], "--bound": ["b=0:1", "a=0:"], "--start": ["a=30,b=0.03"], "--starts": ["2"],
             "--bootstrap": ["5"], "--resample": ["parametric", "cases"], "--bootstrap-level": ["0.9"], "--cross-validate": ["3", "leave-one-out"],
             "--measured-trees": ["2"], "--group": ["plot"], "--residuals": ["out/residuals.csv"], "--where": ["dbh > 20", 'plot == "1"'],
             "--intervals": ["wald", "profile"], "--level": ["0.9"], "--agq-points": ["3"], "--trust-units": None, **TABLE}),
    "compare": (["one.json", "two.json"], ["compare", "one.json", "two.json"], {"--html": ["out/page.html"]}),
    "compare libraries": (["library.json"], ["compare", "library.json", "shanxia-2023"], {"--html": ["out/page.html"]}),
    "predict": (["library.json", "inventory.csv"], ["predict", "library.json", "inventory.csv"],
                {"--level": ["population", "conditional", "calibrated", "marginal"], "--new-groups": ["population", "marginal", "missing", "error"],
                 "--seen-groups": ["fitted", "new", "combined"], "--interval": ["0.95"], "--interval-kind": ["prediction", "confidence"],
                 "--standard-errors": None, "--role": ["ols", "covariates", "nlme"], "--out": ["out/p.csv"], "--case-sensitive": None,
                 "--trust-units": None, **DIGITS, **TABLE}),
    "impute": (["inventory.csv"], ["impute", "inventory.csv"],
               {**FIT, "--response": ["h", "hcb", "cw"], "--by": ["species", "plot"], "--minimum-trees": ["10"], "--add-residual": None,
                "--out": ["out/i.csv"], "--group": ["plot"], "--case-sensitive": None, "--trust-units": None, **DIGITS, **TABLE}),
    "library show": (["library.json"], ["library", "show", "library.json"], {}),
    "library scenes": (["library.json"], ["library", "scenes", "library.json"],
                       {"--out": ["out/scenes.csv"], "--species": ["SM"], "--dbh": ["SM=20"], "--group": ["1"], "--role": ["ols", "nlme"],
                        "--uniform-angle": ["0.25", "1"], "--spacing": ["10"]}),
    "grow": (["few.csv"], ["grow", "few.csv"],
             {"--scene": ["out/s.glb", "out/s.obj", "out/s.ply", "out/s.gltf"], "--out": ["out"], "--use": ["observed", "population"],
              "--preset": ["fir", "broadleaf"], "--format": ["glb", "gltf", "obj", "ply"], "--resolve-overlaps": None,
              "--ground": ["stems", "flat", "none"], "--share": None, "--instancing": None, "--quantize": None, "--compress": None,
              "--ascii": None, "--plain": None, "--builder": ["segment", "lsystem", "ifs", "bamboo"], "--by": ["species", "plot"],
              "--animate": None, "--seconds": ["2"], **PLANTS}),
    "grow predictions": (["predictions.csv"], ["grow", "predictions.csv", "--plot", "1", "--lod", "3", "--scene", "out/s.glb"],
                         {"--use": ["ols", "population", "conditional"], "--share": None, "--resolve-overlaps": None}),
    "grow grammar": (["few.csv", "honda.lsys", "fir.lsys", "odd.lsys"], ["grow", "few.csv", "--builder", "lsystem", "--scene", "out/s.glb"],
                     {"--grammar": ["honda.lsys", "fir.lsys", "odd.lsys"], "--lod": ["2", "3"]}),
    "view": (["few.csv"], ["view", "few.csv", "--no-open", "--out", "out/v.html"], {"--title": ["A stand"], **PLANTS}),
    "view scene": (["stand.glb", "packed.glb"], ["view", "stand.glb", "--no-open", "--out", "out/v.html"],
                   {"--trees": ["few.csv"], "--title": ["A stand"]}),
    "render": (["stand.glb", "packed.glb", "stand.gltf"], ["render", "stand.glb", "--out", "out/p.png", "--size", "40x30", "--samples", "1"],
               {"--camera": ["200,12"], "--view": ["35"], "--zoom": ["2"], "--sun": ["135,45"], "--date": ["2023-06-21T15:00+08:00"],
                "--place": ["31,117"], "--turntable": ["2"], "--no-ground": None}),
    "simulate": (["design.json"], ["simulate", "design.json", "--out", "out/i.csv"], {"--truth": ["out/t.json"]}),
    "study workbook": (["inventory.csv"], ["study", "inventory.csv", "--out", "out", "--config", "settings.json", "--workbook", "out/all.xlsx"],
                       {"--species": ["SM"], "--responses": ["h"], "--minimum-trees": ["20"], **INVENTORY}),
    "indices layers": (LAYERED, ["indices", "trees.xlsx"],
                       {"--out": ["out/indices.csv", "out/trees.gpkg", "out/trees.xlsx", "out/trees.ods"], "--excluded": ["out/excluded.csv"],
                        "--stream": None, "--window-layer": ["plots", "trees"], "--window": ["trees.gpkg"], **LAYERS, **INVENTORY}),
    "fit layers": (LAYERED, ["fit", "trees.xlsx", "--model", "M4"],
                   {"--random": RANDOM, "--where": ["dbh > 20"], "--residuals": ["out/residuals.csv"], **LAYERS, **TABLE}),
    "predict layers": (LAYERED, ["predict", "one.json", "trees.xlsx"],
                       {"--out": ["out/p.csv", "out/p.gpkg", "out/p.xlsx"], "--level": ["population", "calibrated"], **LAYERS, **TABLE}),
    "view layers": (LAYERED, ["view", "trees.xlsx", "--no-open", "--out", "out/v.html", "--lod", "3", "--plot", "1"], {**LAYERS, **TABLE}),
    "models": ([], ["models"], {"--response": ["h", "hcb"], "--builders": None}),
}

# Inputs that stand in for the one that a command names.
INSTEAD = {"view scene": ("stand.glb", ["stand.glb", "packed.glb"]), "render": ("stand.glb", ["stand.glb", "packed.glb", "stand.gltf"]),
           **{name: ("trees.xlsx", LAYERED) for name in ("indices layers", "fit layers", "predict layers", "view layers")},
           "predict": ("library.json", ["library.json", "one.json", "shanxia-2023"])}


def _value(draw, values):
    """Mostly a value that makes sense; else a changed or an odd one. Files keep their folder."""
    sensible = draw.choice(values)
    if draw.random() < 0.75 or sensible.startswith("out"):
        return sensible
    odd = mutations.of_text(draw, sensible) if draw.random() < 0.5 else mutations.value(draw)
    # The system allows no zero byte; absolute paths and ".." may be written where a person asks for it.
    return odd.replace("\0", "").replace("/", "_").replace("..", "._")


def _options(draw, all_options):
    words = []
    for name in draw.sample(sorted(all_options), min(len(all_options), draw.choice([0, 1, 1, 2, 3, 5]))):
        words.append(name)
        if all_options[name] is not None:
            words.append(_value(draw, all_options[name]))
    return words


def make(seed, number, inputs, folder):
    """Writes the inputs of a run into a folder; returns the name of the command and the words after the program's name."""
    draw = random.Random(f"{seed}-{number}")
    name = draw.choice([key for key, (_, _, options) in COMMANDS.items() for _ in range(2 if options else 1)])
    files, words, options = COMMANDS[name]
    words = [*words]
    if name in INSTEAD:
        usual, others = INSTEAD[name]
        words[words.index(usual)] = draw.choice(others)
    words += _options(draw, {**options, **COMMON})
    if name == "fit" and not {"--formula", "--model"} & {*words}:
        words += draw.choice([["--formula", draw.choice(FORMULAS)], ["--model", draw.choice(MODELS)]])
    if name == "grow" and not {"--scene", "--out"} & {*words}:
        words += ["--out", "out"]
    if name.startswith("grow") and "--lod" not in words:
        words += ["--lod", "3"]
    used = {*files} | ({*words} & {path.name for path in inputs.iterdir()})
    changed = {file for file in files if draw.random() < (0.7 if len(files) == 1 else 0.35)}
    if "stand.gltf" in used:
        used.add("stand.bin")
    for file in sorted(used):
        data = (inputs / file).read_bytes()
        suffix = Path(file).suffix
        (folder / file).write_bytes(CHANGES[suffix](draw, data) if file in changed and suffix in CHANGES else data)
    return name, words
