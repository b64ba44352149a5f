# SPDX-License-Identifier: MIT
"""Looks for better fits than those that are recorded: other starts, other methods' ends, contained models."""

import csv
import dataclasses
import statistics

import cases
import fitting
import spati
import summary

DISTINCT = 0.05  # two starts are the same where no coefficient differs by more than this share
MOST_STARTS = 4
SLICE = 300


def group_starts(program, wanted, limit, jobs):
    """Medians of the coefficients of least-squares fits to the single groups, by (data, formula): as nlsList starts nlme."""
    keys = {(case.data, case.formula): case for case, _ in wanted
            if case.family in ("spati", "books") and "|" in case.random and ";" not in case.random and "/" not in case.random and not case.parameters}
    work, places = [], []
    for key, case in keys.items():
        column = case.random.split("|")[1].strip()
        with open(case.data, newline="", encoding="utf-8") as file:
            groups = dict.fromkeys(row[column] for row in csv.DictReader(file))
        alone = dataclasses.replace(case, random="", variance="", covariance="")
        for group in groups:
            work.append((dataclasses.replace(alone, options=("--where", f'{column} == "{group}"')), "ols", ""))
            places.append(key)
    ends = {}
    for key, result in zip(places, fitting.fit_all(program, work, limit, jobs)):
        if result.usable():
            ends.setdefault(key, []).append(coefficients(result))
    return {key: {name: statistics.median(one[name] for one in fits) for name in fits[0]} for key, fits in ends.items() if len(fits) > 2}


def coefficients(result):
    return {name: value for name, value in result.estimates.items()
            if not name.startswith(("sd(", "se(", "cor(")) and name not in ("sigma", "delta")}


def differ(one, other):
    return set(one) != set(other) or any(abs(one[name] - other[name]) > DISTINCT * max(abs(one[name]), abs(other[name])) for name in one)


def starts_of(case, method, defaults, medians):
    """(where from, text) of the starts to try."""
    found = list(case.starts.items())
    ideas = [("medians of groups", medians.get((case.data, case.formula)))]
    if case.family == "spati":
        ideas.append(("linearised curve", spati.linearised(case.name.split("-")[0])))
    mine = [one for one in defaults if one.case == case.name and one.method != method]
    relatives = {other.case for other in defaults} - {case.name}
    same_model = [one for one in defaults if one.case in relatives and case.family in ("spati", "books") and one.family == case.family
                  and one.case.split("-")[0] == case.name.split("-")[0]]
    ideas += [(f"{one.method}'s end" if one.case == case.name else f"{one.method}'s end of {one.case}", coefficients(one))
              for one in mine + same_model if one.estimates]
    own = next((coefficients(one) for one in defaults if one.case == case.name), None)
    kept = []
    for where, values in ideas:
        if values and (not own or set(values) == set(own)) and all(differ(values, other) for _, other in kept):
            kept.append((where, values))
    return found + [(where, cases.start_text(values)) for where, values in kept[:MOST_STARTS]]


def improve(program, wanted, limit, jobs, results=()):
    """Records in best_known.csv the best log-likelihood of converged fits, and of models that a case contains.

    results are fits without a start that need not be made again; all methods' ends of a case are starts for each of its methods.
    """
    made = {(one.case, one.method) for one in results}
    names = {case.name for case, _ in wanted}
    defaults = [one for one in results if one.case in names]
    defaults += fitting.fit_all(program, [(case, method, "") for case, method in wanted if (case.name, method) not in made], limit, jobs)
    medians = group_starts(program, wanted, limit, jobs)
    work, whence, whose = [], [], []
    for case, method in wanted:
        for where, start in starts_of(case, method, defaults, medians):
            work.append((case, method, start))
            whence.append("start: " + where)
            whose.append((case.name, method))
        if method in cases.MIXED:
            for why, smaller in cases.contained(case, (method,)):
                work.append((smaller, smaller.methods[0], ""))
                whence.append("contained: " + why)
                whose.append((case.name, method))
    keep([(one.case, one.method) for one in defaults], ["no start"] * len(defaults), defaults)
    # In slices, so that little is lost where this is interrupted.
    for first in range(0, len(work), SLICE):
        part = slice(first, first + SLICE)
        keep(whose[part], whence[part], fitting.fit_all(program, work[part], limit, jobs))


def keep(keys, where_from, results):
    """Puts what is better than the record into it."""
    best = summary.read_best()
    for key, where, result in zip(keys, where_from, results):
        # A tiny gain is no reason to call the record by another name.
        if result.usable() and (key not in best or result.log_likelihood > best[key][0] + 0.002):
            best[key] = (result.log_likelihood, where)
    summary.write_best(best)
