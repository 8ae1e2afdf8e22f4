"""Recipes that are dictionaries, as TOML; the standard library only reads it."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from numbers import Integral, Real
from typing import Any

_TABLES = ("grid", "view")
_LISTS = ("layer", "rule", "step", "export")
_BARE = re.compile(r"[A-Za-z0-9_-]+")


def value(v: Any) -> str:
    """A value as TOML has it within a line."""
    if isinstance(v, bool):
        return "true" if v else "false"
    if isinstance(v, Integral):
        return str(int(v))
    if isinstance(v, Real):
        v = float(v)
        return {float("inf"): "inf", float("-inf"): "-inf"}.get(v, "nan" if v != v else repr(v))
    if isinstance(v, str):
        # TOML escapes what JSON escapes; DEL alone is not allowed as it is.
        return json.dumps(v, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(v, Mapping):
        return "{ " + ", ".join(f"{key(k)} = {value(x)}" for k, x in v.items()) + " }"
    if hasattr(v, "tolist"):
        return value(v.tolist())
    if isinstance(v, (list, tuple)):
        return "[" + ", ".join(value(x) for x in v) + "]"
    if hasattr(v, "__fspath__"):
        return value(v.__fspath__())
    raise TypeError(f"a recipe takes numbers, texts, lists and tables, not {type(v).__name__}: {v!r}")


def key(k: Any) -> str:
    """A key, in quotes if it needs some."""
    k = str(k)
    return k if _BARE.fullmatch(k) else value(k)


def _lines(table: Mapping, prefix: str = "") -> Iterator[str]:
    for k, v in table.items():
        # Keys such as `hydraulic.rain` may be written as in TOML.
        name = prefix + ".".join(key(part) for part in str(k).split("."))
        if isinstance(v, Mapping) and v:
            yield from _lines(v, name + ".")
        elif v is not None:
            yield f"{name} = {value(v)}"


def document(recipe: Mapping) -> str:
    """A recipe's document. What has another shape than in a recipe is written as it is, for the check to say so."""
    known = {**{t: t for t in _TABLES}, **{t: t for t in _LISTS}, **{f"{t}s": t for t in _LISTS}}
    head: dict[str, Any] = {}
    blocks: list[str] = []
    for k, v in recipe.items():
        name = known.get(k)
        if name in _TABLES and isinstance(v, Mapping):
            blocks.append("\n".join([f"[{name}]", *_lines(v)]))
        elif name in _LISTS and isinstance(v, (list, tuple)) and all(isinstance(table, Mapping) for table in v):
            blocks += ["\n".join([f"[[{name}]]", *_lines(table)]) for table in v]
        else:
            head[name or k] = v
    return "\n\n".join(b for b in ["\n".join(_lines(head)), *blocks] if b) + "\n"


def changes(parameters: Mapping, prefix: str = "") -> list[str]:
    """Keyword arguments as changes of a recipe, `key=value`; `None` leaves a key as it is."""
    out = []
    for k, v in parameters.items():
        if isinstance(v, Mapping):
            out += changes(v, f"{prefix}{k}.")
        elif v is not None:
            out.append(f"{prefix}{k}={value(v)}")
    return out
