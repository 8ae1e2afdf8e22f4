"""The examples of the documents run as they stand, in the order of their page."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
PAGES = ["bindings/python/README.md", "docs/book/src/tutorial/python.md"]


@pytest.mark.parametrize("page", PAGES)
def test_examples_run(page, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = (ROOT / page).read_text()
    blocks = list(re.finditer(r"^```python\n(.*?)^```", text, re.M | re.S))
    assert blocks
    names: dict = {}
    for block in blocks:
        line = text[: block.start(1)].count("\n")
        # Tracebacks then name the line of the page.
        exec(compile("\n" * line + block[1], page, "exec"), names)
