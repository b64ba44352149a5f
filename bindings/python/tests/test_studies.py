# SPDX-License-Identifier: MIT
"""Analyses of inventories: the tables of the program, with the index of the trees."""
import io
import json
import pathlib
import pickle
from urllib.parse import urlparse
from urllib.request import url2pathname

import numpy as np
import pandas as pd
import pytest
from arrow_producer import ArrowTable
from conftest import FORMULA

import silvafit as sf


@pytest.fixture(scope="module")
def small(inventory):
    """Two plots, with labels of their own and a row that cannot be used."""
    trees = inventory[inventory["plot"].isin([1, 2])].copy()
    trees.index = [f"t{k}" for k in range(len(trees))]
    trees.loc["t4", "dbh"] = np.nan
    return trees


@pytest.fixture(scope="module")
def small_file(small, tmp_path_factory):
    file = tmp_path_factory.mktemp("inventory") / "small.csv"
    small.to_csv(file, index=False)
    return file


def test_structural_units_are_those_of_the_program(program, small, small_file):
    theirs = pd.read_csv(io.StringIO(program("indices", small_file, "--quiet")))
    ours = sf.structural_units(small)
    # A tree without dbh is a neighbor of others, but no core tree.
    assert not ours["core"]["t4"] and set(ours.index) <= set(small.index)
    assert len(ours) == len(theirs)
    for index in ("W", "M", "U", "C"):
        assert ours[index].to_numpy() == pytest.approx(theirs[index].to_numpy(), rel=1e-12, nan_ok=True)
    assert ours["dbh"].equals(small["dbh"].reindex(ours.index))
    assert ours.attrs["summary"]["schema"] == "silvafit-indices/1"
    assert sf.structural_units(small_file)["M"].to_numpy() == pytest.approx(ours["M"].to_numpy(), nan_ok=True)


def test_analyses_take_arrow_streams_and_dicts(small):
    columns = ["plot", "tree", "x", "y", "dbh", "h", "species", "cw"]
    expected = sf.structural_units(small)
    arrow = sf.structural_units(ArrowTable(small[columns], text="vu", chunks=3))
    plain = sf.structural_units({name: small[name].to_numpy() for name in columns})
    for found in (arrow, plain):
        assert found["C"].to_numpy() == pytest.approx(expected["C"].to_numpy(), nan_ok=True)
        # Without an index, rows have their numbers.
        assert list(found.index) == [place for place, label in enumerate(small.index) if label in expected.index]
    imputed = sf.impute(ArrowTable(small[columns], text="U"))
    assert list(imputed.columns) == ["h", "h_source", "h_level", "h_flag"] and len(imputed) == len(small)


def test_windows_of_geopandas_are_those_of_files(source, inventory):
    geopandas = pytest.importorskip("geopandas")
    file = source / "examples/fir-mixed/window.geojson"
    # Without a reference system in the file, geopandas takes these meters for degrees.
    frame = geopandas.read_file(file)
    expected = sf.structural_units(inventory, file, per="stand")
    for window in (frame, frame.geometry, frame.geometry.iloc[0]):
        found = sf.structural_units(inventory, window, per="stand")
        assert found["core"].equals(expected["core"]) and found["C"].equals(expected["C"])
    assert not expected["core"].equals(sf.structural_units(inventory)["core"])


def test_further_columns_and_geometries_are_kept(small):
    geopandas = pytest.importorskip("geopandas")
    trees = small.assign(note=range(len(small)))
    points = geopandas.GeoDataFrame(trees.drop(columns=["x", "y"]), geometry=geopandas.points_from_xy(trees.x, trees.y),
                                    crs=32650)
    plain, units = sf.structural_units(trees), sf.structural_units(points)
    assert type(plain) is pd.DataFrame and plain["note"].equals(trees["note"].reindex(plain.index))
    assert isinstance(units, geopandas.GeoDataFrame) and units.crs == points.crs
    assert units["C"].equals(plain["C"]) and units["note"].equals(plain["note"])
    assert units.geometry.x.to_numpy() == pytest.approx(units["x"].to_numpy())
    renamed = sf.structural_units(trees.rename(columns={"dbh": "BHD"}), columns={"dbh": "BHD"})
    assert renamed["BHD"].equals(renamed["dbh"])
    few = points.copy()
    few.loc[few.index[::3], "h"] = np.nan
    for found in (sf.impute(few, "h"), sf.study(few, responses=["h"], candidates={"h": ["M4"]}, covariates=[],
                                                maximum_random_effects=1).predictions):
        assert isinstance(found, geopandas.GeoDataFrame) and found.crs == points.crs
        assert found["note"].equals(points["note"].reindex(found.index))
    assert sf.fit("M4", points).loglik == sf.fit("M4", trees).loglik


def test_points_are_the_positions_beside_other_columns(small):
    geopandas = pytest.importorskip("geopandas")
    feet = small.assign(x=small.x / 0.3048, y=small.y / 0.3048)
    points = geopandas.GeoDataFrame(feet, geometry=geopandas.points_from_xy(small.x, small.y), crs=32650)
    found, expected = sf.structural_units(points), sf.structural_units(small)
    assert found["C"].equals(expected["C"])
    # A frame of pandas with a column of geometries is a table.
    assert sf.fit("M4", pd.DataFrame(points)).loglik == sf.fit("M4", small).loglik


def test_round_numbers_are_labels(small):
    numbered = small.assign(plot=100000 + small["plot"].astype("category").cat.codes)
    found = sf.stand_summary(numbered, plot_area=500)
    assert list(found.plots["plot"].astype(str)) == [str(number) for number in sorted(numbered["plot"].unique())]


def test_pages_are_opened_in_the_browser(monkeypatch, tmp_path):
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    page = sf.View("<p>stand</p>", None, {"trees": 1}, 600)
    page.open()
    written = pathlib.Path(url2pathname(urlparse(opened[0]).path))
    assert written.read_text(encoding="utf-8") == page.html
    written.unlink()
    file = tmp_path / "view.html"
    sf.View("", file, {"trees": 1}, 600).open()
    assert opened[1] == file.as_uri()


def test_windows_of_plots_and_degrees(inventory):
    geopandas = pytest.importorskip("geopandas")
    from shapely.geometry import box

    plots = [1, 2]
    trees = inventory[inventory["plot"].isin(plots)]
    boxes = [box(*trees.loc[trees["plot"] == plot, ["x", "y"]].agg(["min", "max"]).to_numpy().ravel())
             for plot in plots]
    windows = geopandas.GeoDataFrame({"plot": plots}, geometry=boxes)
    summary = sf.stand_summary(trees, windows).summary
    for plot, shape, area in zip(plots, boxes, summary["areas"]):
        assert area["plot"] == str(plot) and area["area_ha"] * 1e4 == pytest.approx(shape.area)
    with pytest.raises(sf.UsageError, match="to_crs"):
        sf.structural_units(trees, windows.set_crs(32650).to_crs(4326))


def test_points_of_geopandas_have_positions(small):
    geopandas = pytest.importorskip("geopandas")
    points = geopandas.GeoDataFrame(small.drop(columns=["x", "y"]),
                                    geometry=geopandas.points_from_xy(small["x"], small["y"]), crs=32650)
    assert sf.structural_units(points)["C"].equals(sf.structural_units(small)["C"])
    with pytest.raises(sf.UsageError, match="to_crs"):
        sf.structural_units(points.to_crs(4326))
    with pytest.raises(sf.UsageError, match="US survey foot"):
        sf.structural_units(points.set_crs(2263, allow_override=True))
    window = geopandas.GeoSeries([points.unary_union.convex_hull], crs=32650)
    # The hull is the area by default, too.
    assert sf.structural_units(points, window, per="stand")["C"].equals(sf.structural_units(points, per="stand")["C"])
    with pytest.raises(sf.UsageError, match="different coordinate reference systems"):
        sf.structural_units(points, window.set_crs(32651, allow_override=True), per="stand")


def test_stand_tables(program, small, small_file):
    stand = sf.stand_summary(small)
    theirs = json.loads(program("stand", small_file, "--json", "--quiet"))
    assert stand.summary["all"] == theirs["all"]
    assert set(stand.tables) >= {"plots", "species", "diameters", "classes"}
    assert set(stand.species["species"]) >= {"SM", "OF"}
    assert "<table" in stand._repr_html_()


def test_imputed_heights_fill_the_gaps(small):
    trees = small.copy()
    hidden = trees.index[::3]
    trees.loc[hidden, "h"] = np.nan
    result = sf.impute(trees, "h")
    assert result.index.equals(trees.index)
    measured = trees["h"].notna()
    assert result.loc[measured, "h"].equals(trees.loc[measured, "h"])
    imputed = result["h_source"] == "imputed"
    assert set(result.index[imputed]) == {label for label in hidden if label != "t4"}
    # Attributes of a DataFrame have to be values of JSON, for example for to_parquet().
    assert json.loads(json.dumps(result.attrs)) == result.attrs
    assert sf.Fit.from_json(result.attrs["models"][""]).converged
    with pytest.raises(sf.InputError, match="h_flag: the file already has this column"):
        sf.impute(trees.assign(h_flag="mine"), "h")
    known = result.loc[imputed, "h"] - small.loc[imputed, "h"]
    assert known.abs().mean() < small["h"].std()
    assert list(result.columns) == [*trees.columns, "h_source", "h_level", "h_flag"]


def test_a_study_writes_its_files_and_predicts(small, tmp_path):
    out = tmp_path / "study"
    study = sf.study(small, out, responses=["h"], minimum_trees=80, candidates={"h": ["M4", "M5"]},
                     covariates=["C"], maximum_random_effects=1, variance_functions=["none"], progress=False)
    assert study.report.is_file() and (out / "library.json").is_file()
    run = json.loads((out / "run.json").read_text())
    assert run["command"].startswith("silvafit.study(trees, out=") and "covariates=['C']" in run["command"]
    assert "silvafit.study(trees, out=" in study.report.read_text(encoding="utf-8")
    assert not study.results.empty and set(study.results["response"]) == {"h"}
    assert set(study.predictions.index) <= set(small.index)
    library = sf.read_library(out / "library.json")
    species = study.results["species"][0]
    assert library.fit("h", species, "ols").loglik == study.library.fit("h", species, "ols").loglik
    predicted = library.predict(small, role="ols", interval="prediction")
    assert list(predicted.columns) == ["h_pred", "h_lower", "h_upper", "flag"]
    trees = small[(small["species"] == species) & small["dbh"].notna()].index
    fit = library.fit("h", species, "ols")
    assert predicted.loc[trees, "h_pred"].to_numpy() == pytest.approx(fit.predict(small.loc[trees], level="population").to_numpy())
    again = pickle.loads(pickle.dumps(library))
    assert again.to_json() == library.to_json()
    with pytest.raises(sf.UsageError, match="colour"):
        sf.study(small, colour="red")


def test_a_library_of_fits_and_published_ones(mixed, stands, tmp_path):
    library = sf.Library.of(mixed)
    library.to_json(tmp_path / "library.json")
    again = sf.read_library(tmp_path / "library.json")
    assert again.predict(stands)["h_pred"].to_numpy() == pytest.approx(mixed.predict(stands, level="population").to_numpy())
    assert len(sf.read_library("shanxia-2023").models) > 0
    with pytest.raises(sf.InputError):
        sf.read_library("no such library")


def test_trees_and_pages(small, tmp_path):
    few = small.iloc[[1, 2, 3]]
    written = sf.grow(few, tmp_path / "stand.glb", lod=3, progress=False)
    assert (tmp_path / "stand.glb").read_bytes()[:4] == b"glTF"
    assert len(written["trees"]) == 3
    sf.grow(few, tmp_path / "trees", lod=3)
    assert len(list((tmp_path / "trees").glob("*.glb"))) == 3
    page = sf.view(few, tmp_path / "view.html", title="Three trees", lod=[3], models=1)
    assert "3 trees" in repr(page)
    frame = page._repr_html_()
    assert frame.startswith("<iframe srcdoc=") and 'height="600"' in frame
    assert (tmp_path / "view.html").read_text() == page.html
    scene = sf.view(tmp_path / "stand.glb")
    assert scene.summary["trees"] == 3
    with pytest.raises(sf.UsageError, match="no effect on a GLB scene"):
        sf.view(tmp_path / "stand.glb", models=3)


def test_plots_of_trees_in_3d_are_names(tmp_path):
    trees = {"plot": [1, 1, 2], "tree": [1, 2, 1], "species": ["SM"] * 3, "x": [0.0, 4.0, 20.0], "y": [0.0, 1.0, 0.0],
             "dbh": [18.0, 24.0, 20.0], "h": [14.0, 17.0, 15.0], "hcb": [5.0, 7.0, 6.0], "cw": [3.0, 4.0, 3.5]}
    for plots, count in (([1], 2), ("2", 1), (["1", "2"], 3)):
        assert len(sf.grow(trees, tmp_path / "stand.glb", lod=3, plots=plots)["trees"]) == count
        assert sf.view(trees, lod=[3], plots=plots).summary["trees"] == count
    with pytest.raises(sf.Error, match="9"):
        sf.grow(trees, tmp_path / "stand.glb", plots="9")
    for name in ("seconds", "models"):
        with pytest.raises(sf.UsageError, match="has no effect without"):
            sf.grow(trees, tmp_path / "stand.glb", **{name: 3})


@pytest.mark.parametrize("name", ["fits", "library", "plots", "catalogue", "listener", "name", "settings", "data"])
def test_no_argument_is_swallowed(name, tmp_path):
    """Names of arguments within the package are no arguments of its functions."""
    x = np.arange(20.0)
    data = {"y": 2.0 + x + np.sin(x), "x": x}
    fit = sf.fit("y ~ a + b*x", data)
    calls = [lambda: fit.bootstrap(5, **{name: 1}), lambda: fit.cross_validate(2, **{name: 1})]
    if name != "data":
        calls.append(lambda: sf.fit("y ~ a + b*x", data, **{name: 1}))
    if name != "plots":
        calls.append(lambda: sf.grow({"plot": [1]}, tmp_path / "a.glb", **{name: 1}))
        calls.append(lambda: sf.stand_summary({"plot": [1]}, **{name: 1}))
    for call in calls:
        with pytest.raises(sf.UsageError, match="unknown argument"):
            call()


def test_the_catalogue():
    models = sf.models()
    assert models.loc["M4", "formula"] == FORMULA
    assert set(models["response"]) == {"h", "hcb", "cw"}


def test_sampled_plots_and_strata():
    # 1e4 / (pi 25) and 1e4 / (pi 100) trees per ha; plot 4 is empty.
    trees = pd.DataFrame({"plot": [1, 1, 2, 3], "tree": [1, 2, 3, 4], "dbh": [10.0, 35.0, 40.0, 12.0]})
    plots = pd.DataFrame({"plot": [1, 2, 3, 4], "stratum": ["a", "a", "b", "b"], "stratum_area": [30.0, 30.0, 10.0, 10.0]})
    stand = sf.stand_summary(trees, plots=plots, circles={7: 5, 30: 10}, trust_units=True)
    small, large = 1e4 / (np.pi * 25), 1e4 / (np.pi * 100)
    assert stand.plots["stems_per_ha"].tolist() == pytest.approx([small + large, large, small, 0.0], rel=1e-12)
    a, b = (small + 2 * large) / 2, small / 2
    assert stand.tables["strata"]["stems_total"].iloc[-1] == pytest.approx(30 * a + 10 * b, rel=1e-12)


def test_growth_of_trees_and_plots():
    trees = pd.DataFrame({"plot": [1, 1, 1, 1], "tree": [1, 2, 1, 3], "year": [2010, 2010, 2015, 2015],
                          "dbh": [20.0, 30.0, 22.0, 8.0]})
    growth = sf.stand_growth(trees, plot_area=500)
    assert growth["growth_trees"]["fate"].tolist() == ["survivor", "not found", "ingrowth"]
    assert growth["growth_trees"]["id"].iloc[0] == pytest.approx(0.4, rel=1e-12)
    assert growth["growth_plots"]["stems_ingrowth"].iloc[0] == pytest.approx(4.0, rel=1e-12)


def test_biomass_and_carbon_by_equations():
    trees = pd.DataFrame({"plot": [1, 1], "tree": [1, 2], "dbh": [20.0, 30.0]})
    stand = sf.stand_summary(trees, plot_area=500, equations=["jenkins-pine", "ipcc-carbon"], trust_units=True)
    biomass = np.exp(-2.5356 + 2.4349 * np.log(trees["dbh"])).sum() * 20
    assert stand.plots["carbon_kg_per_ha"].iloc[0] == pytest.approx(0.47 * biomass, rel=1e-12)


def test_predictions_of_biomass_and_carbon(mixed, stands):
    library = sf.Library.of(mixed)
    found = library.predict(stands, equations=["jenkins-pine", "ipcc-carbon"])
    expected = 0.47 * np.exp(-2.5356 + 2.4349 * np.log(stands["dbh"].to_numpy()))
    assert found["carbon_kg"].to_numpy() == pytest.approx(expected, rel=1e-12)
    with pytest.raises(sf.UsageError, match="no-such"):
        library.predict(stands, equations=["no-such"])


def test_studies_of_repeated_measurements_and_sampled_plots(source):
    trees = pd.read_csv(source / "tests/reference/data/repeated.csv")
    settings = {"responses": ["h"], "candidates": {"h": ["M4"]}, "variance_functions": ["none"], "progress": False}
    plots = pd.DataFrame({"plot": np.arange(1, 11), "area": 400.0})
    study = sf.study(trees, period="year", plots=plots, covariates=["stems_per_ha"], **settings)
    assert study.results["n"].tolist() == [len(trees)] and "| plot/year" in study.results["random"][0]
    # Each plot has 14 trees at each time.
    assert study.predictions["stems_per_ha"].unique() == pytest.approx([14 / 0.04], rel=1e-12)
    assert len(sf.study(trees, **settings).predictions) == 140
    circles = sf.study(trees, period="year", circles={7: 4, 15: 8}, covariates=["stems_per_ha"], **settings)
    first = trees[(trees["plot"] == 1) & (trees["year"] == 2005)]
    factors = np.where(first["dbh"] < 15, 1e4 / (np.pi * 16), 1e4 / (np.pi * 64))[first["dbh"] >= 7]
    # Trees below the smallest dbh are not counted.
    counted = first.index[first["dbh"] >= 7]
    assert circles.predictions.loc[counted, "stems_per_ha"].to_numpy() == pytest.approx(factors.sum(), rel=1e-12)


def test_imputation_of_a_file_has_its_rows_and_texts(tmp_path):
    file = tmp_path / "trees.csv"
    rows = "".join(f"{1 + k % 3:03d};{k};T;{10 + k % 20},5;{'' if k % 4 == 0 else 8 + (k % 20) / 2}\n" for k in range(60))
    file.write_text("plot;tree;species;dbh;h\n" + rows.replace(".", ","))
    found = sf.impute(file, "h", random="none")
    assert list(found.columns[:5]) == ["plot", "tree", "species", "dbh", "h"]
    assert found["plot"][0] == "001" and set(found["species"]) == {"T"}
    assert found["dbh"][3] == 13.5 and found["h"].notna().all() and found["h"][3] == 9.5 and found["h_source"][0] == "imputed"
