"""Plate tectonics of PyPlatec and of Eyot, side by side: seconds a step on the same grid with ten plates.

    python -m venv venv-plates && venv-plates/bin/pip install -r benches/peers/requirements-plates.txt
    venv-plates/bin/python benches/peers/plates_peer.py --eyot target/release/eyot --size 512 --json

PyPlatec works on one thread; Eyot is measured on one and on two. The runs take turns, so that both see the same machine, and
the best of each counts.
"""

import argparse
import json
import subprocess
import time

import platec


def peer(size, seed, steps):
    """Seconds a step of PyPlatec with the parameters of its documentation; building the world is not counted."""
    world = platec.create(seed, size, size, 0.65, 60, 0.02, 1_000_000, 0.33, 2, 10)
    start, done = time.perf_counter(), 0
    while done < steps and platec.is_finished(world) == 0:
        platec.step(world)
        done += 1
    return (time.perf_counter() - start) / max(done, 1), done


def own(eyot, size, threads, seconds):
    """Seconds a step of Eyot."""
    command = [eyot, "bench", "plates", "--size", str(size), "--threads", str(threads), "--seconds", str(seconds), "--json"]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)["seconds_per_step_median"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--eyot", default="eyot", help="the command")
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--steps", type=int, default=1100, help="steps of the peer in a turn")
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--json", action="store_true")
    args = parser.parse_args()
    best = {}
    for turn in range(args.turns):
        times = {"platec": peer(args.size, 3, args.steps)[0]}
        for threads in (1, 2):
            times[f"eyot_{threads}"] = own(args.eyot, args.size, threads, 4)
        for name, seconds in times.items():
            best[name] = min(seconds, best.get(name, seconds))
    report = {"size": args.size, "seconds_per_step": best}
    report["ratio"] = {name: best["platec"] / s for name, s in best.items() if name != "platec"}
    if args.json:
        print(json.dumps(report, indent=2))
        return
    for name, seconds in best.items():
        print(f"{name:10} {1e3 * seconds:8.3f} ms a step, {best['platec'] / seconds:5.2f} times as fast as platec")


if __name__ == "__main__":
    main()
