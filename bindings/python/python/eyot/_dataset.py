"""Worlds as data sets."""

from __future__ import annotations

import json
import warnings
from typing import Any

import numpy as np
import xarray as xr

from . import _eyot


def _axis(n: int, first: float, step: float, at: float) -> np.ndarray:
    return first + (np.arange(n) + at) * step


def dataset(world: _eyot.World, attrs: dict[str, Any] | None = None) -> xr.Dataset:
    """A world as a data set that follows the CF conventions.

    Layers are arrays on the world's own memory, which nobody can write to. Row 0 is north. ``x`` and ``y`` are the middles of cells: m from the
    south-west corner, or coordinates of the world's own reference system. What lives on faces has the dimension ``x_face`` or ``y_face``.
    """
    facts = world.facts()
    (columns, rows), (cell_x, cell_y) = facts["size"], facts["cell"]
    place = facts.get("georeference")
    if place is None or place["transform"][2] or place["transform"][4]:
        place, left, dx, top, dy = None, 0.0, cell_x, rows * cell_y, -cell_y
    else:
        left, dx, _, top, _, dy = place["transform"]
    geographic = bool(place and place["geographic"])
    unit = {"x": "degrees_east", "y": "degrees_north"} if geographic else {"x": "m", "y": "m"}
    standard = {"x": "longitude", "y": "latitude"} if geographic else {a: f"projection_{a}_coordinate" for a in "xy"}

    def coordinate(axis: str, n: int, first: float, step: float, at: float) -> tuple:
        names = {"axis": axis.upper(), "units": unit[axis], "standard_name": standard[axis]}
        names["long_name"] = f"{'middle' if at == 0.5 else 'face'} of cells, {'eastward' if axis == 'x' else 'northward'}"
        return (axis if at == 0.5 else f"{axis}_face",), _axis(n, first, step, at), names

    coords: dict[str, Any] = {
        "x": coordinate("x", columns, left, dx, 0.5),
        "y": coordinate("y", rows, top, dy, 0.5),
    }
    layers: dict[str, Any] = {}
    dims = {"Cell": ("y", "x"), "FaceX": ("y", "x_face"), "FaceY": ("y_face", "x")}
    for layer in world.layers():
        dim = dims[layer["centering"]]
        if "x_face" in dim:
            coords.setdefault("x_face", coordinate("x", columns, left, dx, 1.0))
        if "y_face" in dim:
            coords.setdefault("y_face", coordinate("y", rows, top, dy, 1.0))
        names = {"long_name": layer["meaning"], "units": layer["unit"]}
        if layer["name"] == "height":
            names["standard_name"] = "surface_altitude"
        low, high = layer["range"]
        if np.isfinite([low, high]).all():
            names["valid_range"] = [low, high]
        if place is not None:
            names["grid_mapping"] = "spatial_ref"
        layers[layer["name"]] = (dim, world.array(layer["name"]), names)
    if place is not None:
        names = {"GeoTransform": " ".join(repr(v) for v in place["transform"])}
        if place["epsg"]:
            names["spatial_ref"] = f"EPSG:{place['epsg']}"
        coords["spatial_ref"] = ((), np.int32(0), names)
    ledger = {n: {"amount": a, "unit": u, "meaning": m, "sign": s} for n, a, u, m, s in world.ledger()}
    about = {
        "Conventions": "CF-1.11",
        "source": f"Eyot {_eyot.VERSION}",
        "version": _eyot.VERSION,
        "seed": facts["seed"],
        "sea_level_m": facts["sea_level"],
        "steps_done": facts["step"],
        "cell_m": [cell_x, cell_y],
        "ledger": json.dumps(ledger),
    }
    attrs = {**about, **(attrs or {})}
    attrs.setdefault("fingerprint", world.fingerprint())
    return xr.Dataset(layers, coords, attrs)


def world_of(ds: xr.Dataset, *layers: str) -> _eyot.World | None:
    """The world on whose memory the height of a data set and these layers lie, if they still do and are whole.

    What was computed from them is an array of its own: then the world is not what the data set shows.
    """
    shown = [n for n in ("height", *layers) if n in ds.data_vars] or list(ds.data_vars)[:1]
    worlds = [_owner(ds[n]) for n in shown]
    return worlds[0] if worlds and all(w is worlds[0] for w in worlds) else None


def _owner(layer: xr.DataArray) -> _eyot.World | None:
    owner = layer.variable._data
    while isinstance(owner, np.ndarray):
        owner = owner.base
    if not isinstance(owner, _eyot.World):
        return None
    columns, rows = owner.facts()["size"]
    return owner if layer.shape == (rows, columns) else None


def warn(notes: list[str]) -> None:
    """Says what is to be known."""
    for note in notes:
        warnings.warn(note, stacklevel=3)
