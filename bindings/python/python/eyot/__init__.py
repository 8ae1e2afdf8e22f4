"""Eyot: natural landscapes, from plates to polyps, as xarray data sets.

>>> import eyot
>>> ds = eyot.run("island", size=64)
>>> ds.eyot.fingerprint == ds.attrs["fingerprint"]
True
"""

from __future__ import annotations

from . import _eyot
from ._accessor import Picture, render, stats
from ._eyot import describe, schema
from ._errors import EyotError, MissingPackage, Problem, RecipeError
from ._recipe import Recipe
from ._run import Live, Run, generate, open, run

__version__ = _eyot.VERSION


def recipes() -> dict[str, str]:
    """Names of the built-in recipes, and a sentence about each."""
    return dict(_eyot.names("recipes"))


def generators() -> dict[str, str]:
    """Names of the generators, and a sentence about each."""
    return dict(_eyot.names("generators"))


def processes() -> dict[str, str]:
    """Names of the processes, and a sentence about each."""
    return dict(_eyot.names("processes"))


__all__ = [
    "EyotError",
    "Live",
    "MissingPackage",
    "Picture",
    "Problem",
    "Recipe",
    "RecipeError",
    "Run",
    "describe",
    "generate",
    "generators",
    "open",
    "processes",
    "recipes",
    "render",
    "run",
    "schema",
    "stats",
]
