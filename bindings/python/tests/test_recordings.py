"""Recordings, as xarray opens them."""

import numpy as np
import pytest

import eyot

pytest.importorskip("zarr")

HILL = {
    "name": "Hill",
    "grid": {"size": 32, "cell": 20.0},
    "steps": [
        {"generate": "cone", "height": 300.0},
        {"simulate": ["hydraulic"], "steps": 200, "hydraulic.rain": 0.002},
    ],
    "view": {"enabled": False},
}


def test_a_recording_opens_as_a_data_set_that_knows_eyot(tmp_path):
    import xarray as xr

    ds = eyot.run(HILL, out=tmp_path / "run", record=50)
    recording = xr.open_zarr(tmp_path / "run" / "timeline.zarr")
    assert recording.sizes["time"] == 5
    last = recording.isel(time=-1)
    assert np.array_equal(last.height, ds.height)
    assert last.eyot.stats()["max_m"] == pytest.approx(ds.eyot.stats()["max_m"])
    with pytest.raises(eyot.EyotError, match="time"):
        recording.eyot.stats()


def test_a_recorded_run_goes_back_and_branches(tmp_path):
    with eyot.Run(HILL, out=tmp_path / "run", record=50) as run:
        run.advance(180)
        run.rewind(110)
        run.advance(1)
        kinds = [e["event"] for e in run.events()]
        assert "rewound" in kinds
        run.branch(60, tmp_path / "branch")
        whole = run.finish()
    again = eyot.Run.resume(tmp_path / "branch").finish()
    assert again.attrs["fingerprint"] == whole.attrs["fingerprint"] == eyot.run(HILL).attrs["fingerprint"]
