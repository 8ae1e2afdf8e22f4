//! What snow and melting add to the ice in a year.

/// Mass balance of every cell.
#[non_exhaustive]
pub enum Balance {
    /// By the height of the ice over the equilibrium line.
    Heights {
        /// The equilibrium line here, m.
        line: Vec<f32>,
        /// Change with height, 1/a.
        gradient: f32,
        /// What falls at most, m/a.
        most: f32,
    },
    /// By the summer's warmth and what falls in a year.
    Climate {
        /// Temperature of the summer if the surface lay at 0 m, degrees C.
        summer: Vec<f32>,
        /// Rain and snow of a year, m of water.
        precipitation: Vec<f32>,
        /// How much colder it is higher up, K/m.
        lapse: f32,
    },
}

/// Ice from a depth of water.
const ICE_OF_WATER: f32 = 1.0 / 0.91;

impl Balance {
    /// Rate in a cell whose surface lies at `surface_m`, m of ice a year.
    #[inline(always)]
    pub fn rate(&self, cell: usize, surface_m: f32) -> f32 {
        match self {
            Self::Heights { line, gradient, most } => (gradient * (surface_m - line[cell])).min(*most),
            Self::Climate { summer, precipitation, lapse } => {
                let warmth = summer[cell] - lapse * surface_m;
                ICE_OF_WATER * (precipitation[cell] - melting(warmth))
            }
        }
    }
}

/// What melts in a year where the summer's mean temperature is `t` degrees C, m of water: what falls at the equilibrium lines of 70
/// glaciers (Ohmura, Kasser and Funk 1992). The parabola is followed down to where it has no more melting.
#[inline(always)]
fn melting(t: f32) -> f32 {
    // Its lower zero.
    let t = t.max(-2.347);
    0.001 * (645.0 + t * (296.0 + 9.0 * t))
}
