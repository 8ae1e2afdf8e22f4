//! Tiles of a terrain: rims that fit, skirts, and the surface of water.

use eyot_core::{Boundary, Control, Field, Grid, Limits};
use eyot_mesh::{
    Lod, MeshOptions, OpenWater, Rim, Terrain, TerrainMesh, Tiling, levels_of_detail_controlled, rim_error,
};
use std::collections::BTreeMap;

const SIZE: (usize, usize) = (131, 97);

fn grid() -> Grid {
    Grid::new(SIZE.0, SIZE.1, 10.0, Boundary::CLOSED, &Limits::default()).unwrap()
}

fn hills() -> Field {
    Field::from_fn(SIZE.0, SIZE.1, |x, y| {
        let (x, y) = (x as f32, y as f32);
        60.0 * (0.21 * x).sin() * (0.17 * y).cos() + 7.0 * (1.3 * x + 0.7 * y).sin() + 0.4 * y
    })
}

struct Tile {
    at: [usize; 2],
    full: Terrain,
    levels: Vec<Lod>,
}

fn tiles(tiling: &Tiling, rim: Rim) -> Vec<Tile> {
    let (height, grey) = (hills(), vec![[0.5; 3]; SIZE.0 * SIZE.1]);
    let make = |at| {
        let full = tiling.terrain(at, &height, &grey, &Limits::default()).unwrap();
        let levels = levels_of_detail_controlled(&full, &[0.25, 0.0625, 0.016], rim, &Control::none()).unwrap();
        Tile { at, full, levels }
    };
    tiling.all().map(make).collect()
}

fn cut(n: [usize; 2]) -> Tiling {
    Tiling::new(&grid(), n, &MeshOptions::default(), &Limits::default()).unwrap()
}

/// Vertices by their place seen from above, with height and normal, all as bits.
fn vertices(mesh: &TerrainMesh) -> BTreeMap<[u32; 2], [u32; 4]> {
    let bits =
        |(p, n): (&[f32; 3], &[f32; 3])| ([p[0].to_bits(), p[2].to_bits()], [p[1], n[0], n[1], n[2]].map(f32::to_bits));
    mesh.positions.iter().zip(&mesh.normals).map(bits).collect()
}

#[test]
fn tiles_share_their_rims_to_the_bit_and_leave_nothing_out() {
    let all = tiles(&cut([4, 3]), Rim::Straight);
    assert_eq!(all.len(), 12);
    let mut seen: BTreeMap<[u32; 2], [u32; 4]> = BTreeMap::new();
    let mut shared = 0;
    for tile in &all {
        for (place, values) in vertices(&tile.full.mesh) {
            if let Some(other) = seen.insert(place, values) {
                assert_eq!(other, values);
                shared += 1;
            }
        }
    }
    assert_eq!(seen.len(), SIZE.0 * SIZE.1);
    // Three rims from north to south and two from west to east, and where they cross, the third of four tiles.
    assert_eq!(shared, 3 * SIZE.1 + 2 * SIZE.0 + 3 * 2);
    // Together they are the mesh in one piece.
    assert_eq!(seen, vertices(&tiles(&cut([1, 1]), Rim::Fixed)[0].full.mesh));
    let triangles: usize = all.iter().map(|t| t.full.mesh.triangles()).sum();
    assert_eq!(triangles, 2 * (SIZE.0 - 1) * (SIZE.1 - 1));
}

/// Heights of a level along one side, from north to south or from west to east.
fn side(mesh: &TerrainMesh, axis: usize, at: f32) -> Vec<[f32; 2]> {
    let on = mesh.positions.iter().filter(|p| p[axis] == at);
    let mut line: Vec<[f32; 2]> = on.map(|p| [p[2 - axis], p[1]]).collect();
    line.sort_by(|a, b| a[0].total_cmp(&b[0]));
    line
}

fn height_at(line: &[[f32; 2]], x: f32) -> f32 {
    let i = line.partition_point(|p| p[0] < x).clamp(1, line.len() - 1);
    let ([x0, z0], [x1, z1]) = (line[i - 1], line[i]);
    z0 + (z1 - z0) * (x - x0) / (x1 - x0)
}

#[test]
fn skirts_reach_down_to_every_level_of_the_neighbour() {
    let tiling = cut([3, 2]);
    let all = tiles(&tiling, Rim::Straight);
    let errors: Vec<f32> = all.iter().flat_map(|t| t.levels.iter().map(|l| rim_error(&t.full, l))).collect();
    let depth = 2.0 * errors.iter().copied().fold(0.0, f32::max);
    assert!(depth > 0.5, "no level of detail changed a rim: {depth}");
    for west in all.iter().filter(|t| t.at[0] < 2) {
        let east = all.iter().find(|t| t.at == [west.at[0] + 1, west.at[1]]).unwrap();
        let rim = east.full.mesh.positions[0][0];
        for (a, b) in west.levels.iter().flat_map(|a| east.levels.iter().map(move |b| (a, b))) {
            let (up, down) = (side(&a.mesh, 0, rim), side(&b.mesh, 0, rim));
            assert!(up.len() >= 2 && down.len() >= 2);
            let wall = side(&tiling.skirt(west.at, &west.full, &a.mesh, depth), 0, rim);
            for &[z, height] in up.iter().chain(&down) {
                // The wall goes from this level's rim down to below the other's, wherever that is lower.
                let (here, there) = (height_at(&up, z), height_at(&down, z));
                let lowest = wall.iter().filter(|p| (p[0] - z).abs() < 1e-3).map(|p| p[1]).fold(f32::MAX, f32::min);
                assert!(lowest == f32::MAX || lowest <= there + 1e-3, "{lowest} over {there} at {z}, {height}");
                assert!(here - there <= depth);
            }
        }
    }
}

#[test]
fn skirts_hang_from_inner_rims_alone_and_face_outward() {
    let tiling = cut([2, 1]);
    let all = tiles(&tiling, Rim::Straight);
    let rim = all[1].full.mesh.positions[0][0];
    for (tile, outward) in all.iter().zip([1.0, -1.0]) {
        for level in &tile.levels {
            let skirt = tiling.skirt(tile.at, &tile.full, &level.mesh, 5.0);
            assert!(!skirt.indices.is_empty() && skirt.positions.iter().all(|p| p[0] == rim));
            for t in skirt.indices.chunks_exact(3) {
                let [a, b, c] = [t[0], t[1], t[2]].map(|i| skirt.positions[i as usize]);
                // The eastward part of the cross product of two sides.
                let east = (b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1]);
                assert!(east * outward > 0.0, "{:?} {t:?}", tile.at);
            }
        }
    }
    let alone = cut([1, 1]);
    let tile = &tiles(&alone, Rim::Fixed)[0];
    assert!(alone.skirt([0, 0], &tile.full, &tile.levels[0].mesh, 5.0).indices.is_empty());
}

#[test]
fn straight_rims_let_small_tiles_get_coarse() {
    let tiling = cut([8, 6]);
    let coarsest =
        |rim| -> usize { tiles(&tiling, rim).iter().map(|t| t.levels.last().map_or(0, |l| l.mesh.triangles())).sum() };
    let (fixed, straight) = (coarsest(Rim::Fixed), coarsest(Rim::Straight));
    assert!(straight * 2 < fixed, "{straight} {fixed}");
    // And each level still covers its tile once.
    for tile in tiles(&tiling, Rim::Straight) {
        let area = |m: &TerrainMesh| -> f64 {
            m.indices
                .chunks_exact(3)
                .map(|t| {
                    let [a, b, c] = [t[0], t[1], t[2]].map(|i| m.positions[i as usize].map(f64::from));
                    let twice = (b[2] - a[2]) * (c[0] - a[0]) - (b[0] - a[0]) * (c[2] - a[2]);
                    assert!(twice > 0.0);
                    0.5 * twice
                })
                .sum()
        };
        let whole = area(&tile.full.mesh);
        assert!(tile.levels.iter().all(|l| (area(&l.mesh) / whole - 1.0).abs() < 1e-6));
    }
}

#[test]
fn texture_coordinates_put_pixels_on_vertices() {
    let mesh = &tiles(&cut([1, 1]), Rim::Fixed)[0].full.mesh;
    for (axis, cells) in [(0, SIZE.0), (1, SIZE.1)] {
        let all = || mesh.texture.iter().map(|t| f64::from(t[axis]) / 65535.0);
        let (low, high) = (all().fold(1.0, f64::min), all().fold(0.0, f64::max));
        let half = 0.5 / cells as f64;
        assert!((low - half).abs() < 1e-5 && (high - (1.0 - half)).abs() < 1e-5, "{low} {high}");
    }
    for (p, t) in mesh.positions.iter().zip(&mesh.texture) {
        let column = f64::from(t[0]) / 65535.0 * SIZE.0 as f64 - 0.5;
        assert!((column - (f64::from(p[0]) / 10.0 + 0.5 * SIZE.0 as f64 - 0.5)).abs() < 2e-3);
    }
}

#[test]
fn bounds_hold_for_each_tile_and_too_many_tiles_are_refused() {
    let limits = Limits::default();
    let options = MeshOptions { max_vertices: 1000 };
    let whole = Tiling::new(&grid(), [1, 1], &options, &limits).unwrap();
    let tiled = Tiling::new(&grid(), [4, 4], &options, &limits).unwrap();
    assert!(whole.stride() > 1);
    assert_eq!(tiled.stride(), 1);
    let grey = vec![[0.5; 3]; SIZE.0 * SIZE.1];
    for at in tiled.all() {
        let t = tiled.terrain(at, &hills(), &grey, &limits).unwrap();
        assert!(t.mesh.positions.len() <= 1000);
    }
    assert!(Tiling::new(&grid(), [131, 1], &MeshOptions::default(), &limits).is_err());
    assert!(Tiling::new(&grid(), [0, 1], &MeshOptions::default(), &limits).is_err());
}

/// A sea at 0 in the west, a lake that stands at 31 m, and a river that falls to the east.
fn waters(height: &Field) -> OpenWater {
    let mut water = OpenWater { level: vec![f32::NAN; SIZE.0 * SIZE.1], standing: vec![false; SIZE.0 * SIZE.1] };
    for y in 0..SIZE.1 {
        for x in 0..SIZE.0 {
            let i = y * SIZE.0 + x;
            if height.get(x, y) < 0.0 {
                (water.level[i], water.standing[i]) = (0.0, true);
            } else if (60..75).contains(&x) && (40..60).contains(&y) {
                (water.level[i], water.standing[i]) = (31.0, true);
            } else if y == 80 && x > 70 {
                water.level[i] = 50.0 - 0.3 * x as f32;
            }
        }
    }
    water
}

#[test]
fn standing_water_is_level_and_running_water_is_not() {
    // A beach, and a bowl that lies 5 m under its rim.
    let height = Field::from_fn(SIZE.0, SIZE.1, |x, y| match (x, y) {
        (60..75, 40..60) => 26.0,
        (_, 80) if x > 70 => 48.0 - 0.3 * x as f32,
        _ => 2.0 * x as f32 - 61.0,
    });
    let water = waters(&height);
    for tiling in [cut([1, 1]), cut([3, 2])] {
        let mut found = [0, 0, 0];
        for at in tiling.all() {
            let Some(mesh) = tiling.water(at, &water, &height) else { continue };
            assert_eq!((mesh.normals.len(), mesh.texture.len()), (mesh.positions.len(), mesh.positions.len()));
            for p in &mesh.positions {
                // Cells are 10 m wide, and their middles are vertices.
                let (x, y) = (p[0] / 10.0 + 65.0, p[2] / 10.0 + 48.0);
                match (x, y) {
                    _ if x < 31.5 => {
                        assert_eq!(p[1], 0.0);
                        found[0] += 1;
                    }
                    _ if (59.0..76.0).contains(&x) && (39.0..61.0).contains(&y) => {
                        assert_eq!(p[1], 31.0, "{x} {y}");
                        found[1] += 1;
                    }
                    _ => found[2] += usize::from(p[1].fract() != 0.0),
                }
            }
            for t in mesh.indices.chunks_exact(3) {
                let [a, b, c] = [t[0], t[1], t[2]].map(|i| mesh.positions[i as usize]);
                assert!((b[2] - a[2]) * (c[0] - a[0]) - (b[0] - a[0]) * (c[2] - a[2]) > 0.0);
            }
        }
        assert!(found.iter().all(|&n| n > 3), "{found:?}");
    }
    // A sea of 3000 cells needs few triangles beyond its rim.
    let mesh = cut([1, 1]).water([0, 0], &water, &height).unwrap();
    assert!(mesh.triangles() < 1500, "{}", mesh.triangles());
    assert!(cut([1, 1]).water([0, 0], &OpenWater::default(), &height).is_none());
}
