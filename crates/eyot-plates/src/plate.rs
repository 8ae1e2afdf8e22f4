//! A plate: what it is beside its cells.

/// The numbers that all cells of a plate share.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub(crate) struct Plate {
    /// Way gone that is not yet a whole cell, cells.
    pub(crate) rest: [f64; 2],
    /// Whole cells gone east and south since the plate was made.
    pub(crate) moved: [f64; 2],
    /// Velocity to the east and south, m/yr.
    pub(crate) velocity: [f64; 2],
    /// Where it wants to go by itself: direction times a speed relative to the usual one.
    pub(crate) heading: [f64; 2],
    /// Turn of the heading relative to the fastest, -1..=1.
    pub(crate) spin: f64,
    /// Direction and strength of the slabs' pull, smoothed over a few steps.
    pub(crate) pull: [f64; 2],
    /// True for axes along which it cannot move, because its continents touch a closed rim.
    pub(crate) held: [bool; 2],
}

impl Plate {
    /// Numbers that a plate is stored in.
    pub(crate) const NUMBERS: usize = 13;

    pub(crate) fn numbers(&self) -> [f64; Self::NUMBERS] {
        let flag = |f: bool| f64::from(u8::from(f));
        let Self { rest: r, moved: m, velocity: v, heading: h, spin, pull: p, held } = *self;
        [r[0], r[1], m[0], m[1], v[0], v[1], h[0], h[1], spin, p[0], p[1], flag(held[0]), flag(held[1])]
    }

    pub(crate) fn from_numbers(n: &[f64]) -> Self {
        Self {
            rest: [n[0], n[1]],
            moved: [n[2], n[3]],
            velocity: [n[4], n[5]],
            heading: [n[6], n[7]],
            spin: n[8],
            pull: [n[9], n[10]],
            held: [n[11] != 0.0, n[12] != 0.0],
        }
    }
}

/// What is to be told of a plate.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct PlateInfo {
    /// Its number in the map of owners.
    pub index: u8,
    /// Area, m2.
    pub area_m2: f64,
    /// Share of it with continental crust.
    pub continental: f64,
    /// Volume of its crust, m3.
    pub crust_m3: f64,
    /// Speed, m/yr.
    pub speed_m_per_year: f64,
    /// Where it goes, degrees clockwise from north.
    pub azimuth_deg: f64,
    /// Centre, column and row.
    pub centre: (f64, f64),
}
