"""The stubs say what the module of Rust has."""

import ast
import inspect
from pathlib import Path

from eyot import _eyot


def arguments(function: ast.FunctionDef) -> list[str]:
    a = function.args
    names = [x.arg for x in [*a.posonlyargs, *a.args, *a.kwonlyargs]]
    return [n for n in names if n not in ("self", "cls")]


def found(thing) -> list[str]:
    return [n for n in inspect.signature(thing).parameters if n not in ("self", "cls")]


def test_stubs_and_module_agree():
    text = (Path(_eyot.__file__).parent / "_eyot.pyi").read_text()
    stubs = {n.name: n for n in ast.parse(text).body if isinstance(n, (ast.ClassDef, ast.FunctionDef))}
    there = {n for n in dir(_eyot) if not n.startswith("_")} - {"VERSION"}
    assert set(stubs) == there
    for name, stub in stubs.items():
        thing = getattr(_eyot, name)
        if isinstance(stub, ast.FunctionDef):
            assert arguments(stub) == found(thing), name
            continue
        methods = {m.name: m for m in stub.body if isinstance(m, ast.FunctionDef)}
        own = {m for m in vars(thing) if not m.startswith("_")}
        assert set(methods) - {"__new__"} == own, name
        for method in own:
            assert arguments(methods[method]) == found(getattr(thing, method)), f"{name}.{method}"
        if "__new__" in methods:
            assert arguments(methods["__new__"]) == found(thing), name
