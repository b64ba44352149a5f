#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Fits many models whose best known log-likelihoods are recorded, and says which fits called converged are not the best.

    bench/scorecard/scorecard.py                                  every family, every method
    bench/scorecard/scorecard.py --family spati --only prodan     a part of them; the expression is searched in "CASE METHOD"
    bench/scorecard/scorecard.py --compare before.csv after.csv   two files of results
    bench/scorecard/scorecard.py --best --family fol              tries many starts, and records in best_known.csv what is better
    bench/scorecard/scorecard.py --page results.csv               writes the tables of docs/scorecard.md
    bench/scorecard/scorecard.py --from-truth --seed 7            fits simulated data also from their true values
    bench/scorecard/scorecard.py --part 3/8                       the third of eight parts, on another machine or in a job of an array
    bench/scorecard/scorecard.py --join part-*.csv                the results of all parts

The program is that of the environment variable SILVAFIT, by default build/bin/silvafit.
"""

import argparse
import itertools
import os
import pathlib
import re
import sys

import best_known
import books
import cases
import curves
import degenerate
import drawn
import fitting
import from_truth
import inventories
import page
import recorded
import spati
import summary

ROOT = cases.FOLDER.parent.parent
FAMILIES = {
    "spati": spati.family,
    "books": books.family,
    "biexp": drawn.biexp,
    "fol": drawn.fol,
    "emax": drawn.emax,
    "degenerate": degenerate.family,
    "subsets": degenerate.subsets,
    "near-singular": drawn.near_singular,
    "curves": curves.family,
    "samples": curves.samples,
}


def options():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=os.environ.get("SILVAFIT", str(ROOT / "build" / "bin" / "silvafit")), help="the silvafit to run")
    parser.add_argument("--family", action="append", choices=[*FAMILIES, "inventories"], help="repeatable; default all")
    parser.add_argument("--only", default="", help="regular expression, searched in CASE METHOD")
    parser.add_argument("--methods", default="", help="of lb,laplace,focei,agq; default those that fit a case")
    parser.add_argument("--seed", type=int, default=1, help="of drawn data; what is recorded of drawn data holds for seed 1")
    parser.add_argument("--time-out", type=float, default=60, help="seconds that one fit may take")
    parser.add_argument("--jobs", type=int, default=2, help="fits at the same time")
    parser.add_argument("--inventories", type=int, default=100, help="how many inventories family inventories draws")
    parser.add_argument("--part", type=part, metavar="K/N", help="only every N-th fit and inventory, from the K-th on")
    parser.add_argument("--join", nargs="+", metavar="RESULTS", help="join the results of all parts, in their order")
    parser.add_argument("--out", help="CSV, a line for each case and method; default build/scorecard/results.csv, of a part part-K.csv")
    parser.add_argument("--folder", help="where drawn data are written; default build/scorecard/data, of a part data-K: parts may run at the same time")
    parser.add_argument("--draw", action="store_true", help="only write the drawn data")
    parser.add_argument("--from-truth", action="store_true", help="compare with fits from the true values of simulated data")
    parser.add_argument("--best", action="store_true", help="look for better fits from many starts and record them")
    parser.add_argument("--results", metavar="RESULTS", help="for --best: fits without a start that need not be made again")
    parser.add_argument("--compare", nargs=2, metavar=("BEFORE", "AFTER"), help="files of results")
    parser.add_argument("--summary", metavar="RESULTS", help="print the tables of a file of results, without running anything")
    parser.add_argument("--page", metavar="RESULTS", help="write the tables of docs/scorecard.md from a file of results")
    chosen = parser.parse_args()
    here = ROOT / "build" / "scorecard"
    chosen.out = chosen.out or str(here / (f"part-{chosen.part[0]}.csv" if chosen.part else "results.csv"))
    chosen.folder = chosen.folder or str(here / (f"data-{chosen.part[0]}" if chosen.part else "data"))
    return chosen


def part(text):
    """(K, N) of "K/N"."""
    number, count = map(int, text.split("/"))
    if not 1 <= number <= count:
        raise argparse.ArgumentTypeError(f"K must be from 1 to {count}")
    return number, count


def own_part(chosen, items):
    return items[chosen.part[0] - 1::chosen.part[1]] if chosen.part else items


def by_number(path):
    """Sorts part-2.csv before part-10.csv."""
    return [int(word) if word.isdigit() else word for word in re.split(r"(\d+)", path)]


def joined(parts):
    """The results of parts 1, ..., N in the order of a run of all."""
    def in_turn(lists):
        return [one for row in itertools.zip_longest(*lists) for one in row if one is not None]

    return [one for is_study in (False, True) for one in in_turn([[one for one in results if (one.method == "study") == is_study] for results in parts])]


def chosen_cases(chosen):
    folder = pathlib.Path(chosen.folder)
    return [case for family in chosen.family or FAMILIES if family in FAMILIES for case in FAMILIES[family](folder, chosen.seed)]


def work(chosen, all_cases):
    """(case, method) that the options ask for."""
    wanted = [word for word in chosen.methods.split(",") if word]
    return [(case, method) for case in all_cases for method in case.methods
            if (not wanted or method in wanted) and re.search(chosen.only, f"{case.name} {method}")]


def with_nlme(results):
    """Before them, what nlme said of the same cases."""
    names = {one.case for one in results}
    return [one for family in dict.fromkeys(one.family for one in results) for one in recorded.results(family).values() if one.case in names] + results


def score_of(results, known, seed):
    return summary.Score(with_nlme(results) if seed == 1 else results, known, summary.read_best() if seed == 1 else {})


def print_summary(score):
    print(summary.main_table(score))
    accuracy = summary.accuracy_tables(score)
    if accuracy:
        print(f"\nBias, RMSE of converged fits (in % of the truth where it is not 0):\n\n{accuracy}")
    unsound = [(one, verdict) for one, verdict in summary.degenerate_rows(score) if verdict != "sound"]
    if unsound:
        print("\nDegenerate data, not as expected:\n")
        print(summary.table(["case", "method", "what", "verdict"], [[one.case, one.method, text, one.verdict[:160]] for one, text in unsound]))
    studies = inventories.report(score.results)
    if studies:
        print("\n" + studies)
    bad = summary.bad_cases(score)
    print(f"\nCalled converged, more than {summary.TOLERANCE} below the best known: {len(bad)}\n")
    if bad:
        print(summary.table(summary.BAD_HEAD, bad))
    for one, amount, (value, where) in summary.better_than_known(score):
        print(f"better than known: {one.case} {one.method} {one.log_likelihood:.3f}, {amount:.3f} above {value:.3f} ({where}); --best records it")
    print("\nNot converged:\n")
    print(summary.table(["family", "method", "verdict", "fits"], summary.not_converged(score)))


def compare(chosen, known):
    before, after = (summary.Score(fitting.read(path), known, summary.read_best()) for path in chosen.compare)
    print(summary.before_and_after_table(before, after))
    bad = [{(row[1], row[2]): row for row in summary.bad_cases(score)} for score in (before, after)]
    in_both = {(one.case, one.method) for one in before.results} & {(one.case, one.method) for one in after.results}
    for title, left, right in (("Mended", bad[0], bad[1]), ("New", bad[1], bad[0])):
        rows = [row for key, row in left.items() if key not in right and key in in_both]
        print(f"\n{title}: {len(rows)}\n")
        if rows:
            print(summary.table(summary.BAD_HEAD, rows))


def write_results(path, results):
    pathlib.Path(path).parent.mkdir(parents=True, exist_ok=True)
    fitting.write(path, results)


def main():
    chosen = options()
    all_cases = chosen_cases(chosen)
    known = {case.name: case for case in all_cases}
    if chosen.draw:
        return
    if chosen.compare:
        compare(chosen, known)
        return
    if chosen.page:
        page.write(score_of(fitting.read(chosen.page), known, chosen.seed), ROOT)
        return
    if chosen.join:
        results = joined([fitting.read(path) for path in sorted(chosen.join, key=by_number)])
        write_results(chosen.out, results)
        print_summary(score_of(results, known, chosen.seed))
        return
    if chosen.summary:
        print_summary(score_of(fitting.read(chosen.summary), known, chosen.seed))
        return
    if not os.access(chosen.program, os.X_OK):
        sys.exit(f"{chosen.program} is not here: build it, or name the program by --program or the environment variable SILVAFIT")
    if chosen.from_truth:
        print(from_truth.report(chosen.program, work(chosen, all_cases), chosen.time_out, chosen.jobs))
        return
    if chosen.best:
        best_known.improve(chosen.program, work(chosen, all_cases), chosen.time_out, chosen.jobs,
                            fitting.read(chosen.results) if chosen.results else [])
        return
    results = fitting.fit_all(chosen.program, [(*one, "") for one in own_part(chosen, work(chosen, all_cases))], chosen.time_out, chosen.jobs)
    if not chosen.family or "inventories" in chosen.family:
        results += inventories.run(chosen, own_part(chosen, list(range(chosen.inventories))))
    write_results(chosen.out, results)
    print_summary(score_of(results, known, chosen.seed))


if __name__ == "__main__":
    main()
