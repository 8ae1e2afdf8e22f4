"""Layers from NumPy, xarray and rioxarray, as files that a recipe can import."""

from __future__ import annotations

import os
import tempfile
import weakref
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from . import _eyot
from ._errors import EyotError


def is_array(v: Any) -> bool:
    """True for what is a raster in memory."""
    return isinstance(v, np.ndarray) or (hasattr(v, "dims") and hasattr(v, "values"))


class Kept:
    """A temporary folder for rasters; it goes with the last recipe that uses it."""

    def __init__(self) -> None:
        self.folder = Path(tempfile.mkdtemp(prefix="eyot-"))
        self._end = weakref.finalize(self, _remove, self.folder, os.getpid())
        self.count = 0

    def file(self, array: Any, cell: Any = None) -> str:
        """Writes an array and returns its path."""
        values, facts = raster(array, cell)
        self.count += 1
        path = self.folder / f"array-{self.count}.tif"
        _eyot.write_raster(path, values, **facts)
        return str(path)


def _remove(folder: Path, pid: int) -> None:
    if pid == os.getpid():
        import shutil

        shutil.rmtree(folder, ignore_errors=True)


def raster(array: Any, cell: Any = None) -> tuple[np.ndarray, dict]:
    """Values with row 0 in the north, and what is known of their place."""
    facts: dict[str, Any] = {}
    values = np.asarray(getattr(array, "values", array))
    if values.ndim == 3 and values.shape[0] == 1:
        values = values[0]
    if values.ndim != 2:
        raise EyotError(f"a layer has two dimensions, not {values.ndim}", "choose a band or a moment first")
    if values.dtype.kind not in "fiub":
        raise EyotError(f"a layer holds numbers, not {values.dtype}")
    if hasattr(array, "dims"):
        values, facts = _placed(array, values)
    nodata = getattr(getattr(array, "rio", None), "nodata", None) if hasattr(array, "dims") else None
    values = np.ascontiguousarray(values, dtype=np.float32)
    if nodata is not None and nodata == nodata:
        values = np.where(values == np.float32(nodata), np.float32(np.nan), values)
    if cell is not None:
        facts["cell"] = tuple(np.broadcast_to(np.asarray(cell, float), 2).tolist())
    facts.setdefault("cell", (1.0, 1.0))
    return values, facts


def _placed(array: Any, values: np.ndarray) -> tuple[np.ndarray, dict]:
    """The place of an xarray raster by its coordinates, and by rioxarray if that is there."""
    y_name, x_name = array.dims[-2:]
    facts: dict[str, Any] = {}
    epsg, geographic = None, False
    rio = _rio(array)
    crs = rio.crs if rio is not None else None
    if crs is not None:
        epsg, geographic = crs.to_epsg(), crs.is_geographic
    if x_name not in array.coords or y_name not in array.coords:
        return values, facts
    x, y = (np.asarray(array.coords[n].values, float) for n in (x_name, y_name))
    if len(x) < 2 or len(y) < 2:
        return values, facts
    dx, dy = (x[-1] - x[0]) / (len(x) - 1), (y[-1] - y[0]) / (len(y) - 1)
    for name, axis, d in ((x_name, x, dx), (y_name, y, dy)):
        if d == 0 or np.abs(np.diff(axis) - d).max() > 1e-3 * abs(d):
            raise EyotError(f"the coordinate `{name}` is not evenly spaced", "interpolate the layer to a regular grid")
    if dx < 0:
        values, x, dx = values[:, ::-1], x[::-1], -dx
    if dy > 0:
        values, y, dy = values[::-1], y[::-1], -dy
    facts["cell"] = (dx, -dy)
    if crs is not None:
        facts["transform"] = [x[0] - dx / 2, dx, 0.0, y[0] - dy / 2, 0.0, dy]
        facts["epsg"], facts["geographic"] = epsg, geographic
        if geographic:
            metres = 111_320.0
            facts["cell"] = (dx * metres * np.cos(np.radians(y.mean())), -dy * metres)
    return values, facts


def _rio(array: Any):
    try:
        import rioxarray  # noqa: F401
    except ImportError:
        return None
    return getattr(array, "rio", None)


def kept(v: Any, keep: Kept | None = None, cell: Any = None) -> tuple[Any, Kept | None]:
    """The same with files in the place of arrays that a recipe takes for files."""
    if is_array(v) and getattr(v, "ndim", 0) >= 2:
        keep = keep or Kept()
        return keep.file(v, cell), keep
    if isinstance(v, Mapping):
        out = {}
        for k, x in v.items():
            out[k], keep = kept(x, keep, cell)
        return out, keep
    if isinstance(v, list):
        items = []
        for x in v:
            x, keep = kept(x, keep, cell)
            items.append(x)
        return items, keep
    return v, keep
