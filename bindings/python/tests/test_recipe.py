"""Recipes and what is wrong with them."""

import doctest
import importlib
import json

import numpy as np
import pytest

import eyot


def test_errors_have_place_and_remedy():
    with pytest.raises(eyot.RecipeError) as caught:
        eyot.Recipe('[grid]\nsize = 32\ncell = 20.0\n[[step]]\ngenerate = "con"\n').check()
    (problem, *_) = caught.value.problems
    assert problem.line == 5 and problem.column == 12 and problem.source == "recipe"
    assert "cone" in problem.help and "con" in problem.message


def test_arguments_are_changes_with_a_place_of_their_own():
    with pytest.raises(eyot.RecipeError) as caught:
        eyot.Recipe("island", **{"hydraulic.rian": 0.004}).check()
    assert caught.value.problems[0].source == "set"
    assert "rain" in str(caught.value)


@pytest.mark.parametrize("wrong", ["nowhere", 7, None, b"island", {"steps": 3}, {"grid": []}, "= ]", ""])
def test_what_is_no_recipe_is_refused(wrong):
    with pytest.raises((eyot.EyotError, TypeError)):
        eyot.run(wrong)


@pytest.mark.parametrize(
    "options",
    [
        {"size": 0},
        {"size": -3},
        {"size": "large"},
        {"size": 10**9},
        {"threads": -1},
        {"threads": 10**6},
        {"engine": "abacus"},
        {"engine": "cpu", "adapter": "x"},
        {"seed": -1},
        {"max_memory": 1},
        {"hydraulic": 3},
        {"presets": ["quake"]},
        {"checkpoint_seconds": float("nan")},
        {"replay": [{"no": 1}]},
        {"record": 10},
    ],
)
def test_options_that_cannot_be_are_one_exception(options):
    with pytest.raises((eyot.EyotError, TypeError, ValueError, OverflowError)) as caught:
        eyot.run("island", **{"size": 32, **options})
    assert str(caught.value)


def test_dictionaries_and_documents_are_the_same():
    document = 'name = "H"\n[grid]\nsize = 32\ncell = 20.0\n[[step]]\ngenerate = "cone"\nheight = 300.0\n'
    same = {"name": "H", "grid": {"size": 32, "cell": 20.0}, "steps": [{"generate": "cone", "height": 300.0}]}
    assert eyot.run(document).attrs["fingerprint"] == eyot.run(same).attrs["fingerprint"]


def test_rules_of_ones_own_are_texts():
    recipe = {
        "grid": {"size": 32, "cell": 20.0},
        "layers": [{"name": "memory", "unit": "1", "next": "clamp(0.9 * memory + 0.1 * step(0.001, water), 0, 1)"}],
        "steps": [{"generate": "cone", "height": 300.0}, {"simulate": ["hydraulic", "memory"], "steps": 50}],
    }
    ds = eyot.run(recipe)
    assert 0.0 < float(ds.memory.max()) <= 1.0 and ds.memory.units == "1"


def test_arrays_stand_where_recipes_name_files():
    y, x = np.mgrid[:24, :32].astype(np.float32)
    bowl = (x - 16) ** 2 + (y - 12) ** 2
    recipe = {"grid": {"size": [32, 24], "cell": 5.0}, "steps": [{"generate": "import", "file": bowl}]}
    assert np.array_equal(eyot.run(recipe).height, bowl)


def test_cells_without_a_value_are_missing():
    heights = np.full((16, 16), 5.0)
    heights[3, 4] = np.nan
    recipe = {"grid": {"size": 16, "cell": 5.0}, "steps": [{"generate": "import", "file": heights}]}
    ds = eyot.run(recipe)
    assert np.array_equal(np.argwhere(ds.missing.values), [[3, 4]]) and float(ds.height[3, 4]) == 5.0
    for nothing in (np.full((4, 4), np.nan), np.full((4, 4), np.inf)):
        with pytest.raises(eyot.EyotError, match="the array"):
            eyot.Recipe({"steps": [{"generate": "import", "file": nothing}]})


def test_rasters_of_xarray_keep_their_place():
    import xarray as xr

    values = np.arange(12.0, dtype=np.float32).reshape(3, 4)
    south_first = xr.DataArray(values[::-1], dims=("y", "x"), coords={"y": [5.0, 15.0, 25.0], "x": [5.0, 15.0, 25.0, 35.0]})
    recipe = {"grid": {"from": south_first}, "steps": [{"generate": "import", "file": south_first}]}
    ds = eyot.run(recipe)
    assert np.array_equal(ds.height, values) and ds.attrs["cell_m"] == [10.0, 10.0]


def test_what_there_is_is_listed_and_described():
    assert "island" in eyot.recipes() and "fbm" in eyot.generators() and "hydraulic" in eyot.processes()
    rain = next(p for p in eyot.describe("hydraulic")["parameters"] if p["name"] == "rain")
    assert rain["unit"] and rain["meaning"]
    assert json.dumps(eyot.schema())
    with pytest.raises(eyot.EyotError, match="did you mean"):
        eyot.describe("hydralic")
    assert "@" in eyot.Recipe("island").cite("bibtex")


@pytest.mark.parametrize("module", ["eyot", "eyot._recipe", "eyot._run"])
def test_examples_in_docstrings_are_true(module):
    assert doctest.testmod(importlib.import_module(module)).failed == 0
