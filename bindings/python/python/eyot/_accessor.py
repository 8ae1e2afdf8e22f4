"""``ds.eyot``: what a data set of a landscape can be asked."""

from __future__ import annotations

import base64
import json
from typing import Any

import numpy as np
import xarray as xr

from . import _arrays, _components, _eyot, _run
from ._dataset import world_of
from ._errors import EyotError


class Picture:
    """A PNG picture, which a notebook shows. ``bytes(picture)`` are its bytes."""

    def __init__(self, png: bytes) -> None:
        self.png = png

    def __bytes__(self) -> bytes:
        return self.png

    def _repr_png_(self) -> bytes:
        return self.png

    def save(self, path: Any) -> None:
        """Writes the file."""
        with open(path, "wb") as file:
            file.write(self.png)

    def array(self) -> np.ndarray:
        """Pixels, rows from the top, red, green and blue; needs Pillow."""
        import io

        from ._errors import need

        return np.asarray(need("PIL.Image", "a picture as an array").open(io.BytesIO(self.png)))


@xr.register_dataset_accessor("eyot")
class Accessor:
    """What Eyot knows of a data set beside its arrays.

    Data sets of :func:`eyot.run`, :func:`eyot.open` and :meth:`eyot.Run.snapshot` know their whole world; those of others, such as
    recordings opened with :func:`xarray.open_zarr`, have heights and layers alone.
    """

    def __init__(self, ds: xr.Dataset) -> None:
        self._ds = ds
        self._made: _eyot.World | None = None

    @property
    def world(self) -> _eyot.World:
        """The world: that of the run, or one made of the height if the data set has another one by now."""
        return self._showing()

    def _showing(self, *layers: str) -> _eyot.World:
        if (world := world_of(self._ds, *layers)) is not None:
            return world
        if self._made is None:
            self._made = self._of_height()
        return self._made

    def _of_height(self) -> _eyot.World:
        if "height" not in self._ds:
            raise EyotError("the data set has no layer `height`", f"it has: {', '.join(map(str, self._ds.data_vars))}")
        height = self._ds["height"]
        if height.ndim != 2:
            extra = [d for d in height.dims if d not in ("x", "y")]
            raise EyotError(f"the height has the dimensions {height.dims}", f"choose a moment first: ds.isel({extra[0]}=-1).eyot")
        values, facts = _arrays.raster(height, self._ds.attrs.get("cell_m") if "x" not in self._ds.coords else None)
        path = _run._temporary("height.tif")
        try:
            _eyot.write_raster(path, values, **facts)
            return _eyot.open(path)[0]
        finally:
            import shutil

            shutil.rmtree(path.parent, ignore_errors=True)

    @property
    def ledger(self) -> dict[str, dict[str, Any]]:
        """What entered, left, moved and was clamped: ``amount``, ``unit``, ``meaning`` and ``sign`` by account."""
        return json.loads(self._ds.attrs.get("ledger", "{}"))

    @property
    def fingerprint(self) -> str:
        """Fingerprint of the world, hexadecimal."""
        return self._ds.attrs.get("fingerprint") or self.world.fingerprint()

    def stats(self, channel_area_m2: float | None = None) -> dict[str, Any]:
        """Statistics of the terrain, and of climate, plates, rivers and lakes if there are some, as ``eyot stats --json``."""
        return self.world.stats(channel_area_m2)

    def render(
        self,
        layer: str | None = None,
        *,
        relief: bool = False,
        drape: str | None = None,
        size: int | tuple[int, int] | None = None,
        engine: str | None = None,
        adapter: str | None = None,
        **look: Any,
    ) -> Picture:
        """A picture: the land as a camera sees it, its ``relief`` from above, or a map of a ``layer``.

        ``drape`` covers the land with a layer's colours. ``size`` is in pixels; ``look`` are keys of the recipe's view, such as
        ``azimuth`` and ``elevation`` (``eyot.describe("view")`` lists them).
        """
        if size is not None:
            look["size"] = list(size) if isinstance(size, (tuple, list)) else [size, size if relief or layer else size * 2 // 3]
        subject = f"layer:{layer}" if layer else "relief" if relief else "view"
        world = self._showing(*(n for n in (layer, drape) if n))
        return Picture(_run.picture(lambda path: world.draw(path, subject, json.dumps(look), drape, engine, adapter)))

    @property
    def components(self) -> dict[str, str]:
        """What the world keeps beside layers: ``table``, ``points``, ``lines`` or ``features``, by name."""
        return dict(self.world.components())

    def table(self, name: str, form: str = "pandas") -> Any:
        """Rows of a component, such as a census or the places of trees: ``pandas``, ``arrow`` (needs pyarrow) or ``numpy``."""
        return _components.table(self.world, name, form)

    def frame(self, name: str) -> Any:
        """Rivers, lakes or points as a GeoPandas frame (needs geopandas)."""
        return _components.frame(self.world, name)

    def _repr_html_(self) -> str:
        png = base64.b64encode(bytes(self.render(size=(480, 320)))).decode()
        title = self._ds.attrs.get("title", "")
        head = f"<b>{title}</b> {self._ds.attrs.get('fingerprint', '')}"
        return f'<div>{head}<br><img alt="{title}" src="data:image/png;base64,{png}"></div>'


def render(ds: xr.Dataset, layer: str | None = None, **options: Any) -> Picture:
    """A picture of a landscape; see :meth:`Accessor.render`."""
    return ds.eyot.render(layer, **options)


def stats(ds: xr.Dataset, channel_area_m2: float | None = None) -> dict[str, Any]:
    """Statistics of a landscape; see :meth:`Accessor.stats`."""
    return ds.eyot.stats(channel_area_m2)
