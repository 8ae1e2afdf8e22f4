"""Recipes."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from . import _eyot, _toml
from ._arrays import Kept, kept
from ._errors import EyotError


class Recipe:
    """Everything that decides the bytes of a landscape.

    ``source`` is the name of a built-in recipe, the path of a recipe file, a TOML document, or a dictionary with the keys of one
    (``steps``, ``layers``, ``rules`` and ``exports`` may be written in the plural). Where a recipe names the file of a raster, an array of
    NumPy, xarray or rioxarray will do. ``size`` is the number of cells of the longer side, or columns and rows, for the same extent;
    all other keyword arguments are changes as the command line's ``--set``.

    >>> import eyot
    >>> hill = eyot.Recipe({
    ...     "name": "Hill",
    ...     "grid": {"size": 64, "cell": 20.0},
    ...     "steps": [{"generate": "cone", "height": 300.0}],
    ... }, seed=7)
    >>> hill.check()
    >>> hill.seed, hill.size, [step["name"] for step in hill.steps]
    (7, (64, 64), ['cone'])
    """

    def __init__(
        self,
        source: str | os.PathLike | Mapping | Recipe,
        *,
        size: int | tuple[int, int] | None = None,
        presets: list[str] | tuple[str, ...] = (),
        max_memory: int | None = None,
        **changes: Any,
    ) -> None:
        self._keep: list[Kept] = []
        self._checked: _eyot.Recipe | None = None
        if isinstance(source, Recipe):
            self.name, self.text, self.folder = source.name, source.text, source.folder
            self._set, self._size = list(source._set), source._size
            self._presets, self._max_memory = source._presets, source._max_memory
            self._keep = list(source._keep)
        else:
            self.name, self.text, self.folder = self._find(source)
            self._set, self._size, self._presets, self._max_memory = [], None, (), None
        changes, keep = kept(changes)
        if keep:
            self._keep.append(keep)
        self._set += _toml.changes(changes)
        if size is not None:
            self._size = (size, None) if not isinstance(size, (tuple, list)) else tuple(size)
        self._presets = ((presets,) if isinstance(presets, str) else tuple(presets)) or self._presets
        self._max_memory = max_memory if max_memory is not None else self._max_memory

    def _find(self, source: Any) -> tuple[str, str, Path]:
        if isinstance(source, Mapping):
            cell = source.get("grid", {}).get("cell") if isinstance(source.get("grid", {}), Mapping) else None
            source, keep = kept(source, cell=cell)
            if keep:
                self._keep.append(keep)
            return "recipe", _toml.document(source), Path.cwd()
        if isinstance(source, str) and ("\n" in source or "=" in source):
            return "recipe", source, Path.cwd()
        if isinstance(source, (str, os.PathLike)):
            name, text, folder = _eyot.find_recipe(os.fspath(source))
            return name, text, Path(folder)
        raise EyotError(
            f"a recipe is no {type(source).__name__}",
            "give the name of a built-in recipe, a path, a TOML document or a dictionary",
        )

    @property
    def checked(self) -> _eyot.Recipe:
        """The recipe in Rust.

        Raises :class:`RecipeError` with all places and remedies if it cannot be run.
        """
        if self._checked is None:
            folder, size, presets = Path(self.folder), self._size, list(self._presets)
            self._checked = _eyot.Recipe(self.name, self.text, folder, self._set, size, presets, self._max_memory)
        return self._checked

    def check(self) -> None:
        """Checks the recipe.

        Raises :class:`RecipeError` with all places and remedies if it cannot be run.
        """
        self.checked  # noqa: B018

    def cite(self, form: str = "text") -> str:
        """What the recipe rests on, as ``text``, ``bibtex`` or ``json``."""
        return _eyot.cite(self.checked, form)

    def to_toml(self) -> str:
        """The document with all changes and every key that has a value."""
        return self.checked.effective_toml()

    def facts(self) -> dict[str, Any]:
        """Name, sentence, seed, size, cell size (m), sea level (m), steps and doubts."""
        return self.checked.facts()

    @property
    def title(self) -> str:
        """What the landscape is called."""
        return self.facts()["name"]

    @property
    def seed(self) -> int:
        """Seed of all random numbers."""
        return self.facts()["seed"]

    @property
    def size(self) -> tuple[int, int]:
        """Columns and rows."""
        return self.facts()["size"]

    @property
    def cell(self) -> tuple[float, float]:
        """Size of a cell, west-east and north-south, m."""
        return self.facts()["cell"]

    @property
    def steps(self) -> list[dict[str, Any]]:
        """What is done, in order."""
        return self.facts()["steps"]

    @property
    def total_steps(self) -> int:
        """Steps of all steps that are switched on; a generator counts as one."""
        return sum(step["steps"] for step in self.steps if step["enabled"])

    def __getstate__(self) -> dict[str, Any]:
        state = {**self.__dict__, "_checked": None, "_keep": []}
        # Rasters that were arrays lie in a temporary folder of this process: they travel along.
        state["_files"] = [(str(p), p.read_bytes()) for k in self._keep for p in sorted(k.folder.iterdir())]
        return state

    def __setstate__(self, state: dict[str, Any]) -> None:
        files = state.pop("_files")
        self.__dict__.update(state)
        if files:
            keep = Kept()
            self._keep = [keep]
            for name, data in files:
                path = keep.folder / f"{len(list(keep.folder.iterdir()))}-{Path(name).name}"
                path.write_bytes(data)
                self.text = self.text.replace(_toml.value(name), _toml.value(str(path)))
                self._set = [s.replace(_toml.value(name), _toml.value(str(path))) for s in self._set]

    def __repr__(self) -> str:
        changes = "".join(f", {s}" for s in self._set)
        return f"eyot.Recipe({self.name!r}{'' if self._size is None else f', size={self._size[0]}'}{changes})"
