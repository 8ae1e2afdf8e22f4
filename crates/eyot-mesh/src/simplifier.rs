//! The simplifier at hand: meshoptimizer, or none in a build without the feature `simplify`.

#[cfg(feature = "simplify")]
mod how {
    use meshopt::{SimplifyOptions, VertexDataAdapter, utilities::typed_to_bytes};

    type Simplified = (Vec<u32>, f32);

    fn simplify(
        indices: &[u32],
        positions: &[[f32; 3]],
        locked: &[bool],
        (target, most): (usize, f32),
        options: SimplifyOptions,
    ) -> Option<Simplified> {
        let vertices = VertexDataAdapter::new(typed_to_bytes(positions), size_of::<[f32; 3]>(), 0).ok()?;
        let mut error = 0.0;
        let out = meshopt::simplify_with_locks(indices, &vertices, locked, target, most, options, Some(&mut error));
        Some((out, error))
    }

    pub(crate) fn simplify_open(
        indices: &[u32],
        positions: &[[f32; 3]],
        locked: &[bool],
        target: usize,
        lock_rim: bool,
    ) -> Option<Vec<u32>> {
        let options = if lock_rim { SimplifyOptions::LockBorder } else { SimplifyOptions::empty() };
        Some(simplify(indices, positions, locked, (target, f32::MAX), options)?.0)
    }

    pub(crate) fn simplify_within(
        indices: &[u32],
        positions: &[[f32; 3]],
        locked: &[bool],
        most: f32,
    ) -> Option<Vec<u32>> {
        Some(simplify(indices, positions, locked, (0, most), SimplifyOptions::ErrorAbsolute)?.0)
    }

    pub(crate) fn simplify_closed(
        indices: &[u32],
        positions: &[[f32; 3]],
        locked: &[bool],
        target: usize,
    ) -> Option<Simplified> {
        simplify(indices, positions, locked, (target, f32::MAX), SimplifyOptions::ErrorAbsolute)
    }

    pub(crate) fn order_for_cache(indices: &[u32], vertices: usize) -> Vec<u32> {
        meshopt::optimize_vertex_cache(indices, vertices)
    }
}

#[cfg(not(feature = "simplify"))]
mod how {
    pub(crate) fn simplify_open(_: &[u32], _: &[[f32; 3]], _: &[bool], _: usize, _: bool) -> Option<Vec<u32>> {
        None
    }

    pub(crate) fn simplify_within(_: &[u32], _: &[[f32; 3]], _: &[bool], _: f32) -> Option<Vec<u32>> {
        None
    }

    pub(crate) fn simplify_closed(_: &[u32], _: &[[f32; 3]], _: &[bool], _: usize) -> Option<(Vec<u32>, f32)> {
        None
    }

    pub(crate) fn order_for_cache(indices: &[u32], _: usize) -> Vec<u32> {
        indices.to_vec()
    }
}

/// The triangles in an order that suits caches of vertices on graphics cards.
pub(crate) use how::order_for_cache;
/// About `target` indices of a closed surface, and the estimated distance from the full one in the positions' units.
pub(crate) use how::simplify_closed;
/// About `target` indices of a surface whose rim stays where it is, or on its lines.
pub(crate) use how::simplify_open;
/// As few indices as a distance of `most` from the surface allows, in the positions' units.
pub(crate) use how::simplify_within;
