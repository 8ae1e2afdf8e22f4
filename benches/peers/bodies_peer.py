"""Marching cubes of scikit-image on a field that numpy computes at every point, and Eyot's meshing of the same body.

    python -m venv venv-bodies && venv-bodies/bin/pip install -r benches/peers/requirements-bodies.txt
    cargo build --release -p eyot-io --example surface
    venv-bodies/bin/python benches/peers/bodies_peer.py --surface target/release/examples/surface --json

The body is a coral of rounded cones that fork from one foot. The peer knows no blocks: each cone is evaluated at all points, in
single precision, and the surface extracted by Lewiner's tables. Both fields are the same: kernels of Muraki, blended by the
Gini mean of orders 9 and 1. Eyot relaxes the vertices as well, and finds its normals from exact gradients. The runs take turns,
and the best of each counts.
"""

import argparse
import json
import pathlib
import re
import subprocess
import tempfile
import time

import numpy as np
from skimage.measure import marching_cubes

REACH = 1 / np.sqrt(1 - np.sqrt(0.5))  # radius of influence over radius: the kernel is 1/2 on the surface


def coral(generations=7, seed=1):
    """Rounded cones: ends and radii, m."""
    random = np.random.default_rng(seed)
    tips, cones = [(np.zeros(3), np.array([0.0, 1.0, 0.0]), 0.05)], []
    for _ in range(generations):
        grown = []
        for foot, way, radius in tips:
            for _ in range(2):
                lean = way + random.uniform(-0.7, 0.7, 3)
                lean[1] = max(lean[1], 0.1)
                lean /= np.linalg.norm(lean)
                tip = foot + 0.16 * lean
                cones.append((foot, tip, radius, 0.95 * radius))
                grown.append((tip, lean, 0.95 * radius))
        tips = grown
    return cones


def field(cones, axes):
    """Values at all points, above 0 inside."""
    x, y, z = (a.astype(np.float32) for a in np.meshgrid(*axes, indexing="ij", sparse=True))
    total = np.zeros([len(a) for a in axes], np.float32)
    ninth = np.zeros_like(total)
    for a, b, r, s in cones:
        axis = (b - a).astype(np.float32)
        dx, dy, dz = x - np.float32(a[0]), y - np.float32(a[1]), z - np.float32(a[2])
        t = np.clip((dx * axis[0] + dy * axis[1] + dz * axis[2]) / np.float32(axis @ axis), 0, 1)
        square = (dx - t * axis[0]) ** 2 + (dy - t * axis[1]) ** 2 + (dz - t * axis[2]) ** 2
        radius = np.float32(REACH * r) + t * np.float32(REACH * (s - r))
        k = np.maximum(1 - square / radius**2, 0) ** 2
        total += k
        k8 = k * k
        k8 *= k8
        k8 *= k8
        ninth += k * k8
    mean = np.divide(ninth, total, out=np.zeros_like(total), where=total > 0)
    return np.sqrt(np.sqrt(np.sqrt(mean))) - np.float32(0.5)


def peer(cones, voxel):
    """Seconds of field and surface, and triangles."""
    ends = np.array([[*a, *b] for a, b, _, _ in cones]).reshape(-1, 3)
    reach = REACH * max(max(r, s) for _, _, r, s in cones)
    axes = [np.arange(low - reach - voxel, high + reach + voxel, voxel) for low, high in zip(ends.min(0), ends.max(0))]
    start = time.perf_counter()
    values = field(cones, axes)
    sampled = time.perf_counter()
    _, faces, _, _ = marching_cubes(values, 0.0, spacing=(voxel,) * 3)
    return [sampled - start, time.perf_counter() - sampled], len(faces)


def own(surface, cones, voxel):
    """Seconds of Eyot, and triangles."""
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "coral.txt"
        file.write_text("".join(f"{' '.join(map(str, a))} {r} {' '.join(map(str, b))} {s}\n" for a, b, r, s in cones))
        command = [surface, str(file), str(file.with_suffix(".ply")), str(voxel)]
        out = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    triangles, ms = re.match(r"(\d+) triangles in ([\d.]+) ms", out).groups()
    return 1e-3 * float(ms), int(triangles)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--surface", default="target/release/examples/surface", help="the example of eyot-io")
    parser.add_argument("--voxel", type=float, default=0.02, help="m")
    parser.add_argument("--generations", type=int, default=7)
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--json", action="store_true")
    args = parser.parse_args()
    cones = coral(args.generations)
    turns = [(peer(cones, args.voxel), own(args.surface, cones, args.voxel)) for _ in range(args.turns)]
    sampled, extracted = (min(p[0][i] for p, _ in turns) for i in range(2))
    report = {
        "cones": len(cones),
        "voxel_m": args.voxel,
        "peer_field_seconds": sampled,
        "peer_surface_seconds": extracted,
        "peer_triangles": turns[0][0][1],
        "eyot_seconds": min(o[0] for _, o in turns),
        "eyot_triangles": turns[0][1][1],
    }
    report["times_as_fast"] = (sampled + extracted) / report["eyot_seconds"]
    alike = report["eyot_triangles"] / report["peer_triangles"]
    if not 0.97 < alike < 1.03:
        raise SystemExit(f"not the same body: {report}")
    print(json.dumps(report) if args.json else "\n".join(f"{k} {v}" for k, v in report.items()))


if __name__ == "__main__":
    main()
