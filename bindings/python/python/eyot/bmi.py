"""Recipes as models with a Basic Model Interface (needs bmipy)."""

from __future__ import annotations

from typing import Any

import numpy as np

from ._errors import EyotError, need
from ._run import Run

need("bmipy", "a Basic Model Interface")
from bmipy import Bmi  # noqa: E402


class BmiEyot(Bmi):
    """A recipe as a BMI model, version 2.0.

    ``initialize`` takes the path of a recipe or the name of a built-in one. Time is counted in steps of simulation, since not every recipe has a
    clock. All layers on cells are variables, on one uniform rectilinear grid whose node (0, 0) is the south-western cell, as BMI has it.

    >>> from eyot.bmi import BmiEyot
    >>> model = BmiEyot()
    >>> model.initialize("island")
    >>> model.update_until(10)
    >>> float(model.get_value_ptr("height").max()) > 500.0
    True
    >>> model.finalize()
    """

    def __init__(self, **options: Any) -> None:
        self._options: dict[str, Any] = options
        self._run: Run | None = None
        self._time, self._end = 0, 0
        self._values: dict[str, np.ndarray] = {}

    # The course of the model.

    def initialize(self, config_file: str) -> None:
        self._run = Run(config_file, paused=True, **self._options)
        self._end = sum(s["steps"] for s in self._run.recipe.steps if s["enabled"] and "simulate" in s)
        self._time, self._values = 0, {}
        # Until the first simulation there are no layers.
        while self._time == 0 and self._run.status != "finished":
            self._run.step(1)
            self._look()

    def update(self) -> None:
        self.update_until(self._time + 1)

    def update_until(self, time: float) -> None:
        model = self._model
        if time < self._time or time != int(time):
            raise EyotError(f"{time} is no later whole step than {self._time}", "give a later number of steps")
        # Generators between simulations count as steps of a run, not of the model.
        while self._time < time and model.status != "finished":
            model.step(int(time) - self._time)
            self._look()

    def finalize(self) -> None:
        if self._run is not None:
            self._run.__exit__()
        self._run, self._values = None, {}

    @property
    def _model(self) -> Run:
        if self._run is None:
            raise EyotError("the model is not initialized", "call initialize() first")
        return self._run

    def _look(self) -> None:
        """Takes over what the model has made. What was handed out keeps its memory, as BMI asks."""
        ds = self._model.snapshot()
        self._time = ds.attrs["steps_done"]
        self._cell, self._shape = ds.attrs["cell_m"], ds["height"].shape
        for name, layer in ds.data_vars.items():
            if layer.dims != ("y", "x"):
                continue
            values = layer.values[::-1].ravel()
            if name in self._values:
                self._values[name][:] = values
            else:
                self._values[name] = values.copy()
        self._units = {name: layer.attrs["units"] for name, layer in ds.data_vars.items()}

    # What it is.

    def get_component_name(self) -> str:
        return "Eyot"

    def get_input_item_count(self) -> int:
        return len(self.get_input_var_names())

    def get_output_item_count(self) -> int:
        return len(self.get_output_var_names())

    def get_input_var_names(self) -> tuple[str, ...]:
        return tuple(self._values)

    def get_output_var_names(self) -> tuple[str, ...]:
        return tuple(self._values)

    # Time.

    def get_start_time(self) -> float:
        return 0.0

    def get_current_time(self) -> float:
        return float(self._time)

    def get_end_time(self) -> float:
        return float(self._end)

    def get_time_step(self) -> float:
        return 1.0

    def get_time_units(self) -> str:
        return "1"

    # Variables.

    def _variable(self, name: str) -> np.ndarray:
        if name not in self._values:
            raise EyotError(f"there is no variable `{name}`", f"there is: {', '.join(self._values)}")
        return self._values[name]

    def get_var_grid(self, name: str) -> int:
        self._variable(name)
        return 0

    def get_var_type(self, name: str) -> str:
        return str(self._variable(name).dtype)

    def get_var_units(self, name: str) -> str:
        self._variable(name)
        return self._units[name]

    def get_var_itemsize(self, name: str) -> int:
        return self._variable(name).itemsize

    def get_var_nbytes(self, name: str) -> int:
        return self._variable(name).nbytes

    def get_var_location(self, name: str) -> str:
        self._variable(name)
        return "node"

    def get_value(self, name: str, dest: np.ndarray) -> np.ndarray:
        dest[:] = self._variable(name)
        return dest

    def get_value_ptr(self, name: str) -> np.ndarray:
        return self._variable(name)

    def get_value_at_indices(self, name: str, dest: np.ndarray, inds: np.ndarray) -> np.ndarray:
        dest[:] = self._variable(name)[inds]
        return dest

    def set_value(self, name: str, src: np.ndarray) -> None:
        values = self._variable(name)
        new = np.asarray(src, np.float32).reshape(self._shape)
        with self._model.paused() as world:
            world[name] = new[::-1]
        values[:] = new.ravel()

    def set_value_at_indices(self, name: str, inds: np.ndarray, src: np.ndarray) -> None:
        values = self._variable(name).copy()
        values[inds] = src
        self.set_value(name, values)

    # The grid.

    def get_grid_rank(self, grid: int) -> int:
        return 2

    def get_grid_size(self, grid: int) -> int:
        return int(np.prod(self._shape))

    def get_grid_type(self, grid: int) -> str:
        return "uniform_rectilinear"

    def get_grid_shape(self, grid: int, shape: np.ndarray) -> np.ndarray:
        shape[:] = self._shape
        return shape

    def get_grid_spacing(self, grid: int, spacing: np.ndarray) -> np.ndarray:
        spacing[:] = self._cell[::-1]
        return spacing

    def get_grid_origin(self, grid: int, origin: np.ndarray) -> np.ndarray:
        # The middle of the south-western cell, y first.
        origin[:] = [c / 2 for c in self._cell[::-1]]
        return origin

    def get_grid_x(self, grid: int, x: np.ndarray) -> np.ndarray:
        x[:] = (np.arange(self._shape[1]) + 0.5) * self._cell[0]
        return x

    def get_grid_y(self, grid: int, y: np.ndarray) -> np.ndarray:
        y[:] = (np.arange(self._shape[0]) + 0.5) * self._cell[1]
        return y

    def get_grid_z(self, grid: int, z: np.ndarray) -> np.ndarray:
        raise NotImplementedError("the grid is flat")

    def get_grid_node_count(self, grid: int) -> int:
        return self.get_grid_size(grid)

    def get_grid_edge_count(self, grid: int) -> int:
        raise NotImplementedError("the grid is no mesh")

    def get_grid_face_count(self, grid: int) -> int:
        raise NotImplementedError("the grid is no mesh")

    def get_grid_edge_nodes(self, grid: int, edge_nodes: np.ndarray) -> np.ndarray:
        raise NotImplementedError("the grid is no mesh")

    def get_grid_face_edges(self, grid: int, face_edges: np.ndarray) -> np.ndarray:
        raise NotImplementedError("the grid is no mesh")

    def get_grid_face_nodes(self, grid: int, face_nodes: np.ndarray) -> np.ndarray:
        raise NotImplementedError("the grid is no mesh")

    def get_grid_nodes_per_face(self, grid: int, nodes_per_face: np.ndarray) -> np.ndarray:
        raise NotImplementedError("the grid is no mesh")
