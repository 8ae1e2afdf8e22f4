//! Mean, standard deviation, skewness and quantiles of a sample, and the straight line through points.

/// First three moments of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// Number of values.
    pub count: usize,
    /// Arithmetic mean.
    pub mean: f64,
    /// Population standard deviation (divided by `count`).
    pub deviation: f64,
    /// Skewness g1 = m3 / m2^1.5 (Fisher & Pearson, without bias correction); `None` if all values are equal.
    pub skewness: Option<f64>,
}

/// Moments of `values`, folded in their order in f64; `None` for an empty sample.
pub fn moments(values: &[f32]) -> Option<Moments> {
    if values.is_empty() {
        return None;
    }
    let n = values.len() as f64;
    let mean = values.iter().map(|&v| f64::from(v)).sum::<f64>() / n;
    let (mut m2, mut m3) = (0.0, 0.0);
    for &v in values {
        let d = f64::from(v) - mean;
        m2 += d * d;
        m3 += d * d * d;
    }
    (m2, m3) = (m2 / n, m3 / n);
    // Rounding of the mean leaves a trace of variance in a constant sample.
    let varies = values.iter().any(|&v| v != values[0]);
    Some(Moments {
        count: values.len(),
        mean,
        deviation: m2.sqrt(),
        skewness: finite(m3 / m2.powf(1.5)).filter(|_| varies),
    })
}

/// The quantile `q` in 0..=1 of `values`, linear between order statistics; reorders them. `None` for an empty sample.
pub fn quantile(values: &mut [f32], q: f64) -> Option<f64> {
    let last = values.len().checked_sub(1)?;
    let at = q.clamp(0.0, 1.0) * last as f64;
    let lower = at.floor() as usize;
    let (_, &mut a, above) = values.select_nth_unstable_by(lower, f32::total_cmp);
    let b = above.iter().copied().min_by(f32::total_cmp).unwrap_or(a);
    Some(f64::from(a) + (f64::from(b) - f64::from(a)) * (at - lower as f64))
}

/// Slope of the least-squares line through `points` (x, y); `None` with fewer than two different x.
pub fn line_slope(points: &[(f64, f64)]) -> Option<f64> {
    let n = points.len() as f64;
    let (mx, my) = points.iter().fold((0.0, 0.0), |(a, b), p| (a + p.0 / n, b + p.1 / n));
    let sxx: f64 = points.iter().map(|p| (p.0 - mx).powi(2)).sum();
    let sxy: f64 = points.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum();
    let spread = points.iter().any(|p| p.0 != points[0].0);
    finite(sxy / sxx).filter(|_| spread)
}

/// `v` unless it is NaN or infinite.
pub(super) fn finite(v: f64) -> Option<f64> {
    v.is_finite().then_some(v)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_of_known_samples() {
        let m = moments(&[1.0, 1.0, 1.0, 5.0]).unwrap();
        assert_eq!((m.count, m.mean), (4, 2.0));
        assert!((m.deviation - 3.0_f64.sqrt()).abs() < 1e-12);
        // m3 = (3 (-1)^3 + 3^3) / 4 = 6, m2 = 3.
        assert!((m.skewness.unwrap() - 6.0 / 3.0_f64.powf(1.5)).abs() < 1e-12);
        assert_eq!(moments(&[]), None);
        assert_eq!(moments(&[0.1; 9]).unwrap().skewness, None);
    }

    #[test]
    fn quantiles_interpolate() {
        let mut v = [4.0, 1.0, 3.0, 2.0];
        assert_eq!(quantile(&mut v, 0.5), Some(2.5));
        assert_eq!(quantile(&mut v, 1.0), Some(4.0));
        assert_eq!(quantile(&mut v, 0.0), Some(1.0));
        assert_eq!(quantile(&mut [], 0.5), None);
    }

    #[test]
    fn a_line_needs_two_places() {
        assert!((line_slope(&[(1.0, 5.0), (2.0, 3.0), (4.0, -1.0)]).unwrap() + 2.0).abs() < 1e-12);
        assert_eq!(line_slope(&[(1.0, 5.0), (1.0, 3.0)]), None);
        assert_eq!(line_slope(&[]), None);
    }
}
