"""Rivers, lakes, trees and tables of a small world."""

import pytest

import eyot


@pytest.fixture(scope="module")
def reef():
    return eyot.run("reef", size=64)


def test_components_are_listed_and_become_tables(reef):
    names = reef.eyot.components
    assert names
    for name in names:
        table = reef.eyot.table(name, "numpy")
        assert len({len(v) for v in table.values()}) <= 1
    with pytest.raises(eyot.EyotError, match="it keeps"):
        reef.eyot.table("unicorns")
