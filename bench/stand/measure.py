#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Seconds, memory and bytes of large scenes: bench/stand/measure.py PROGRAM FOLDER [--large]

Writes stands of simulated trees into FOLDER, grows them with PROGRAM and prints a table. Trees are drawn by this script from
a fixed seed: three species, heights 5 to 25 m, 2.5 m apart. --large adds a million trees.
"""

import os
import random
import subprocess
import sys
import time
from pathlib import Path

HEADER = "plot,tree,species,x,y,z,dbh,h,hcb,cw\n"


def write_stand(path, trees):
    if path.exists():
        return
    draw = random.Random(1)
    side = int(trees ** 0.5 + 1)
    with path.open("w", encoding="utf-8") as file:
        file.write(HEADER)
        for i in range(trees):
            h = draw.uniform(5, 25)
            x = 2.5 * (i % side) + draw.uniform(-0.5, 0.5)
            y = 2.5 * (i // side) + draw.uniform(-0.5, 0.5)
            z = 0.02 * x + 3 * (y / 100) ** 0.5 if y > 0 else 0.02 * x
            file.write(f"{1 + i // 1000},{i},{draw.choice(['SM', 'BHN', 'MH'])},{x:.2f},{y:.2f},{z:.2f},"
                       f"{h * draw.uniform(0.8, 1.5):.1f},{h:.1f},{h * draw.uniform(0.2, 0.5):.1f},"
                       f"{draw.uniform(1.5, 5):.2f}\n")


def measure(program, stand, scene, options):
    start = time.perf_counter()
    child = subprocess.Popen([program, "grow", str(stand), "--scene", str(scene), "--quiet", *options],
                             stdout=subprocess.PIPE, text=True)
    out = child.stdout.read()
    _, status, usage = os.wait4(child.pid, 0)
    if status != 0:
        sys.exit(f"{options} failed with {status}")
    words = out.split()
    return {"wall": time.perf_counter() - start, "cpu": usage.ru_utime + usage.ru_stime,
            "memory": usage.ru_maxrss / 1024, "bytes": scene.stat().st_size, "triangles": int(words[2])}


def main():
    program, folder = sys.argv[1], Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    runs = [(10_000, "each tree its own, level 3", ["--lod", "3"]),
            (10_000, "the same, packed", ["--lod", "3", "--compress"]),
            (10_000, "shared models, level 2", ["--share", "--lod", "2"]),
            (10_000, "shared, instanced, packed", ["--share", "--lod", "2", "--instancing", "--compress"]),
            (1_000, "level 0, plain", ["--lod", "0", "--ground", "none"]),
            (1_000, "level 0, packed", ["--lod", "0", "--ground", "none", "--compress"]),
            (1_000, "level 3, overlaps resolved", ["--lod", "3", "--resolve-overlaps"])]
    if "--large" in sys.argv:
        runs.append((1_000_000, "shared, instanced, packed, no ground",
                     ["--share", "--lod", "2", "--instancing", "--compress", "--ground", "none"]))
    print(f"{'trees':>9}  {'how':38} {'wall s':>8} {'cpu s':>8} {'peak MB':>8} {'file MB':>8} {'B/tree':>9} {'B/triangle':>10}")
    for trees, how, options in runs:
        stand = folder / f"stand-{trees}.csv"
        write_stand(stand, trees)
        scene = folder / "scene.glb"
        seen = measure(program, stand, scene, options)
        shared = "--share" in options
        each = f"{'' if shared else format(seen['bytes'] / seen['triangles'], '10.1f'):>10}"
        print(f"{trees:9}  {how:38} {seen['wall']:8.1f} {seen['cpu']:8.1f} {seen['memory']:8.0f} "
              f"{seen['bytes'] / 1e6:8.1f} {seen['bytes'] / trees:9.0f} {each}", flush=True)
        scene.unlink()


if __name__ == "__main__":
    main()
