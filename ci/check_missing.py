"""Cells without a value survive `eyot convert`, by the word of rasterio and xarray.

Usage: python check_missing.py EYOT
"""

import pathlib
import subprocess
import sys
import tempfile

import numpy as np
import rasterio
import xarray

from checks import check, finish

SIZE = (530, 610)


def source(path, south_up):
    """A slope with a round hole and a missing corner, also upside down."""
    y, x = np.mgrid[: SIZE[0], : SIZE[1]]
    values = (300.0 + x - 0.5 * y).astype("float32")
    gone = ((x < 4) & (y < 3)) | (np.hypot(x - 400, y - 200) < 90)
    values[gone] = -32768.0
    transform = rasterio.transform.from_origin(500000.0, 4100000.0, 30.0, 30.0)
    if south_up:
        transform = rasterio.Affine(30.0, 0.0, 500000.0, 0.0, 30.0, 4100000.0 - 30.0 * SIZE[0])
    profile = dict(driver="GTiff", width=SIZE[1], height=SIZE[0], count=1, dtype="float32", crs="EPSG:32611")
    with rasterio.open(path, "w", transform=transform, nodata=-32768.0, **profile) as tif:
        tif.write(values[::-1] if south_up else values, 1)
    return np.ma.masked_array(values, gone)


def main():
    eyot = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)

        def convert(a, b):
            subprocess.run([eyot, "convert", folder / a, folder / b], check=True, capture_output=True)

        for south_up in (False, True):
            start = f"start-{south_up}.tif"
            expected = source(folder / start, south_up)
            convert(start, f"{south_up}.zarr")
            convert(f"{south_up}.zarr", f"{south_up}.tif")
            with rasterio.open(folder / f"{south_up}.tif") as tif:
                values = tif.read(1, masked=True)
                check(start, "rasterio sees the same holes", (values.mask == expected.mask).all())
                check(start, "rasterio sees the same values", (values == expected).all())
                small = tif.read(1, masked=True, out_shape=(SIZE[0] // 4, SIZE[1] // 4))
                check(start, "overviews have holes", 0 < small.mask.sum() < small.size / 4, small.mask.sum())
                check(start, "overviews hold no marks", small.min() >= expected.min(), small.min())
                check(start, "the source's mark is kept", tif.nodata == -32768.0, tif.nodata)
            with xarray.open_zarr(folder / f"{south_up}.zarr", consolidated=True) as store:
                array = store["height"].values.reshape(SIZE)
                check(start, "xarray sees the same holes", (np.isnan(array) == expected.mask).all())
                check(start, "xarray sees the same values", (array[~expected.mask] == expected.compressed()).all())
    finish()


main()
