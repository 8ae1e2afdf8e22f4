"""Judges rivers and lakes as a hydrologist would, by laws and by the rasters of the same run, without any code of ours.

Usage: python check_rivers.py REAL PLAIN

REAL holds a run of vectors.toml, a measured land; PLAIN one of rivers.toml, where slow rivers wind. Prints each failure, the measures and at the end
"N passed, M failed".
"""

import json
import pathlib
import sys
from collections import defaultdict

import numpy as np
import rasterio

from checks import check, finish


def read(path):
    """The features of a GeoJSON file: of each its attributes and its lines or rings, in metres."""
    features = json.loads(path.read_text())["features"]
    rows = []
    for f in features:
        kind, parts = f["geometry"]["type"], f["geometry"]["coordinates"]
        parts = {"LineString": lambda: [parts], "MultiLineString": lambda: parts, "Polygon": lambda: parts,
                 "MultiPolygon": lambda: [ring for polygon in parts for ring in polygon]}[kind]()
        rows.append((f["properties"], [np.array(p, float) for p in parts]))
    return rows


def slope(x, y):
    """Exponent of a power law by least squares."""
    return np.polyfit(np.log(x), np.log(y), 1)[0]


def graph(name, rivers, metres):
    """What holds of every graph of rivers; returns its reaches by their ids."""
    reach = {p["HYRIV_ID"]: (p, lines) for p, lines in rivers}
    above = defaultdict(list)
    for p, lines in rivers:
        for line in lines:
            check(name, "no vertex lies higher than the one before", (np.diff(line[:, 2]) <= 0).all(), p["HYRIV_ID"])
        if p["NEXT_DOWN"]:
            above[p["NEXT_DOWN"]].append(p["HYRIV_ID"])
            below = reach[p["NEXT_DOWN"]][1]
            apart = np.abs(lines[0][-1, :2] - below[0][0, :2]).max() * metres
            check(name, "reaches are joined", apart < 0.01, (p["HYRIV_ID"], apart))
    # From the springs down: orders after Strahler, the longest way from a spring. Reaches that are never reached lie on a loop.
    order, longest, waiting = {}, {}, {i: len(above[i]) for i in reach}
    ready = [i for i in reach if waiting[i] == 0]
    while ready:
        i = ready.pop()
        highest = sorted((order[k] for k in above[i]), reverse=True) or [1]
        order[i] = highest[0] + (len(highest) > 1 and highest[0] == highest[1])
        p = reach[i][0]
        longest[i] = p["LENGTH_KM"] + max((longest[k] for k in above[i]), default=0.0)
        if p["NEXT_DOWN"]:
            waiting[p["NEXT_DOWN"]] -= 1
            if waiting[p["NEXT_DOWN"]] == 0:
                ready.append(p["NEXT_DOWN"])
    check(name, "has no loop", len(order) == len(reach), len(reach) - len(order))
    wrong = [i for i in order if order[i] != reach[i][0]["ORD_STRA"]]
    check(name, "has Strahler's orders", not wrong, wrong[:5])
    ends = [p["END"] for p, _ in rivers if not p["NEXT_DOWN"]]
    check(name, "every river ends in the sea, at the rim, in a lake or in a hollow", all(1 <= e <= 4 for e in ends))
    return reach, order, longest


def ratio(order, reach):
    """How many times fewer streams the next order has, weighted by their numbers (Schumm 1956); a stream is a chain of reaches of one order."""
    count = defaultdict(int)
    for i, o in order.items():
        below = reach[i][0]["NEXT_DOWN"]
        count[o] += not below or order[below] != o
    n = np.array([count[o] for o in sorted(count)], float)
    return np.average(n[:-1] / n[1:], weights=n[:-1] + n[1:])


def wavelengths(line, width):
    """Way along the valley from one bend to the next to the same side, in widths, of a line."""
    way = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(line[:, :2], axis=0).T))])
    at = np.arange(0, way[-1], width / 2)
    x, y = np.interp(at, way, line[:, 0]), np.interp(at, way, line[:, 1])
    turn = np.unwrap(np.arctan2(np.diff(y), np.diff(x)))
    bend = np.diff(np.convolve(turn, np.ones(5) / 5, "valid"))
    # Bends sharper than a radius of 20 widths; between two of opposite sign lies half a wave.
    side = np.sign(bend[np.abs(bend) > 0.5 / 20])
    halves = np.count_nonzero(np.diff(side)) + 1
    # A moving mean of 25 widths is the axis of the valley.
    n = 50
    axis = np.stack([np.convolve(v, np.ones(n) / n, "valid") for v in (x, y)])
    valley = np.hypot(*np.diff(axis, axis=1)).sum() * len(x) / max(axis.shape[1], 1)
    return valley / (halves / 2) / width


real, plain = (pathlib.Path(a) for a in sys.argv[1:3])

rivers = read(real / "rivers.geojson")
with rasterio.open(real / "height.tif") as tif:
    # GeoJSON holds degrees.
    metres, middle = 111_000.0, np.radians((tif.bounds.top + tif.bounds.bottom) / 2)
reach, order, longest = graph("real", rivers, metres)
open_ = [i for i in reach if reach[i][0]["LAKE_ID"] == 0]
of = lambda key: np.array([reach[i][0][key] for i in open_])
hack = slope(of("UPLAND_SKM"), of("DIST_UP_KM"))
check("real", "Hack's exponent is 0.50 to 0.62", 0.50 <= hack <= 0.62, hack)
check("real", "the way from the divide is no shorter than that from the spring",
      (of("DIST_UP_KM") > 0.6 * np.array([longest[i] for i in open_])).all())
bifurcation = ratio(order, reach)
# The folded rock of Jacksboro has long parallel ridges, with many small streams beside each large one.
check("real", "the bifurcation ratio is that of natural networks, 3 to 5", 3.0 <= bifurcation <= 5.0, bifurcation)
single = of("THREADS") == 1
width = slope(of("DIS_AV_CMS")[single], of("WIDTH_M")[single])
check("real", "width goes with the root of the discharge", abs(width - 0.5) <= 0.02, width)

steps = np.concatenate([np.diff(line[:, :2], axis=0) for p, lines in rivers if not p["LAKE_ID"] for line in lines])
steps[:, 0] *= np.cos(middle)
length = np.hypot(*steps.T)
turn = np.degrees(np.arctan2(steps[:, 1], steps[:, 0])) % 45
along = length[np.minimum(turn, 45 - turn) <= 1].sum() / length.sum()
check("real", "at most 5 % of headings within a degree of multiples of 45", along <= 0.05, along)

rivers = read(plain / "rivers.geojson")
reach, order, _ = graph("plain", rivers, 1.0)
made = ratio(order, reach)
check("plain", "the bifurcation ratio is 3.5 to 4.6", 3.5 <= made <= 4.6, made)
winding = [(p, lines[0]) for p, lines in rivers if p["PATTERN"] == 1 and p["LENGTH_KM"] * 1000 > 60 * p["WIDTH_M"]]
check("plain", "slow rivers wind", len(winding) >= 3, len(winding))
waves = np.median([wavelengths(line, p["WIDTH_M"]) for p, line in winding])
check("plain", "a meander is 8 to 14 widths long", 8 <= waves <= 14, waves)
braided = [p for p, lines in rivers if len(lines) > 1]
check("plain", "threads are counted", all(p["THREADS"] > 1 and p["PATTERN"] == 2 for p in braided))

with rasterio.open(plain / "lake_level.tif") as tif:
    level, cell, area = tif.read(1), tif.transform.a, abs(tif.transform.a * tif.transform.e)
    south = tif.transform.f + tif.height * tif.transform.e
with rasterio.open(plain / "height.tif") as tif:
    height = tif.read(1)
lakes = read(plain / "lakes.geojson")
wet = level > height
known = np.array([p["LEVEL_M"] for p, _ in lakes], np.float32)
check("plain", "has lakes", len(lakes) >= 3, len(lakes))
check("plain", "every cell under a lake has the level of one, to the bit", np.isin(level[wet], known).all())
for p, rings in lakes:
    cells = np.count_nonzero(wet & (level == np.float32(p["LEVEL_M"])))
    check("plain", "the area of a lake is that of its cells", abs(cells * area / 1e6 - p["AREA_SKM"]) <= 2 * area / 1e6, p["LAKE_ID"])
    check("plain", "a shore is level", all(np.ptp(ring[:, 2]) == 0 for ring in rings), p["LAKE_ID"])
oxbows = read(plain / "oxbow_lakes.geojson")
check("plain", "bends were cut off", len(oxbows) > 0, len(oxbows))
check("plain", "oxbow lakes are level", all(np.ptp(r[:, 2]) == 0 for _, rings in oxbows for r in rings))

print(f"Hack {hack:.3f}, bifurcation {bifurcation:.2f} and {made:.2f}, width exponent {width:.3f}, headings {along:.4f}, wavelength {waves:.1f} widths")
finish()
