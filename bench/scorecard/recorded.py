# SPDX-License-Identifier: MIT
"""What R's nlme said of the cases: files of results like our own, so that nothing here needs R."""

import functools

import cases
import fitting


@functools.lru_cache
def results(family):
    """Results of nlme by case; drawn families are those of seed 1."""
    name = family if family in ("spati", "books") else "drawn"
    path = cases.FOLDER / "recorded" / f"nlme-{name}.csv"
    return {one.case: one for one in fitting.read(path) if one.family == family} if path.exists() else {}


def log_likelihoods(family):
    """nlme's log-likelihood by case, None where it failed."""
    return {case: one.log_likelihood if one.converged else None for case, one in results(family).items()}
