"""Cuts island-reef.tif out of the island that `eyot run island --out island` makes.

Usage: python make_island_reef.py island [OUTPUT]   (needs numpy, rasterio; see README.md for the versions used)

The eastern reef: lagoon, crest and outer slope, 300 x 160 m around the 200 x 60 m of the recipe `reef-slope`, as heights over
the sea at the end of the run. What makes it a reef slope is checked.
"""

import json
import pathlib
import sys

import numpy as np
import rasterio
from rasterio.transform import from_origin

COLUMN, ROW, COLUMNS, ROWS = 442, 248, 30, 16

folder = pathlib.Path(sys.argv[1])
sea = json.loads((folder / "run.json").read_text())["sea_level_m"]
with rasterio.open(folder / "height.tif") as tif:
    heights = tif.read(1)[ROW : ROW + ROWS, COLUMN : COLUMN + COLUMNS].astype("f8") - sea
heights = np.round(heights, 2).astype("f4")

middle = heights[ROWS // 2]
crest = int(middle[5:20].argmax()) + 5
assert -1.5 < middle[crest] < 0, "the crest is just below the water"
assert middle[:crest].min() < -5, "a lagoon behind it"
assert -35 < middle[-1] < middle[crest + 1] - 10, "a slope before it"

output = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else pathlib.Path(__file__).with_name("island-reef.tif")
profile = dict(driver="GTiff", width=COLUMNS, height=ROWS, count=1, dtype="float32", compress="deflate", predictor=3)
with rasterio.open(output, "w", transform=from_origin(0, 10 * ROWS, 10, 10), **profile) as tif:
    tif.write(heights, 1)
    tif.set_band_description(1, "height")
    tif.units = ("m",)
print(output, heights.shape, heights.min(), heights.max())
