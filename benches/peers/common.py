"""What the peers share: the cases (start fields and parameters), timing and output.

The same start fields and parameters are in `crates/eyot/src/bench.rs`; `check.py` shows that they are the same.
"""

import argparse
import json
import math
import statistics
import time
from typing import NamedTuple

import numpy as np

F = np.float32

# Layers of each case, in the order of the raw files.
LAYERS = {
    "classic": ("height", "water", "sediment", "outflow_west", "outflow_east", "outflow_north", "outflow_south"),
    "signed": ("height", "water", "sediment", "flux_x", "flux_y"),
    "thermal": ("height",),
    "reef": ("height", "limestone", "growth", "carbon", "reef_floor"),
}
# Lowest and highest ground, m.
RELIEF = {"classic": (0.0, 80.0), "signed": (-350.0, 650.0), "thermal": (0.0, 1000.0), "reef": (-140.0, 60.0)}


class Hydraulic(NamedTuple):
    """Parameters of `signed` and `classic`, as the rules take them; cells are square."""

    push: F  # dt g H / dx^2
    friction: F  # share of the flux that friction leaves
    dt: F
    dx: F
    slope: F  # 1 / (2 dx)
    fallen: F  # rain during dt
    keep: F  # share of the water that evaporation leaves
    dry: F
    speed2_max: F
    sine2_min: F
    sine2_max: F
    capacity: F
    ramp: F
    dig: F
    settle: F
    dig_limit: F
    sea: F


class Thermal(NamedTuple):
    stay: F  # height difference that stays
    stay_d: F  # the same between diagonal neighbours
    rate: F
    rate_d: F


class Reef(NamedTuple):
    spread: F  # diffusion number
    sea: F
    open_sea: F
    years: F
    growth: F
    per_light_depth: F
    shallow: F
    deep: F
    uptake: F
    sink: F


def hydraulic(dx, dt, rain, evaporation, wave_depth, friction, max_speed, capacity, slopes, ramp_depth, dry, rate,
              dig_limit, sea):
    share = F(1.0) - F(math.exp(F(-rate * dt)))  # Rounded as in Eyot.
    values = dict(
        push=dt * 9.81 * wave_depth / dx**2, friction=math.exp(-friction * dt), dt=dt, dx=dx, slope=0.5 / dx,
        fallen=rain * dt, keep=math.exp(-evaporation * dt), dry=dry, speed2_max=max_speed**2,
        sine2_min=slopes[0] ** 2, sine2_max=slopes[1] ** 2, capacity=capacity, ramp=1.0 / ramp_depth,
        dig=share, settle=share, dig_limit=dig_limit, sea=sea)
    return Hydraulic(**{k: F(v) for k, v in values.items()})


def parameters(case):
    if case == "classic":  # Mei 2007 on cells of 1 m; there is no sea.
        return hydraulic(1.0, 0.02, 0.01, 0.015, 1.0, 0.0, 50.0, 0.1, (0.05, 1.0), 1e-4, 1e-3, 0.5, 1.0, -1e30)
    if case == "signed":  # The engine's defaults on cells of 10 m.
        return hydraulic(10.0, 0.5, 0.004, 0.01, 10.0, 0.1, 10.0, 1.0, (0.05, 0.5), 0.5, 0.005, 0.1, 0.25, 0.0)
    if case == "thermal":  # Talus 36 degrees, rate 0.5, cells of 10 m.
        stay = math.tan(math.radians(36.0)) * 10.0
        return Thermal(F(stay), F(stay * math.sqrt(2.0)), F(0.5 / 12.0), F(0.5 / 24.0))
    if case == "reef":  # Defaults with steps of one year on cells of 10 m, which makes one spreading a growth.
        return Reef(*map(F, (20.0 / 10.0**2, 0.0, 60.0, 1.0, 0.012, 1.0 / 20.0, 0.5, 40.0, 0.4, 0.0)))
    raise ValueError(case)


def hashed(x, y, salt):
    """A number in [0, 1) from two integers (the hash lowbias32)."""
    with np.errstate(over="ignore"):
        h = np.uint32(0x9E3779B1) * np.asarray(x, np.uint32) ^ np.uint32(0x85EBCA77) * np.asarray(y, np.uint32)
        h = h ^ np.uint32(0xC2B2AE3D * (salt + 1) & 0xFFFFFFFF)
        h = (h ^ (h >> np.uint32(16))) * np.uint32(0x21F0AAAD)
        h = (h ^ (h >> np.uint32(15))) * np.uint32(0x735A2D97)
        h = h ^ (h >> np.uint32(15))
    return h / 4294967296.0


def terrain(size):
    """Value noise in 0..1: seven octaves with periods of 128 to 2 cells."""
    y, x = np.mgrid[0:size, 0:size]
    total = np.zeros((size, size))
    for octave in range(7):
        period = 128 >> octave
        u, v = x % period / period, y % period / period
        u, v = u * u * (3.0 - 2.0 * u), v * v * (3.0 - 2.0 * v)
        i, j = x // period, y // period
        a, b = hashed(i, j, octave), hashed(i + 1, j, octave)
        c, d = hashed(i, j + 1, octave), hashed(i + 1, j + 1, octave)
        north, south = a + (b - a) * u, c + (d - c) * u
        total += (north + (south - north) * v) * 0.5**octave
    return total / (2.0 - 0.5**6)


def start_fields(case, size):
    """Layers by name: hills, water of 0 to 0.2 m, carbon everywhere."""
    fields = {name: np.zeros((size, size), F) for name in LAYERS[case]}
    low, high = RELIEF[case]
    fields["height"] = (low + (high - low) * terrain(size)).astype(F)
    if "water" in fields:
        y, x = np.mgrid[0:size, 0:size]
        fields["water"] = (0.2 * hashed(x, y, 99)).astype(F)
    if "carbon" in fields:
        fields["carbon"][:] = 1.0
        fields["reef_floor"][:] = fields["height"]  # No limestone yet.
    return fields


def read_fields(case, path):
    names = LAYERS[case]
    values = np.fromfile(path, F)
    size = math.isqrt(values.size // len(names))
    return dict(zip(names, values.reshape(len(names), size, size)))


def main(peer, cases, set_threads=None, threading_layer=lambda: None):
    """Command line of a peer.

    `cases[name](fields, parameters)` makes an object with advance(steps), fields() and ledger().
    """
    parser = argparse.ArgumentParser(description=f"Steps of Eyot's processes in {peer}")
    parser.add_argument("case", choices=cases)
    parser.add_argument("--size", type=int, default=512, help="cells along a side")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--steps", type=int, default=0, help="steps of a repeat; 0: about a second's worth")
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--check", metavar="FILE", help="start from raw f32, run --steps, write FILE.out and the sums")
    args = parser.parse_args()
    if set_threads:
        set_threads(args.threads)
    elif args.threads != 1:
        parser.error(f"{peer} has no threads")

    if args.check:
        fields = read_fields(args.case, args.check)
        case = cases[args.case](fields, parameters(args.case))
        case.advance(args.steps)
        result = case.fields()
        np.concatenate([result[name].ravel() for name in LAYERS[args.case]]).astype(F).tofile(args.check + ".out")
        print(json.dumps({"ledger": case.ledger()}))
        return

    case = cases[args.case](start_fields(args.case, args.size), parameters(args.case))
    case.advance(2)  # Compiles, and touches all memory.
    started = time.perf_counter()
    case.advance(4)
    steps = args.steps or max(4, round(4.0 / (time.perf_counter() - started)))
    times = []
    for _ in range(args.repeats):
        started = time.perf_counter()
        case.advance(steps)
        times.append((time.perf_counter() - started) / steps)
    best, median = min(times), statistics.median(times)
    report = {
        "peer": peer, "what": args.case, "size": args.size, "threads": args.threads,
        "threading_layer": threading_layer(), "steps": steps, "repeats": args.repeats, "seconds_per_step": best,
        "seconds_per_step_median": median, "cell_steps_per_second": args.size**2 / best,
        "cell_steps_per_second_median": args.size**2 / median,
    }
    if args.json:
        print(json.dumps(report))
    else:
        print(f"{peer} {args.case} {args.size}^2, {args.threads} thread(s): "
              f"{args.size**2 / best / 1e6:.1f} ({args.size**2 / median / 1e6:.1f}) million cell-steps a second")
