"""Writes the files of this folder with GDAL, as GIS programs do: python make.py (needs rasterio and numpy)."""
import numpy as np
import rasterio
from rasterio.transform import from_origin

PLACE = dict(width=12, height=10, crs="EPSG:32617", transform=from_origin(700000, 4000000, 30, 30))
LAND = (100 + 5 * np.arange(12)[None, :] + 3 * np.arange(10)[:, None]).astype("float32")


def write(name, bands, **more):
    with rasterio.open(name, "w", driver="GTiff", count=len(bands), dtype=bands[0].dtype, **PLACE, **more) as file:
        for number, band in enumerate(bands, 1):
            file.write(band, number)


# A mask inside the file: the north-western corner of three by two cells is outside.
with rasterio.Env(GDAL_TIFF_INTERNAL_MASK=True):
    write("masked.tif", [LAND])
    with rasterio.open("masked.tif", "r+") as file:
        inside = np.full(LAND.shape, 255, "uint8")
        inside[:2, :3] = 0
        file.write_mask(inside)

# Heights are the second of two bands.
write("bands.tif", [np.full_like(LAND, 7), LAND], compress="deflate")

# Numbers for missing cells that the file does not name.
for name, mark in [("untagged.tif", -9999), ("beyond.tif", np.float32(-3.4028235e38))]:
    land = LAND.copy()
    land[:2, :3] = mark
    write(name, [land])
