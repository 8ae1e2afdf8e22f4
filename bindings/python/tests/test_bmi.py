"""The Basic Model Interface."""

import doctest

import numpy as np
import pytest

pytest.importorskip("bmipy")

import eyot  # noqa: E402
import eyot.bmi  # noqa: E402
from eyot.bmi import BmiEyot  # noqa: E402

RAMP = """
name = "Ramp"
[grid]
size = [12, 8]
cell = [10.0, 20.0]
[[step]]
generate = "ramp"
[[step]]
simulate = ["hydraulic"]
steps = 20
"""


@pytest.fixture
def model(tmp_path):
    (tmp_path / "ramp.toml").write_text(RAMP)
    model = BmiEyot()
    model.initialize(str(tmp_path / "ramp.toml"))
    yield model
    model.finalize()


def test_a_model_ends_with_the_bytes_of_a_run(model):
    model.update_until(7)
    assert model.get_current_time() == 7.0 and model.get_end_time() == 20.0
    model.update_until(model.get_end_time())
    height = model.get_value("height", np.empty(model.get_grid_size(0), np.float32))
    assert np.array_equal(height.reshape(8, 12)[::-1], eyot.run(RAMP).height)


def test_the_grid_begins_in_the_south_west(model):
    assert list(model.get_grid_shape(0, np.empty(2, int))) == [8, 12]
    assert list(model.get_grid_spacing(0, np.empty(2))) == [20.0, 10.0]
    assert list(model.get_grid_origin(0, np.empty(2))) == [10.0, 5.0]
    ds = model._model.snapshot()
    at = 3 * 12 + 5
    here = ds.height.sel(x=model.get_grid_x(0, np.empty(12))[5], y=model.get_grid_y(0, np.empty(8))[3])
    assert model.get_value_at_indices("height", np.empty(1), np.array([at]))[0] == float(here)


def test_values_can_be_set(model):
    pointer = model.get_value_ptr("height")
    model.set_value_at_indices("height", np.array([0, 95]), np.array([7.0, 9.0]))
    assert pointer[0] == 7.0 and pointer[95] == 9.0
    ds = model._model.snapshot()
    # South-west and north-east.
    assert ds.height.values[-1, 0] == 7.0 and ds.height.values[0, -1] == 9.0
    model.update()
    assert model.get_value_ptr("height") is pointer


def test_every_method_of_the_interface_is_there_and_named_things_must_be():
    assert not BmiEyot.__abstractmethods__
    with pytest.raises(eyot.EyotError, match="initialize"):
        BmiEyot().update_until(1)


def test_the_example_is_true():
    assert doctest.testmod(eyot.bmi).failed == 0
