"""Data sets: arrays, coordinates, pictures, tables."""

import gc
import json
import resource

import numpy as np
import pytest

import eyot


def test_a_data_set_follows_cf(island):
    height = island.height
    assert height.dims == ("y", "x") and height.dtype == np.float32
    assert height.attrs["units"] == "m" and height.attrs["long_name"] and height.attrs["standard_name"] == "surface_altitude"
    dx, dy = island.attrs["cell_m"]
    assert np.allclose(np.diff(island.x), dx) and np.allclose(np.diff(island.y), -dy)
    assert float(island.y[-1]) == dy / 2 and float(island.x[0]) == dx / 2
    assert island.attrs["Conventions"].startswith("CF") and island.attrs["version"] == eyot.__version__
    assert "water.rain" in json.loads(island.attrs["ledger"])
    assert eyot.Recipe(island.attrs["recipe"]).seed == island.attrs["seed"]


def test_layers_are_the_memory_of_the_world(island):
    from eyot._dataset import world_of

    values = island.height.values
    assert not values.flags.owndata and not values.flags.writeable
    assert world_of(island) is not None
    assert np.shares_memory(values, world_of(island).array("height"))
    with pytest.raises(ValueError, match="read-only"):
        values[0, 0] = 1.0
    with pytest.raises(ValueError):
        values.flags.writeable = True


def test_a_large_layer_is_no_copy():
    ds = eyot.run({"grid": {"size": 2048, "cell": 10.0}, "steps": [{"generate": "cone", "height": 300.0}]})
    world = ds.eyot.world
    gc.collect()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    arrays = [world.array("height") for _ in range(64)]
    after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    # 64 copies would be a gigabyte.
    assert after - before < 8 << 10
    assert all(np.shares_memory(a, arrays[0]) for a in arrays)


def test_arrays_outlive_their_data_set():
    heights = [eyot.run("island", size=32).height.values for _ in range(3)]
    gc.collect()
    assert all(np.array_equal(h, heights[0]) for h in heights)


def test_pictures_are_drawn(island):
    for picture in (island.eyot.render(size=(96, 64)), eyot.render(island, "height", size=64), island.eyot.render(relief=True, size=64)):
        assert bytes(picture).startswith(b"\x89PNG") and picture._repr_png_() == bytes(picture)
    assert "data:image/png;base64" in island.eyot._repr_html_()
    with pytest.raises(eyot.EyotError):
        island.eyot.render("nothing")
    with pytest.raises(eyot.EyotError):
        island.eyot.render(azimut=3)


def test_statistics_are_those_of_the_command(island):
    stats = eyot.stats(island)
    assert stats == island.eyot.stats()
    assert island.assign_coords(x=island.x)[["height"]].eyot.stats()


def test_a_data_set_of_others_has_a_world_too(island):
    other = island[["height"]].copy(deep=True)
    assert bytes(other.eyot.render(size=(96, 64))).startswith(b"\x89PNG")
    assert np.array_equal(other.eyot.world.array("height"), island.height)


def test_a_data_set_that_was_computed_on_is_what_it_shows(island):
    higher = island.assign(height=island.height + np.float32(100.0))
    assert higher.eyot.stats()["max_m"] == pytest.approx(island.eyot.stats()["max_m"] + 100.0)
    other = island.assign(water=island.water * 0)
    with pytest.raises(eyot.EyotError, match="water"):
        other.eyot.render("water")
    assert bytes(other.eyot.render("limestone", size=64))
