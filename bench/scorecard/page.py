# SPDX-License-Identifier: MIT
"""Writes the tables of docs/scorecard.md between their marks."""

import re

import inventories
import summary

SHOWN = 40


def overview(score):
    rows = []
    for family, method in score.kinds():
        if method == "study":
            continue
        chosen = score.select(family, method)
        beside = [value for value in map(score.beside_nlme, chosen) if value is not None] if method in summary.LIKE_NLME else None
        rows.append([family, method, len(chosen), sum(one.converged for one in chosen), sum(score.below(one) > 0 for one in chosen),
                     "" if beside is None else sum(value > summary.TOLERANCE for value in beside),
                     "" if beside is None else sum(value < -summary.TOLERANCE for value in beside),
                     *summary.seconds([summary.time_of(one) for one in chosen])])
    return summary.table(["family", "method", "cases", "converged", "below the best known", "above nlme", "below nlme", "median [s]", "90 % [s]", "longest [s]"], rows)


def bad_list(score):
    bad = summary.bad_cases(score)
    if not bad:
        return "None."
    more = f"\n\nand {len(bad) - SHOWN} more." if len(bad) > SHOWN else ""
    return f"{len(bad)} fits:\n\n" + summary.table(summary.BAD_HEAD, bad[:SHOWN]) + more


def degenerate_table(score):
    """How many cases end as they should by all methods, and each method's end of the others."""
    ends = {}
    for one, judgement in summary.degenerate_rows(score):
        ends.setdefault(one.case, {})[one.method] = judgement
    methods = ["lb", "laplace", "focei", "agq"]
    others = {case: by for case, by in ends.items() if set(by.values()) != {"sound"}}
    text = f"{len(ends) - len(others)} of {len(ends)} cases are sound by all methods"
    if not others:
        return text + "."
    return f"{text}. The others:\n\n" + summary.table(["case", *methods], [[case, *(by.get(method, "") for method in methods)] for case, by in others.items()])


def write(score, root):
    parts = {
        "overview": overview(score),
        "worst": bad_list(score),
        "degenerate": degenerate_table(score),
        "inventories": inventories.report(score.results) or "Not run.",
    }
    path = root / "docs" / "scorecard.md"
    text = path.read_text(encoding="utf-8")
    for name, table in parts.items():
        text = re.sub(rf"(<!-- {name} -->\n).*?(<!-- end of {name} -->)", lambda found, table=table: f"{found[1]}\n{table}\n\n{found[2]}", text, flags=re.S)
    path.write_text(text, encoding="utf-8")
    print(f"the tables of {path} are written")
