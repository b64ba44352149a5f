# SPDX-License-Identifier: MIT
"""What users of statsmodels and R expect: their names, with the numbers of R (bench/r/reference_formulas.R)."""
import json

import numpy as np
import pandas as pd
import pytest
from arrow_producer import ArrowTable
from conftest import FORMULA

import silvafit as sf

# Linear least squares: both programs have nearly all digits; R's file has 15.
LINEAR = 1e-9
# R's nls stops at a relative offset of 1e-9, so that estimates have about 7 digits.
NLS = 1e-6
# nlme stops at its tolerances; F values depend on their squares.
NLME = 5e-4


@pytest.fixture(scope="module")
def expected(source):
    return json.loads((source / "tests/reference/expected/formulas.json").read_text())["fits"]


@pytest.fixture(scope="module")
def linear(stands):
    return sf.fit("log(h) ~ a + b*log(dbh)", stands)


def test_the_names_of_statsmodels_have_the_numbers_of_lm(linear, expected):
    reference = expected["log_h"]
    for name in ("params", "bse", "tvalues"):
        assert getattr(linear, name).to_numpy() == pytest.approx(reference[name], rel=LINEAR), name
    assert list(linear.params.index) == ["a", "b"]
    assert linear.pvalues.to_numpy() == pytest.approx(reference["pvalues"], rel=1e-6, abs=1e-300)
    assert linear.llf == pytest.approx(reference["llf"], rel=LINEAR)
    assert linear.scale == pytest.approx(reference["scale"], rel=LINEAR)
    assert linear.rsquared == pytest.approx(reference["rsquared"], rel=LINEAR)
    assert linear.conf_int(0.1).to_numpy() == pytest.approx(np.array(reference["conf_int"]), rel=LINEAR)
    assert list(linear.conf_int().columns) == [0, 1]
    assert linear.cov_params().to_numpy() == pytest.approx(np.array(reference["cov_params"]), rel=LINEAR)
    # Residuals are differences of numbers near 3.
    assert linear.resid.iloc[:10].to_numpy() == pytest.approx(reference["resid"], rel=1e-8, abs=1e-12)
    assert linear.fittedvalues.iloc[:10].to_numpy() == pytest.approx(reference["fittedvalues"], rel=LINEAR)


def test_predictions_have_the_limits_of_predict_lm(linear, expected):
    reference = expected["log_h"]
    frame = linear.get_prediction({"dbh": reference["dbh"]}).summary_frame(alpha=0.1)
    assert list(frame.columns) == ["mean", "mean_se", "mean_ci_lower", "mean_ci_upper", "obs_ci_lower", "obs_ci_upper"]
    for name in ("mean", "mean_se"):
        assert frame[name].to_numpy() == pytest.approx(reference[name], rel=LINEAR)
    for name in ("mean_ci", "obs_ci"):
        assert frame[[f"{name}_lower", f"{name}_upper"]].to_numpy() == pytest.approx(np.array(reference[name]), rel=LINEAR)


def test_predictions_read_a_stream_once(linear, stands):
    stream, other = (ArrowTable(stands[["dbh"]], text="u") for _ in range(2))
    prediction = linear.get_prediction(stream)
    assert prediction.summary_frame().reset_index(drop=True).equals(linear.get_prediction(stands).summary_frame())
    linear.predict(other)
    assert stream.made == other.made


def test_mixed_fits_have_the_names_too(mixed, stands):
    assert mixed.fe_params.equals(mixed.params) and mixed.bse_fe.equals(mixed.standard_errors)
    assert mixed.cov_re.equals(mixed.random_covariance)
    explained = 1.0 - (mixed.resid**2).sum() / ((stands["h"] - stands["h"].mean()) ** 2).sum()
    assert mixed.rsquared == pytest.approx(explained, rel=1e-9)
    assert (stands["h"] - mixed.fittedvalues).to_numpy() == pytest.approx(mixed.resid.to_numpy(), abs=1e-9)
    assert mixed.fitted("population").equals(mixed.predict(level="population"))
    prediction = mixed.get_prediction(stands, level="population")
    assert prediction.predicted_mean.to_numpy() == pytest.approx(mixed.fitted("population").to_numpy())
    assert (prediction.conf_int(obs=True)["upper"] > prediction.conf_int()["upper"]).all()


def test_combinations_of_coefficients_are_tested(linear, expected, mixed):
    reference = expected["log_h"]
    beta, covariance = np.array(reference["params"]), np.array(reference["cov_params"])
    assert (linear.df_model, linear.df_resid) == (2, linear.nobs - 2)
    # Each coefficient alone is the row of the table of lm().
    alone = linear.t_test(np.eye(2))
    assert alone["t"].to_numpy() == pytest.approx(reference["tvalues"], rel=LINEAR)
    assert alone["p"].to_numpy() == pytest.approx(reference["pvalues"], rel=1e-6, abs=1e-300)
    # b = 0.5 and a - 2 b = 1 by hand: the difference from the value, and the error by L V L'.
    rows, values = np.array([[0.0, 1.0], [1.0, -2.0]]), np.array([0.5, 1.0])
    tests = linear.t_test("b = 0.5, a - 2*b = 1")
    assert tests["effect"].to_numpy() == pytest.approx(rows @ beta, rel=LINEAR)
    error = np.sqrt(np.diag(rows @ covariance @ rows.T))
    assert tests["t"].to_numpy() == pytest.approx((rows @ beta - values) / error, rel=1e-8)
    assert linear.t_test((rows, values)).equals(tests) and (tests["df"] == linear.df_resid).all()
    difference = rows @ beta - values
    joint = linear.wald_test(["b = 0.5", "a - 2*b = 1"])
    assert joint["statistic"] == pytest.approx(difference @ np.linalg.solve(rows @ covariance @ rows.T, difference) / 2, rel=1e-7)
    assert (joint["df"], joint["df_denominator"]) == (2, linear.df_resid)
    assert linear.wald_test("b").equals(linear.f_test("b = 0"))
    assert linear.wald_test("b")["statistic"] == pytest.approx(reference["tvalues"][1] ** 2, rel=LINEAR)
    terms = mixed.update(parameters={"a": "species"}, data=mixed.data.assign(species=np.where(mixed.data.index % 2, "A", "B")))
    name = next(name for name in terms.params.index if "species" in name)
    assert terms.t_test(f"`{name}` = 0")["t"][0] == pytest.approx(terms.tvalues[name])
    for text, match in (("b*b = 1", "multiplied by numbers"), ("c = 1", "unknown name 'c'"), ("a = b = 1", "several ="), ("a +", "cannot be read"),
                        ("exp(a)", "may have")):
        with pytest.raises(sf.UsageError, match=match):
            linear.t_test(text)
    with pytest.raises(sf.UsageError, match="a number for each coefficient: a, b"):
        linear.t_test(np.eye(3))


def test_expressions_are_responses(linear, stands):
    column = sf.fit("log_h ~ a + b*log(dbh)", stands.assign(log_h=np.log(stands["h"])))
    assert linear.response == "log(h)" and column.params.equals(linear.params)
    again = sf.Fit.from_json(linear.to_json()).with_data(stands)
    assert again.resid.equals(linear.resid)
    mixed = sf.fit("h/dbh ~ a + b*log(dbh)", stands, random="a | plot")
    new = stands[stands["plot"] == "S1P1"].assign(plot="new")
    own = stands.assign(ratio=stands["h"] / stands["dbh"])
    expected = sf.fit("ratio ~ a + b*log(dbh)", own, random="a | plot").calibrate(
        new.assign(ratio=new["h"] / new["dbh"]))
    assert mixed.calibrate(new).equals(expected)
    assert mixed.predict(new[["dbh"]], level="population").notna().all()
    by_library = sf.Library.of(mixed).predict(new, level="calibrated")["h/dbh_pred"]
    assert by_library.to_numpy() == pytest.approx(mixed.predict(new, level="calibrated").to_numpy(), rel=1e-12)
    with pytest.raises(sf.InputError, match="not defined") as caught:
        sf.fit("log(h) ~ a + b*dbh", stands.assign(h=stands["h"].where(stands.index != 7, -1.0)))
    assert caught.value.row == 7
    with pytest.raises(sf.InputError, match="did you mean.*dbh|dbh"):
        sf.fit("log(hh) ~ a + b*dbh", stands)
    with pytest.raises(sf.FormulaError, match="write log"):
        sf.fit("h ~ a + b*np.log(dbh)", stands)


def test_self_starting_models_are_those_of_nls(expected, stands):
    for reference in expected["self_starting"]:
        fit = sf.fit(reference["formula"], stands)
        assert fit.converged
        for name, value in reference["params"].items():
            assert fit.params[name] == pytest.approx(value, rel=NLS), reference["formula"]
        assert fit.llf == pytest.approx(reference["llf"], rel=1e-9)
    named = sf.fit("h ~ SSlogis(scal = s, dbh, Asym = top, middle)", stands)
    assert list(named.params) == pytest.approx(list(sf.fit("h ~ top/(1 + exp((middle - dbh)/s))", stands).params))
    with pytest.raises(sf.FormulaError, match=r"SSlogis\(input, Asym, xmid, scal\)"):
        sf.fit("h ~ SSlogis(dbh, Asym)", stands)


def test_terms_are_tested_as_by_nlme(expected, stands):
    reference = expected["terms"]
    sizes = pd.cut(stands["crowding"], [-np.inf, *reference["limits"], np.inf], labels=["low", "medium", "high"])
    # The reference of a factor does not change the tests of the others.
    trees = stands.assign(size=sizes)
    mixed = sf.fit("h ~ 1.3 + a*(1 - exp(-b*dbh/10))", trees, random="a | plot", parameters={"a": "size + species"})
    tests = mixed.wald_test_terms()
    assert list(tests.index) == ["a", "a:size", "a:species", "b"]
    theirs = pd.DataFrame(reference["mixed"]).set_index("names")
    assert list(tests["df"]) == list(theirs["df"])
    assert list(tests["df_denominator"]) == list(theirs["df_denominator"])
    for ours, name in (("a:size", "a.size"), ("a:species", "a.species"), ("b", "b")):
        assert tests.loc[ours, "statistic"] == pytest.approx(theirs.loc[name, "F"], rel=NLME)
    assert tests.loc["a:species", "p"] == pytest.approx(theirs.loc["a.species", "p"], rel=NLME)
    plain = sf.fit("h ~ a + b*dbh", trees, parameters=["a ~ size", "b ~ size"]).wald_test_terms()
    theirs = pd.DataFrame(reference["linear"]).set_index("names")
    assert plain.loc["b:size", "statistic"] == pytest.approx(theirs.loc["size:dbh", "F"], rel=1e-7)
    assert plain.loc["b:size", "p"] == pytest.approx(theirs.loc["size:dbh", "p"], rel=1e-6)
    assert plain.loc["a:size", "statistic"] == pytest.approx(theirs.loc["size", "F"], rel=1e-7)
    held = sf.fit("h ~ a + b*dbh", stands, hold={"b": 0.3}).wald_test_terms()
    assert list(held.index) == ["a"]


def test_fits_are_updated(mixed, stands):
    simpler = mixed.update(variance=None, random="a | plot")
    assert simpler.loglik == sf.fit(FORMULA, stands, random="a | plot").loglik
    other = mixed.update("M4", random=None)
    assert other.model == "M4" and other.variance == "power" and other.random is None
    with pytest.raises(sf.UsageError, match="'crowding'; give the data"):
        mixed.update("h ~ 1.3 + a*(1 - exp(-b*dbh)) + c*crowding")
    with_covariate = mixed.update(parameters={"b": "1 + crowding"}, data=stands)
    assert with_covariate.parameters == {"b": "1 + crowding"}
    assert with_covariate.update(parameters=with_covariate.parameters).loglik == with_covariate.loglik
    read = sf.Fit.from_json(mixed.to_json())
    assert read.update(data=stands).loglik == pytest.approx(mixed.loglik, rel=1e-9)
    with pytest.raises(sf.UsageError, match="varience.*did you mean variance"):
        mixed.update(varience="power")


def test_levels_have_the_numbers_of_nlme(mixed, stands):
    assert mixed.predict(stands, level=0).equals(mixed.predict(stands, level="population"))
    assert mixed.predict(stands, level=1).equals(mixed.predict(stands))
    nested = sf.fit(FORMULA, stands, random="a | stand/plot")
    assert nested.predict(stands, level=2).equals(nested.predict(stands))
    with pytest.raises(sf.UsageError, match="level"):
        nested.predict(stands, level=1)


def test_words_of_other_packages(mixed, stands):
    assert mixed.residuals("raw").equals(mixed.residuals("response"))
    for theirs, ours in (("mean", "confidence"), ("obs", "prediction")):
        assert mixed.predict(interval=theirs).equals(mixed.predict(interval=ours))
    restricted = sf.fit(FORMULA, stands, random="a + b | plot", method="REML", covariance="pdDiag")
    assert restricted.reml and restricted.method == "lb"
    assert restricted.loglik == sf.fit(FORMULA, stands, random="a + b | plot", reml=True, covariance="diagonal").loglik
    assert not restricted.update(method="ML").reml
    for formula in ("h ~ a + b*dbh + C(species)", "h ~ a + b*dbh + factor(species)"):
        with pytest.raises(sf.FormulaError, match="sub-model"):
            sf.fit(formula, stands)


def test_missing_groups_are_pointed_out(mixed, stands):
    new = stands.head(2).assign(plot=None)
    with pytest.warns(UserWarning, match="plot missing"):
        assert mixed.predict(new).equals(mixed.predict(new, level="population"))
