"""Do the peers and Eyot compute the same thing? Start fields bit by bit, then results after some steps.

    python check.py [--size 512] [--peer-fields PATH_OF_BUILT_EXAMPLE]

Results differ by rounding: orders of summation, fused multiply-adds (numba), exponentials. The models have thresholds
(a cell is dry or not, land or sea, and a cell that becomes sea drops all its sediment), so after some tens of steps
rounding decides a few cells differently, in Eyot and the peers as in the peers among themselves. Hence two tests:

- after 5 steps every cell agrees: largest difference at most 1e-4 of the layer's largest magnitude, or half the last
  place of the ground's height a step, to which Eyot rounds what ground, load and limestone exchange;
- after 50 steps 99.9 % of the cells do, within 1e-3 of it, and the layer's sum within 1e-3 of the sum of magnitudes.

Accounts of the ledger agree within 1e-3. Two are nothing but rounding and are small everywhere: `water.clamped` at most
1e-6 of the rain, `limestone.worn` (nothing wears limestone here) at most 1e-4 of what grew.

The peers leave out what does not change the work's result: `classic` keeps no ledger and no test for the sea.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

import common

HERE = pathlib.Path(__file__).parent
EXACT = {5: 1e-4}  # steps: largest difference allowed
MOST = {50: 1e-3}  # steps: difference that 0.1 % of the cells may exceed
SUM = 1e-3
ROUNDING = {"water.clamped": (1e-6, "water.rain"), "limestone.worn": (1e-4, "ground.reef")}
PEERS = {  # script: its cases
    "numba_steps": tuple(common.LAYERS),
    "numba_plain": ("classic", "signed", "thermal"),
    "numpy_steps": tuple(common.LAYERS),
}


def output_of(*command):
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def compare(label, steps, layers, ours, theirs, ledger, their_ledger):
    """Prints one line a layer and account; returns the number of disagreements."""
    failures = 0

    def line(name, agrees, text):
        nonlocal failures
        failures += not agrees
        print(f"{label} {name:22} {text}{'' if agrees else '  DISAGREES'}")

    last_place = float(np.spacing(np.abs(ours["height"]).max()))
    for name in layers:
        a, b = ours[name].astype(np.float64), theirs[name].astype(np.float64)
        largest, magnitude = max(np.abs(a).max(), 1e-12), max(np.abs(a).sum(), 1e-12)
        difference = np.abs(a - b)
        worst, most = difference.max(), np.quantile(difference, 0.999)
        total = abs(a.sum() - b.sum()) / magnitude
        if steps in EXACT:
            agrees = worst <= max(EXACT[steps] * largest, 0.5 * steps * last_place)
        else:
            agrees = most <= MOST[steps] * largest
        agrees = agrees and total <= SUM
        line(name, agrees, f"largest {largest:8.3g}  max |diff| {worst:.1e}  99.9 % below {most:.1e}  "
                           f"sum {b.sum():.9g} / {a.sum():.9g} ({total:.0e})")
    for account, theirs_ in their_ledger.items():
        want = ledger[account]
        if account in ROUNDING:
            share, of = ROUNDING[account]
            line(account, max(theirs_, want) <= share * ledger[of], f"{theirs_:.1e} / {want:.1e}")
        else:
            error = abs(theirs_ - want) / max(abs(want), 1e-9)
            line(account, error <= SUM, f"{theirs_:.9g} / {want:.9g} ({error:.0e})")
    return failures


def main():
    parser = argparse.ArgumentParser(description="Compares the peers with Eyot")
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--peer-fields", help="the built example; by default cargo builds and runs it")
    args = parser.parse_args()
    example = [args.peer_fields] if args.peer_fields else [
        "cargo", "run", "--quiet", "--release", "--package", "eyot-bench", "--example", "peer_fields", "--"]
    failures = 0
    with tempfile.TemporaryDirectory() as folder:
        for case, layers in common.LAYERS.items():
            start = str(pathlib.Path(folder, case))
            for steps in (*EXACT, *MOST):
                said = json.loads(output_of(*example, case, str(args.size), str(steps), start))
                if tuple(said["layers"]) != layers:
                    sys.exit(f"{case}: Eyot's layers are {said['layers']}")
                if steps in EXACT:
                    made, wanted = common.start_fields(case, args.size), common.read_fields(case, start)
                    same = all(np.array_equal(made[n], wanted[n]) for n in layers)
                    print(f"{case}: start fields {'are the same to the bit' if same else 'DIFFER'}")
                    failures += not same
                ours = common.read_fields(case, start + ".eyot")
                for peer, cases in PEERS.items():
                    if case not in cases:
                        continue
                    script = [sys.executable, str(HERE / f"{peer}.py"), case, "--steps", str(steps)]
                    ledger = json.loads(output_of(*script, "--check", start))["ledger"]
                    theirs = common.read_fields(case, start + ".out")
                    label = f"{case:7} {steps:2} steps {peer:11}"
                    failures += compare(label, steps, layers, ours, theirs, said["ledger"], ledger)
    print(f"{failures} disagreement(s)")
    sys.exit(failures > 0)


if __name__ == "__main__":
    main()
