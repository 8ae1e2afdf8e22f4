//! Lengths of lines and distances of places.

/// Distance of two places in the plane, m.
pub fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    let (dx, dy) = (a[0] - b[0], a[1] - b[1]);
    (dx * dx + dy * dy).sqrt()
}

/// Length of a line in the plane, m.
pub fn length(line: &[[f64; 2]]) -> f64 {
    line.windows(2).map(|p| distance(p[0], p[1])).sum()
}

/// A vertex without its height.
pub fn plane(v: &[f32; 3]) -> [f64; 2] {
    [f64::from(v[0]), f64::from(v[1])]
}

/// Length of a line as seen from above, m.
pub fn length_m(line: &[[f32; 3]]) -> f64 {
    line.windows(2).map(|p| distance(plane(&p[0]), plane(&p[1]))).sum()
}

/// The line with vertices as evenly apart as they can be about `spacing`; ends stay.
pub fn resampled(line: &[[f64; 2]], spacing: f64) -> Vec<[f64; 2]> {
    let whole = length(line);
    let parts = (whole / spacing).round().max(1.0) as usize;
    let step = whole / parts as f64;
    let mut out = Vec::with_capacity(parts + 1);
    out.push(line[0]);
    let (mut k, mut passed) = (0, 0.0);
    for part in 1..parts {
        let at = part as f64 * step;
        while k + 2 < line.len() && passed + distance(line[k], line[k + 1]) < at {
            passed += distance(line[k], line[k + 1]);
            k += 1;
        }
        let size = distance(line[k], line[k + 1]).max(1e-12);
        let t = ((at - passed) / size).clamp(0.0, 1.0);
        out.push([0, 1].map(|c| line[k][c] + t * (line[k + 1][c] - line[k][c])));
    }
    out.push(line[line.len() - 1]);
    out
}

/// One pass of (1, 2, 1)/4 between the ends.
pub fn smooth(points: &mut [[f64; 2]]) {
    let Some(mut before) = points.first().copied() else { return };
    for k in 1..points.len().saturating_sub(1) {
        let (here, after) = (points[k], points[k + 1]);
        points[k] = [0, 1].map(|c| 0.25 * before[c] + 0.5 * here[c] + 0.25 * after[c]);
        before = here;
    }
}
