//! How the result of a generator joins the layer that is there.

use eyot_core::Field;
use eyot_core::math::pow;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A way to put the new values `b` on the old values `h`; `a` is the step's `amount`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Merge {
    /// `h + a b`
    #[default]
    Add,
    /// `h a b`
    Multiply,
    /// `max(h, a b)`
    Max,
    /// `min(h, a b)`
    Min,
    /// `top (h / top)^(1 + a b)` with the layer's largest value as `top`; ground at or below zero stays.
    Power,
    /// `h + a (b - h)`
    Lerp,
    /// `a b`
    Set,
}

impl Merge {
    /// One pair of values. `top` is the largest old value.
    fn one(self, h: f32, b: f32, amount: f32, top: f32) -> f32 {
        match self {
            Self::Add => h + amount * b,
            Self::Multiply => h * (amount * b),
            Self::Max => h.max(amount * b),
            Self::Min => h.min(amount * b),
            // Below an exponent of 0 the flanks would rise above the top.
            Self::Power if h > 0.0 => top * pow(h / top, (1.0 + amount * b).max(0.0)),
            Self::Power => h,
            Self::Lerp => h + amount * (b - h),
            Self::Set => amount * b,
        }
    }

    /// Merges `new` into `base`. Where a mask is given, its value (0 to 1) says how much of the change is kept.
    ///
    /// All fields must have the same size.
    pub fn apply(self, base: &mut Field, new: &Field, amount: f32, mask: Option<&Field>) {
        let top = if self.needs_top() { base.min_max().1 } else { 0.0 };
        self.apply_below(top, base, new, amount, mask);
    }

    /// True if the largest value of the whole layer matters.
    pub fn needs_top(self) -> bool {
        self == Self::Power
    }

    /// As [`Merge::apply`] to some rows of a layer whose largest value is `top`.
    pub fn apply_below(self, top: f32, base: &mut Field, new: &Field, amount: f32, mask: Option<&Field>) {
        let mut rows: Vec<&mut [f32]> = base.rows_mut().collect();
        rows.par_iter_mut().enumerate().for_each(|(y, row)| {
            let mask = mask.map(|m| m.row(y));
            for (x, (h, &b)) in row.iter_mut().zip(new.row(y)).enumerate() {
                let merged = self.one(*h, b, amount, top);
                *h = match mask {
                    Some(m) => *h + m[x].clamp(0.0, 1.0) * (merged - *h),
                    None => merged,
                };
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn merged(merge: Merge, h: &[f32], b: &[f32], amount: f32, mask: Option<&[f32]>) -> Vec<f32> {
        let field = |v: &[f32]| Field::from_slice(v.len(), 1, v).unwrap();
        let mut base = field(h);
        merge.apply(&mut base, &field(b), amount, mask.map(field).as_ref());
        base.to_vec()
    }

    #[test]
    fn each_merge_is_its_formula() {
        let (h, b) = ([4.0, -2.0], [3.0, 5.0]);
        assert_eq!(merged(Merge::Add, &h, &b, 2.0, None), [10.0, 8.0]);
        assert_eq!(merged(Merge::Multiply, &h, &b, 1.0, None), [12.0, -10.0]);
        assert_eq!(merged(Merge::Max, &h, &b, 1.0, None), [4.0, 5.0]);
        assert_eq!(merged(Merge::Min, &h, &b, 1.0, None), [3.0, -2.0]);
        assert_eq!(merged(Merge::Lerp, &h, &b, 0.5, None), [3.5, 1.5]);
        assert_eq!(merged(Merge::Set, &h, &b, 1.0, None), [3.0, 5.0]);
    }

    #[test]
    fn power_keeps_the_top_and_ground_below_zero() {
        let out = merged(Merge::Power, &[900.0, 225.0, 0.0, -50.0], &[1.0, 1.0, 1.0, 1.0], 1.0, None);
        assert_eq!(out, [900.0, 900.0 * 0.0625, 0.0, -50.0]);
        // A rough field that would turn the exponent negative does not lift anything above the top.
        let out = merged(Merge::Power, &[900.0, 1e-20], &[-9.0, -9.0], 1.0, None);
        assert_eq!(out, [900.0, 900.0]);
        // Nothing above zero: nothing to do, and no division by zero.
        assert_eq!(merged(Merge::Power, &[-1.0, 0.0], &[1.0, 1.0], 1.0, None), [-1.0, 0.0]);
    }

    #[test]
    fn a_mask_limits_every_merge() {
        assert_eq!(
            merged(Merge::Set, &[1.0, 1.0, 1.0], &[9.0, 9.0, 9.0], 1.0, Some(&[0.0, 0.5, 7.0])),
            [1.0, 5.0, 9.0]
        );
    }
}
