//! Kernels of implicit surfaces: how the influence of a point falls with distance.
//!
//! All are functions of `x = r / R`, the distance over the radius of influence: 1 at 0, and 0 with zero slope from 1 on.
//!
//! # Equations
//! 1. Blinn 1982: `exp(-b x^2)`, less its tangent in `x^2` at 1, over what that leaves at 0. The original never ends.
//! 2. Wyvill, McPheeters and Wyvill 1986: `1 - 22/9 x^2 + 17/9 x^4 - 4/9 x^6`.
//! 3. Nishimura and others 1985: `1 - 3 x^2` up to 1/3, then `3/2 (1 - x)^2`.
//! 4. Muraki 1991: `(1 - x^2)^2`.

use eyot_core::real::Real;

/// Bits of `b` of equation 1: large ones make hard little balls.
const BLOBBINESS: f32 = 4.0;

/// A kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Kernel {
    /// A bell curve, cut off smoothly.
    Blinn,
    /// A polynomial of the sixth degree that is 1/2 at 1/2.
    Wyvill,
    /// Two parabolas.
    Nishimura,
    /// The cheapest one, and the default.
    #[default]
    Muraki,
}

impl Kernel {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Blinn, Self::Wyvill, Self::Nishimura, Self::Muraki];

    /// Value where `v = 1 - x^2`, `v` within 0..=1. Exactly 0 at `v = 0`.
    #[inline(always)]
    pub(crate) fn at<R: Real>(self, v: R) -> R {
        let n = R::of;
        match self {
            // e^(-b x^2) - e^-b (1 + b v) = e^-b (e^(b v) - 1 - b v)
            Self::Blinn => (rest(v) / rest(n(1.0))).positive(),
            // The polynomial divided by v^2, which makes its end exact.
            Self::Wyvill => v * v * (n(5.0 / 9.0) + n(4.0 / 9.0) * v),
            Self::Nishimura => {
                let x = (n(1.0) - v).sqrt();
                let near = n(1.0) - n(3.0) * (n(1.0) - v);
                let far = n(1.5) * (n(1.0) - x) * (n(1.0) - x);
                n(1.0 / 3.0).lt(x).pick(far, near)
            }
            Self::Muraki => v * v,
        }
    }

    /// Derivative by `v`; 0 at `v = 0`.
    #[inline(always)]
    pub(crate) fn derivative<R: Real>(self, v: R) -> R {
        let n = R::of;
        match self {
            Self::Blinn => n(BLOBBINESS) * ((n(BLOBBINESS) * v).exp() - n(1.0)) / rest(n(1.0)),
            Self::Wyvill => v * (n(10.0 / 9.0) + n(4.0 / 3.0) * v),
            Self::Nishimura => {
                let x = (n(1.0) - v).sqrt();
                n(1.0 / 3.0).lt(x).pick(n(1.5) * (n(1.0) - x) / x, n(3.0))
            }
            Self::Muraki => n(2.0) * v,
        }
    }

    /// Value at `x = r / R`.
    pub fn value(self, x: f32) -> f32 {
        self.at((1.0 - x * x).clamp(0.0, 1.0))
    }

    /// Where the kernel has a value within 0..1: `x`, to the precision of the numbers.
    pub fn radius_of(self, value: f32) -> f32 {
        // All kernels fall all the way.
        let (mut low, mut high) = (0.0f32, 1.0f32);
        for _ in 0..30 {
            let middle = 0.5 * (low + high);
            if self.value(middle) > value { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }
}

/// `e^(b v) - 1 - b v`.
#[inline(always)]
fn rest<R: Real>(v: R) -> R {
    let bv = R::of(BLOBBINESS) * v;
    bv.exp() - R::of(1.0) - bv
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_fall_smoothly_from_one_to_nothing() {
        for kernel in Kernel::ALL {
            assert!((kernel.value(0.0) - 1.0).abs() < 1e-6, "{kernel:?}");
            assert_eq!((kernel.value(1.0), kernel.value(1.5), kernel.at(0.0)), (0.0, 0.0, 0.0), "{kernel:?}");
            let mut last = 1.0 + 1e-6;
            for i in 1..1000 {
                let (v, step) = (1.0 - i as f32 / 1000.0, 1e-3);
                let slope = (kernel.at(v + step) - kernel.at((v - step).max(0.0))) / (v + step - (v - step).max(0.0));
                assert!(
                    (slope - kernel.derivative(v)).abs() < 6e-3,
                    "{kernel:?} {v}: {slope} {}",
                    kernel.derivative(v)
                );
                assert!(kernel.at(v) < last, "{kernel:?} at {v}");
                last = kernel.at(v);
            }
            assert!(kernel.value(0.999) < 1e-4, "{kernel:?} ends with zero slope");
        }
    }

    #[test]
    fn half_values_are_those_of_the_literature() {
        let known = [(Kernel::Wyvill, 0.5), (Kernel::Muraki, 0.541_196), (Kernel::Nishimura, 0.422_650)];
        for (kernel, x) in known {
            assert!((kernel.radius_of(0.5) - x).abs() < 1e-5, "{kernel:?} {}", kernel.radius_of(0.5));
        }
        // The printed polynomial.
        let sextic = |x: f32| 1.0 - 22.0 / 9.0 * x.powi(2) + 17.0 / 9.0 * x.powi(4) - 4.0 / 9.0 * x.powi(6);
        assert!((0..100).all(|i| (sextic(i as f32 / 100.0) - Kernel::Wyvill.value(i as f32 / 100.0)).abs() < 1e-6));
    }
}
