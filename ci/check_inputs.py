"""Makes rasters with GDAL, Pillow, NumPy, OpenEXR and xarray in many variants, lets Eyot read them, and compares.

Usage: python check_inputs.py FOLDER -- COMMAND...

COMMAND gets FOLDER as its last argument and must be Eyot's example `read_all`:
    python check_inputs.py out/foreign -- cargo run -p eyot-io --example read_all --
Prints each failure and at the end "N passed, M failed".
"""

import json
import pathlib
import subprocess
import sys

import numpy as np
import OpenEXR
import rasterio
import xarray
import zarr
from PIL import Image
from rasterio.transform import Affine, from_origin

WIDTH, HEIGHT = 301, 173
UTM = from_origin(500010.0, 4100020.0, 10.0, 20.0)


def land(dtype):
    """Hills with full use of the type's range where that is small; deterministic."""
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    hills = 100 + 60 * np.sin(x / 17.0) * np.cos(y / 23.0) + 0.1 * x
    if np.issubdtype(dtype, np.integer):
        return np.round(hills).astype(dtype)
    return hills.astype(dtype)


def variants():
    """(name, dtype, creation options, further profile entries)"""
    for dtype in ("uint8", "int8", "uint16", "int16", "uint32", "int32", "uint64", "int64", "float32", "float64"):
        yield f"type-{dtype}", dtype, {}, {}
    for compress in ("lzw", "deflate", "packbits", "zstd", "lerc", "lerc_deflate", "none"):
        yield f"float-{compress}", "float32", {"compress": compress}, {}
        yield f"int16-{compress}", "int16", {"compress": compress}, {}
    for predictor in (2, 3):
        for compress in ("lzw", "deflate", "zstd"):
            yield f"float-{compress}-p{predictor}", "float32", {"compress": compress, "predictor": predictor}, {}
    yield "double-deflate-p3", "float64", {"compress": "deflate", "predictor": 3}, {}
    yield "int16-lzw-p2", "int16", {"compress": "lzw", "predictor": 2}, {}
    yield "int32-deflate-p2", "int32", {"compress": "deflate", "predictor": 2}, {}
    for block in (16, 64, 512):
        yield f"tiled-{block}", "float32", {"tiled": True, "blockxsize": block, "blockysize": block, "compress": "deflate"}, {}
    yield "tiled-oblong", "int16", {"tiled": True, "blockxsize": 128, "blockysize": 32}, {}
    yield "one-strip", "float32", {"blockysize": HEIGHT, "compress": "deflate"}, {}
    yield "one-row-strips", "float32", {"blockysize": 1}, {}
    yield "big-endian", "float32", {"endianness": "big", "compress": "lzw"}, {}
    yield "big-endian-int16", "int16", {"endianness": "big"}, {}
    yield "big-endian-p3", "float32", {"endianness": "big", "compress": "deflate", "predictor": 3}, {}
    yield "bigtiff", "float32", {"bigtiff": "yes", "tiled": True, "blockxsize": 64, "blockysize": 64}, {}
    yield "bigtiff-big-endian", "int16", {"bigtiff": "yes", "endianness": "big"}, {}
    yield "cog", "float32", {"driver": "COG", "compress": "deflate", "blocksize": 128}, {}
    yield "cog-lerc", "float32", {"driver": "COG", "compress": "lerc_zstd", "max_z_error": 0}, {}
    yield "no-place", "float32", {}, {"transform": Affine.identity(), "crs": None}
    yield "geographic", "int16", {}, {"transform": from_origin(-84.4, 36.5, 1 / 1200, 1 / 1200), "crs": "EPSG:4326"}
    yield "rotated", "float32", {}, {"transform": Affine(8.0, 3.0, 100.0, 3.0, -8.0, 200.0)}
    yield "feet", "float32", {}, {"crs": "EPSG:2264"}


def write(path, values, options, extra):
    profile = dict(driver="GTiff", width=WIDTH, height=HEIGHT, count=1, dtype=values.dtype, crs="EPSG:32611", transform=UTM)
    with rasterio.open(path, "w", **{**profile, **extra, **options}) as tif:
        tif.write(values, 1)


def make(folder):
    """Writes all files and returns what Eyot must find: name -> (values, cell size or None, exact)."""
    expected = {}
    skipped = []
    for name, dtype, options, extra in variants():
        path = folder / f"{name}.tif"
        values = land(dtype)
        try:
            write(path, values, options, extra)
        except Exception as reason:  # this GDAL was built without the codec
            path.unlink(missing_ok=True)
            skipped.append(f"{name}: {reason}")
            continue
        cell = {"no-place": (1, 1), "rotated": (73**0.5,) * 2, "feet": (10 * 1200 / 3937, 20 * 1200 / 3937), "geographic": (74.75, 92.47)}.get(name, (10, 20))
        expected[path.name] = (values.astype(np.float32), cell)

    south_up = Affine(10.0, 0, 500010.0, 0, 20.0, 4100020.0 - HEIGHT * 20.0)
    write(folder / "south-up.tif", land("float32")[::-1], {}, {"transform": south_up})
    expected["south-up.tif"] = (land("float32"), (10, 20))

    hole = land("float32")
    hole[40:90, 100:160] = -9999
    write(folder / "hole.tif", hole, {"compress": "deflate"}, {"nodata": -9999})
    expected["hole.tif"] = (np.where(hole == -9999, np.nan, hole), (10, 20))
    hole[hole == -9999] = np.nan
    write(folder / "hole-nan.tif", hole, {}, {"nodata": np.nan})
    expected["hole-nan.tif"] = (hole, (10, 20))
    lowest = np.where(np.isnan(hole), np.finfo("f4").min, hole)
    write(folder / "hole-lowest.tif", lowest, {}, {"nodata": float(np.finfo("f4").min)})
    expected["hole-lowest.tif"] = (hole, (10, 20))
    # Tiles that were never written read as nodata.
    with rasterio.open(
        folder / "sparse.tif", "w", driver="GTiff", width=WIDTH, height=HEIGHT, count=1, dtype="float32", nodata=-1,
        tiled=True, blockxsize=64, blockysize=64, sparse_ok=True, transform=UTM, crs="EPSG:32611",
    ) as tif:
        tif.write(land("float32")[:64, :128], 1, window=((0, 64), (0, 128)))
    sparse = np.full((HEIGHT, WIDTH), np.nan, "f4")
    sparse[:64, :128] = land("float32")[:64, :128]
    expected["sparse.tif"] = (sparse, (10, 20))

    # Decimetres from -50 m, as some elevation models are packed.
    write(folder / "packed.tif", land("int16"), {}, {})
    with rasterio.open(folder / "packed.tif", "r+") as tif:
        tif.scales, tif.offsets, tif.units = (0.1,), (-50.0,), ("metre",)
        tif.update_tags(SOURCE="a survey & more", TIFFTAG_COPYRIGHT="nobody's")
    expected["packed.tif"] = ((land("int16") * 0.1 - 50.0).astype(np.float32), (10, 20))

    grey = (land("uint16").astype(np.int32) * 300).astype(np.uint16)
    Image.fromarray(grey).save(folder / "grey16.png")
    expected["grey16.png"] = (grey.astype(np.float32), None)
    Image.fromarray(land("uint8")).save(folder / "grey8.png")
    expected["grey8.png"] = (land("uint8").astype(np.float32) * 257, None)
    make_arrays(folder, expected)
    make_exrs(folder, expected)
    make_stores(folder, expected)
    return expected, skipped


def make_arrays(folder, expected):
    for dtype in ("u1", "<i2", ">i2", "<u4", "<f2", "<f4", ">f4", "<f8", "?"):
        name = f"array-{dtype.strip('<>?') or 'bool'}{'-big' if dtype[0] == '>' else ''}.npy"
        values = land("float64") > 100 if dtype == "?" else land("float64").astype(dtype)
        np.save(folder / name, values)
        expected[name] = (values.astype(np.float32), None)
    np.save(folder / "fortran.npy", np.asfortranarray(land("float32")))
    expected["fortran.npy"] = (land("float32"), None)


def make_exrs(folder, expected):
    kinds = {"zip": OpenEXR.ZIP_COMPRESSION, "zips": OpenEXR.ZIPS_COMPRESSION, "piz": OpenEXR.PIZ_COMPRESSION, "rle": OpenEXR.RLE_COMPRESSION, "none": OpenEXR.NO_COMPRESSION}
    for kind, compression in kinds.items():
        for dtype in ("float32", "float16", "uint32"):
            name = f"{kind}-{dtype}.exr"
            values = land("float64").astype(dtype)
            header = {"compression": compression, "type": OpenEXR.scanlineimage}
            with OpenEXR.File(header, {"Y": values}) as exr:
                exr.write(str(folder / name))
            expected[name] = (values.astype(np.float32), None)
    with OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, {"height": land("float32"), "mask": 0 * land("float32")}) as exr:
        exr.write(str(folder / "channels.exr"))
    expected["channels.exr"] = (land("float32"), None)


def make_stores(folder, expected):
    """Stores as xarray and zarr-python write them, with and without places, shards and times."""
    x, y = 500015.0 + 10 * np.arange(WIDTH), 4100010.0 - 20 * np.arange(HEIGHT)
    codecs = {"usual": None, "gzip": zarr.codecs.GzipCodec(), "zstd-crc": [zarr.codecs.ZstdCodec(), zarr.codecs.Crc32cCodec()], "none": []}
    for dtype in ("float32", "float64", "int16", "uint8"):
        for codec, compressors in codecs.items():
            name = f"store-{dtype}-{codec}.zarr"
            data = xarray.DataArray(land(dtype), coords={"y": y, "x": x}, dims=("y", "x"), name="elevation")
            encoding = {} if codec == "usual" else {"compressors": compressors}
            data.to_dataset().to_zarr(folder / name, encoding={"elevation": encoding}, zarr_format=3, mode="w")
            expected[name] = (land(dtype).astype(np.float32), (10, 20))
    south = xarray.DataArray(land("float32")[::-1], coords={"y": y[::-1], "x": x}, dims=("y", "x"), name="height")
    south.to_dataset().to_zarr(folder / "store-south.zarr", zarr_format=3, mode="w")
    expected["store-south.zarr"] = (land("float32"), (10, 20))
    times = xarray.DataArray(np.stack([0 * land("float32"), land("float32")]), coords={"time": [0, 10], "y": y, "x": x}, dims=("time", "y", "x"), name="height")
    for name, chunks, shards in (("store-times.zarr", (1, 50, 60), None), ("store-times-sharded.zarr", (1, 32, 64), (2, 64, 128))):
        encoding = {"height": {"chunks": chunks, "shards": shards}}
        times.to_dataset().to_zarr(folder / name, encoding=encoding, zarr_format=3, mode="w", safe_chunks=False)
        expected[name] = (land("float32"), (10, 20))
    hole = land("float32")
    hole[40:90, 100:160] = np.nan
    holed = xarray.DataArray(hole, coords={"y": y, "x": x}, dims=("y", "x"), name="height")
    holed.to_dataset().to_zarr(folder / "store-hole.zarr", zarr_format=3, mode="w")
    expected["store-hole.zarr"] = (hole, (10, 20))
    for name, order in (("start", "start"), ("end", "end")):
        array = zarr.create_array(folder / f"plain-{name}.zarr", shape=(HEIGHT, WIDTH), dtype="float32", chunks=(32, 32), shards=zarr.core.array.ShardsConfigParam(shape=(64, 96), index_location=order))
        array[:] = land("float32")
        expected[f"plain-{name}.zarr"] = (land("float32"), None)


REFUSED = {"rgb.tif": "bands", "rgb.png": "colour", "palette.png": "colour", "complex.tif": "", "lzma.tif": "COMPRESS=DEFLATE", "holes-unmarked.tif": "NaN", "complex.npy": "astype", "cube.npy": "dimensions", "rgb.exr": "`layer`", "blosc.zarr": "blosc", "version2.zarr": "zarr_format=3"}


def make_refused(folder):
    rgb = np.zeros((3, HEIGHT, WIDTH), np.uint8)
    with rasterio.open(folder / "rgb.tif", "w", driver="GTiff", width=WIDTH, height=HEIGHT, count=3, dtype="uint8") as tif:
        tif.write(rgb)
    Image.fromarray(rgb.transpose(1, 2, 0)).save(folder / "rgb.png")
    Image.fromarray(land("uint8")).convert("P").save(folder / "palette.png")
    with rasterio.open(folder / "complex.tif", "w", driver="GTiff", width=9, height=9, count=1, dtype="complex64") as tif:
        tif.write(np.zeros((1, 9, 9), np.complex64))
    write(folder / "lzma.tif", land("int16"), {"compress": "lzma"}, {})
    np.save(folder / "complex.npy", np.zeros((3, 4), "c8"))
    np.save(folder / "cube.npy", np.zeros((3, 4, 5), "f4"))
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, {c: land("float32") for c in "RGB"}) as exr:
        exr.write(str(folder / "rgb.exr"))
    zarr.create_array(folder / "blosc.zarr", shape=(9, 9), dtype="float32", compressors=zarr.codecs.BloscCodec(), overwrite=True)[:] = 1
    zarr.create_array(folder / "version2.zarr", shape=(9, 9), dtype="float32", zarr_format=2, overwrite=True)[:] = 1
    hole = land("float32")
    hole[3, 4] = np.nan
    write(folder / "holes-unmarked.tif", hole, {}, {})


def judge(folder, name, values, cell):
    """None if all is well, else what is not."""
    path = folder / f"{name}.read.r32"
    if not path.exists():
        error = folder / f"{name}.error"
        return error.read_text() if error.exists() else "nothing was written"
    about = json.loads(path.with_name(path.name + ".json").read_text())
    found = np.fromfile(path, "<f4").reshape(about["height"], about["width"])
    if found.shape != values.shape:
        return f"size {found.shape}"
    known = ~np.isnan(values)
    if not (found[known] == values[known]).all():
        return f"{(found[known] != values[known]).sum()} of {known.sum()} values differ"
    if not known.all():
        low, high = values[known].min(), values[known].max()
        if not ((found >= low) & (found <= high)).all():
            return "filled cells leave the range of the others"
    size = (about["cell_x_m"], about["cell_y_m"])
    if cell is not None and not np.allclose(size, cell, rtol=1e-3):
        return f"cell size {size}, expected {cell}"
    return None


def main():
    folder, command = pathlib.Path(sys.argv[1]), sys.argv[sys.argv.index("--") + 1 :]
    folder.mkdir(parents=True, exist_ok=True)
    expected, skipped = make(folder)
    make_refused(folder)
    subprocess.run([*command, str(folder)], check=True)
    verdicts = {name: judge(folder, name, *rest) for name, rest in expected.items()}
    for name, part in REFUSED.items():
        error = folder / f"{name}.error"
        text = error.read_text() if error.exists() else "was read"
        verdicts[name] = None if name in text and part in text else f"should be refused with `{part}`: {text}"
    for name, verdict in verdicts.items():
        if verdict is not None:
            print(f"FAILED {name}: {verdict}")
    for reason in skipped:
        print(f"skipped {reason}")
    failed = sum(v is not None for v in verdicts.values())
    print(f"{len(verdicts) - failed} passed, {failed} failed")
    sys.exit(1 if failed else 0)


main()
