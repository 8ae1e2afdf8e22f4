//! Is a mesh the surface of a body? How good are its triangles?

use super::solid_mesh::Solid;
use super::vector::{cross, dot, sub};
use crate::primitive::Point;

/// How the triangles of a mesh hang together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Topology {
    /// Vertices that triangles use.
    pub vertices: usize,
    /// Edges.
    pub edges: usize,
    /// Triangles.
    pub triangles: usize,
    /// Edges with a single triangle: rims of holes.
    pub open_edges: usize,
    /// Edges with more than two triangles, and such whose two triangles look to opposite sides.
    pub bad_edges: usize,
    /// Vertices whose triangles make more than one fan.
    pub pinched_vertices: usize,
    /// Connected pieces.
    pub pieces: usize,
}

impl Topology {
    /// True if every edge has two triangles that look to the same side, and the triangles around every vertex make one fan.
    pub const fn is_closed_manifold(&self) -> bool {
        self.open_edges == 0 && self.bad_edges == 0 && self.pinched_vertices == 0
    }

    /// Vertices minus edges plus triangles: 2 for a ball, 2 less for each handle, summed over pieces.
    pub const fn euler(&self) -> i64 {
        self.vertices as i64 - self.edges as i64 + self.triangles as i64
    }
}

/// How even the triangles of a mesh are.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Quality {
    /// Share of triangles with an angle below 10 degrees.
    pub slivers: f64,
    /// Mean of `4 sqrt 3 area / (sum of squared sides)`: 1 if all are equilateral.
    pub mean: f64,
    /// Share of triangles for which that is above 0.8.
    pub good: f64,
}

impl Solid {
    /// How the triangles hang together.
    pub fn topology(&self) -> Topology {
        // Directed edges, sorted by their lower end and then by their higher one, with the direction last.
        let mut edges: Vec<u64> = Vec::with_capacity(self.indices.len());
        for t in self.indices.chunks_exact(3) {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                edges.push(u64::from(a.min(b)) << 33 | u64::from(a.max(b)) << 1 | u64::from(a > b));
            }
        }
        edges.sort_unstable();
        let mut found = Topology { triangles: self.triangles(), ..Topology::default() };
        for edge in edges.chunk_by(|a, b| a >> 1 == b >> 1) {
            found.edges += 1;
            match edge {
                [_] => found.open_edges += 1,
                [a, b] if a != b && a >> 33 != a >> 1 & 0xffff_ffff => {}
                _ => found.bad_edges += 1,
            }
        }
        let pieces = self.pieces();
        let mut uses = vec![0u32; self.positions.len()];
        self.indices.iter().for_each(|&i| uses[i as usize] += 1);
        found.vertices = uses.iter().filter(|&&n| n > 0).count();
        found.pieces = (0..pieces.len()).filter(|&i| pieces[i] as usize == i && uses[i] > 0).count();
        found.pinched_vertices = self.pinched(&uses).len();
        found
    }

    /// Vertices whose triangles make more than one fan.
    pub(crate) fn pinched(&self, uses: &[u32]) -> Vec<u32> {
        let mut starts = vec![0u32; uses.len() + 1];
        for (i, n) in uses.iter().enumerate() {
            starts[i + 1] = starts[i] + n;
        }
        // For each corner of a vertex, the other two of its triangle, in order.
        let mut around = vec![[0u32; 2]; self.indices.len()];
        let mut next = starts.clone();
        for t in self.indices.chunks_exact(3) {
            for (a, b, c) in [(t[0], t[1], t[2]), (t[1], t[2], t[0]), (t[2], t[0], t[1])] {
                around[next[a as usize] as usize] = [b, c];
                next[a as usize] += 1;
            }
        }
        let is_pinched = |v: usize| {
            let fan = &around[starts[v] as usize..starts[v + 1] as usize];
            let Some(&[first, mut at]) = fan.first() else { return false };
            let mut seen = 1;
            while at != first {
                let Some(triangle) = fan.iter().find(|t| t[0] == at) else { break };
                at = triangle[1];
                seen += 1;
                if seen > fan.len() {
                    break;
                }
            }
            seen != fan.len()
        };
        (0..uses.len()).filter(|&v| is_pinched(v)).map(|v| v as u32).collect()
    }

    /// How even the triangles are. All zeros without triangles.
    pub fn quality(&self) -> Quality {
        let n = self.triangles() as f64;
        if n == 0.0 {
            return Quality::default();
        }
        let mut quality = Quality::default();
        for corners in self.corners() {
            let (evenness, angle) = shape(corners);
            quality.mean += evenness / n;
            quality.good += f64::from(u8::from(evenness > 0.8)) / n;
            quality.slivers += f64::from(u8::from(angle < 10.0)) / n;
        }
        quality
    }
}

/// Evenness and smallest angle, in degrees.
fn shape([a, b, c]: [Point; 3]) -> (f64, f64) {
    let sides = [sub(c, b), sub(a, c), sub(b, a)];
    let squares = sides.map(|s| f64::from(dot(s, s)));
    let normal = cross(sides[0], sides[1]);
    let twice_area = f64::from(dot(normal, normal)).sqrt();
    let sum: f64 = squares.iter().sum();
    if sum == 0.0 {
        return (0.0, 0.0);
    }
    // The smallest angle is opposite the shortest side: tan = 2 area / (product of the other two along each other).
    let shortest = (0..3).min_by(|&i, &j| squares[i].total_cmp(&squares[j])).unwrap_or(0);
    let [u, v] = [sides[(shortest + 1) % 3], sides[(shortest + 2) % 3]];
    let angle = twice_area.atan2(-f64::from(dot(u, v))).to_degrees();
    (2.0 * 3f64.sqrt() * twice_area / sum, angle)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solid(n: u32, indices: Vec<u32>) -> Solid {
        let positions = (0..n).map(|i| [i as f32, (i * i % 7) as f32, (i * i * i % 5) as f32]).collect();
        Solid { positions, normals: vec![[0.0, 0.0, 1.0]; n as usize], indices }
    }

    const TETRAHEDRON: [u32; 12] = [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3];

    #[test]
    fn a_tetrahedron_is_a_ball() {
        let t = solid(4, TETRAHEDRON.to_vec()).topology();
        assert!(t.is_closed_manifold());
        assert_eq!((t.vertices, t.edges, t.triangles, t.pieces, t.euler()), (4, 6, 4, 1, 2));
        let t = solid(8, TETRAHEDRON.iter().copied().chain(TETRAHEDRON.map(|i| i + 4)).collect()).topology();
        assert_eq!((t.pieces, t.euler()), (2, 4));
    }

    #[test]
    fn holes_turned_triangles_and_pinches_are_found() {
        let open = solid(4, TETRAHEDRON[..9].to_vec()).topology();
        assert_eq!((open.open_edges, open.is_closed_manifold()), (3, false));
        let mut turned = TETRAHEDRON.to_vec();
        turned.swap(0, 1);
        assert_eq!(solid(4, turned).topology().bad_edges, 3);
        // Two tetrahedra that share a vertex, and two that share an edge.
        let joined = |map: [u32; 4]| TETRAHEDRON.iter().copied().chain(TETRAHEDRON.map(|i| map[i as usize])).collect();
        let pinched = solid(7, joined([0, 4, 5, 6])).topology();
        assert_eq!((pinched.pinched_vertices, pinched.open_edges, pinched.bad_edges), (1, 0, 0));
        assert!(solid(6, joined([0, 1, 4, 5])).topology().bad_edges > 0);
    }

    #[test]
    fn the_best_triangle_is_equilateral() {
        let (evenness, angle) = shape([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.75f32.sqrt(), 0.0]]);
        assert!((evenness - 1.0).abs() < 1e-6 && (angle - 60.0).abs() < 1e-4);
        let (evenness, angle) = shape([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.01, 0.0]]);
        assert!(evenness < 0.03 && (angle - 1.1458).abs() < 1e-3, "{angle}");
        assert_eq!(shape([[1.0; 3]; 3]), (0.0, 0.0));
    }
}
