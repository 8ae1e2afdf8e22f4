"""Makes jacksboro.tif from the elevation sample that matplotlib ships.

Usage: python make_jacksboro.py [OUTPUT]   (needs numpy, matplotlib, rasterio; see README.md for the versions used)

Rows and columns. The sample has 344 rows, 403 columns and a cell of 3 arc-seconds. Its metadata name the edges xmin,
xmax, ymin and ymax, but ymin (36.7329) is larger than ymax (36.4463): the height of the tile was added to the north
edge instead of subtracted. That the north edge is ymax, and that row 0 lies there, is checked below against the land:
the highest cell must be the summit of Cross Mountain (36.1983 N, 84.2306 W), and Caryville (36.299 N, 84.223 W) must
lie in the valley.
"""

import pathlib
import sys

import matplotlib
import numpy as np
import rasterio
from rasterio.transform import from_origin

sample = pathlib.Path(matplotlib.get_data_path()) / "sample_data" / "jacksboro_fault_dem.npz"
with np.load(sample) as dem:
    heights = dem["elevation"]
    dx, dy = float(dem["dx"]), float(dem["dy"])
    west, east, north = float(dem["xmin"]), float(dem["xmax"]), float(dem["ymax"])

rows, columns = heights.shape
assert (rows, columns) == (344, 403) and heights.dtype == np.int16
# xmin and xmax are outer edges of cells, not their middles.
assert abs((east - west) / columns - dx) < 1e-9 and abs(dx - 1 / 1200) < 1e-12 and dx == dy


def cell(latitude, longitude):
    return int((north - latitude) / dy), int((longitude - west) / dx)


top = np.unravel_index(heights.argmax(), heights.shape)
wanted = cell(36.1983, -84.2306)
assert max(abs(top[0] - wanted[0]), abs(top[1] - wanted[1])) <= 1, (top, wanted)
assert heights[cell(36.299, -84.223)] < 340, "Caryville is not in the valley"

output = sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).with_name("jacksboro.tif")
profile = dict(
    driver="GTiff", width=columns, height=rows, count=1, dtype="int16", crs="EPSG:4326", nodata=-32768,
    transform=from_origin(west, north, dx, dy), compress="deflate", predictor=2, zlevel=9,
)
with rasterio.open(output, "w", **profile) as tif:
    tif.write(heights, 1)
    tif.set_band_unit(1, "metre")
    tif.update_tags(SOURCE="USGS SRTM 3 arc-seconds by way of matplotlib, public domain")
print(output, pathlib.Path(output).stat().st_size, "bytes")
