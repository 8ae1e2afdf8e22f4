//! The rules of hydraulic erosion with one signed flux to each of eight neighbours; equation numbers as in the parent module.
//!
//! # Why eight
//! Water that has four ways out of a cell runs in stairs where the land falls diagonally. Stairs are longer and wider than a
//! straight channel, so that channels along the axes win, and gullies meet at right angles. With pipes to the diagonal
//! neighbours of a quarter of the strength, `sum (h_n - h)` is the Laplacian of nine points, whose leading error is the same in
//! all directions.
//!
//! # Rims
//! No diagonal pipe crosses a rim. The pipes along the rim take over what those would have carried, as if the land were mirrored
//! there, so that a channel of one row is the wave equation in one dimension.

use super::ErodeParams;
use super::signed::{Dig, Flows, SHARED_BY_SIGNED, boundary_sums, exchange, head};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, Side, Tally, read};
use eyot_core::rule_params;

rule_params! {
    /// Parameters of [`EightFlux`].
    pub struct EightParams {
        /// `dt c^2 / dx^2`, 1/s.
        push_x,
        /// `dt c^2 / dy^2`, 1/s.
        push_y,
        /// `dt c^2 / (3 (dx^2 + dy^2))`, 1/s.
        push_d,
        /// Share of the flux that friction leaves, 1.
        keep,
        /// Time step, s.
        dt,
        /// Level of the sea, m; far below the ground where there is none.
        sea,
        /// First column that has no column west of it; before all columns where the rim wraps.
        first_x,
        /// Last column; behind all columns where the rim wraps.
        last_x,
        /// First row.
        first_y,
        /// Last row.
        last_y,
    }
}

/// Equations (1) and (2): new fluxes, and how much of them each cell can afford.
pub struct EightFlux;

impl Rule for EightFlux {
    const NAME: &'static str = "hydraulic_eight_flux";
    const READS: &'static [Read] = &[
        read("height", 1),
        read("water", 1),
        read("sediment", 0),
        read("flux_x", 1),
        read("flux_y", 1),
        read("flux_se", 1),
        read("flux_sw", 1),
    ];
    const WRITES: &'static [&'static str] = &["raw_x", "raw_y", "raw_se", "raw_sw", "afford", "afford_sediment"];
    type Params = EightParams<()>;
    type Out<R: Real> = [R; 6];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &EightParams<R>, c: &impl Cell<R>) -> ([R; 6], [R; 0]) {
        let [water, sediment, flux_x, flux_y, flux_se, flux_sw] = [1, 2, 3, 4, 5, 6];
        let (x, y) = (c.x(), c.y());
        let (to_west, to_east) = (p.first_x.lt(x).one(), x.lt(p.last_x).one());
        let (to_north, to_south) = (p.first_y.lt(y).one(), y.lt(p.last_y).one());
        let push_x = (p.push_x - p.push_d * (to_north + to_south)).named("(1) push_x");
        let push_y = (p.push_y - p.push_d * (to_west + to_east)).named("(1) push_y");
        let here = head(p.sea, c, 0, 0).named("head");
        // (1) A pipe's flux is pushed by the difference of the heads at its two ends.
        let east = (p.keep * c.here(flux_x) + push_x * (here - head(p.sea, c, 1, 0))).named("(1) east");
        let west = (p.keep * c.at(flux_x, -1, 0) + push_x * (head(p.sea, c, -1, 0) - here)).named("(1) west");
        let south = (p.keep * c.here(flux_y) + push_y * (here - head(p.sea, c, 0, 1))).named("(1) south");
        let north = (p.keep * c.at(flux_y, 0, -1) + push_y * (head(p.sea, c, 0, -1) - here)).named("(1) north");
        let (d, keep) = (p.push_d, p.keep);
        let se = ((to_south * to_east) * (keep * c.here(flux_se) + d * (here - head(p.sea, c, 1, 1)))).named("(1) se");
        let nw = ((to_north * to_west) * (keep * c.at(flux_se, -1, -1) + d * (head(p.sea, c, -1, -1) - here)))
            .named("(1) nw");
        let sw = ((to_south * to_west) * (keep * c.here(flux_sw) + d * (here - head(p.sea, c, -1, 1)))).named("(1) sw");
        let ne =
            ((to_north * to_east) * (keep * c.at(flux_sw, 1, -1) + d * (head(p.sea, c, 1, -1) - here))).named("(1) ne");
        // (2) What flows out during dt must be there.
        let zero = R::of(0.0);
        let beside = (east.positive() - west.min(zero)) + (south.positive() - north.min(zero));
        let across = (se.positive() - nw.min(zero)) + (sw.positive() - ne.min(zero));
        let out = (p.dt * (beside + across)).named("(2) out");
        let depth = c.here(water);
        let afford = depth.lt(out).pick(depth / out, R::of(1.0)).named("(2) afford");
        // The sediment that a unit of raw outflow carries: concentration times what the cell can afford.
        let concentration = (c.here(sediment) / depth.max(R::of(1e-6))).named("(2) concentration");
        ([east.flushed(), south.flushed(), se.flushed(), sw.flushed(), afford, afford * concentration], [])
    }
}

/// Equations (3) to (8): water and sediment move, the ground is dug and built up, water rains and evaporates. With `BY_ROCK` what
/// is dug depends on the layer `erodibility`.
pub struct EightErode<const BY_ROCK: bool = false>;

const HEIGHT: usize = 0;
const WATER: usize = 1;
const SEDIMENT: usize = 2;
const RAW_X: usize = 3;
const RAW_Y: usize = 4;
const RAW_SE: usize = 5;
const RAW_SW: usize = 6;
const AFFORD: usize = 7;
const AFFORD_SEDIMENT: usize = 8;
const ERODIBILITY: usize = 9;

/// What the rule reads; the last one only by rock.
const ERODE: [Read; 10] = [
    read("height", 1),
    read("water", 0),
    read("sediment", 0),
    read("raw_x", 1),
    read("raw_y", 1),
    read("raw_se", 1),
    read("raw_sw", 1),
    read("afford", 1),
    read("afford_sediment", 1),
    read("erodibility", 0),
];

impl<const BY_ROCK: bool> Rule for EightErode<BY_ROCK> {
    const NAME: &'static str = if BY_ROCK { "hydraulic_eight_erode_by_rock" } else { "hydraulic_eight_erode" };
    const READS: &'static [Read] = if BY_ROCK { &ERODE } else { ERODE.split_at(ERODIBILITY).0 };
    const WRITES: &'static [&'static str] = &["height", "water", "sediment", "flux_x", "flux_y", "flux_se", "flux_sw"];
    const TALLIES: &'static [Tally] = &SHARED_BY_SIGNED;
    type Params = ErodeParams<()>;
    type Out<R: Real> = [R; 7];
    type Sums<R: Real> = [R; 9];

    #[inline(always)]
    fn cell<R: Real>(p: &ErodeParams<R>, c: &impl Cell<R>) -> ([R; 7], [R; 9]) {
        let (east, east_load) = edge(c, RAW_X, (0, 0), (1, 0));
        let (west, west_load) = edge(c, RAW_X, (-1, 0), (0, 0));
        let (south, south_load) = edge(c, RAW_Y, (0, 0), (0, 1));
        let (north, north_load) = edge(c, RAW_Y, (0, -1), (0, 0));
        let (se, se_load) = edge(c, RAW_SE, (0, 0), (1, 1));
        let (nw, nw_load) = edge(c, RAW_SE, (-1, -1), (0, 0));
        let (sw, sw_load) = edge(c, RAW_SW, (0, 0), (-1, 1));
        let (ne, ne_load) = edge(c, RAW_SW, (1, -1), (0, 0));

        // (4) Half the flux of each edge, along it.
        let (falling, rising) = (nw + se, ne + sw);
        // (5) The isotropic gradient of eight neighbours.
        let (h_east, h_west) = (c.at(HEIGHT, 1, 0), c.at(HEIGHT, -1, 0));
        let (h_south, h_north) = (c.at(HEIGHT, 0, 1), c.at(HEIGHT, 0, -1));
        let (h_se, h_nw) = (c.at(HEIGHT, 1, 1), c.at(HEIGHT, -1, -1));
        let (h_ne, h_sw) = (c.at(HEIGHT, 1, -1), c.at(HEIGHT, -1, 1));
        let (down, up) = (h_se - h_nw, h_ne - h_sw);
        let (half, four, sixth) = (R::of(0.5), R::of(4.0), R::of(1.0 / 6.0));
        let beside = h_east.min(h_west).min(h_south.min(h_north));
        let across = h_se.min(h_nw).min(h_ne.min(h_sw));
        let flows = Flows {
            gain: ((west - east) + (north - south)) + ((nw - se) + (ne - sw)),
            load_gain: ((west_load - east_load) + (north_load - south_load))
                + ((nw_load - se_load) + (ne_load - sw_load)),
            qx: half * p.dx * ((west + east) + (falling - rising)),
            qy: half * p.dy * ((north + south) + (falling + rising)),
            gx: sixth * p.slope_x * (four * (h_east - h_west) + (down + up)),
            gy: sixth * p.slope_y * (four * (h_south - h_north) + (down - up)),
            lowest: beside.min(across),
            dig: if BY_ROCK { Dig::by_rock(p, c.here(ERODIBILITY)) } else { Dig::everywhere(p) },
        };
        let ([height, water, sediment], sums) = exchange(p, c.here(HEIGHT), c.here(WATER), c.here(SEDIMENT), &flows);
        ([height, water, sediment, east, south, se, sw], sums)
    }

    #[inline(always)]
    fn boundary_outflow<R: Real>(p: &ErodeParams<R>, c: &impl Cell<R>, side: Side) -> Option<[R; 9]> {
        let (flow, load) = match side {
            Side::West => edge(c, RAW_X, (-1, 0), (0, 0)),
            Side::East => edge(c, RAW_X, (0, 0), (1, 0)),
            Side::North => edge(c, RAW_Y, (0, -1), (0, 0)),
            Side::South => edge(c, RAW_Y, (0, 0), (0, 1)),
        };
        let inwards = matches!(side, Side::West | Side::North);
        let (flow, load) = if inwards { (-flow, -load) } else { (flow, load) };
        Some(boundary_sums(p, flow, load))
    }
}

/// Flux of water and of sediment from one cell to another, whose edge's raw flux is kept at the first.
///
/// The donor decides: raw flux forth is scaled by what the first cell affords, flux back by what the second does. Both cells of
/// an edge compute the same numbers from the same operands, so what one loses the other gains to the bit.
#[inline(always)]
fn edge<R: Real>(c: &impl Cell<R>, raw: usize, (x0, y0): (isize, isize), (x1, y1): (isize, isize)) -> (R, R) {
    let (raw, zero) = (c.at(raw, x0, y0), R::of(0.0));
    let afford = raw.lt(zero).pick(c.at(AFFORD, x1, y1), c.at(AFFORD, x0, y0));
    let sediment = raw.lt(zero).pick(c.at(AFFORD_SEDIMENT, x1, y1), c.at(AFFORD_SEDIMENT, x0, y0));
    (raw * afford, raw * sediment)
}
