"""Opens vector files with GDAL, as geographic programs do, and compares them with each other and with the run's GeoTIFF.

Usage: python check_vectors.py FOLDER

FOLDER holds a run of vectors.toml. Prints each failure and at the end "N passed, M failed".
"""

import pathlib
import struct
import sys

import numpy as np
import pyogrio
import rasterio

from checks import check, finish


def vertices(wkb):
    """All lines and rings of a geometry, each as rows of (x, y, z), from its well-known binary."""
    found = []

    def count(at):
        return struct.unpack_from("<I", wkb, at)[0], at + 4

    def line(at):
        n, at = count(at)
        found.append(np.frombuffer(wkb, "<f8", 3 * n, at).reshape(n, 3))
        return at + 24 * n

    def geometry(at):
        # 2 is a line, 3 a polygon, 5 and 6 are several of them; the rest of the number says that there are heights.
        kind, at = count(at + 1)
        kind = (kind & 0x0FFFFFFF) % 1000
        if kind == 2:
            return line(at)
        parts, at = count(at)
        for _ in range(parts):
            at = line(at) if kind == 3 else geometry(at)
        return at

    geometry(0)
    return found


def read(path):
    meta, _, shapes, columns = pyogrio.raw.read(path)
    table = dict(zip(meta["fields"], columns))
    return meta, [vertices(s) for s in shapes], table


folder = pathlib.Path(sys.argv[1])
with rasterio.open(folder / "height.tif") as tif:
    bounds, crs, cell, heights = tif.bounds, tif.crs, tif.transform.a, tif.read(1)
files = {f: read(folder / f) for f in ["rivers.geojson", "rivers.fgb", "rivers.gpkg", "lakes.gpkg", "contours.fgb"]}
for name, (meta, shapes, _) in files.items():
    check(name, "has features", len(shapes) > 10, len(shapes))
    # GDAL calls longitude, latitude and height of GeoJSON by the code of the three.
    system = {"EPSG:4979": "EPSG:4326"}.get(meta["crs"], meta["crs"])
    check(name, "has the raster's coordinate system", rasterio.crs.CRS.from_user_input(system) == crs, system)
    every = np.concatenate([part for shape in shapes for part in shape])
    inside = (
        (every[:, 0] >= bounds.left - cell) & (every[:, 0] <= bounds.right + cell)
        & (every[:, 1] >= bounds.bottom - cell) & (every[:, 1] <= bounds.top + cell)
    )
    check(name, "lies in the raster", inside.all(), np.count_nonzero(~inside))
    # The ground near each vertex, to the north and to the south of which others would have to be found if rows were turned.
    columns = np.clip(((every[:, 0] - bounds.left) / cell).astype(int), 0, heights.shape[1] - 1)
    rows = np.clip(((bounds.top - every[:, 1]) / abs(tif.transform.e)).astype(int), 0, heights.shape[0] - 1)
    off = np.median(np.abs(heights[rows, columns] - every[:, 2]))
    check(name, "lies on the ground", off < 10.0, off)

_, lines, table = files["rivers.geojson"]
order = np.argsort(table["HYRIV_ID"])
for name in ["rivers.fgb", "rivers.gpkg"]:
    _, others, columns = files[name]
    at = np.argsort(columns["HYRIV_ID"])
    for key in table:
        same = np.array_equal(table[key][order], columns[key][at], equal_nan=True)
        check(name, f"has the same {key} as the GeoJSON", same)
    worst = max(np.abs(lines[i][0] - others[j][0]).max() for i, j in zip(order, at))
    check(name, "has the same lines as the GeoJSON", worst < 1e-3, worst)
uphill = max(np.diff(line[0][:, 2]).max() for line in lines)
check("rivers.geojson", "no river runs uphill", uphill <= 0.0, uphill)
known = set(table["HYRIV_ID"].tolist()) | {0}
check("rivers.geojson", "what is downstream is there", set(table["NEXT_DOWN"].tolist()) <= known)
_, shores, _ = files["lakes.gpkg"]
level = all(len(np.unique(np.concatenate(shore)[:, 2])) == 1 for shore in shores)
check("lakes.gpkg", "lakes are level", level)
_, lines, table = files["contours.fgb"]
check("contours.fgb", "heights are multiples of 100 m", (table["height"] % 100 == 0).all())
check("contours.fgb", "lines have their height", all((line[0][:, 2] == z).all() for line, z in zip(lines, table["height"])))
finish()
