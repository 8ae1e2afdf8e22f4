//! Hydraulic erosion as published in 2007, for comparison: four one-way fluxes a cell, sediment traced back along the
//! velocity.
//!
//! It differs from the signed form only where the publication does: equation (1) for each of four fluxes that are never
//! negative, and equation (7) as `s1(x) = s(x - v t)` with bilinear interpolation, at most one cell far. The trace does
//! not conserve sediment; the ledger's account `ground.traced` says how much it made or lost.

use super::signed::{Dig, SHARED, head, spare};
use super::{ErodeParams, FluxParams};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, Side, Tally, TallyUnit, read};

/// Equations (1) and (2) for the four fluxes that leave a cell.
pub struct ClassicFlux;

impl Rule for ClassicFlux {
    const NAME: &'static str = "hydraulic_classic_flux";
    const READS: &'static [Read] = &[
        read("height", 1),
        read("water", 1),
        read("outflow_west", 0),
        read("outflow_east", 0),
        read("outflow_north", 0),
        read("outflow_south", 0),
    ];
    const WRITES: &'static [&'static str] = &["outflow_west", "outflow_east", "outflow_north", "outflow_south"];
    type Params = FluxParams<()>;
    type Out<R: Real> = [R; 4];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &FluxParams<R>, c: &impl Cell<R>) -> ([R; 4], [R; 0]) {
        let here = head(p.sea, c, 0, 0);
        let west = (p.keep * c.here(2) + p.push_x * (here - head(p.sea, c, -1, 0))).positive();
        let east = (p.keep * c.here(3) + p.push_x * (here - head(p.sea, c, 1, 0))).positive();
        let north = (p.keep * c.here(4) + p.push_y * (here - head(p.sea, c, 0, -1))).positive();
        let south = (p.keep * c.here(5) + p.push_y * (here - head(p.sea, c, 0, 1))).positive();
        let wanted = p.dt * ((west + east) + (north + south));
        let depth = c.here(1);
        let k = depth.lt(wanted).pick(depth / wanted, R::of(1.0));
        ([(k * west).flushed(), (k * east).flushed(), (k * north).flushed(), (k * south).flushed()], [])
    }
}

const WEST: usize = 3;
const EAST: usize = 4;
const NORTH: usize = 5;
const SOUTH: usize = 6;

/// Equations (3) to (6), and the exchange with the ground of (7). With `BY_ROCK` what is dug depends on the layer `erodibility`.
pub struct ClassicErode<const BY_ROCK: bool = false>;

/// What the rule reads; the last one only by rock.
const ERODE: [Read; 8] = [
    read("height", 1),
    read("water", 0),
    read("sediment", 0),
    read("outflow_west", 1),
    read("outflow_east", 1),
    read("outflow_north", 1),
    read("outflow_south", 1),
    read("erodibility", 0),
];

impl<const BY_ROCK: bool> Rule for ClassicErode<BY_ROCK> {
    const NAME: &'static str = if BY_ROCK { "hydraulic_classic_erode_by_rock" } else { "hydraulic_classic_erode" };
    const READS: &'static [Read] = if BY_ROCK { &ERODE } else { ERODE.split_at(7).0 };
    const WRITES: &'static [&'static str] = &["height", "water", "sediment", "speed_x", "speed_y"];
    const TALLIES: &'static [Tally] = &SHARED;
    type Params = ErodeParams<()>;
    type Out<R: Real> = [R; 5];
    type Sums<R: Real> = [R; 7];

    #[inline(always)]
    fn cell<R: Real>(p: &ErodeParams<R>, c: &impl Cell<R>) -> ([R; 5], [R; 7]) {
        let (zero, one) = (R::of(0.0), R::of(1.0));
        let (out_west, out_east) = (c.here(WEST), c.here(EAST));
        let (out_north, out_south) = (c.here(NORTH), c.here(SOUTH));
        let (from_west, from_east) = (c.at(EAST, -1, 0), c.at(WEST, 1, 0));
        let (from_north, from_south) = (c.at(SOUTH, 0, -1), c.at(NORTH, 0, 1));
        let gain =
            ((from_west + from_east) + (from_north + from_south)) - ((out_west + out_east) + (out_north + out_south));
        let depth = c.here(1);
        let moved = depth + p.dt * gain;
        let wet = moved.positive();

        let mean = R::of(0.5) * (depth + wet);
        let flowing = p.dry.lt(mean);
        let per_depth = flowing.pick(R::of(0.5) / mean.max(p.dry), zero);
        let vx = p.dx * ((from_west - out_west) + (out_east - from_east)) * per_depth;
        let vy = p.dy * ((from_north - out_north) + (out_south - from_south)) * per_depth;
        let gx = p.slope_x * (c.at(0, 1, 0) - c.at(0, -1, 0));
        let gy = p.slope_y * (c.at(0, 0, 1) - c.at(0, 0, -1));
        let g2 = gx * gx + gy * gy;
        let sine2 = (g2 / (one + g2)).clamp(p.sine2_min, p.sine2_max);
        let speed2 = vx * vx + vy * vy;
        let capacity = p.capacity * (speed2.min(p.speed2_max) * sine2).sqrt() * (mean * p.ramp).min(one);

        let (h, load) = (c.here(0), c.here(2));
        let lowest = c.at(0, 1, 0).min(c.at(0, -1, 0)).min(c.at(0, 0, 1).min(c.at(0, 0, -1)));
        let missing = capacity - load;
        let dig = if BY_ROCK { Dig::by_rock(p, c.here(7)) } else { Dig::everywhere(p) };
        let wish = dig.share * missing.positive();
        let dug = wish.min(dig.limit * (h - lowest).positive());
        let settled = p.settle * (-missing).positive();
        let at_sea = h.lt(p.sea);
        let refused = at_sea.pick(zero, wish - dug);
        let dug = at_sea.pick(zero, dug);
        let settled = at_sea.pick(load, settled);

        // As in the signed form: the load takes what the ground really gave.
        let new_height = ((h - dug) + settled.min(spare(h, load))).no_contract();
        let new_load = (load + (h - new_height)).flushed();

        let kept = wet * at_sea.pick(zero, p.keep);
        let fallen = at_sea.pick(zero, p.rain * p.dt);
        let new_water = (kept + fallen).flushed();
        let lost = wet - kept;
        let sums = [
            new_water - kept,
            at_sea.pick(zero, lost),
            at_sea.pick(lost, zero),
            wet - moved,
            refused,
            p.speed2_max.lt(speed2).one(),
            (h - new_height).positive(),
        ];
        ([new_height, new_water, new_load, vx, vy], sums)
    }

    #[inline(always)]
    fn boundary_outflow<R: Real>(p: &ErodeParams<R>, c: &impl Cell<R>, side: Side) -> Option<[R; 7]> {
        let flow = match side {
            Side::West => c.here(WEST),
            Side::East => c.here(EAST),
            Side::North => c.here(NORTH),
            Side::South => c.here(SOUTH),
        };
        let zero = R::of(0.0);
        Some([zero, zero, p.dt * flow, zero, zero, zero, zero])
    }
}

/// The transport of (7): what is here now was upstream a step ago.
pub struct ClassicAdvect;

impl Rule for ClassicAdvect {
    const NAME: &'static str = "hydraulic_classic_advect";
    const READS: &'static [Read] = &[read("sediment", 1), read("speed_x", 0), read("speed_y", 0)];
    const WRITES: &'static [&'static str] = &["sediment"];
    const TALLIES: &'static [Tally] = &[Tally {
        account: "ground.traced",
        unit: TallyUnit::Thickness,
        sign: 1,
        meaning: "Sediment that tracing back made (or lost, if negative)",
    }];
    type Params = ErodeParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 1];

    #[inline(always)]
    fn cell<R: Real>(p: &ErodeParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 1]) {
        let one = R::of(1.0);
        // Cells upstream; 2 slope = 1 / cell size. The clamp catches rounding only: what crosses a cell during dt is at
        // most what was there or comes in, and the mean depth is at least half of both, so that |u| <= 1.
        let u = (p.dt * R::of(2.0) * p.slope_x * c.here(1)).clamp(-one, one);
        let v = (p.dt * R::of(2.0) * p.slope_y * c.here(2)).clamp(-one, one);
        let (west, east) = (u.positive(), (-u).positive());
        let (north, south) = (v.positive(), (-v).positive());
        let (middle_x, middle_y) = (one - u.abs(), one - v.abs());
        // Four of the nine weights are not zero: bilinear interpolation without a branch. Opposite cells are added first,
        // so that mirrored and turned worlds stay so to the bit.
        let sides = (c.at(0, -1, 0) * west + c.at(0, 1, 0) * east) * middle_y
            + (c.at(0, 0, -1) * north + c.at(0, 0, 1) * south) * middle_x;
        let corners = (c.at(0, -1, -1) * (west * north) + c.at(0, 1, 1) * (east * south))
            + (c.at(0, 1, -1) * (east * north) + c.at(0, -1, 1) * (west * south));
        let traced = c.here(0) * (middle_x * middle_y) + (sides + corners);
        let s = traced.flushed();
        ([s], [s - c.here(0)])
    }
}
