"""Fixtures."""

import os
import shutil
from pathlib import Path

import pytest

import eyot


@pytest.fixture(scope="session")
def island():
    """A small finished landscape."""
    return eyot.run("island", size=64)


@pytest.fixture(scope="session")
def command():
    """The `eyot` command, if it is built: that of EYOT, of the path, or of the workspace."""
    built = Path(__file__).parents[3] / "target" / "release" / "eyot"
    found = os.environ.get("EYOT") or shutil.which("eyot") or (str(built) if built.exists() else None)
    if found is None:
        pytest.skip("the eyot command is not built")
    return found
