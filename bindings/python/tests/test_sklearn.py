# SPDX-License-Identifier: MIT
"""The estimator in scikit-learn's own checks, in cross-validation and in pipelines."""
import inspect
import warnings

import numpy as np
import pandas as pd
import pytest
from conftest import FORMULA

pytest.importorskip("sklearn")
from sklearn.base import clone  # noqa: E402
from sklearn.compose import TransformedTargetRegressor  # noqa: E402
from sklearn.linear_model import LinearRegression  # noqa: E402
from sklearn.model_selection import GridSearchCV, GroupKFold, cross_val_score  # noqa: E402
from sklearn.pipeline import make_pipeline  # noqa: E402
from sklearn.preprocessing import StandardScaler  # noqa: E402
from sklearn.utils.estimator_checks import check_estimator  # noqa: E402

import silvafit as sf  # noqa: E402
from silvafit.sklearn import MixedRegressor  # noqa: E402

try:
    from sklearn.utils.estimator_checks import estimator_checks_generator  # scikit-learn 1.6

    CHECKS = list(estimator_checks_generator(MixedRegressor()))
except ImportError:
    CHECKS = list(check_estimator(MixedRegressor(), generate_only=True))
#: The argument of cross_val_score with those of fit.
FIT_PARAMS = "params" if "params" in inspect.signature(cross_val_score).parameters else "fit_params"


@pytest.mark.parametrize("estimator, check", CHECKS, ids=[getattr(check, "func", check).__name__ for _, check in CHECKS])
def test_checks_of_scikit_learn(estimator, check):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", sf.ConvergenceWarning)
        check(estimator)


def test_without_groups_it_is_least_squares(stands):
    X = stands[["dbh", "crowding"]]
    ours = MixedRegressor().fit(X, stands["h"])
    theirs = LinearRegression().fit(X, stands["h"])
    assert ours.predict(X) == pytest.approx(theirs.predict(X), rel=1e-9)
    assert ours.score(X, stands["h"]) == pytest.approx(theirs.score(X, stands["h"]), rel=1e-9)


def test_groups_by_column_and_by_argument_are_the_same(stands):
    X = stands[["dbh", "plot"]]
    by_column = MixedRegressor(FORMULA, random="a + b | plot").fit(X, stands["h"])
    by_argument = MixedRegressor(FORMULA, random="a + b").fit(X[["dbh"]], stands["h"], groups=stands["plot"])
    assert by_column.fit_.loglik == by_argument.fit_.loglik
    conditional = by_column.predict(X)
    assert conditional == pytest.approx(by_argument.predict(X[["dbh"]], groups=stands["plot"]))
    assert conditional == pytest.approx(by_column.fit_.fitted().to_numpy())
    with pytest.raises(sf.UsageError, match="need the groups.*level='population'"):
        by_argument.predict(X[["dbh"]])
    without = by_argument.set_params(level="population").predict(X[["dbh"]])
    assert without == pytest.approx(by_column.fit_.predict(X, level="population").to_numpy())
    with pytest.raises(sf.UsageError, match="random='a . plot'"):
        MixedRegressor(FORMULA, random="a").fit(X, stands["h"])
    linear = MixedRegressor().fit(X[["dbh"]], stands["h"], groups=stands["plot"])
    assert linear.fit_.random == "intercept | group"


def test_cross_validation_by_groups(stands):
    X, y, plots = stands[["dbh", "plot"]], stands["h"], stands["plot"]
    folds = GroupKFold(4)
    scores = cross_val_score(MixedRegressor(FORMULA, random="a | plot"), X, y, groups=plots, cv=folds)
    by_hand = []
    for train, test in folds.split(X, y, plots):
        fit = sf.fit(FORMULA, stands.iloc[train], random="a | plot")
        error = y.iloc[test] - fit.predict(stands.iloc[test], level="population")
        by_hand.append(1 - (error**2).sum() / ((y.iloc[test] - y.iloc[test].mean()) ** 2).sum())
    assert scores == pytest.approx(by_hand, rel=1e-9)
    with_parameter = cross_val_score(MixedRegressor(FORMULA, random="a", level="population"), X[["dbh"]], y, groups=plots,
                                     cv=folds, **{FIT_PARAMS: {"groups": plots.to_numpy()}})
    assert with_parameter == pytest.approx(by_hand, rel=1e-9)


def test_pipelines_clones_and_searches(stands):
    X = stands[["dbh", "crowding"]]
    scaled = make_pipeline(StandardScaler(), MixedRegressor(level="population"))
    scaled.fit(X, stands["h"], mixedregressor__groups=stands["plot"])
    plain = MixedRegressor(level="population").fit(X, stands["h"], groups=stands["plot"])
    assert scaled.predict(X) == pytest.approx(plain.predict(X), rel=1e-6)
    model = MixedRegressor(FORMULA, random="a | plot", variance="power")
    assert clone(model).get_params() == model.get_params()
    search = GridSearchCV(model, {"random": ["a | plot", "b | plot"]}, cv=GroupKFold(3))
    search.fit(stands[["dbh", "plot"]], stands["h"], groups=stands["plot"])
    assert search.best_params_["random"] in ("a | plot", "b | plot")


def test_groups_need_effects(stands):
    with pytest.raises(sf.UsageError, match="random='a'"):
        MixedRegressor(FORMULA).fit(stands[["dbh"]], stands["h"], groups=stands["plot"])


def test_arrays_have_columns_x0_and_so_on(stands):
    array = stands[["dbh"]].to_numpy()
    model = MixedRegressor("h ~ 1.3 + a*(1 - exp(-b*x0))").fit(array, stands["h"].to_numpy())
    assert model.fit_.fixed_effects.to_numpy() == pytest.approx(sf.fit(FORMULA, stands).fixed_effects.to_numpy())
    assert isinstance(model.predict(array), np.ndarray) and isinstance(stands, pd.DataFrame)


def test_the_name_on_the_left_is_y_and_a_function_of_it_is_refused(stands):
    by_id = MixedRegressor("M4", random="a | plot").fit(stands[["dbh", "plot"]], stands["h"].rename("height"))
    assert by_id.fit_.model == "M4"
    assert by_id.fit_.loglik == sf.fit("M4", stands, random="a | plot").loglik
    for left in ("height", "`total height`", "h.m"):
        assert MixedRegressor(f"{left} ~ a + b*dbh").fit(stands[["dbh"]], stands["h"]).score(stands[["dbh"]], stands["h"]) == pytest.approx(
            LinearRegression().fit(stands[["dbh"]], stands["h"]).score(stands[["dbh"]], stands["h"]), rel=1e-12)
    for left in ("log(h)", "h - 1.3", "h/dbh"):
        with pytest.raises(sf.UsageError, match="TransformedTargetRegressor") as caught:
            MixedRegressor(f"{left} ~ a + b*log(dbh)").fit(stands[["dbh"]], stands["h"])
        assert caught.value.column == "formula"
    logarithm = TransformedTargetRegressor(MixedRegressor("h ~ a + b*log(dbh)"), func=np.log, inverse_func=np.exp)
    logarithm.fit(stands[["dbh"]], stands["h"])
    assert logarithm.regressor_.fit_.fixed_effects.to_numpy() == pytest.approx(
        np.polynomial.polynomial.polyfit(np.log(stands["dbh"]), np.log(stands["h"]), 1), rel=1e-9)


def test_groups_are_named_once(stands):
    X, y = stands[["dbh", "plot"]], stands["h"]
    with pytest.raises(sf.UsageError, match="omit one of them") as caught:
        MixedRegressor(FORMULA, random="a | plot").fit(X, y, groups=stands["species"])
    assert caught.value.column == "groups"
    assert MixedRegressor(FORMULA, random="a | plot", method="REML").fit(X, y).fit_.reml


def test_new_groups_are_calibrated_from_their_measured_trees(stands):
    folds, y, plots = GroupKFold(4), stands["h"], stands["plot"]
    few = y.where(stands.groupby("plot").cumcount() < 3)
    X = stands[["dbh", "plot"]].assign(some_h=few)
    model = MixedRegressor(FORMULA, random="a | plot", level="calibrated", measured="some_h")
    train, test = next(folds.split(X, y, plots))
    predicted = model.fit(X.iloc[train], y.iloc[train]).predict(X.iloc[test])
    new = stands.iloc[test].assign(h=few.iloc[test])
    expected = sf.fit(FORMULA, stands.iloc[train], random="a | plot").predict(new, level="calibrated")
    assert predicted == pytest.approx(expected.to_numpy(), rel=1e-12)
    # The trees of three heights say much of a plot: better than the population in all folds.
    plain = MixedRegressor(FORMULA, random="a | plot")
    assert (cross_val_score(model, X, y, groups=plots, cv=folds) > cross_val_score(plain, X, y, groups=plots, cv=folds)).all()
    with pytest.raises(sf.UsageError, match="measured='h_measured'"):
        MixedRegressor(FORMULA, random="a | plot", level="calibrated").fit(X, y).predict(X)


def test_a_feature_called_group_is_no_column_of_groups():
    table = pd.DataFrame({"x": np.arange(12.0), "group": np.arange(12.0) % 5})
    with pytest.raises(sf.UsageError, match="a feature is called group"):
        MixedRegressor("y ~ a + b*x + c*group", random="a").fit(table, 2.0 * table.x, groups=[1, 2, 3] * 4)
