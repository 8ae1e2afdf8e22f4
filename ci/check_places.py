"""Coordinate systems without an EPSG code, vertical datums and feet survive `eyot convert`, by the word of rasterio.

Usage: python check_places.py EYOT
"""

import pathlib
import subprocess
import sys
import tempfile

import numpy as np
import rasterio

from checks import check, finish

SYSTEMS = {
    "albers": "ESRI:102039",
    "bessel": "+proj=tmerc +lat_0=0 +lon_0=9 +k=1 +x_0=3500000 +y_0=0 +ellps=bessel +units=m",
    "compound": "EPSG:9518",
    "feet": "EPSG:2225",
    "utm": "EPSG:32611",
}


def main():
    eyot = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)

        def run(*arguments):
            done = subprocess.run([eyot, *arguments], cwd=folder, check=True, capture_output=True, text=True)
            return done.stderr

        for name, crs in SYSTEMS.items():
            start, cell = f"{name}.tif", 0.01 if name == "compound" else 30.0
            transform = rasterio.transform.from_origin(-84.0, 36.0, cell, cell)
            profile = dict(driver="GTiff", width=9, height=7, count=1, dtype="float32", transform=transform)
            with rasterio.open(folder / start, "w", crs=crs, **profile) as tif:
                tif.write(np.arange(63, dtype="float32").reshape(7, 9), 1)
                expected = tif.crs
            recipe = f'[grid]\nfrom = "{start}"\n[[step]]\ngenerate = "import"\nfile = "{start}"\n[[export]]\nformat = "geotiff"\n'
            (folder / "a.toml").write_text(recipe + "[view]\nenabled = false\n")
            run("run", "a.toml", "--out", name, "--quiet")
            (folder / name / "height.tif").rename(folder / f"{name}-run.tif")
            plain = name in ("feet", "utm")
            for through in ["tif", "zarr", "exr", "npy", "png", "r16", "run.tif"]:
                there, back = f"{name}-{through}" if through == "run.tif" else f"there.{through}", f"back-{name}-{through}.tif"
                if through != "run.tif":
                    said = run("convert", start, there, "--force")
                    check(name, f"{through} says what it cannot", ("only Eyot" in said) == (through == "zarr" and not plain), said)
                run("convert", there, back)
                with rasterio.open(folder / back) as tif:
                    check(name, f"through {through}", tif.crs == expected, tif.crs)
                    check(name, f"through {through}: place", tif.transform.almost_equals(transform), tif.transform)
    finish()


main()
