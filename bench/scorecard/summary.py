# SPDX-License-Identifier: MIT
"""Tables of results, in Markdown."""

import csv
import math
import statistics

import cases

LIKE_NLME = ("lb", "ols", "gnls")  # methods whose log-likelihoods compare with those of nlme and gnls
TOLERANCE = 0.05  # of log-likelihoods: what optimizers leave, and nlme's own tolerance, stay below
BEST_KNOWN = cases.FOLDER / "best_known.csv"


def read_best():
    """(log-likelihood, where it was found) by (case, method)."""
    if not BEST_KNOWN.exists():
        return {}
    with open(BEST_KNOWN, newline="", encoding="utf-8") as file:
        return {(row["case"], row["method"]): (float(row["log_likelihood"]), row["found"]) for row in csv.DictReader(file)}


def write_best(best):
    with open(BEST_KNOWN, "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(("case", "method", "log_likelihood", "found"))
        for (case, method), (value, found) in sorted(best.items()):
            rows.writerow((case, method, f"{value:.4f}", found))


class Score:
    """Results beside what is known of their cases."""

    def __init__(self, results, known_cases, best):
        self.results = results
        self.cases = known_cases
        self.best = best

    def known(self, result):
        """The best known (log-likelihood, where found) of a result's case and method; None if nothing is."""
        method = "lb" if result.method == "nlme" else result.method
        found = [self.best[(result.case, method)]] if (result.case, method) in self.best else []
        case = self.cases.get(result.case)
        if method in LIKE_NLME and case is not None and case.nlme is not None:
            found.append((case.nlme, "nlme"))
        return max(found) if found else None

    def below(self, result):
        """How far a fit that is called converged lies below the best known; 0 if it does not."""
        known = self.known(result)
        if not result.usable() or known is None:
            return 0.0
        amount = known[0] - result.log_likelihood
        return amount if amount > TOLERANCE else 0.0

    def beside_nlme(self, result):
        """Log-likelihood less nlme's; None where either is missing."""
        case = self.cases.get(result.case)
        if case is None or case.nlme is None or result.log_likelihood is None or not result.converged:
            return None
        return result.log_likelihood - case.nlme

    def select(self, family, method):
        return [one for one in self.results if one.family == family and one.method == method]

    def kinds(self):
        order = ["nlme", "lb", "laplace", "focei", "agq", "ols", "gnls", "study"]
        pairs = {(one.family, one.method) for one in self.results}
        families = list(dict.fromkeys(one.family for one in self.results))
        return sorted(pairs, key=lambda pair: (families.index(pair[0]), order.index(pair[1]) if pair[1] in order else 99))


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows])


def share(part, whole):
    return f"{part} ({100 * part / whole:.1f} %)" if whole else "0"


def time_of(result):
    """Seconds of the fit, as the program says; where other work on the machine delayed it, those of the processor for the whole process."""
    return result.cpu_seconds if result.fit_seconds is None else min(result.fit_seconds, result.cpu_seconds)


def seconds(values):
    """Median, what nine in ten stay below, the longest."""
    values = sorted(values)
    if not values:
        return ["", "", ""]
    return [f"{value:.3g}" for value in (statistics.median(values), values[math.ceil(0.9 * len(values)) - 1], values[-1])]


def main_row(score, family, method):
    chosen = score.select(family, method)
    beside = [value for value in map(score.beside_nlme, chosen) if value is not None]
    nlme = [sum(value > TOLERANCE for value in beside), sum(value < -TOLERANCE for value in beside)]
    return [family, method, len(chosen), share(sum(one.converged for one in chosen), len(chosen)),
            sum(score.below(one) > 0 for one in chosen),
            *(nlme if method in LIKE_NLME else ["", ""]), *seconds([time_of(one) for one in chosen])]


HEAD = ["family", "method", "cases", "converged", "converged below the best known", "above nlme", "below nlme", "median [s]", "90 % [s]", "longest [s]"]


def main_table(score):
    return table(HEAD, [main_row(score, *pair) for pair in score.kinds() if pair[1] != "study"])


def before_and_after_table(before, after):
    """Converged, and converged below the best known, of two sets of results for what both have."""
    both = {(one.case, one.method) for one in before.results} & {(one.case, one.method) for one in after.results}
    rows = []
    for family, method in after.kinds():
        cells = []
        for score in (before, after):
            chosen = [one for one in score.select(family, method) if (one.case, one.method) in both]
            times = seconds([time_of(one) for one in chosen])
            cells.append((sum(one.converged for one in chosen), sum(score.below(one) > 0 for one in chosen), times[0], times[2], len(chosen)))
        if cells[0][4]:
            rows.append([family, method, cells[0][4]] + [cells[side][what] for what in range(4) for side in (0, 1)])
    return table(["family", "method", "cases", "converged before", "after", "converged below the best before", "after",
                  "median before [s]", "after", "longest before [s]", "after"], rows)


def bad_cases(score):
    """Called converged, and below the best known: worst first."""
    found = [(score.below(one), one) for one in score.results if score.below(one) > 0 and one.method != "nlme"]
    rows = []
    for amount, one in sorted(found, key=lambda pair: -pair[0]):
        value, where = score.known(one)
        rows.append([one.family, one.case, one.method, f"{one.log_likelihood:.3f}", f"{value:.3f}", where, f"{amount:.3f}"])
    return rows


BAD_HEAD = ["family", "case", "method", "log-likelihood", "best known", "found by", "below by"]


def better_than_known(score):
    """Fits that beat the record: best_known.csv should learn of them."""
    for one in score.results:
        known = score.known(one) if one.method != "nlme" else None
        if one.usable() and known is not None and one.log_likelihood - known[0] > TOLERANCE:
            yield one, one.log_likelihood - known[0], known


def not_converged(score):
    """How many verdicts of each kind, numbers left out."""
    counts = {}
    for one in score.results:
        if not one.converged and one.method != "nlme":
            text = "".join("#" if letter.isdigit() else letter for letter in (one.verdict or one.ended))[:110]
            key = (one.family, one.method, text)
            counts[key] = counts.get(key, 0) + 1
    return [[*key, count] for key, count in sorted(counts.items(), key=lambda pair: (pair[0][0], pair[0][1], -pair[1]))]


def accuracy_rows(score, family, prefix=""):
    """Bias and RMSE of the converged fits of drawn data; in percent of the truth where that is not zero."""
    for method in [pair[1] for pair in score.kinds() if pair[0] == family]:
        chosen = [one for one in score.select(family, method) if one.usable() and one.case.startswith(prefix) and "given" not in one.case]
        if not chosen:
            continue
        truth = score.cases[chosen[0].case].truth
        cells = []
        for name, value in truth.items():
            errors = [one.estimates[name] - value for one in chosen if name in one.estimates]
            if not errors:
                cells.append("")
                continue
            scale = 100 / abs(value) if value else 1.0
            rmse = math.sqrt(statistics.fmean(error**2 for error in errors))
            unit = " %" if value else ""
            cells.append(f"{short(scale * statistics.fmean(errors), True)}, {short(scale * rmse)}{unit}")
        yield [method, len(chosen), *cells]


def short(value, sign=False):
    text = f"{value:.2g}" if abs(value) < 10 else f"{value:.0f}" if abs(value) < 1e4 else f"{value:.1e}"
    return "+" + text if sign and value >= 0 else text


def accuracy_tables(score):
    """One table for each drawn design."""
    texts = []
    designs = {}
    for one in score.results:
        case = score.cases.get(one.case)
        if case is not None and case.truth and one.method != "nlme" and "given" not in one.case:
            designs.setdefault((one.family, one.case.rsplit("-", 1)[0] + "-"), case)
    for (family, prefix), case in designs.items():
        rows = list(accuracy_rows(score, family, prefix))
        texts.append(f"**{prefix[:-1]}**\n\n" + table(["method", "fits", *(f"`{name}`" for name in case.truth)], rows))
    return "\n\n".join(texts)


def degenerate_rows(score):
    """Cases with an expected end: what was expected, what came."""
    by_key = {(one.case, one.method): one for one in score.results}
    for one in score.results:
        case = score.cases.get(one.case)
        if case is not None and case.expected is not None and one.method != "nlme":
            yield one, case.expected.judge(one, by_key.get((case.expected.same_as, one.method)))
