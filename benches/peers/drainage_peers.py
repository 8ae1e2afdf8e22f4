"""Fill, route and accumulate in other programs, on the land of `eyot bench drainage`.

cargo run --release -p eyot-bench --example peer_fields -- drainage 1024 0 land.f32
venv/bin/python benches/peers/drainage_peers.py land.f32 --json
eyot bench drainage --size 1024 --threads 2 --json

richdem fills with a gradient, because its D8 stops on flats. fastscapelib's priority flood does likewise. pyflwdir takes its
directions from the flood. All three use one thread; pyflwdir compiles first, which is not counted.
"""

import argparse
import json
import statistics
import time

import numpy as np


def with_richdem(z):
    import richdem

    height = richdem.rdarray(z.copy(), no_data=-9999)
    richdem.FillDepressions(height, epsilon=True, in_place=True)
    return np.array(richdem.FlowAccumulation(height, method="D8"))


def with_fastscapelib(z):
    import fastscapelib as fs

    rim = fs.RasterBoundaryStatus([fs.NodeStatus.FIXED_VALUE] * 4)
    grid = fs.RasterGrid(list(z.shape), [30.0, 30.0], rim)
    graph = fs.FlowGraph(grid, [fs.PFloodSinkResolver(), fs.SingleFlowRouter()])
    graph.update_routes(z.astype(np.float64))
    return graph.accumulate(1.0) / 900.0


def with_pyflwdir(z):
    import pyflwdir

    _, d8 = pyflwdir.dem.fill_depressions(z, nodata=-9999.0, max_depth=-1.0, outlets="edge")
    return pyflwdir.from_array(d8, ftype="d8", latlon=False).upstream_area("cell")


PEERS = {"richdem": with_richdem, "fastscapelib": with_fastscapelib, "pyflwdir": with_pyflwdir}

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("land", help="raw f32 of a square grid")
    parser.add_argument("--peers", nargs="+", choices=PEERS, default=list(PEERS))
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--json", action="store_true")
    args = parser.parse_args()
    z = np.fromfile(args.land, np.float32)
    size = round(z.size**0.5)
    z = z.reshape(size, size)
    for peer in args.peers:
        area = PEERS[peer](z)
        rim = np.ones(z.shape, bool)
        rim[1:-1, 1:-1] = False
        times = []
        for _ in range(args.repeats):
            started = time.perf_counter()
            PEERS[peer](z)
            times.append(time.perf_counter() - started)
        best, median = min(times), statistics.median(times)
        report = {
            "peer": peer, "what": "drainage", "size": size, "threads": 1, "seconds_per_step": best,
            "seconds_per_step_median": median, "cell_steps_per_second": z.size / best,
            "cell_steps_per_second_median": z.size / median, "cells_at_the_rim": float(area[rim].sum()),
        }
        if args.json:
            print(json.dumps(report))
        else:
            print(f"{peer} {size}^2: {z.size / best / 1e6:.1f} ({z.size / median / 1e6:.1f}) million cells a second")
