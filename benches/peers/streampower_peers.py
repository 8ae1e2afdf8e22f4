"""Stream power in fastscapelib, from the same start field with the same parameters as `eyot bench streampower`.

A step: uplift, routing over filled or carved depressions, drained areas, implicit incision (m = 0.45, n = 1), no creep.
`pip install fastscapelib numpy`; prints the best and the median step, after as many steps to warm up.
"""

import argparse
import json
import statistics
import time

import fastscapelib as fs
import numpy as np

from common import terrain

YEARS, UPLIFT, ERODIBILITY, AREA_EXPONENT, CELL = 10_000.0, 1e-3, 2e-5, 0.45, 30.0


def steps(size, sinks, slope_exponent, count):
    height = 200.0 * terrain(size).astype(np.float32).astype(float)
    grid = fs.RasterGrid([size, size], [CELL, CELL], fs.NodeStatus.FIXED_VALUE)
    resolver = fs.MSTSinkResolver() if sinks == "mst" else fs.PFloodSinkResolver()
    graph = fs.FlowGraph(grid, [fs.SingleFlowRouter(), resolver])
    eroder = fs.SPLEroder(graph, ERODIBILITY, AREA_EXPONENT, slope_exponent)
    rise = np.zeros_like(height)
    rise[1:-1, 1:-1] = UPLIFT * YEARS
    for _ in range(count):
        start = time.perf_counter()
        graph.update_routes(height)
        area = graph.accumulate(1.0)
        lifted = height + rise
        height = lifted - eroder.erode(lifted, area, YEARS)
        yield time.perf_counter() - start, height


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--size", type=int, default=1024)
    parser.add_argument("--steps", type=int, default=20)
    parser.add_argument("--sinks", choices=["mst", "flood"], default="mst")
    parser.add_argument("--slope-exponent", type=float, default=1.0)
    parser.add_argument("--json", action="store_true")
    a = parser.parse_args()
    times = []
    for seconds, height in steps(a.size, a.sinks, a.slope_exponent, 2 * a.steps):
        times.append(seconds)
    times = times[a.steps:]
    best, median = min(times), statistics.median(times)
    result = {
        "what": "streampower", "peer": f"fastscapelib {fs.__version__} ({a.sinks})", "size": a.size, "threads": 1,
        "steps": a.steps, "seconds_per_step": best, "seconds_per_step_median": median,
        "cell_steps_per_second": a.size**2 / best, "cell_steps_per_second_median": a.size**2 / median,
        "highest_m": float(height.max()),
    }
    print(json.dumps(result) if a.json else "\n".join(f"{k:30} {v}" for k, v in result.items()))


if __name__ == "__main__":
    main()
