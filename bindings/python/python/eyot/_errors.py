"""What goes wrong."""

from __future__ import annotations

from dataclasses import dataclass


class EyotError(RuntimeError):
    """An error with its remedy.

    ``message`` says what is wrong, ``help`` what to do about it (``None`` if the message says all).
    """

    def __init__(self, message: str, help: str | None = None) -> None:
        super().__init__(message, help)
        self.message = message
        self.help = help

    def __str__(self) -> str:
        return self.message if self.help is None else f"{self.message}\n  help: {self.help}"


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong with a recipe.

    ``source`` names the text (``set`` for keyword arguments), ``line`` and ``column`` count from 1; they are ``None`` for what has no place.
    """

    message: str
    help: str | None
    source: str | None
    line: int | None
    column: int | None
    label: str = ""


class RecipeError(EyotError, ValueError):
    """A recipe that cannot be run: ``problems`` lists what is wrong, where, and what would be right."""

    def __init__(self, message: str, help: str | None = None, problems: list[dict] | tuple = ()) -> None:
        super().__init__(message, help)
        self.problems = tuple(Problem(**p) if isinstance(p, dict) else p for p in problems)

    def __reduce__(self):
        return type(self), (self.message, self.help, self.problems)


class MissingPackage(ImportError):
    """A package that only this function needs is not installed."""


def need(package: str, what: str):
    """Imports an optional package, or says how to install it."""
    import importlib

    try:
        return importlib.import_module(package)
    except ImportError as e:
        name = package.split(".")[0]
        raise MissingPackage(f"{what} needs the package {name}: pip install {name}") from e
