"""Makes earth.tif from the one-degree relief that Debian's package ferret-datasets ships.

Usage: python make_earth.py etopo60.cdf [OUTPUT]   (needs numpy, scipy, rasterio; see README.md for the versions used)

The file has 180 rows from the south and 360 columns from 20.5 degrees east; both are middles of cells. They are turned
here to rows from the north and columns from 180 degrees west, and rounded to metres. Where things lie is checked against places that
everybody knows.
"""

import pathlib
import sys

import numpy as np
import rasterio
from rasterio.transform import from_origin
from scipy.io import netcdf_file

source = netcdf_file(sys.argv[1], "r", mmap=False)
longitude = source.variables["ETOPO60X"][:]
latitude = source.variables["ETOPO60Y"][:]
heights = source.variables["ROSE"][:].astype("f8")
assert heights.shape == (180, 360) and np.abs(heights).max() < 9000
assert np.allclose(np.diff(longitude), 1) and np.allclose(np.diff(latitude), 1) and latitude[0] == -89.5

east = (longitude + 180) % 360 - 180
heights = heights[::-1][:, np.argsort(east)]
heights = np.rint(heights).astype("i2")


def at(north, east):
    return heights[int(90 - north), int(east + 180)]


places = {
    "Tibet": (at(33, 88) > 4000),
    "Mount Everest's degree": (at(28.5, 87.5) > 3500),
    "the Mariana Basin": (at(12, 145) < -3000),
    "Greenland": (at(73, -40) > 2000),
    "the South Pole": (at(-89.5, 0) > 2000),
    "the North Pole": (at(89.5, 0) < -2000),
    "the Amazon": (0 < at(-4, -62) < 200),
    "the Atlantic": (at(0, -25) < -3000),
    "the Andes": (at(-16.5, -69.5) > 3000),
    "Australia": (0 < at(-25, 133) < 900),
}
assert all(places.values()), places
assert 0.69 < np.average(heights < 0, weights=np.cos(np.radians(89.5 - np.arange(180)))[:, None].repeat(360, 1)) < 0.73

output = sys.argv[2] if len(sys.argv) > 2 else pathlib.Path(__file__).with_name("earth.tif")
profile = dict(
    driver="GTiff", width=360, height=180, count=1, dtype="int16", crs="EPSG:4326",
    transform=from_origin(-180, 90, 1, 1), compress="deflate", predictor=2, zlevel=9,
)
with rasterio.open(output, "w", **profile) as tif:
    tif.write(heights, 1)
    tif.set_band_unit(1, "metre")
    tif.update_tags(SOURCE="ETOPO, 60 arc-minutes, NOAA, by way of ferret-datasets, public domain")
print(output, pathlib.Path(output).stat().st_size, "bytes")
