# SPDX-License-Identifier: MIT
"""Runs the program on cases, two at a time, and keeps what the scorecard needs of each answer."""

import concurrent.futures
import csv
import dataclasses
import json
import math
import os
import signal
import subprocess
import sys
import tempfile
import threading


@dataclasses.dataclass
class Result:
    """One case by one method. ended is "yes", or why there is no answer: "time-out", "crash", "refused" (the program said what it will not fit)."""

    family: str
    case: str
    method: str
    log_likelihood: float | None = None
    converged: bool = False
    ended: str = "yes"
    fit_seconds: float | None = None
    cpu_seconds: float = 0.0
    estimates: dict = dataclasses.field(default_factory=dict)
    verdict: str = ""

    def usable(self):
        return self.converged and self.log_likelihood is not None


FIELDS = [field.name for field in dataclasses.fields(Result)]


def run(command, limit):
    """(exit status or None at the limit, both outputs, processor seconds) of a command, which may take so many seconds of processor time.

    The time that passes is limited too, more widely, since other work on the machine may slow a command down.
    """
    limited = ["sh", "-c", f'ulimit -t {math.ceil(limit)}; exec "$@"', "sh", *command]
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        child = subprocess.Popen(limited, stdout=out, stderr=err, stdin=subprocess.DEVNULL)
        timer = threading.Timer(10 * limit, child.kill)
        timer.start()
        _, status, usage = os.wait4(child.pid, 0)
        timer.cancel()
        child.returncode = os.waitstatus_to_exitcode(status)
        texts = []
        for file in (out, err):
            file.seek(0)
            texts.append(file.read().decode("utf-8", "replace"))
        late = -child.returncode in (signal.SIGXCPU, signal.SIGKILL)
        return None if late else child.returncode, *texts, usage.ru_utime + usage.ru_stime


def parameters_of(fit):
    """Coefficients, sd(...), cor(..., ...), sigma and delta by name, of the finer grouping."""
    found = {name: one["estimate"] for name, one in fit["fixed"].items()}
    if fit.get("random"):
        finest = fit["random"][-1]
        names = finest["effects"]
        for i, name in enumerate(names):
            found[f"sd({name})"] = finest["sd"][i]
            for j in range(i):
                found[f"cor({names[j]}, {name})"] = finest["correlation"][i][j]
    found["sigma"] = fit["sigma"]
    if isinstance(fit["variance"].get("delta"), float):
        found["delta"] = fit["variance"]["delta"]
    return {name: value for name, value in found.items() if value is not None}


def errors_of(fit):
    return {f"se({name})": one["se"] for name, one in fit["fixed"].items() if one.get("se") is not None}


def fit(program, case, method, limit, start=""):
    status, out, err, cpu = run([program, *case.arguments(method, start)], limit)
    result = Result(case.family, case.name, method, cpu_seconds=round(cpu, 4))
    try:
        answer = json.loads(out)
    except ValueError:
        result.ended = "time-out" if status is None else "crash" if status < 0 else "refused"
        result.verdict = " ".join(err.split())[:400]
        return result
    value = answer["log_likelihood"]
    result.log_likelihood = value if value is not None and math.isfinite(value) else None
    result.converged = bool(answer["converged"])
    result.fit_seconds = answer["seconds"]
    result.verdict = " ".join(answer["verdict"].split())
    result.estimates = {**parameters_of(answer), **errors_of(answer)}
    return result


def fit_all(program, work, limit, jobs=2):
    """Results of work, a list of (case, method, start), in its order; progress goes to the standard error output."""
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        running = [pool.submit(fit, program, case, method, limit, start) for case, method, start in work]
        for done, _ in enumerate(concurrent.futures.as_completed(running), 1):
            if sys.stderr.isatty() or done % 100 == 0 or done == len(running):
                print(f"\r{done} of {len(running)}", end="", file=sys.stderr, flush=True)
        print(file=sys.stderr)
        return [one.result() for one in running]


def write(path, results):
    with open(path, "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(FIELDS)
        for one in results:
            values = dataclasses.asdict(one)
            values["log_likelihood"] = "" if one.log_likelihood is None else f"{one.log_likelihood:.6f}"
            values["fit_seconds"] = "" if one.fit_seconds is None else f"{one.fit_seconds:.4g}"
            values["converged"] = "yes" if one.converged else "no"
            values["estimates"] = json.dumps({name: float(f"{value:.7g}") for name, value in one.estimates.items()})
            rows.writerow(values[name] for name in FIELDS)


def read(path):
    with open(path, newline="", encoding="utf-8") as file:
        return [Result(row["family"], row["case"], row["method"],
                       float(row["log_likelihood"]) if row["log_likelihood"] else None, row["converged"] == "yes", row["ended"],
                       float(row["fit_seconds"]) if row["fit_seconds"] else None, float(row["cpu_seconds"]),
                       json.loads(row["estimates"] or "{}"), row["verdict"])
                for row in csv.DictReader(file)]
