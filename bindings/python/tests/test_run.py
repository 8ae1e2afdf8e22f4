"""Runs: their bytes, their course, their ends."""

import json
import os
import pickle
import signal
import subprocess
import sys
import threading

import numpy as np
import pytest

import eyot

HILL = {
    "name": "Hill",
    "grid": {"size": 32, "cell": 20.0},
    "steps": [
        {"generate": "cone", "height": 300.0},
        {"simulate": ["hydraulic"], "steps": 200, "hydraulic.rain": 0.002},
    ],
}


def test_a_run_has_the_bytes_of_the_command(command, tmp_path):
    ds = eyot.run("island", size=64, seed=3, **{"hydraulic.rain": 0.004})
    arguments = ["--size", "64", "--seed", "3", "--set", "hydraulic.rain=0.004", "--quiet", "--out", tmp_path / "out"]
    subprocess.run([command, "run", "island", *arguments], check=True)
    report = json.loads((tmp_path / "out" / "run.json").read_text())
    assert ds.attrs["fingerprint"] == report["fingerprint"]
    again = eyot.open(tmp_path / "out")
    assert again.eyot.fingerprint == report["fingerprint"]
    assert np.array_equal(again.height, ds.height)


def test_a_run_with_a_folder_writes_the_files_of_the_command(tmp_path):
    ds = eyot.run(HILL, out=tmp_path / "out")
    report = json.loads((tmp_path / "out" / "run.json").read_text())
    assert report["fingerprint"] == ds.attrs["fingerprint"]
    assert (tmp_path / "out" / "world.eyot").exists()
    assert not (tmp_path / "out" / "eyot.lock").exists()


def test_threads_change_no_byte():
    prints = {eyot.run(HILL, threads=n).attrs["fingerprint"] for n in (1, 2, 3)}
    assert len(prints) == 1


def test_a_run_is_an_iterator_over_events():
    with eyot.Run(HILL) as run:
        events = list(run)
    kinds = [e["event"] for e in events]
    assert kinds[0] == "started" and kinds[-1] == "done"
    assert [e["name"] for e in events if e["event"] == "step_done"] == ["cone", "hydraulic"]
    assert run.status == "finished" and run.fingerprint == events[-1]["fingerprint"]


def test_steps_can_be_done_one_by_one():
    with eyot.Run(HILL, paused=True) as run:
        assert run.advance() == "paused"
        assert run.step(1) == "paused"
        assert run.step(7) == "paused"
        assert run.snapshot().attrs["steps_done"] == 7
    assert run.status == "stopped"


def test_changes_by_hand_are_remembered_and_made_again():
    with eyot.Run(HILL) as run:
        run.advance(51)
        run.set(**{"hydraulic.rain": 0.008})
        ds = run.finish()
    assert [e["step"] for e in run.journal] == [50]
    assert eyot.run(HILL, replay=run.journal).attrs["fingerprint"] == ds.attrs["fingerprint"]
    assert eyot.run(HILL).attrs["fingerprint"] != ds.attrs["fingerprint"]


def test_a_stopped_run_goes_on_to_the_same_bytes(tmp_path):
    whole = eyot.run(HILL)
    with eyot.Run(HILL, out=tmp_path / "run") as run:
        run.advance(100)
    assert run.status == "stopped"
    assert eyot.Run.resume(tmp_path / "run").finish().attrs["fingerprint"] == whole.attrs["fingerprint"]


def test_ctrl_c_stops_with_a_checkpoint(tmp_path):
    recipe = {**HILL, "steps": [HILL["steps"][0], {**HILL["steps"][1], "steps": 50_000_000}]}
    timer = threading.Timer(0.7, os.kill, (os.getpid(), signal.SIGINT))
    run = eyot.Run(recipe, out=tmp_path / "run")
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        run.finish()
    timer.join()
    assert run.status == "stopped"
    assert eyot.Run.resume(tmp_path / "run").advance(1) == "working"


def test_another_thread_can_stop_a_run_and_pythons_lock_is_free():
    recipe = {**HILL, "steps": [HILL["steps"][0], {**HILL["steps"][1], "steps": 50_000_000}]}
    run, ticks = eyot.Run(recipe), 0
    worker = threading.Thread(target=run.advance)
    worker.start()
    while ticks < 100_000:
        ticks += 1
    with pytest.raises(eyot.EyotError, match="another thread"):
        run.snapshot()
    run.stop()
    worker.join(10)
    assert not worker.is_alive() and run.status == "stopped"


def test_a_process_in_python_acts_between_steps():
    seen = []

    def lift(world):
        seen.append(world.step)
        world["height"] = world["height"] + np.float32(1.0)

    ds = eyot.run(HILL, between=lift, every=50)
    assert seen == [50, 100, 150, 200]
    account = ds.eyot.ledger["ground.by_hand"]
    assert account["amount"] == pytest.approx(4 * 32 * 32 * 400.0, rel=1e-4) and account["unit"] == "m3"


def test_a_run_that_fails_says_why_and_stays_failed():
    recipe = {
        **HILL,
        "layers": [{"name": "wild", "unit": "1", "start": 1.0, "next": "wild * 1e30"}],
        "steps": [HILL["steps"][0], {"simulate": ["wild"], "steps": 50}],
    }
    run = eyot.Run(recipe)
    with pytest.raises(eyot.EyotError) as caught:
        run.finish()
    assert caught.value.help and run.status == "failed"
    assert run.events()[-1]["event"] == "failed" and run.advance() == "failed"
    # What is no failure of the run leaves it as it is.
    run = eyot.Run(HILL)
    with pytest.raises(OverflowError):
        run.advance(-1)
    assert run.status == "working" and run.finish() is not None


def test_the_world_of_a_paused_run_is_not_copied_and_not_lost():
    with eyot.Run(HILL) as run:
        run.advance(11)
        with run.paused() as world:
            kept = world["height"]
            before = kept.copy()
            with pytest.raises(ValueError, match="read-only"):
                kept[0, 0] = 1.0
            with pytest.raises(eyot.EyotError, match="looked at"):
                run.advance()
        with pytest.raises(eyot.EyotError, match="belongs to the run"):
            world["height"]
        run.advance(50)
        assert np.array_equal(kept, before)
        assert not np.array_equal(run.snapshot().height, before)
        ds = run.finish()
    assert ds.attrs["fingerprint"] == eyot.run(HILL).attrs["fingerprint"]


@pytest.mark.parametrize("values", [np.inf, np.nan, 1e9, np.zeros((3, 3))])
def test_a_layer_takes_no_values_that_it_cannot_have(values):
    with eyot.Run(HILL) as run:
        run.advance(11)
        with pytest.raises((eyot.EyotError, ValueError)):
            with run.paused() as world:
                world["height"] = values
        assert run.finish().attrs["fingerprint"] == eyot.run(HILL).attrs["fingerprint"]


def test_recipes_are_pickled():
    recipe = eyot.Recipe(HILL, seed=4)
    assert eyot.run(pickle.loads(pickle.dumps(recipe))).attrs["fingerprint"] == eyot.run(recipe).attrs["fingerprint"]


def test_a_pickled_run_goes_on_where_it_was():
    run = eyot.Run(HILL)
    run.advance(51)
    run.set(**{"hydraulic.rain": 0.008})
    run.advance(10)
    copy = pickle.loads(pickle.dumps(run))
    assert copy.finish().attrs["fingerprint"] == run.finish().attrs["fingerprint"]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork here")
def test_a_forked_process_is_refused():
    code = """
import os, eyot
eyot.run("island", size=32)
pid = os.fork()
if pid == 0:
    try:
        eyot.run("island", size=32)
    except eyot.EyotError as e:
        os._exit(0 if "forked" in str(e) and "spawn" in e.help else 1)
    os._exit(2)
raise SystemExit(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]))
"""
    assert subprocess.run([sys.executable, "-W", "ignore", "-c", code], timeout=60).returncode == 0
