# SPDX-License-Identifier: MIT
"""Compares fits without start values with fits that start from the true values of simulated data, of any seed."""

import fitting
import summary

START = "the truth"
HEAD = ["family", "method", "cases", "converged", "from the truth", "converged lower than from the truth", "converged only from the truth"]


def is_lower(usual, best):
    return usual.usable() and best.usable() and usual.log_likelihood < best.log_likelihood - summary.TOLERANCE


def report(program, work, limit, jobs):
    """A table by family and method, and a line for each worse fit."""
    work = [(case, method) for case, method in work if START in case.starts]
    ends = fitting.fit_all(program, [(case, method, start) for case, method in work for start in ("", case.starts[START])], limit, jobs)
    pairs = list(zip(ends[::2], ends[1::2]))
    rows = []
    for kind in dict.fromkeys((usual.family, usual.method) for usual, _ in pairs):
        mine = [(usual, best) for usual, best in pairs if (usual.family, usual.method) == kind]
        rows.append([*kind, len(mine), sum(usual.usable() for usual, _ in mine), sum(best.usable() for _, best in mine),
                     sum(is_lower(usual, best) for usual, best in mine), sum(best.usable() and not usual.usable() for usual, best in mine)])
    lines = [f"{usual.case} {usual.method}: {usual.log_likelihood}, from the truth {best.log_likelihood}; {usual.verdict[:100]}"
             for usual, best in pairs if is_lower(usual, best) or (best.usable() and not usual.usable())]
    return "\n".join([summary.table(HEAD, rows), "", *lines])
