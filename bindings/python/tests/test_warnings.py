# SPDX-License-Identifier: MIT
"""What was left out or is in doubt is a warning of the package's own category, at the line of the caller."""
import warnings

import numpy as np
import pandas as pd
import pytest
from conftest import FORMULA

import silvafit as sf


def told(call):
    """The value of a call, and the texts of its warnings, which are all of the package."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        value = call()
    assert all(issubclass(one.category, sf.SilvafitWarning) and one.filename == __file__ for one in caught)
    return value, [str(one.message) for one in caught]


@pytest.fixture(scope="module")
def spoilt(inventory):
    """Texts in every second dbh."""
    trees = inventory.astype({"dbh": object}).set_axis([f"t{k}" for k in range(len(inventory))])
    trees.loc[trees.index[::2], "dbh"] = "about 20"
    return trees


@pytest.mark.parametrize("function, options", [
    (sf.structural_units, {}), (sf.stand_summary, {"plot_area": 400}),
    (sf.study, {"responses": ["h"], "candidates": {"h": ["M4"]}, "maximum_random_effects": 1, "covariates": ["dbh"]})])
def test_skipped_rows_are_counted_and_the_first_named(spoilt, function, options):
    skipped = (len(spoilt) + 1) // 2
    _, texts = told(lambda: function(spoilt, **options))
    assert f"{skipped} of {len(spoilt)} rows skipped" in texts[0]
    for label in ("t0", "t2", "t4"):
        assert f"row '{label}': dbh: 'about 20' is not a number" in texts[0]
    commas = spoilt.replace({"dbh": {"about 20": "20,7"}})
    with pytest.raises(sf.InputError, match="row 't0': dbh: '20,7' is no number here: write decimals with a point"):
        function(commas, **options)


def test_skipped_rows_of_growth(inventory):
    later = inventory.assign(year=2020, dbh=1.1 * inventory["dbh"]).astype({"dbh": object})
    later.loc[3, "dbh"] = "thick"
    both = pd.concat([inventory.assign(year=2010), later], ignore_index=True)
    _, texts = told(lambda: sf.stand_growth(both, plot_area=400))
    assert len(texts) == 1 and f"row {len(inventory) + 3}: dbh: 'thick'" in texts[0]


def test_good_data_are_read_without_a_warning(inventory):
    for call in (lambda: sf.structural_units(inventory), lambda: sf.stand_summary(inventory, plot_area=400), lambda: sf.fit("M4", inventory)):
        assert told(call)[1] == []


def test_a_study_without_models_says_so(inventory):
    study, texts = told(lambda: sf.study(inventory, responses=["h"], candidates={"h": ["M4"]}, minimum_trees=10000))
    assert study.results.empty
    assert texts[0].startswith("no model was fitted. Too few trees for models (fewer than 10000)")


def test_levels_that_are_not_in_the_fit_are_named(stands):
    fit = sf.fit(FORMULA, stands, parameters="a ~ species")
    new = stands.head(6).assign(species=["oak", "oak", "ash", *stands["species"][3:6]])
    predicted, texts = told(lambda: fit.predict(new))
    assert predicted.isna().tolist() == [True] * 3 + [False] * 3
    assert texts == ["column species has levels that are not in the fit (oak, ash): 3 predictions are missing"]
    of_library, texts = told(lambda: sf.Library.of(fit).predict(new))
    assert of_library["h_pred"].isna().sum() == 3 and texts == ["3 rows have no h_pred, the first: row 0: unknown species "
                                                                f"(plot {new['plot'][0]}, tree {new['tree'][0]})"]


def test_groups_without_a_measured_row_are_named(stands):
    fit = sf.fit(FORMULA, stands, random="a | plot")
    new = stands.head(3).assign(plot="new", h=np.nan)
    predicted, texts = told(lambda: fit.predict(new, level="calibrated"))
    assert predicted.equals(fit.predict(new, level="population"))
    assert "3 rows are of groups that are not in the fit and have no measured row (plot new)" in texts[0]
    assert told(lambda: fit.predict(new, level="calibrated", new_groups="population"))[1] == []


def test_values_that_cannot_be_filled_in_are_counted(inventory):
    trees = inventory[inventory["plot"] < 3].copy()
    trees.loc[trees.index[::3], "h"] = np.nan
    trees.loc[trees.index[0], "dbh"] = np.nan
    filled, texts = told(lambda: sf.impute(trees))
    assert filled["h"].isna().sum() == 1
    assert texts == ["1 row has no h, the first: row 0: dbh is missing (plot 1, tree 1)"]
    trees.loc[5, "h"] = np.inf
    with pytest.raises(sf.InputError, match="not finite") as caught:
        sf.impute(trees)
    assert (caught.value.row, caught.value.column) == (5, "h")


def test_units_of_a_fit_are_doubted_as_those_of_an_inventory(inventory):
    for trees, doubt in ((inventory.assign(h=10 * inventory["h"]), "h has the median 119 m"),
                         (inventory.assign(dbh=10 * inventory["dbh"]), "dbh has the median 156 cm")):
        for model in (FORMULA, "M4"):
            assert any(doubt in text for text in told(lambda: sf.fit(model, trees))[1])
        with pytest.raises(sf.InputError, match=doubt):
            sf.stand_summary(trees, plot_area=400)
    mixed = inventory.assign(dbh=inventory["dbh"].where(inventory["plot"] != 2, 10 * inventory["dbh"]))
    assert any("in plot 2 dbh seems to be in mm" in text for text in told(lambda: sf.fit(FORMULA, mixed, random="a | plot"))[1])


def test_trees_that_are_not_grown_are_named(inventory, tmp_path):
    trees = inventory.head(3).assign(dbh=[20.0, np.nan, 30.0])
    grown, texts = told(lambda: sf.grow(trees, tmp_path / "stand.glb", lod=[3]))
    assert len(grown["trees"]) == 2 and len(texts) == 1 and texts[0].startswith("row 1: dbh: is missing")


def test_an_alpha_that_is_a_coverage_is_said(inventory):
    fit = sf.fit(FORMULA, inventory[inventory["species"] == "SM"])
    for call in (lambda: fit.conf_int(0.95), lambda: fit.get_prediction({"dbh": [20.0]}).conf_int(alpha=0.95)):
        assert told(call)[1] == ["alpha=0.95 is a coverage of 5 %; for 95 % use alpha=0.05"]
    assert not told(fit.conf_int)[1]


def test_rows_of_a_table_of_plots_are_not_those_of_trees(inventory):
    plots = pd.DataFrame({"plot": inventory["plot"].unique(), "area": -1.0})
    with pytest.raises(sf.InputError, match="plots:1: area: -1 must be above 0"):
        sf.stand_summary(inventory.set_axis([f"t{k}" for k in range(len(inventory))]), plots=plots)


def test_a_species_in_feet_is_said_by_fits(inventory):
    trees = inventory[inventory["species"].isin(["SM", "BHN"]) & (inventory["dbh"] > 10)]
    feet = trees.assign(h=trees["h"].where(trees["species"] == "BHN", 4 * trees["h"]))
    fit, texts = told(lambda: sf.fit(FORMULA, feet))
    assert any("of species SM, unlike others, h has the median" in text for text in texts)
    assert set(fit.data.columns) == {"h", "dbh"} and not told(lambda: sf.fit(FORMULA, trees))[1]
