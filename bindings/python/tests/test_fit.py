# SPDX-License-Identifier: MIT
"""Fits of DataFrames: what they contain, their indices, and the numbers of the program."""
import copy
import json
import pickle

import numpy as np
import pandas as pd
import pytest
from conftest import FORMULA

import silvafit as sf


def assert_same_json(ours, theirs, path=""):
    """The program's JSON to 1e-12 relative; only times and the source of the rows differ."""
    if isinstance(ours, dict):
        assert set(ours) == set(theirs), path
        for key in ours:
            if key != "seconds":
                assert_same_json(ours[key], theirs[key], f"{path}/{key}")
    elif isinstance(ours, list):
        assert len(ours) == len(theirs), path
        for place, (one, other) in enumerate(zip(ours, theirs)):
            assert_same_json(one, other, f"{path}/{place}")
    elif isinstance(ours, float) and isinstance(theirs, (int, float)):
        assert ours == pytest.approx(theirs, rel=1e-12, abs=1e-300), path
    else:
        assert ours == theirs, path


@pytest.mark.parametrize("arguments, options", [
    (dict(), []),
    (dict(random="a + b | plot", variance="power"), ["--random", "a + b | plot", "--variance", "power"]),
    (dict(random="a | stand/plot", parameters=["b ~ 1 + crowding"], reml=True),
     ["--random", "a | stand/plot", "--parameter", "b ~ 1 + crowding", "--reml"]),
    (dict(random="a | plot", parameters="a ~ 1 + species", method="laplace"),
     ["--random", "a | plot", "--parameter", "a ~ 1 + species", "--method", "laplace"]),
    (dict(bounds={"b": (0.01, None)}, hold={"a": 30}), ["--bound", "b=0.01:", "--fix", "a=30"]),
])
def test_the_json_is_that_of_the_program(program, stands, stands_file, arguments, options):
    theirs = json.loads(program("fit", stands_file, "--formula", FORMULA, "--json", "--quiet", *options))
    theirs.pop("recognized", None)
    assert_same_json(json.loads(sf.fit(FORMULA, stands, **arguments).to_json()), theirs)


def test_a_model_of_the_catalogue_is_that_of_the_program(program, inventory, source):
    file = source / "examples/fir-mixed/inventory.csv"
    theirs = json.loads(program("fit", file, "--model", "M4", "--random", "a | plot", "--json", "--quiet"))
    theirs.pop("recognized", None)
    fit = sf.fit("M4", inventory, random="a | plot")
    assert fit.model == "M4"
    assert_same_json(json.loads(fit.to_json()), theirs)


def test_values_have_the_shapes_and_names_of_pandas(mixed, stands):
    assert list(mixed.fixed_effects.index) == ["a", "b"]
    assert list(mixed.coefficients.columns) == ["estimate", "se", "df", "t", "p"]
    assert mixed.covariance.shape == (2, 2)
    assert np.sqrt(np.diag(mixed.covariance)) == pytest.approx(mixed.standard_errors.to_numpy())
    assert mixed.random_effects.index.name == "plot"
    assert set(mixed.random_effects.index) == set(stands["plot"])
    assert mixed.random_standard_errors.shape == mixed.random_effects.shape
    assert mixed.random_covariance.loc["a", "b"] == mixed.random_covariance.loc["b", "a"]
    assert list(mixed.variance_components.index) == ["sd(a)", "sd(b)", "cor(a, b)", "delta", "sigma"]
    assert mixed.converged and mixed.status == "converged" and mixed.verdict
    assert mixed.aic == pytest.approx(-2 * mixed.loglik + 2 * mixed.parameter_count)
    assert mixed.nobs == len(stands) and mixed.groups == {"plot": 32}


def test_correlated_residuals(stands):
    trees = stands.assign(order=stands.groupby("plot").cumcount())
    fit = sf.fit(FORMULA, trees, random="a | plot", correlation="ar1(order)")
    assert fit.correlation == "ar1(order)" and "correlation of the residuals" in str(fit.summary())
    assert list(fit.variance_components.index) == ["sd(a)", "phi", "sigma"]
    assert fit.loglik >= sf.fit(FORMULA, trees, random="a | plot").loglik
    assert fit.update(correlation=None).correlation == "none"
    assert sf.Fit.from_json(fit.to_json()).correlation == "ar1(order)"
    with pytest.raises(sf.InputError, match="repeated"):
        sf.fit(FORMULA, trees.assign(order=1), random="a | plot", correlation="car1(order)")


def test_crossed_groups_are_a_dict_of_their_own(stands):
    years = stands.assign(year=[2000 + k % 5 for k in range(len(stands))])
    fit = sf.fit(FORMULA, years, random="a | plot + year")
    assert {name: len(effects) for name, effects in fit.random_effects.items()} == {
        "plot": years["plot"].nunique(), "year": 5}
    assert fit.random == "(a | plot) + (a | year)"
    assert sf.fit(FORMULA, years, random=fit.random).loglik == fit.loglik
    of_years = fit.group_coefficients["year"]
    expected = fit.fixed_effects["a"] + fit.random_effects["year"]["a"]
    assert (of_years["a"] - expected).abs().max() < 1e-12
    conditional = fit.predict(years, level="conditional")
    assert (conditional - fit.fitted()).abs().max() < 1e-10
    # The trees of the fit, as if their groups were new, give its effects and their errors.
    errors = fit.predict(years, level="conditional", interval="prediction")
    again = fit.predict(years, level="calibrated", seen_groups="new", interval="prediction")
    assert (again["prediction"] - errors["prediction"]).abs().max() < 1e-6
    assert (again["upper"] - errors["upper"]).abs().max() < 1e-4
    groups = fit.calibrate(years)
    assert list(groups) == list(fit.random_effects)
    for name, effects in fit.random_effects.items():
        assert (groups[name][list(effects)].reindex(effects.index) - effects).abs().max().max() < 1e-6
    assert groups["year"]["measured"].sum() == len(years)


def test_three_levels_have_an_index_of_all_columns(stands):
    regions = stands.assign(region=["east" if stand < "S5" else "west" for stand in stands["stand"]])
    fit = sf.fit(FORMULA, regions, random="a | region/stand/number")
    assert list(fit.random_effects) == ["region", "region:stand", "region:stand:number"]
    assert fit.random_effects["region:stand:number"].index.names == ["region", "stand", "number"]


def test_nested_groups_have_an_index_of_both_columns(stands):
    fit = sf.fit(FORMULA, stands, random="a | stand/plot")
    assert list(fit.random_effects) == ["stand", "plot"]
    inner = fit.random_effects["plot"]
    assert inner.index.names == ["stand", "plot"]
    assert set(inner.index) == set(map(tuple, stands[["stand", "plot"]].drop_duplicates().to_numpy()))
    assert fit.random == "a | stand; a | stand/plot"
    assert sf.fit(FORMULA, stands, random=fit.random).loglik == fit.loglik
    recurring = stands.assign(plot=stands.groupby("stand")["plot"].transform(lambda labels: pd.factorize(labels)[0]))
    with pytest.raises(sf.FormulaError, match=r"write `a \| stand/plot`"):
        sf.fit(FORMULA, recurring, random="a | stand; a | plot")
    assert sf.fit(FORMULA, recurring, random="a | stand/plot").loglik == pytest.approx(fit.loglik, rel=1e-9)
    with pytest.raises(sf.InputError, match="outer"):
        sf.fit(FORMULA, stands, random="a | outer/plot")


def test_results_keep_the_index_and_skip_rows_with_missing_values(stands):
    trees = stands.copy()
    trees.index = [f"tree {k}" for k in range(len(trees))]
    trees.loc["tree 3", "h"] = np.nan
    trees.loc["tree 5", "dbh"] = np.nan
    fit = sf.fit(FORMULA, trees, random="a | plot")
    assert fit.nobs == len(trees) - 2 and fit.excluded == 2
    residuals = fit.residuals()
    assert residuals.index.equals(trees.index)
    assert list(residuals.index[residuals.isna()]) == ["tree 3", "tree 5"]
    sums = (fit.fitted() + residuals).dropna()
    assert sums.to_numpy() == pytest.approx(trees["h"].drop(["tree 3", "tree 5"]).to_numpy())
    predicted = fit.predict(trees, level="population")
    assert list(predicted.index[predicted.isna()]) == ["tree 5"]
    # The formula itself is the population prediction.
    a, b = fit.fixed_effects
    expected = 1.3 + a * (1 - np.exp(-b * trees["dbh"].dropna()))
    assert predicted.dropna().to_numpy() == pytest.approx(expected.to_numpy(), rel=1e-12)


def test_conditional_predictions_add_the_random_effects(mixed, stands):
    a = mixed.fixed_effects["a"] + mixed.random_effects["a"].reindex(stands["plot"]).to_numpy()
    b = mixed.fixed_effects["b"] + mixed.random_effects["b"].reindex(stands["plot"]).to_numpy()
    expected = 1.3 + a * (1 - np.exp(-b * stands["dbh"].to_numpy()))
    assert mixed.predict(stands, level="conditional").to_numpy() == pytest.approx(expected, rel=1e-12)
    assert mixed.fitted().to_numpy() == pytest.approx(expected, rel=1e-12)


def test_intervals_of_a_line_are_those_of_the_t_distribution():
    """Textbook intervals of simple regression at a new point (scipy has the quantile)."""
    from scipy import stats

    x = np.array([1.0, 2.0, 3.0, 4.0, 6.0])
    y = np.array([1.1, 1.9, 3.2, 3.9, 6.3])
    fit = sf.fit("y ~ a + b*x", {"x": x, "y": y})
    slope, intercept = np.polyfit(x, y, 1)
    s = np.sqrt(np.sum((y - intercept - slope * x) ** 2) / 3)
    leverage = 1 / 5 + (5.0 - x.mean()) ** 2 / np.sum((x - x.mean()) ** 2)
    t = stats.t.ppf(0.975, 3)
    new = fit.predict({"x": [5.0]}, interval="prediction", standard_errors=True)
    mean = fit.predict({"x": [5.0]}, interval="confidence", standard_errors=True)
    # As predict() of R, without an interval that of the mean; sigma^2 is the difference to that of an observation.
    assert fit.predict({"x": [5.0]}, standard_errors=True)["se"].to_numpy() == mean["se"].to_numpy()
    assert new["se"].to_numpy()**2 - mean["se"].to_numpy()**2 == pytest.approx(fit.sigma**2)
    assert list(new.columns) == ["prediction", "lower", "upper", "se"]
    center = intercept + slope * 5.0
    half = t * s * np.sqrt(1 + leverage)
    # The quadrature of intervals is exact to 1e-9 of the half-width for lines.
    assert new.iloc[0, :3].to_numpy() == pytest.approx([center, center - half, center + half], rel=1e-8)
    mean = fit.predict({"x": [5.0]}, interval="confidence")
    assert mean["upper"][0] - center == pytest.approx(t * s * np.sqrt(leverage), rel=1e-8)


def test_calibration_of_a_new_plot_is_that_of_its_trees(mixed, stands):
    new = stands[stands["plot"] == "S1P1"].assign(plot="new")
    # The same trees give the effects of the fit (docs/prediction.md: to 1e-8 standard deviations).
    effects = mixed.calibrate(new)
    assert effects.loc["new", "measured"] == len(new)
    assert effects.loc["new", ["a", "b"]].to_numpy(float) == pytest.approx(
        mixed.random_effects.loc["S1P1"].to_numpy(), abs=1e-7)
    predicted = mixed.predict(new, level="calibrated")
    assert predicted.to_numpy() == pytest.approx(mixed.fitted()[new.index].to_numpy(), rel=1e-7)


def test_new_groups_are_those_of_the_population_or_an_error(mixed):
    new = pd.DataFrame({"dbh": [20.0], "plot": ["never seen"]})
    with pytest.warns(UserWarning, match="groups that are not in the fit"):
        assert mixed.predict(new)[0] == mixed.predict(new, level="population")[0]
    assert np.isnan(mixed.predict(new, level="conditional", new_groups="missing")[0])
    with pytest.raises(sf.InputError, match="never seen"):
        mixed.predict(new, level="conditional", new_groups="error")
    marginal = mixed.predict(new, level="marginal")[0]
    assert marginal != mixed.predict(new, level="population")[0]


def test_simulated_responses_have_the_index(mixed, stands):
    simulated = mixed.simulate(3, seed=7)
    assert simulated.shape == (len(stands), 3) and simulated.index.equals(stands.index)
    assert simulated.equals(mixed.simulate(3, seed=7))
    assert not simulated.equals(mixed.simulate(3, seed=8))
    spread = (simulated[0] - mixed.predict(level="population")).std()
    total = np.sqrt((stands["h"] - mixed.predict(level="population")).var())
    assert 0.5 * total < spread < 2 * total


def test_the_bootstrap_and_cross_validation_are_those_of_the_program(program, stands, stands_file):
    fit = sf.fit(FORMULA, stands, random="a | plot")
    theirs = json.loads(program("fit", stands_file, "--formula", FORMULA, "--random", "a | plot", "--json", "--quiet",
                                "--bootstrap", "40", "--cross-validate", "4", "--seed", "3"))
    ours = fit.bootstrap(40, seed=3, progress=False)
    for name, expected in theirs["bootstrap"]["parameters"].items():
        assert ours.parameters.loc[name, "se"] == pytest.approx(expected["se"], rel=1e-12)
        assert ours.parameters.loc[name, "basic_upper"] == pytest.approx(expected["basic"][1], rel=1e-12)
    assert ours.values.shape == (40, len(ours.parameters))
    folds = fit.cross_validate(4, seed=3, progress=False)
    assert folds.attrs["population"]["rmse"] == pytest.approx(theirs["cross_validation"]["population"]["rmse"], rel=1e-12)
    error = folds["observed"] - folds["predicted"]
    assert folds.attrs["population"]["mae"] == pytest.approx(error.abs().mean())


def test_comparisons_test_each_fit_against_the_next(stands):
    small = sf.fit(FORMULA, stands, random="a | plot")
    large = sf.fit(FORMULA, stands, random="a | plot", variance="power")
    table = sf.compare(large, small, names=["power", "constant"])
    assert list(table.index) == ["constant", "power"]
    statistic = 2 * (large.loglik - small.loglik)
    assert table.loc["power", "statistic"] == pytest.approx(statistic)
    from scipy import stats

    assert table.loc["power", "p"] == pytest.approx(stats.chi2.sf(statistic, 1))
    assert table["akaike_weight"].sum() == pytest.approx(1.0)
    fewer = sf.fit(FORMULA, stands.iloc[:500], random="a | plot")
    with pytest.warns(UserWarning, match="cannot be compared"):
        sf.compare(small, fewer)


def test_intervals_profile_and_wald(stands):
    fit = sf.fit(FORMULA, stands)
    wald = fit.intervals()
    assert list(wald.columns) == ["kind", "estimate", "lower", "upper", "note"]
    from scipy import stats

    half = stats.t.ppf(0.975, fit.nobs - 2) * fit.standard_errors["a"]
    assert wald.loc["a", "upper"] == pytest.approx(fit.fixed_effects["a"] + half)
    profile = fit.intervals("profile", level=0.9)
    assert profile.loc["a", "lower"] > wald.loc["a", "lower"]
    assert profile.attrs["level"] == 0.9 and profile.attrs["likelihood"]


def test_fits_are_pickled_and_copied_with_their_data(mixed, stands):
    for other in (pickle.loads(pickle.dumps(mixed)), copy.copy(mixed), copy.deepcopy(mixed)):
        assert other.to_json() == mixed.to_json()
        assert other.residuals("pearson").equals(mixed.residuals("pearson"))
        assert other.predict(stands).equals(mixed.predict(stands))
        assert other.random_effects.equals(mixed.random_effects)


def test_fits_are_written_and_read_as_json(mixed, stands, tmp_path):
    file = tmp_path / "fit.json"
    assert mixed.to_json(file) is None
    for read in (sf.Fit.from_json(file), sf.Fit.from_json(mixed.to_json())):
        assert read.loglik == mixed.loglik
        assert read.predict(stands, level="conditional").equals(mixed.predict(stands, level="conditional"))
        with pytest.raises(sf.UsageError, match="with_data"):
            read.residuals()
        assert read.with_data(stands).residuals().equals(mixed.residuals())
        for others in (stands.iloc[:50], stands.assign(h=2 * stands["h"])):
            with pytest.raises(sf.InputError, match="these are not the data of the fit"):
                read.with_data(others)


def test_structural_indices_are_computed_for_sub_models(inventory):
    trees = inventory[inventory["species"] == "SM"]
    with_units = sf.structural_units(inventory)
    column = with_units.loc[trees.index.intersection(with_units.index), "C"]
    with pytest.warns(UserWarning):
        computed = sf.fit(FORMULA, inventory, parameters="b ~ 1 + C")
    assert computed.parameters == {"b": "1 + C"}
    given = sf.fit(FORMULA, inventory.assign(C=with_units["C"].reindex(inventory.index)), parameters="b ~ 1 + C")
    assert computed.fixed_effects.to_numpy() == pytest.approx(given.fixed_effects.to_numpy(), rel=1e-6)
    assert column.notna().any()


def test_the_trace_has_a_line_for_each_iteration(stands, capsys):
    sf.fit(FORMULA, stands, random="a | plot", trace=True)
    assert len(capsys.readouterr().err.splitlines()) > 3
    sf.fit(FORMULA, stands, random="a | plot")
    assert capsys.readouterr().err == ""


def test_summaries_say_what_the_fit_is(mixed):
    text = str(mixed.summary())
    for part in ("a + b | plot", "power", "std. dev.", "Converged", "914"):
        assert part in text
    assert "<pre>" in mixed._repr_html_() and "<pre>" in mixed.summary()._repr_html_()
    assert "a + b | plot" in repr(mixed)


def test_the_default_of_predict_is_that_of_r(mixed, stands):
    assert mixed.predict(stands).equals(mixed.predict(stands, level="conditional"))
    with pytest.raises(sf.InputError, match="level='population'"):
        mixed.predict({"dbh": [20.0]})


def test_bar_terms_of_lme4_are_random_effects(stands):
    by_bar = sf.fit("h ~ a + b*log(dbh) + (1 | plot)", stands)
    assert by_bar.loglik == sf.fit("h ~ a + b*log(dbh)", stands, random="a | plot").loglik
    with pytest.raises(sf.FormulaError, match=r'h ~ b0 \+ b1\*dbh with random="b0 \| plot"'):
        sf.fit("h ~ dbh + (1 | plot)", stands)


def test_names_that_may_be_columns_are_named(stands):
    with pytest.warns(sf.ConvergenceWarning, match="dhb is not a column of the data.*did you mean the column dbh"):
        sf.fit("h ~ a + b*dhb", stands)
    with pytest.warns(UserWarning, match="did you mean the column height"):
        assert sf.fit("h ~ dbh*hgt", stands.assign(height=stands["h"])).converged
    with pytest.raises(sf.FormulaError, match="did you mean 'dbh'"):
        sf.fit("h ~ a + b*DBH", stands)
    with pytest.warns(UserWarning, match="two values only"):
        sf.fit("tall ~ a + b*dbh", stands.assign(tall=(stands["h"] > stands["h"].median()) * 1.0))


def test_columns_of_digits_that_are_texts_are_factors(stands):
    codes = stands["plot"].astype("category").cat.codes % 3
    expected = sf.fit("h ~ a + b*dbh", stands.assign(code=codes), parameters="a ~ factor(code)")
    for column in (codes.astype(str), codes.astype("category"), codes.astype(str).astype("category")):
        found = sf.fit("h ~ a + b*dbh", stands.assign(code=column), parameters="a ~ code")
        assert list(found.fixed_effects) == pytest.approx(list(expected.fixed_effects))


def test_unknown_arguments_are_named(stands):
    with pytest.raises(sf.UsageError, match="did you mean dominance"):
        sf.structural_units(stands, dominanse="dbh")
    with pytest.raises(sf.UsageError, match="did you mean trust_units"):
        sf.stand_summary(stands, trust_unit=True)


def test_functions_of_coefficients_have_standard_errors():
    # R 4.2.2: vcov(lm(weight ~ group, PlantGrowth)); Dobson 1983.
    weight = [4.17, 5.58, 5.18, 6.11, 4.50, 4.61, 5.17, 4.53, 5.33, 5.14, 4.81, 4.17, 4.41, 3.59, 5.87,
              3.83, 6.03, 4.89, 4.32, 4.69, 6.31, 5.12, 5.54, 5.50, 5.37, 5.29, 4.92, 6.15, 5.80, 5.26]
    plants = pd.DataFrame({"weight": weight, "group": ["ctrl"] * 10 + ["trt1"] * 10 + ["trt2"] * 10, "one": 1.0})
    text = '`a:(group == "trt2")` - `a:(group == "trt1")`'
    found = sf.fit("weight ~ a*one", plants, parameters="a ~ group", derive={"difference": text})
    assert found.derived.loc["difference", "estimate"] == pytest.approx(0.865, rel=1e-12)
    assert found.derived.loc["difference", "se"] == pytest.approx(0.2787816084, rel=1e-9)
    assert found.intervals().index[-1] == "difference"
    with pytest.raises(sf.UsageError, match="did you mean"):
        sf.fit("weight ~ a*one", plants, derive="r = aa/2")
    means = sf.fit("weight ~ a*one", plants, parameters="a ~ group", means=["group"]).derived
    assert list(means.index) == ["a (group ctrl)", "a (group trt1)", "a (group trt2)"]
    assert means["estimate"].tolist() == pytest.approx([5.032, 4.661, 5.526], rel=1e-12)
    with pytest.raises(sf.UsageError, match="truth values"):
        sf.fit("weight ~ a*one", plants.assign(half=[True, False] * 15), parameters="a ~ group + half", means=["group"])
    with pytest.raises(sf.InputError, match="holds texts such as '1.0'; make them numbers"):
        sf.fit("weight ~ a*one", plants.assign(one="1.0"))
