"""Processes of Eyot as components of Landlab (needs landlab)."""

from __future__ import annotations

from typing import Any

import numpy as np

from . import _eyot
from ._errors import EyotError, need
from ._run import Run

need("landlab", "a component of Landlab")
from landlab import Component, RasterModelGrid  # noqa: E402

#: Steps that a component can do; no more than a recipe may ask for.
_STEPS = 1_000_000_000


class EyotProcess(Component):
    """A process of Eyot that works on ``topographic__elevation``.

    >>> from landlab import RasterModelGrid
    >>> from eyot.landlab import EyotProcess
    >>> grid = RasterModelGrid((20, 30), xy_spacing=100.0)
    >>> z = grid.add_zeros("topographic__elevation", at="node")
    >>> z += grid.x_of_node * 0.01
    >>> rivers = EyotProcess(grid, "streampower", uplift=0.001)
    >>> rivers.run_one_step(dt=1000.0)

    Between two steps other components may change the field. Node (0, 0) is in the south-west, as Landlab has it. The rim is open if all nodes of the
    perimeter are (Landlab's own usage), closed if all are closed; a mixture is refused.

    Parameters
    ----------
    grid
        A raster.
    process
        The name of a process (``eyot.processes()``) that needs no other layer than the height.
    parameters
        Of the process, as ``eyot.describe(process)`` lists them.
    """

    _name = "EyotProcess"
    _unit_agnostic = False
    _info = {
        "topographic__elevation": {
            "dtype": float,
            "intent": "inout",
            "optional": False,
            "units": "m",
            "mapping": "node",
            "doc": "Land surface topographic elevation",
        },
    }

    def __init__(self, grid: RasterModelGrid, process: str = "streampower", **parameters: Any) -> None:
        if not isinstance(grid, RasterModelGrid):
            raise EyotError(f"Eyot works on rasters, not on a {type(grid).__name__}", "make a RasterModelGrid")
        super().__init__(grid)
        known = {p["name"] for p in _eyot.describe(process)["parameters"]}
        self._process, self._has_years = process, "years_per_step" in known
        rows, columns = grid.shape
        recipe = {
            "name": process,
            "sea_level": "none",
            "grid": {"size": [columns, rows], "cell": [float(grid.dx), float(grid.dy)], "rim": _rim(grid)},
            "steps": [
                {"generate": "import", "file": self._heights().astype(np.float32)},
                {"simulate": [process], "steps": _STEPS, process: parameters},
            ],
        }
        self._run = Run(recipe, paused=True)
        self._run.step(1)

    def _heights(self) -> np.ndarray:
        z = self.grid.at_node["topographic__elevation"].reshape(self.grid.shape)
        return z[::-1]

    def run_one_step(self, dt: float = 1.0) -> None:
        """Lets the process act: for ``dt`` years if it counts in years, else for ``dt`` of its steps, a whole number."""
        steps = 1
        if self._has_years:
            if dt != getattr(self, "_dt", None):
                self._run.set(**{f"{self._process}.years_per_step": float(dt)})
                self._dt = dt
        elif dt < 1 or dt != int(dt):
            raise EyotError(f"`{self._process}` does whole steps, not {dt}", "give the number of its steps")
        else:
            steps = int(dt)
        z = self._heights()
        with self._run.paused() as world:
            # The field has more digits than a layer; what a layer cannot hold is in another one, if the process has it.
            world["height"] = z
            if "height_rest" in world:
                world["height_rest"] = z - world["height"].astype(float)
        self._run.step(steps)
        for event in self._run.events():
            if event["event"] == "not_changed":
                raise EyotError(f"`{event['set']}` cannot be: {event['reason']}")
        with self._run.paused() as world:
            z[:] = world["height"]
            if "height_rest" in world:
                z += world["height_rest"]

    @property
    def run(self) -> Run:
        """The run behind the component, for its other layers: ``component.run.snapshot()``, whose row 0 is north."""
        return self._run


def _rim(grid: RasterModelGrid) -> str:
    closed = grid.status_at_node[grid.perimeter_nodes] == grid.BC_NODE_IS_CLOSED
    if closed.all():
        return "closed"
    if closed.any():
        raise EyotError("some nodes of the perimeter are closed and others are not", "close all four sides, or none")
    return "open"
