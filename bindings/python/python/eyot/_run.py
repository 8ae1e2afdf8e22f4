"""Runs: recipes being carried out."""

from __future__ import annotations

import io
import json
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from . import _eyot, _toml
from ._dataset import dataset, warn
from ._errors import EyotError, need
from ._recipe import Recipe

#: Seconds of work between two events of an iteration, at most.
_TURN = 0.1


class Run:
    """A recipe being carried out, step by step.

    A run is a context manager, which stops what is left when its block is left, and an iterator over events: dictionaries whose
    ``event`` says what happened. ``out`` is a folder for the files that the command ``eyot run`` would write, and for checkpoints.
    Without one, ``files`` keeps them in memory: :attr:`files`, :meth:`mesh`. ``record`` keeps a frame of the recording each so many
    steps. ``threads``, ``engine`` (``auto``, ``cpu``, ``gpu``), ``adapter`` and ``max_memory`` (bytes) change no byte of the result, but for a
    graphics card. A run that is pickled goes on from a checkpoint, without a
    folder; commands that it has not heard yet are lost. All other arguments are those of :class:`Recipe`.

    >>> import eyot
    >>> with eyot.Run("island", size=64) as run:
    ...     kinds = {event["event"] for event in run}
    >>> run.status, "progress" in kinds
    ('finished', True)
    """

    def __init__(
        self,
        recipe: str | os.PathLike | Mapping | Recipe,
        *,
        size: int | tuple[int, int] | None = None,
        out: str | os.PathLike | None = None,
        threads: int | None = None,
        engine: str | None = None,
        adapter: str | None = None,
        max_memory: int | None = None,
        paused: bool = False,
        restart: bool = False,
        force: bool = False,
        record: int | None = None,
        record_limit: int | None = None,
        checkpoint_seconds: float = 60.0,
        replay: list[dict] | None = None,
        files: bool = False,
        presets: list[str] | tuple[str, ...] = (),
        **changes: Any,
    ) -> None:
        if record is not None and record < 1:
            raise EyotError(f"`record={record}` is no number of steps", "give 1 or more, or leave it out")
        self.recipe = Recipe(recipe, size=size, presets=presets, max_memory=max_memory, **changes)
        self._options = {"threads": threads or 0, "engine": engine, "adapter": adapter, "max_memory": max_memory}
        self._options |= {"checkpoint_seconds": checkpoint_seconds}
        self._out = None if out is None else Path(out)
        self._begin(
            self.recipe.checked,
            paused=paused,
            restart=restart,
            force=force,
            record=record,
            record_limit=record_limit,
            files=files and out is None,
            replay=json.dumps(replay or []),
        )

    def _begin(self, recipe: _eyot.Recipe | None, **options: Any) -> None:
        self._session = _eyot.Session(recipe, out=self._out, **self._options, **options)
        self.status = "working"
        self._journal: list[dict] = []
        self._heard: list[dict] = []

    @classmethod
    def resume(cls, folder: str | os.PathLike, *, threads: int | None = None, **options: Any) -> Run:
        """Goes on with the stopped run in a folder, at the exact step."""
        run = cls.__new__(cls)
        run._out, run.recipe = Path(folder), None
        run._options = {"threads": threads or 0, **options}
        run._begin(None)
        return run

    # Going on.

    def advance(self, steps: int | None = None, *, seconds: float | None = None) -> str:
        """Works for so many steps of simulation (a generator is one) or seconds, or to the end or a pause.

        Returns the status: ``working``, ``paused``, ``finished`` or ``stopped``. Python's lock is free meanwhile. Ctrl-C stops the run, with a
        checkpoint if it has a folder, before the exception comes.
        """
        try:
            self.status = self._session.advance(steps, seconds)
        except BaseException:
            self.status = self._session.state() or self.status
            raise
        return self.status

    def events(self) -> list[dict[str, Any]]:
        """What has happened since the last call."""
        self._listen()
        events, self._heard = self._heard, []
        return events

    def _listen(self) -> None:
        events = self._session.events()
        self._journal += [e for e in events if e["event"] == "changed"]
        self._heard += events

    def __iter__(self) -> Iterator[dict[str, Any]]:
        while self.status == "working":
            self.advance(seconds=_TURN)
            yield from self.events()

    def finish(self, progress: bool = False) -> xr.Dataset:
        """Works to the end and returns the landscape. ``progress`` shows a bar, if tqdm is installed."""
        self.go_on()
        if progress:
            _show(self)
        else:
            while self.status == "working":
                self.advance()
        return self.dataset()

    def go_on(self) -> None:
        """Lets a paused run go on, when it is advanced."""
        if self.status == "paused":
            self._session.command("resume")
            self.status = "working"

    # Commands.

    def pause(self) -> None:
        """Asks the run to wait after the present step; from any thread."""
        self._session.command("pause")

    def step(self, n: int = 1) -> str:
        """Does so many steps and waits."""
        self._session.command("step", steps=n)
        self.status = "working"
        return self.advance()

    def set(self, **changes: Any) -> None:
        """Changes the simulation under way before its next step: ``run.set(**{"hydraulic.rain": 0.004})``.

        Also the level of the sea (``sea_level``, m) and all cells of a layer (``layer={"water": 0.0}``). What a recipe could not have is
        refused in an event ``not_changed``. The journal remembers it.
        """
        for change in _toml.changes(changes):
            self._session.command("set", set=change)

    def rewind(self, step: int, forget: bool = False) -> None:
        """Goes back to the last recorded frame that has at most so many steps done."""
        self._session.command("rewind", steps=step, forget=forget)

    def branch(self, step: int, out: str | os.PathLike) -> None:
        """Puts the last recorded frame that has at most so many steps done into a new folder, to be resumed there."""
        self._session.command("branch", steps=step, out=Path(out))

    def stop(self) -> None:
        """Asks the run to end, with a checkpoint if it has a folder; from any thread."""
        self._session.command("stop")

    def checkpoint(self) -> Path | None:
        """Writes a checkpoint now; ``None`` without a folder."""
        return self._session.save()

    # Looking.

    def snapshot(self) -> xr.Dataset:
        """The landscape as it is: a copy of the world that stays as it is. Of a run that is over, the last world itself."""
        return dataset(self._session.world(), self._attrs())

    def dataset(self) -> xr.Dataset:
        """As :meth:`snapshot`."""
        return self.snapshot()

    @contextmanager
    def paused(self) -> Iterator[Live]:
        """The world itself, between two steps, without a copy.

        ``world["height"]`` is an array that nobody can write to. ``world["height"] = values`` puts other values into the layer when the
        block is left; what that adds or takes away has an account in the ledger, but the journal does not know of it. Arrays that
        outlive the block keep their values, and the run goes on with a copy; drop them to save that.
        """
        live = Live(self._session.lend())
        try:
            yield live
        except BaseException:
            live._close()
            self._session.restore([])
            raise
        self._session.restore(live._close())

    @property
    def outcome(self) -> dict[str, Any] | None:
        """Fingerprint, whether the run came to its end, its files and its journal, once it is over."""
        return self._session.outcome()

    @property
    def fingerprint(self) -> str | None:
        """Fingerprint of the finished world, hexadecimal."""
        outcome = self.outcome
        return outcome["fingerprint"] if outcome else None

    @property
    def journal(self) -> list[dict[str, Any]]:
        """The changes by hand, with their steps; ``Run(recipe, replay=journal)`` makes them again."""
        outcome = self.outcome
        if outcome:
            return outcome["journal"]
        self._listen()
        return [{k: e[k] for k in ("recipe_step", "step", "set")} for e in self._journal]

    @property
    def files(self) -> Mapping[str, bytes]:
        """The files of a run that is over, by name: those of its folder, or those in memory if it was begun with ``files=True``."""
        return Files(self._out, self._session)

    def mesh(self, name: str | None = None) -> Any:
        """A mesh among the files as a scene of trimesh (needs trimesh): corals, trees or the terrain; the only one if there is no ``name``."""
        trimesh = need("trimesh", "a mesh")
        files = self.files
        meshes = [n for n in files if n.endswith(".glb")]
        if name is None and len(meshes) != 1:
            hint = "begin the run with files=True or out=, and export a glb" if not meshes else "name one of them"
            raise EyotError(f"there is not one mesh: {', '.join(meshes) or 'none'}", hint)
        name = name or meshes[0]
        if name not in files:
            raise EyotError(f"there is no file `{name}`", f"there is: {', '.join(files)}")
        return trimesh.load(io.BytesIO(files[name]), file_type=name.rsplit(".", 1)[-1])

    def _attrs(self) -> dict[str, Any]:
        attrs: dict[str, Any] = {}
        if self.recipe is not None:
            facts = self.recipe.facts()
            attrs |= {"title": facts["name"], "recipe": self.recipe.to_toml()}
        if outcome := self.outcome:
            attrs |= {"fingerprint": outcome["fingerprint"], "journal": json.dumps(outcome["journal"])}
        return attrs

    # Being held.

    def __getstate__(self) -> dict[str, Any]:
        checkpoint = self._session.freeze()
        if checkpoint is None:
            raise EyotError("a run that is over cannot be pickled", "pickle `run.dataset()`, or `run.recipe` and `run.journal`")
        kept = ("recipe", "_options", "status", "_journal")
        return {"checkpoint": checkpoint, **{k: self.__dict__[k] for k in kept}}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.recipe, self._options, self._out = state["recipe"], state["_options"], None
        self._begin(None, checkpoint=state["checkpoint"], paused=state["status"] == "paused")
        self.status, self._journal = state["status"], state["_journal"]

    def __enter__(self) -> Run:
        return self

    def __exit__(self, *_: object) -> None:
        if self.status in ("working", "paused"):
            self.stop()
            self.status = self._session.advance(None, None)

    def __repr__(self) -> str:
        return f"<eyot.Run of {self.recipe!r}: {self.status}>"


class Files(Mapping):
    """Files of a run by name; each is read when it is asked for."""

    def __init__(self, folder: Path | None, session: _eyot.Session) -> None:
        self._folder, self._session = folder, session

    def _names(self) -> list[str]:
        if self._folder is None:
            return self._session.file_names()
        return sorted(str(p.relative_to(self._folder)) for p in self._folder.rglob("*") if p.is_file())

    def __getitem__(self, name: str) -> bytes:
        if self._folder is None:
            found = self._session.file(name)
        else:
            found = (self._folder / name).read_bytes() if name in self._names() else None
        if found is None:
            raise KeyError(name)
        return found

    def __iter__(self) -> Iterator[str]:
        return iter(self._names())

    def __len__(self) -> int:
        return len(self._names())

    def __repr__(self) -> str:
        return f"<files of a run: {', '.join(self) or 'none'}>"


class Live:
    """The layers of a run's world between two steps; see :meth:`Run.paused`."""

    def __init__(self, world: _eyot.World) -> None:
        self._world: _eyot.World | None = world
        self._changes: dict[str, np.ndarray] = {}
        self._layers = {layer["name"]: layer for layer in world.layers()}

    def _open(self) -> _eyot.World:
        if self._world is None:
            raise EyotError("the world belongs to the run again", "look at it inside `with run.paused()`")
        return self._world

    def keys(self) -> list[str]:
        """Names of the layers."""
        return list(self._layers)

    def __iter__(self) -> Iterator[str]:
        return iter(self._layers)

    def __contains__(self, name: str) -> bool:
        return name in self._layers

    def __getitem__(self, name: str) -> np.ndarray:
        world = self._open()
        return self._changes[name] if name in self._changes else world.array(name)

    def __setitem__(self, name: str, values: Any) -> None:
        shape = self._open().array(name).shape
        # A copy, which the run takes over.
        self._changes[name] = np.array(np.broadcast_to(np.asarray(values, np.float32), shape))

    @property
    def step(self) -> int:
        """Steps of simulation done."""
        return self._open().facts()["step"]

    @property
    def cell(self) -> tuple[float, float]:
        """Size of a cell, west-east and north-south, m."""
        return self._open().facts()["cell"]

    def dataset(self) -> xr.Dataset:
        """The world as a data set, without a copy and without the changes."""
        return dataset(self._open(), {})

    def _close(self) -> list[tuple[str, np.ndarray]]:
        self._world = None
        return list(self._changes.items())


def run(
    recipe: str | os.PathLike | Mapping | Recipe,
    *,
    progress: bool = False,
    between: Callable[[Live], None] | None = None,
    every: int = 1,
    **arguments: Any,
) -> xr.Dataset:
    """Carries a recipe out and returns the landscape.

    ``between`` is a process of your own: it is called after each ``every`` steps of simulation with the world as in
    :meth:`Run.paused`, and may put other values into its layers. All other arguments are those of :class:`Run`.

    >>> import eyot
    >>> ds = eyot.run("island", size=64, seed=3, **{"hydraulic.rain": 0.004})
    >>> ds.height.dims, ds.height.units, ds.attrs["seed"]
    (('y', 'x'), 'm', 3)
    """
    with Run(recipe, **arguments) as work:
        if between is None:
            return work.finish(progress)
        if every < 1:
            raise EyotError(f"`every={every}` is no number of steps", "give 1 or more")
        done = last = 0
        # Generators count as steps of `advance`, not as steps of a simulation.
        while work.advance(every - (done - last)) == "working":
            with work.paused() as world:
                done = world.step
                if done - last >= every:
                    last = done
                    between(world)
        return work.dataset()


def generate(generator: str, *, size: int | tuple[int, int] = 256, cell: float = 20.0, seed: int = 0, **parameters: Any) -> xr.DataArray:
    """What one generator makes, as an array of heights.

    >>> import eyot
    >>> eyot.generate("fbm", size=32, seed=2).shape
    (32, 32)
    """
    grid = {"size": list(size) if isinstance(size, (tuple, list)) else size, "cell": cell}
    step = {"generate": generator, **parameters}
    return run({"name": generator, "seed": seed, "grid": grid, "steps": [step]})["height"]


def open(path: str | os.PathLike, *, max_memory: int | None = None) -> xr.Dataset:
    """The landscape in the folder of a run, a saved world (``world.eyot``) or a height map of any format that Eyot reads."""
    world, notes = _eyot.open(Path(path), max_memory)
    warn(notes)
    attrs: dict[str, Any] = {}
    report = Path(path) / "run.json"
    if report.is_file():
        about = json.loads(report.read_text())
        attrs = {"title": about.get("name", ""), "fingerprint": about["fingerprint"]} if "fingerprint" in about else {}
    return dataset(world, attrs)


def _show(work: Run) -> None:
    try:
        from tqdm.auto import tqdm
    except ImportError:
        tqdm = None
    bar = tqdm(total=100.0, unit="%", bar_format="{l_bar}{bar}| {elapsed}<{remaining}") if tqdm else None
    try:
        for event in work:
            if bar is None:
                continue
            if event["event"] == "step_begun":
                bar.set_description(event["name"])
            elif event["event"] == "progress":
                bar.update(100.0 * event["overall"] - bar.n)
        if bar is not None and work.status == "finished":
            bar.update(100.0 - bar.n)
    finally:
        if bar is not None:
            bar.close()


def _temporary(name: str) -> Path:
    return Path(tempfile.mkdtemp(prefix="eyot-")) / name


def picture(draw: Callable[[Path], Any]) -> bytes:
    """The bytes of a PNG picture that is drawn into a file."""
    path = _temporary("picture.png")
    try:
        draw(path)
        return path.read_bytes()
    finally:
        shutil.rmtree(path.parent, ignore_errors=True)
