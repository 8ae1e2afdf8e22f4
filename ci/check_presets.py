"""Opens the files of presets as the programs that they are for would, and compares them with the run's GeoTIFF.

Usage: python check_presets.py FOLDER PRESET...

FOLDER holds a run of presets.toml whose grid has the size that the presets want, so that nothing was resampled. Sizes,
scales, orders of bytes and rows, and what the JSON files tell users to enter are asserted. Prints each failure and at the
end "N passed, M failed".
"""

import json
import pathlib
import sys

import numpy as np
import OpenEXR
import rasterio
import trimesh
from PIL import Image

from checks import check, finish

MATERIALS = ["grass", "rock", "sand", "snow"]
# Vertices along a side: quads of a section, sections along a side of a component, components along a side.
UNREAL = {505: (63, 1, 8), 1009: (63, 2, 8), 2017: (63, 2, 16), 4033: (63, 2, 32), 8129: (127, 2, 32)}


class Run:
    def __init__(self, folder):
        self.folder = folder
        with rasterio.open(folder / "height.tif") as tif:
            self.heights = tif.read(1)
            self.cell = tif.transform.a
        self.n = self.heights.shape[0]
        self.low, self.high = float(self.heights.min()), float(self.heights.max())

    def about(self, preset):
        return json.loads((self.folder / f"{preset}.json").read_text())

    def shares(self):
        """The shares of the ground as floats, one raster a material."""
        return [rasterio.open(self.folder / f"share_{m}.tif").read(1) for m in MATERIALS]

    def compare(self, name, heights, tolerance):
        worst = np.abs(heights - self.heights.astype(np.float64)).max()
        check(name, "heights are the run's, north on top", worst <= tolerance, (worst, tolerance))
        turned = min(np.abs(h - self.heights).max() for h in (heights[::-1], heights[:, ::-1], heights.T))
        check(name, "and would not be if turned over", turned > 100 * max(tolerance, 1e-3), turned)


def weights(run, name, bytes_, shares):
    """Bytes of four materials against their exact shares: the largest remainder is less than one step away."""
    check(name, "weights sum to 255", bool((bytes_.astype(int).sum(axis=2) == 255).all()))
    for i, material in enumerate(MATERIALS):
        off = np.abs(bytes_[..., i] / 255.0 - shares[i]).max()
        check(name, f"{material} is where it belongs", off < 1.001 / 255, off)
        check(name, f"there is {material}", bytes_[..., i].max() > 200, bytes_[..., i].max())


def unreal(run):
    about, n = run.about("unreal"), run.n
    quads, sections, components = UNREAL[n]
    check("unreal", "size is of whole components", n == components * sections * quads + 1 and components**2 <= 1024)
    found = (about["section_size_quads"], about["sections_per_component"], about["components"], about["resolution"])
    check("unreal", "sections, components, size", found == (quads, [sections] * 2, [components] * 2, [n, n]), found)
    png = np.asarray(Image.open(run.folder / about["heightmap"]))
    check("unreal", "16-bit grey PNG", (png.dtype, png.shape) == (np.dtype("<u2"), (n, n)), (png.dtype, png.shape))
    raw = np.fromfile(run.folder / about["heightmap_raw"]["file"], "<u2")
    check("unreal", "raw is little-endian, north first", raw.size == n * n and np.array_equal(raw.reshape(n, n), png))
    # What the engine makes of a number at this scale and location, in cm: 1/128 a step at a scale of 1.
    z = about["scale"]["z"]
    cm = (png.astype(np.float64) - 32768) / 128 * z + about["location_z_cm"]
    run.compare("unreal", cm / 100, 0.51 * (run.high - run.low) / 65535 + 1e-3)
    check("unreal", "Z scale of the relief", abs(z / ((run.high - run.low) * 100 / 512) - 1) < 2e-5, z)
    check("unreal", "X and Y scale are cm a quad", np.allclose([about["scale"]["x"], about["scale"]["y"]], run.cell * 100))
    check("unreal", "all 65536 steps are used", (png.min(), png.max()) == (0, 65535))
    maps = [np.asarray(Image.open(run.folder / w["file"])) for w in about["weightmaps"]]
    check("unreal", "8-bit grey weight maps", all(m.dtype == np.uint8 and m.shape == (n, n) for m in maps))
    weights(run, "unreal", np.stack(maps, axis=2), run.shares())


def unity(run):
    about, n = run.about("unity"), run.n
    height = about["heightmap"]
    check("unity", "a power of two and one", n in [2**k + 1 for k in range(5, 13)] and height["resolution"] == n, n)
    check("unity", "depth and order", (height["depth"], height["byte_order"]) == ("16 bit", "Windows"), height)
    raw = np.fromfile(run.folder / height["file"], "<u2").reshape(n, n).astype(np.float64)
    # Unity lays the first row at z = 0, or with "Flip Vertically" the last; z is north.
    rows = raw[::-1] if height["flip_vertically"] else raw
    size = about["terrain_size_m"]
    heights = about["position_y_m"] + rows / 65535 * size["y"]
    run.compare("unity", heights[::-1], 0.51 * size["y"] / 65535 + 1e-3)
    check("unity", "terrain size", np.allclose([size["x"], size["z"]], (n - 1) * run.cell), size)
    splat = np.asarray(Image.open(run.folder / about["splatmap"]["file"]))
    check("unity", "a texel for every quad", splat.shape == (n - 1, n - 1, 4), splat.shape)
    check("unity", "weights sum to 255", bool((splat.astype(int).sum(axis=2) == 255).all()))
    check("unity", "materials", about["splatmap"]["layers"] == MATERIALS, about["splatmap"])
    # Between the four vertices of a quad, shares are about their mean.
    means = [(s[1:, 1:] + s[1:, :-1] + s[:-1, 1:] + s[:-1, :-1]) / 4 for s in run.shares()]
    off = [np.abs(splat[..., i] / 255 - m).mean() for i, m in enumerate(means)]
    turned = [np.abs(splat[::-1, :, i] / 255 - m).mean() for i, m in enumerate(means)]
    check("unity", "shares are where they belong", all(3 * o < t for t, o in zip(turned, off)), (off, turned))


def exr(path):
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return np.array(file.channels()["Y"].pixels)


def godot(run):
    about = run.about("godot")
    heights = exr(run.folder / about["heightmap"])
    check("godot", "real heights to the bit", np.array_equal(heights.view("u4"), run.heights.view("u4")))
    check("godot", "no NaN, which would make holes", bool(np.isfinite(heights).all()))
    check("godot", "size, scale, spacing", (about["resolution"], about["import_scale"], about["vertex_spacing"]) == ([run.n] * 2, 1.0, run.cell), about)
    run.compare("godot", heights, 0)
    splat = np.asarray(Image.open(run.folder / about["splatmap"]["file"]))
    weights(run, "godot", splat, run.shares())


def blender(run):
    about, n = run.about("blender"), run.n
    check("blender", "displacement to the bit", np.array_equal(exr(run.folder / about["displacement"]["file"]), run.heights))
    files = [f"blender_{material}.png" for material in MATERIALS]
    check("blender", "a mask for each material", set(files) <= {m["file"] for m in about["masks"]}, about["masks"])
    masks = [np.asarray(Image.open(run.folder / file)) for file in files]
    weights(run, "blender", np.stack(masks, axis=2), run.shares())
    scene = trimesh.load(run.folder / about["mesh"], process=False, maintain_order=True)
    # Beside the ground there may be the surface of its water.
    drawn = [scene.geometry[scene.graph[node][1]] for node in scene.graph.nodes_geometry]
    mesh = max(drawn, key=lambda m: len(m.vertices))
    check("blender", "a vertex for every cell", len(mesh.vertices) == n * n, len(mesh.vertices))
    extent = mesh.vertices.max(axis=0) - mesh.vertices.min(axis=0)
    check("blender", "extent", np.allclose(extent[[0, 2]], about["size_m"], rtol=1e-5), extent)
    # x is east, z south, the origin in the middle.
    column = np.rint(mesh.vertices[:, 0] / run.cell + (n - 1) / 2).astype(int)
    row = np.rint(mesh.vertices[:, 2] / run.cell + (n - 1) / 2).astype(int)
    check("blender", "heights of the vertices", np.allclose(mesh.vertices[:, 1], run.heights[row, column], atol=1e-3))
    for material, share in zip(MATERIALS, run.shares()):
        name = f"_{material.upper()}"
        values = mesh.vertex_attributes.get(name)
        check("blender", f"attribute {name}", values is not None and name in about["mesh_attributes"], list(mesh.vertex_attributes))
        if values is not None:
            check("blender", f"{name} is the share in the vertex", np.array_equal(np.ravel(values), share[row, column]))


def gis(run):
    with rasterio.open(run.folder / "gis_height.tif") as tif:
        structure = tif.tags(ns="IMAGE_STRUCTURE")
        check("gis", "f32, deflate, predictor 3", (tif.dtypes, tif.compression.value, structure["PREDICTOR"]) == (("float32",), "DEFLATE", "3"), structure)
        check("gis", "a COG", structure["LAYOUT"] == "COG", structure)
        check("gis", "-9999 for missing cells", tif.nodata == -9999)
        check("gis", "metres", tif.units == ("m",) and tif.descriptions == ("height",), (tif.units, tif.descriptions))
        check("gis", "pixel is area", tif.tags().get("AREA_OR_POINT", "Area") == "Area")
        check("gis", "north is up from the corner", tif.transform.to_gdal() == (0, run.cell, 0, run.n * run.cell, 0, -run.cell), tif.transform)
        check("gis", "heights to the bit", np.array_equal(tif.read(1).view("u4"), run.heights.view("u4")))


def main():
    run = Run(pathlib.Path(sys.argv[1]))
    total = sum(s.astype(np.float64) for s in run.shares())
    check("shares", "float shares sum to 1", np.abs(total - 1).max() < 1e-6, np.abs(total - 1).max())
    for preset in sys.argv[2:]:
        {"unreal": unreal, "unity": unity, "godot": godot, "blender": blender, "gis": gis}[preset](run)
    finish()


main()
