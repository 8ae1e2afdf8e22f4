"""Opens the files that Eyot wrote with programs of other people and compares the formats with each other.

Usage: python check_outputs.py FOLDER [--no-node]

Every .tif is opened with rasterio and checked by rio-cogeo, every .png with Pillow, every .r32, .r16 and .npy with numpy
by its JSON file, every .exr with OpenEXR, every .zarr with xarray and zarr-python (recordings, timeline.zarr, too), every
.parquet with pyarrow and pandas, every .obj and .ply with trimesh, every .glb with
trimesh and Khronos' validator (node, with `npm install` done in this folder). Files that differ in the extension alone
hold the same layer: those of floats must then agree bit by bit with R32, PNG and R16 within half a step. Prints each
failure and at the end "N passed, M failed"; exits with 1 if anything failed or there was nothing to check.
"""

import argparse
import csv
import json
import pathlib
import subprocess
import tempfile
import traceback
import zlib

import numpy as np
import OpenEXR
import pandas
import pyarrow.parquet
import rasterio
import trimesh
import xarray
import zarr
from PIL import Image
from rio_cogeo.cogeo import cog_validate

from checks import check, finish

HERE = pathlib.Path(__file__).resolve().parent
# Heights of big worlds are pictures beyond Pillow's idea of a sound size.
Image.MAX_IMAGE_PIXELS = None

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
        check(path, "tiles", (profile["tiled"] or max(values.shape) <= 256) and profile["blockxsize"] in (256, 512))
        check(path, "finite", bool(np.isfinite(values).all()))
        check(path, "nodata is given", tif.nodata is not None)
        check(path, "no value is missing", not (values == np.float32(tif.nodata)).any(), tif.nodata)
        check(path, "name and unit of the band", bool(tif.descriptions[0] and tif.units[0]), (tif.descriptions, tif.units))
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
        if image.mode == "RGBA":
            legend = json.loads(path.with_name(path.name + ".json").read_text())
            weights = np.asarray(image).astype(int)
            check(path, "size of the legend", weights.shape[:2] == (legend["height"], legend["width"]), weights.shape)
            check(path, "weights sum to 255", bool((weights.sum(axis=2) == 255).all()))
            check(path, "no gamma", "gamma" not in image.info and "srgb" not in image.info, image.info)
            return None
        if image.mode == "L":
            check(path, "8-bit grey mask", "gamma" not in image.info and "srgb" not in image.info, image.info)
            return None
        check(path, "16-bit grey", image.mode == "I;16", image.mode)
        samples = np.asarray(image).astype(np.float64)
        low, high = float(image.text["min"]), float(image.text["max"])
        check(path, "cell size", float(image.text["cell_x_m"]) > 0 and float(image.text["cell_y_m"]) > 0)
        # The scale of a preset may be a little wider.
        full = samples.min() == 0 and (samples.max() == 65535 or low == high)
        check(path, "uses all of its range", full or "unreal" in path.name, (samples.min(), samples.max()))
        return low + samples / 65535 * (high - low), low, high


def inspect_r16(path):
    about = json.loads(path.with_name(path.name + ".json").read_text())
    data = path.read_bytes()
    check(path, "checksum", f"{zlib.crc32(data):08x}" == about["crc32"])
    numbers = np.frombuffer(data, "<u2" if about["byte_order"] == "little-endian" else ">u2")
    numbers = numbers.reshape(about["height"], about["width"])
    if about["row_order"] == "south to north":
        numbers = numbers[::-1]
    low, high = about["low"], about["high"]
    return low + numbers.astype(np.float64) / 65535 * (high - low), low, high


def inspect_npy(path):
    about = json.loads(path.with_name(path.name + ".json").read_text())
    values = np.load(path)
    check(path, "f32 in C's order", values.dtype == np.dtype("<f4") and values.flags["C_CONTIGUOUS"], values.dtype)
    check(path, "checksum", f"{zlib.crc32(path.read_bytes()):08x}" == about["crc32"])
    check(path, "shape", values.shape == (about["height"], about["width"]), values.shape)
    return values


def inspect_exr(path):
    with OpenEXR.File(str(path), separate_channels=True) as exr:
        check(path, "one part", len(exr.parts) == 1)
        header = exr.header()
        check(path, "ZIP, line by line", header["compression"] == OpenEXR.ZIP_COMPRESSION, header["compression"])
        about = json.loads(header["eyot"])
        channels = {name: np.array(channel.pixels) for name, channel in exr.channels().items()}
    for name, values in channels.items():
        check(path, f"channel {name} is finite f32", values.dtype == np.float32 and bool(np.isfinite(values).all()))
        check(path, f"channel {name} has the size", values.shape == (about["height"], about["width"]), values.shape)
    check(path, "no NaN marks holes", all(np.isfinite(v).all() for v in channels.values()))
    return channels.get("Y")


def inspect_zarr(path):
    with xarray.open_zarr(path) as data:
        check(path, "CF", data.attrs["Conventions"].startswith("CF-"), data.attrs)
        layers = [name for name in data.data_vars if name != "spatial_ref"]
        for name in layers:
            layer = data[name]
            check(path, f"{name}: dimensions", layer.dims == ("time", "y", "x"), layer.dims)
            check(path, f"{name}: units", "units" in layer.attrs and "long_name" in layer.attrs, layer.attrs)
            check(path, f"{name}: finite f32", layer.dtype == np.float32 and bool(np.isfinite(layer.values).all()))
        times, height, width = data[layers[0]].shape
        check(path, "one step of time, a number", times == 1 and len(inspect_time(path, data)) == 1, data["time"])
        for axis, n in (("x", width), ("y", height)):
            steps = np.diff(data[axis].values)
            check(path, f"{axis}: even steps", data[axis].shape == (n,) and bool(np.allclose(steps, steps[:1])))
        check(path, "north is up", height < 2 or data["y"].values[0] > data["y"].values[-1])
        values = {name: data[name].values[0] for name in layers}
        corner = data.isel(x=slice(64), y=slice(64))
        with tempfile.TemporaryDirectory() as folder:
            corner.to_netcdf(f"{folder}/a.nc")
            with xarray.open_dataset(f"{folder}/a.nc") as copy:
                check(path, "goes to netCDF", copy.equals(corner.load()), copy)
    group = zarr.open_group(path, mode="r")
    array = group[layers[0]]
    check(path, "Zarr 3, sharded", array.metadata.zarr_format == 3 and array.shards == (1, 512, 512), array.shards)
    check(path, "chunks", array.chunks == (1, 128, 128), array.chunks)
    check(path, "zarr-python reads the same", bool((array[0].view("u4") == values[layers[0]].view("u4")).all()))
    if "recipe" in group.attrs:
        known = all(k in group.attrs for k in ("engine_version", "seed", "backend", "steps_done"))
        check(path, "says where it comes from", known, dict(group.attrs))
    return values


def inspect_time(path, data):
    """Steps along time, after a look at what xarray makes of them: dates, years, or the steps where no clock is known."""
    with xarray.open_zarr(path, decode_times=False, mask_and_scale=False) as raw:
        steps = raw["time"].values
    check(path, "steps are whole numbers", steps.dtype == np.int64, steps.dtype)
    time, seconds = data["time"], data.attrs.get("seconds_per_step")
    if seconds is None:
        check(path, "no clock, and it says so", time.dtype == np.int64 and "comment" in time.attrs, time.attrs)
    elif np.issubdtype(time.dtype, np.datetime64):
        passed = (time.values - np.datetime64("2000-01-01")) / np.timedelta64(1, "ns") * 1e-9
        check(path, "dates follow the clock", bool(np.allclose(passed, steps * seconds, rtol=1e-9)), time.values)
    else:
        years = steps * seconds / (365.25 * 86400)
        check(path, "years follow the clock", time.attrs["units"] == "years" and bool(np.allclose(time.values, years)), time)
    return steps


def inspect_recording(path):
    """A recorded run: one data set along time, whose last frame is what the run exported."""
    with xarray.open_zarr(path) as data:
        check(path, "CF", data.attrs["Conventions"].startswith("CF-"), data.attrs)
        time = inspect_time(path, data)
        check(path, "time increases", len(time) > 2 and bool((np.diff(time) > 0).all()), time)
        check(path, "time says that it is", data["time"].attrs.get("axis") == "T", data["time"].attrs)
        layers = [name for name in data.data_vars if name != "spatial_ref"]
        width, height = data.sizes["x"], data.sizes["y"]
        for name in layers:
            layer = data[name]
            sizes = {"y": height, "y_face": height + 1, "x": width, "x_face": width + 1}
            expected = (len(time), *(sizes[d] for d in layer.dims[1:]))
            check(path, f"{name}: shape", layer.dims[0] == "time" and layer.shape == expected, (layer.dims, layer.shape))
            check(path, f"{name}: units", "units" in layer.attrs and "long_name" in layer.attrs, layer.attrs)
            finite = np.isfinite(layer.values)
            there = finite.all(axis=(1, 2))
            check(path, f"{name}: frames whole or empty", bool((there == finite.any(axis=(1, 2))).all()))
            check(path, f"{name}: once there, always there", bool((np.diff(there.astype(int)) >= 0).all() and there[-1]))
        check(path, "layers that come late", any(np.isnan(data[name].values[0]).all() for name in layers))
        check(path, "layers on faces", any("x_face" in data[name].dims for name in layers))
        for axis in ("x", "y"):
            middles = (data[f"{axis}_face"].values[1:] + data[f"{axis}_face"].values[:-1]) / 2
            check(path, f"{axis}: faces lie between cells", bool(np.allclose(middles, data[axis].values)))
        last = {name: data[name].isel(time=-1).values for name in layers}
        with tempfile.TemporaryDirectory() as folder:
            data.to_netcdf(f"{folder}/a.nc")
            with xarray.open_dataset(f"{folder}/a.nc") as copy:
                check(path, "goes to netCDF", copy.equals(data.load()), copy)
    exported = [f for f in path.parent.glob("*.tif") if f.stem in last]
    check(path, "there are exports of its layers", len(exported) > 1, exported)
    for file in exported:
        with rasterio.open(file) as tif:
            same = (tif.read(1).view("u4") == last[file.stem].view("u4")).all()
            check(file, "is the last frame of the recording, bit by bit", bool(same))
    array = zarr.open_group(path, mode="r")["height"]
    check(path, "Zarr 3, a shard a frame", array.metadata.zarr_format == 3 and array.shards == (1, 512, 512), array.shards)
    own = zarr.open_array(path / "height", mode="r")
    check(path, "arrays open alone, too", own.shape == array.shape, (own.shape, array.shape))


def count_pieces(faces, vertices):
    """Connected pieces: every vertex takes the lowest number around it, until nothing changes."""
    lowest = np.arange(vertices)
    while True:
        last = lowest.copy()
        np.minimum.at(lowest, faces.ravel(), np.repeat(lowest[faces].min(axis=1), 3))
        lowest = lowest[lowest]
        if (lowest == last).all():
            return len(np.unique(lowest[faces]))


def inspect_bodies(path, mesh, parts=None):
    """Closed bodies: no hole, all faces outwards, one piece for each node."""
    check(path, "finite", bool(np.isfinite(mesh.vertices).all()))
    check(path, "closed", mesh.is_watertight)
    check(path, "all faces look the same way", mesh.is_winding_consistent)
    pieces = count_pieces(mesh.faces, len(mesh.vertices))
    check(path, "one piece for each body", parts is None or pieces == parts, (pieces, parts))
    check(path, "outwards", mesh.volume > 0, mesh.volume)
    # What the middle of a face is shaded by: the mean of its corners' normals, which are ours, against the face's own.
    shading = mesh.vertex_normals[mesh.faces].sum(axis=1)
    straight = (mesh.face_normals * shading).sum(axis=1) / np.linalg.norm(shading, axis=1).clip(1e-9)
    check(path, "normals point out of the faces", bool(np.mean(straight > 0.3) > 0.99), straight.min())


def inspect_parquet(path):
    """A census: what pyarrow and pandas read is the CSV beside it, with types, and with units in the metadata."""
    table = pyarrow.parquet.read_table(path)
    about = json.loads(table.schema.metadata[b"eyot"])
    check(path, "says where it comes from", "engine_version" in about and "seed" in about, list(about))
    units = {name: column["unit"] for name, column in about["columns"].items()}
    check(path, "a unit for each column", list(units) == table.column_names and all(units.values()), units)
    whole = {name for name in table.column_names if table.schema.field(name).type == pyarrow.int64()}
    others = {table.schema.field(name).type for name in table.column_names if name not in whole}
    check(path, "whole numbers and doubles", "month" in whole and others == {pyarrow.float64()}, (whole, others))
    check(path, "no nulls", all(table.column(name).null_count == 0 for name in table.column_names))
    frame = pandas.read_parquet(path)
    with path.with_suffix(".csv").open(newline="") as text:
        names, *lines = csv.reader(text)
    rows = np.array([[float(cell) for cell in line] for line in lines])
    check(path, "rows", len(frame) > 0 and len(frame) == len(rows), (len(frame), len(rows)))
    check(path, "the same columns as the CSV", list(frame.columns) == names, list(frame.columns))
    check(path, "the same numbers as the CSV", bool((frame.to_numpy("f8") == rows).all()))


def inspect_ply(path):
    mesh = trimesh.load(path, process=False)
    check(path, "has triangles", len(mesh.faces) > 0)
    check(path, "has colours", mesh.visual.kind == "vertex", mesh.visual.kind)
    inspect_bodies(path, mesh)


def inspect_obj(path):
    mesh = trimesh.load(path, process=False, maintain_order=True)
    if path.read_bytes().startswith(b"# Eyot, bodies"):
        parts = list(mesh.geometry.values()) if isinstance(mesh, trimesh.Scene) else [mesh]
        return inspect_bodies(path, trimesh.util.concatenate(parts))
    check(path, "has triangles", len(mesh.faces) > 0)
    check(path, "finite", bool(np.isfinite(mesh.vertices).all()))
    check(path, "all faces look up", bool((mesh.face_normals[:, 1] > 0).all()), mesh.face_normals[:, 1].min())
    # With texture coordinates, trimesh leaves the colours that stand after positions alone.
    corners = [line.split() for line in path.read_text().splitlines() if line.startswith("v ")]
    check(path, "has colours", len(corners) > 0 and all(len(corner) == 7 for corner in corners), corners[0])
    check(path, "texture coordinates within 0..1", bool(((mesh.visual.uv >= 0) & (mesh.visual.uv <= 1)).all()))


def compare_floats(r32s, kinds):
    for kind, found in kinds.items():
        for name, values in found.items():
            reference = r32s.get(name)
            if reference is not None and values is not None:
                same = reference[0].shape == values.shape and (reference[0].view("u4") == values.view("u4")).all()
                check(name, f"{kind} and R32 agree bit by bit", bool(same))


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


def inspect_glb_bodies(path, document):
    scene = trimesh.load(path, process=False)
    nodes = document["nodes"]
    check(path, "every node is there", len(scene.graph.nodes_geometry) == len(nodes), len(scene.graph.nodes_geometry))
    inspect_bodies(path, scene.to_geometry(), len(nodes))
    check(path, "every mesh has a name and is shown", {n["mesh"] for n in nodes} == set(range(len(document["meshes"]))))
    for mesh in document["meshes"]:
        check(path, "every mesh has vertex colours", "COLOR_0" in mesh["primitives"][0]["attributes"], mesh["name"])
    return sum(len(g.faces) for g in scene.geometry.values())


def inspect_glb_instances(path, document, binary):
    """Copies of bodies by EXT_mesh_gpu_instancing: returns how many there are."""

    def numbers(accessor):
        a = document["accessors"][accessor]
        view = document["bufferViews"][a["bufferView"]]
        width = {"VEC3": 3, "VEC4": 4}[a["type"]]
        return np.frombuffer(binary, "<f4", a["count"] * width, view["byteOffset"]).reshape(a["count"], width)

    copies = 0
    for node in document["nodes"]:
        attributes = node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]
        places, turns, sizes = (numbers(attributes[name]) for name in ("TRANSLATION", "ROTATION", "SCALE"))
        check(path, f"every {node['name']} has a place, a turn and a size", len(places) == len(turns) == len(sizes) > 0)
        check(path, f"every {node['name']} has a finite place", bool(np.isfinite(places).all()))
        check(path, f"every {node['name']} has a size", bool((sizes > 0).all()), sizes.min())
        check(path, "turns are unit quaternions", bool((abs((turns**2).sum(axis=1) - 1) < 1e-5).all()))
        copies += len(places)
    return copies


def inspect_glb(path):
    data = path.read_bytes()
    length = int.from_bytes(data[12:16], "little")
    document = json.loads(data[20 : 20 + length])
    if document["scenes"][0].get("extras", {}).get("kind") == "instances":
        return inspect_glb_instances(path, document, data[28 + length :])
    if document["scenes"][0].get("extras", {}).get("kind") == "bodies":
        return inspect_glb_bodies(path, document)
    scene = trimesh.load(path)
    drawn = [scene.graph[node][1] for node in scene.graph.nodes_geometry]
    # The ground has colours; the surface of its water is a mesh of its own.
    ground = [name for name in drawn if "color" in scene.geometry[name].visual.vertex_attributes]
    check(path, "the scene draws the ground, and at most its water", len(ground) == 1 and len(drawn) <= 2, drawn)
    mesh = scene.geometry[ground[0]]
    check(path, "has triangles", len(mesh.faces) > 0)
    check(path, "finite", bool(np.isfinite(mesh.vertices).all()))
    # With a material, trimesh keeps vertex colours beside it.
    colours = mesh.visual.vertex_attributes["color"]
    check(path, "one colour a vertex", colours.shape == (len(mesh.vertices), 4), colours.shape)
    # The levels of detail, too, which the scene does not draw.
    levels = len(document["meshes"])
    check(path, "every level is there", len(scene.geometry) == levels, (len(scene.geometry), levels))
    for name, level in scene.geometry.items():
        normals = level.face_normals
        check(path, f"all faces of {name} look up", bool((normals[:, 1] > 0).all()), normals[:, 1].min())
        check(path, f"no face of {name} has lost its normal", len(normals) == len(level.faces))
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
    r16s = each(of(".r16") + of(".raw"), inspect_r16)
    compare(tifs, r32s, pngs)
    for name in pngs.keys() & r16s.keys():
        check(name, "PNG and R16 hold the same numbers", np.array_equal(pngs[name][0], r16s[name][0]))
    stores = [f for f in options.folder.rglob("*.zarr") if f.is_dir()]
    recordings = [f for f in stores if f.name == "timeline.zarr"]
    each(recordings, inspect_recording)
    stores = [f for f in stores if f not in recordings]
    kinds = {"NPY": each(of(".npy"), inspect_npy), "EXR": each(of(".exr"), inspect_exr), "Zarr": {}}
    for name, layers in each(stores, inspect_zarr).items():
        # A run's store holds the layers that other files are named after.
        named = {name.with_name(layer): v for layer, v in layers.items()} if name.name == "world" else {name: layers.popitem()[1]}
        kinds["Zarr"].update(named)
    compare_floats(r32s, kinds)
    each(of(".parquet"), inspect_parquet)
    each(of(".obj"), inspect_obj)
    each(of(".ply"), inspect_ply)
    each(of(".glb"), inspect_glb)
    if not options.no_node:
        validate_glbs(of(".glb"))
    check(options.folder, "holds nothing unfinished", not list(options.folder.rglob(".eyot-*")))

    finish()


main()
