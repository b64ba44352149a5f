# SPDX-License-Identifier: MIT
"""The package without names that newer versions of pandas and scikit-learn have removed."""
import os
import pathlib
import subprocess
import sys

import pytest

import silvafit as sf

# pandas 2 and 3, scikit-learn 1.6 and 1.7. validate_data stands for the function that replaced the methods.
WITHOUT_OLD_NAMES = '''
import pandas as pd
import numpy as np

for owner, names in ((pd.arrays, ["PandasArray"]), (pd.DataFrame, ["append", "applymap", "iteritems", "lookup"]),
                     (pd.Series, ["append", "iteritems"]),
                     (pd.api.types, ["is_categorical_dtype", "is_interval_dtype", "is_datetime64tz_dtype",
                                     "is_int64_dtype", "is_period_dtype"])):
    for name in names:
        if name in vars(owner):
            delattr(owner, name)

from sklearn.base import BaseEstimator, RegressorMixin
from sklearn.utils import validation

if not hasattr(validation, "validate_data"):
    check_names, check_count, check_all = (getattr(BaseEstimator, name) for name in (
        "_check_feature_names", "_check_n_features", "_validate_data"))

    def validate_data(_estimator, /, X="no_validation", y="no_validation", reset=True, validate_separately=False,
                      skip_check_array=False, **check_params):
        check_names(_estimator, X, reset=reset)
        if skip_check_array:
            check_count(_estimator, X, reset=reset)
            return X if isinstance(y, str) else (X, y)
        for name, kept in (("_check_feature_names", check_names), ("_check_n_features", check_count)):
            setattr(BaseEstimator, name, kept)
        try:
            return check_all(_estimator, X, y, reset=reset, **check_params)
        finally:
            del BaseEstimator._check_feature_names, BaseEstimator._check_n_features

    validation.validate_data = validate_data
    for name in ("_check_feature_names", "_check_n_features", "_validate_data", "_more_tags", "_get_tags"):
        delattr(BaseEstimator, name)
    del RegressorMixin._more_tags

import matplotlib
matplotlib.use("Agg")
import silvafit as sf
from silvafit.sklearn import MixedRegressor

trees = pd.read_csv("tests/reference/data/stands.csv")
for plots in (trees["plot"], trees["plot"].astype("category"), trees["plot"].astype("string")):
    fit = sf.fit("h ~ 1.3 + a*(1 - exp(-b*dbh))", trees.assign(plot=plots), random="a | plot", parameters="b ~ species")
    assert fit.converged and len(fit.random_effects) == 32
fit.plot(groups=["S1P1"])
fit.plot("qq")
sf.fit("h ~ a + b*dbh + c*(day == '2020-05-01')", trees.assign(day=pd.Timestamp("2020-05-01") + pd.to_timedelta(
    trees.index % 2, unit="D")))
inventory = pd.read_csv("examples/fir-mixed/inventory.csv")
inventory = inventory[inventory["plot"] < 3].assign(note="kept")
units = sf.structural_units(inventory)
assert (units["note"] == "kept").all()
inventory.loc[inventory.index[::3], "h"] = np.nan
assert sf.impute(inventory, "h")["h"].notna().all()
X = trees[["dbh", "plot"]]
model = MixedRegressor("M4", random="a | plot").fit(X, trees["h"])
assert list(model.feature_names_in_) == ["dbh", "plot"] and model.score(X, trees["h"]) > 0.5
plain = MixedRegressor().fit(X[["dbh"]].to_numpy(), trees["h"])
assert plain.n_features_in_ == 1 and plain.predict(X[["dbh"]].to_numpy()).shape == (len(X),)
try:
    model.predict(X.rename(columns={"dbh": "diameter"}))
except ValueError as error:
    assert "feature names" in str(error), error
else:
    raise AssertionError("other columns than in the fit")
print("done")
'''


def test_names_that_newer_versions_removed_are_not_used(source):
    pytest.importorskip("sklearn")
    pytest.importorskip("matplotlib")
    environment = dict(os.environ, PYTHONPATH=str(pathlib.Path(sf.__file__).parents[1]))
    done = subprocess.run([sys.executable, "-W", "error::FutureWarning:silvafit", "-c", WITHOUT_OLD_NAMES], cwd=source,
                          env=environment, capture_output=True, text=True, check=False)
    assert done.stdout == "done\n", done.stderr[-3000:]
