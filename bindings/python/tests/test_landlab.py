"""The component for Landlab, beside Landlab's own."""

import doctest

import numpy as np
import pytest

pytest.importorskip("landlab")
from landlab import RasterModelGrid  # noqa: E402
from landlab.components import LinearDiffuser  # noqa: E402

import eyot.landlab  # noqa: E402
from eyot.landlab import EyotProcess  # noqa: E402


def hill(shape=(41, 51), north=30):
    grid = RasterModelGrid(shape, xy_spacing=10.0)
    z = grid.add_zeros("topographic__elevation", at="node")
    y, x = np.divmod(np.arange(z.size), shape[1])
    z += 50.0 * np.exp(-((x - 20.0) ** 2 + (y - north) ** 2) / 40.0)
    return grid, z


def test_creep_is_landlabs_diffusion_and_rows_start_in_the_south():
    grid, z = hill()
    other, theirs = hill()
    ours = EyotProcess(grid, "streampower", uplift=0.0, erodibility=0.0, diffusivity=0.5)
    diffuser = LinearDiffuser(other, linear_diffusivity=0.5)
    for _ in range(40):
        ours.run_one_step(dt=10.0)
        diffuser.run_one_step(dt=10.0)
    assert np.abs(z).max() < 45.0
    assert np.abs(z - theirs).max() < 0.01 * np.abs(theirs).max()
    # The hill is in the north: where Landlab has it.
    assert np.argmax(z) == np.argmax(theirs)


def test_what_others_change_between_steps_counts():
    grid, z = hill()
    creep = EyotProcess(grid, "streampower", uplift=0.0, erodibility=0.0, diffusivity=0.0)
    creep.run_one_step(dt=10.0)
    before = z.copy()
    # Less than a layer of 32 bits could hold beside 50 m.
    z += 1e-7
    creep.run_one_step(dt=10.0)
    assert np.allclose(z, before + 1e-7, rtol=0, atol=1e-9)


def test_processes_without_years_count_their_steps():
    grid, z = hill()
    steep = np.abs(np.diff(z)).max()
    EyotProcess(grid, "thermal", talus=10.0).run_one_step(dt=50)
    assert np.abs(np.diff(z)).max() < steep
    with pytest.raises(eyot.EyotError, match="whole"):
        EyotProcess(hill()[0], "thermal").run_one_step(dt=0.5)


def test_what_cannot_be_is_refused():
    grid, _ = hill()
    with pytest.raises(eyot.RecipeError):
        EyotProcess(grid, "streampower", upliff=0.0)
    grid.set_closed_boundaries_at_grid_edges(True, False, False, False)
    with pytest.raises(eyot.EyotError, match="perimeter"):
        EyotProcess(grid)


def test_the_example_is_true():
    assert doctest.testmod(eyot.landlab).failed == 0
