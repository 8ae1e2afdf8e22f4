"""Rivers, lakes, trees and tables of a small world."""

import pytest

import eyot


@pytest.fixture(scope="module")
def reef():
    return eyot.run("reef", size=32, **{"step.2.steps": 60})


def test_components_are_listed_and_become_tables(reef):
    names = reef.eyot.components
    assert names
    for name in names:
        table = reef.eyot.table(name, "numpy")
        assert len({len(v) for v in table.values()}) <= 1
    with pytest.raises(eyot.EyotError, match="it keeps"):
        reef.eyot.table("unicorns")


@pytest.fixture(scope="module")
def valley():
    return eyot.run("valley", size=128)


def test_rivers_and_lakes_are_frames(valley):
    pytest.importorskip("geopandas")
    rivers, lakes = valley.eyot.frame("rivers"), valley.eyot.frame("lakes")
    assert len(rivers) and set(rivers.geometry.geom_type) <= {"LineString", "MultiLineString"}
    assert len(lakes) and lakes.is_valid.all() and set(lakes.geometry.geom_type) <= {"Polygon", "MultiPolygon"}
    # Shores run between cells, so that areas of small lakes differ from those of their cells.
    largest = lakes.loc[lakes.area.idxmax()]
    assert largest.geometry.area / 1e6 == pytest.approx(largest["AREA_SKM"], rel=0.1)
    # Lakes lie where the layer of their level has them: north is up in both.
    place = largest.geometry.representative_point()
    level = valley.lake_level.sel(x=place.x, y=place.y, method="nearest")
    assert float(level) == pytest.approx(largest["LEVEL_M"], abs=0.01)


def test_frames_of_a_georeferenced_world_have_its_reference_system():
    pytest.importorskip("geopandas")
    recipe = {
        "grid": {"from": "builtin:jacksboro.tif", "rim": "open"},
        "steps": [{"generate": "import", "file": "builtin:jacksboro.tif"}, {"simulate": ["rivers"], "steps": 1}],
    }
    ds = eyot.run(recipe, size=96, sea_level="none")
    rivers = ds.eyot.frame("rivers")
    assert rivers.crs is not None and rivers.crs.is_geographic
    west, south, east, north = rivers.total_bounds
    assert float(ds.x[0]) - 0.01 < west < east < float(ds.x[-1]) + 0.01
    assert float(ds.y[-1]) - 0.01 < south < north < float(ds.y[0]) + 0.01


def test_tables_are_arrows_and_tell_their_units(reef):
    pytest.importorskip("pyarrow")
    colonies = reef.eyot.table("corals.colonies", "arrow")
    census = reef.eyot.table("corals.census")
    assert colonies.num_rows > 0 and len(census) > 0
    assert all(b"unit" in (field.metadata or {}) for field in colonies.schema)
    assert set(census.attrs["units"]) == set(census.columns)


def test_files_and_meshes_lie_in_memory():
    pytest.importorskip("trimesh")
    recipe = {
        "grid": {"size": 32, "cell": 20.0},
        "steps": [{"generate": "cone", "height": 300.0}],
        "exports": [{"format": "glb"}, {"format": "geotiff", "layers": ["height"]}],
    }
    with eyot.Run(recipe, files=True) as run:
        run.finish()
    assert {"height.tif", "terrain.glb", "run.json", "world.eyot"} <= set(run.files)
    scene = run.mesh()
    assert scene.extents.max() == pytest.approx(32 * 20.0, rel=0.1)
    with pytest.raises(eyot.EyotError, match="no file"):
        run.mesh("corals.glb")
    with pytest.raises(eyot.EyotError, match="files=True"):
        eyot.Run(recipe).mesh()
