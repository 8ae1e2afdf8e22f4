"""Opens the files that Eyot wrote with programs of other people and compares the formats with each other.

Usage: python check_outputs.py FOLDER [--no-node]

Every .tif is opened with rasterio and checked by rio-cogeo, every .png with Pillow, every .r32 with numpy by its JSON
file, every .glb with trimesh and Khronos' validator (node, with `npm install` done in this folder). Files that differ in
the extension alone hold the same layer: GeoTIFF and R32 must then agree bit by bit, PNG within half a step. Prints each
failure and at the end "N passed, M failed"; exits with 1 if anything failed or there was nothing to check.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import traceback
import zlib

import numpy as np
import rasterio
import trimesh
from PIL import Image
from rio_cogeo.cogeo import cog_validate

HERE = pathlib.Path(__file__).resolve().parent
# Heights of big worlds are pictures beyond Pillow's idea of a sound size.
Image.MAX_IMAGE_PIXELS = None

passed, failed = 0, 0


def check(path, what, ok, detail=""):
    global passed, failed
    if ok:
        passed += 1
    else:
        failed += 1
        print(f"FAILED {path}: {what} {detail}")


def each(paths, inspect):
    """Runs `inspect` on every path and returns what it gave; an exception is a failure."""
    results = {}
    for path in sorted(paths):
        try:
            results[path.with_suffix("")] = inspect(path)
        except Exception:
            check(path, "opens", False, traceback.format_exc(limit=3))
    return results


def inspect_tif(path):
    with rasterio.open(path) as tif:
        values = tif.read(1)
        profile = tif.profile
        check(path, "one band of f32", tif.count == 1 and profile["dtype"] == "float32", profile)
        check(path, "deflate", profile.get("compress") == "deflate", profile)
        check(path, "predictor 3", tif.tags(ns="IMAGE_STRUCTURE").get("PREDICTOR") == "3", tif.tags(ns="IMAGE_STRUCTURE"))
        check(path, "layout is COG", tif.tags(ns="IMAGE_STRUCTURE").get("LAYOUT") == "COG")
        check(path, "tiles", profile["tiled"] and profile["blockxsize"] in (256, 512))
        check(path, "finite", bool(np.isfinite(values).all()))
        check(path, "nodata is given", tif.nodata is not None)
        check(path, "no value is missing", not (values == np.float32(tif.nodata)).any(), tif.nodata)
        check(path, "pixel is area", tif.tags().get("AREA_OR_POINT", "Area") == "Area", tif.tags())
        check(path, "north is up", tif.transform.a > 0 and tif.transform.e < 0, tif.transform)
        # A world of its own has no CRS at all, not an unnamed one.
        if tif.crs is not None:
            check(path, "CRS has a code", tif.crs.to_epsg() is not None, tif.crs)
        smallest = max(values.shape) / (tif.overviews(1) or [1])[-1]
        check(path, "overviews down to one tile", smallest <= profile["blockxsize"], tif.overviews(1))
        place = (tif.transform, None if tif.crs is None else tif.crs.to_epsg())
    valid, errors, warnings = cog_validate(str(path), quiet=True)
    check(path, "rio-cogeo finds it valid", valid and not errors and not warnings, (errors, warnings))
    return values, place


def inspect_r32(path):
    about = json.loads(path.with_name(path.name + ".json").read_text())
    data = path.read_bytes()
    check(path, "little-endian, north first", (about["byte_order"], about["row_order"]) == ("little-endian", "north to south"))
    check(path, "length", len(data) == 4 * about["width"] * about["height"], len(data))
    check(path, "checksum", f"{zlib.crc32(data):08x}" == about["crc32"])
    values = np.frombuffer(data, "<f4").reshape(about["height"], about["width"])
    check(path, "finite", bool(np.isfinite(values).all()))
    check(path, "range", values.min() == np.float32(about["min"]) and values.max() == np.float32(about["max"]))
    return values, about


def inspect_png(path):
    with Image.open(path) as image:
        image.load()
        if image.mode == "RGB":
            check(path, "8-bit RGB", True)
            return None
        check(path, "16-bit grey", image.mode == "I;16", image.mode)
        samples = np.asarray(image).astype(np.float64)
        low, high = float(image.text["min"]), float(image.text["max"])
        check(path, "cell size", float(image.text["cell_x_m"]) > 0 and float(image.text["cell_y_m"]) > 0)
        check(path, "uses all of its range", samples.min() == 0 and (samples.max() == 65535 or low == high))
        return low + samples / 65535 * (high - low), low, high


def compare(tifs, r32s, pngs):
    for name, (values, about) in r32s.items():
        tif = tifs.get(name)
        check(name, "has a GeoTIFF", tif is not None)
        if tif is not None:
            same = tif[0].shape == values.shape and (tif[0].view("u4") == values.view("u4")).all()
            check(name, "GeoTIFF and R32 agree bit by bit", bool(same))
            georeference = about.get("georeference")
            if georeference is None:
                t, cell = tif[1][0], (about["cell_x_m"], -about["cell_y_m"])
                check(name, "cell size of both agrees", np.allclose((t.a, t.e), cell, rtol=1e-12), t)
            else:
                check(name, "place of both agrees", np.allclose(tif[1][0].to_gdal(), georeference["transform"], rtol=1e-12))
                check(name, "CRS of both agrees", tif[1][1] == georeference["epsg"], tif[1][1])
        png = pngs.get(name)
        check(name, "has a PNG", png is not None)
        if png is not None:
            heights, low, high = png
            step = (high - low) / 65535
            worst = np.abs(heights - values.astype(np.float64)).max()
            check(name, "PNG is within half a step", worst <= step * 0.5001, (worst, step))


def inspect_glb(path):
    scene = trimesh.load(path)
    drawn = [scene.graph[node][1] for node in scene.graph.nodes_geometry]
    check(path, "the scene draws one mesh", len(drawn) == 1, drawn)
    mesh = scene.geometry[drawn[0]]
    check(path, "has triangles", len(mesh.faces) > 0)
    check(path, "finite", bool(np.isfinite(mesh.vertices).all()))
    # With a material, trimesh keeps vertex colours beside it.
    colours = mesh.visual.vertex_attributes["color"]
    check(path, "one colour a vertex", colours.shape == (len(mesh.vertices), 4), colours.shape)
    normals = mesh.face_normals
    check(path, "all faces look up", bool((normals[:, 1] > 0).all()), normals[:, 1].min())
    return len(mesh.faces)


def validate_glbs(paths):
    if not paths:
        return
    run = subprocess.run(["node", HERE / "validate_glb.mjs", *paths], capture_output=True, text=True)
    lines = [json.loads(line) for line in run.stdout.splitlines()]
    check("validate_glb.mjs", "gave a verdict on every file", len(lines) == len(paths), run.stderr)
    for verdict in lines:
        clean = verdict["errors"] == 0 and verdict["warnings"] == 0
        check(verdict["file"], "Khronos' validator finds no error and no warning", clean, verdict["messages"])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--no-node", action="store_true", help="leave out Khronos' validator")
    options = parser.parse_args()
    files = [f for f in options.folder.rglob("*") if f.is_file()]
    of = lambda extension: [f for f in files if f.suffix == extension]  # noqa: E731

    tifs = each(of(".tif"), inspect_tif)
    r32s = each(of(".r32"), inspect_r32)
    pngs = {name: png for name, png in each(of(".png"), inspect_png).items() if png is not None}
    compare(tifs, r32s, pngs)
    each(of(".glb"), inspect_glb)
    if not options.no_node:
        validate_glbs(of(".glb"))
    check(options.folder, "holds nothing unfinished", not list(options.folder.rglob(".eyot-*")))

    print(f"{passed} passed, {failed} failed")
    sys.exit(0 if failed == 0 and passed > 1 else 1)


main()
