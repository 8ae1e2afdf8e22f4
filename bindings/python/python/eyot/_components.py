"""What worlds keep beside layers: tables, points, lines and polygons."""

from __future__ import annotations

from typing import Any

import numpy as np

from . import _eyot
from ._errors import EyotError, need


def component(world: _eyot.World, name: str) -> dict[str, Any]:
    """The arrays of a component."""
    found = world.component(name)
    if found is None:
        there = ", ".join(n for n, _ in world.components()) or "nothing"
        raise EyotError(f"the world keeps no `{name}`", f"it keeps: {there}")
    return found


def columns(world: _eyot.World, name: str) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """Columns and their units; places are ``x`` and ``y`` as in data sets, and ``z`` above the datum, m."""
    found = component(world, name)
    values = {n: v for n, _, v in found["columns"]}
    units = {n: u for n, u, _ in found["columns"]}
    if "positions" in found:
        xyz = _placed(world, found["positions"])
        for i, axis in enumerate("xyz"):
            # A column of the same name keeps it.
            values.setdefault(axis, xyz[:, i])
            units.setdefault(axis, "m")
    return values, units


def _placed(world: _eyot.World, xyz: np.ndarray) -> np.ndarray:
    """From m east and south of the north-west corner to the coordinates of the data set."""
    facts = world.facts()
    (_, rows), (cell_x, cell_y) = facts["size"], facts["cell"]
    out = np.array(xyz, np.float64)
    if place := facts.get("georeference"):
        t = place["transform"]
        column, row = out[:, 0] / cell_x, out[:, 1] / cell_y
        out[:, 0] = t[0] + column * t[1] + row * t[2]
        out[:, 1] = t[3] + column * t[4] + row * t[5]
    else:
        out[:, 1] = rows * cell_y - out[:, 1]
    return out


def table(world: _eyot.World, name: str, form: str) -> Any:
    """Rows of a component."""
    values, units = columns(world, name)
    if form == "numpy":
        return values
    if form == "arrow":
        pa = need("pyarrow", "a table for Arrow")
        fields = [pa.field(n, pa.array(v[:0]).type, metadata={"unit": units[n]}) for n, v in values.items()]
        return pa.table([pa.array(v) for v in values.values()], schema=pa.schema(fields))
    if form == "pandas":
        frame = need("pandas", "a table").DataFrame(values)
        frame.attrs["units"] = units
        return frame
    raise EyotError(f"there is no table `{form}`", "there is pandas, arrow and numpy")


def frame(world: _eyot.World, name: str) -> Any:
    """A component that lies somewhere, as a GeoPandas frame."""
    gpd = need("geopandas", "a frame of lines, polygons or points")
    shapely = need("shapely", "a frame of lines, polygons or points")
    found = component(world, name)
    place = world.facts().get("georeference")
    crs = f"EPSG:{place['epsg']}" if place and place["epsg"] else None
    if "features" in found:
        shapes = [_shape(shapely, world, parts, rings) for parts, rings in zip(found["features"], found["rings"], strict=True)]
        rows = {n: v for n, _, v in found["columns"]}
    elif "edges" in found:
        xyz = _placed(world, found["positions"])
        edges = found["edges"].astype(int)
        shapes = list(shapely.linestrings(xyz[edges])) if len(edges) else []
        rows = {"from": edges[:, 0], "to": edges[:, 1], **{n: v for n, _, v in found["edge_columns"]}}
    elif "positions" in found:
        shapes = shapely.points(_placed(world, found["positions"]))
        rows = {n: v for n, _, v in found["columns"]}
    else:
        raise EyotError(f"`{name}` is a table, which lies nowhere", f"take ds.eyot.table({name!r})")
    return gpd.GeoDataFrame(rows, geometry=gpd.GeoSeries(list(shapes)), crs=crs)


def _shape(shapely: Any, world: _eyot.World, parts: list[np.ndarray], rings: list[int]) -> Any:
    placed = [_placed(world, part) for part in parts]
    if not rings:
        return shapely.LineString(placed[0]) if len(placed) == 1 else shapely.MultiLineString(placed)
    polygons, at = [], 0
    for n in rings:
        polygons.append(shapely.Polygon(placed[at], placed[at + 1 : at + n]))
        at += n
    return polygons[0] if len(polygons) == 1 else shapely.MultiPolygon(polygons)
