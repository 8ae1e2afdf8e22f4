//! The rules of hydraulic erosion with one signed flux an edge; equation numbers as in the parent module.

use eyot_core::ledger::known::{DRAINED, EVAPORATED, RAIN, WATER_CLAMPED};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, Side, Tally, TallyUnit, read};
use eyot_core::rule_params;

rule_params! {
    /// Parameters of [`Flux`].
    pub struct FluxParams {
        /// `dt c^2 / dx^2`, 1/s.
        push_x,
        /// `dt c^2 / dy^2`, 1/s.
        push_y,
        /// Share of the flux that friction leaves, 1.
        keep,
        /// Time step, s.
        dt,
        /// Level of the sea, m; far below the ground where there is none.
        sea,
    }
}

/// Equations (1) and (2): new fluxes, and how much of them each cell can afford.
pub struct Flux;

impl Rule for Flux {
    const NAME: &'static str = "hydraulic_flux";
    const READS: &'static [Read] =
        &[read("height", 1), read("water", 1), read("sediment", 0), read("flux_x", 1), read("flux_y", 1)];
    const WRITES: &'static [&'static str] = &["raw_x", "raw_y", "afford", "afford_sediment"];
    type Params = FluxParams<()>;
    type Out<R: Real> = [R; 4];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &FluxParams<R>, c: &impl Cell<R>) -> ([R; 4], [R; 0]) {
        let [water, sediment, flux_x, flux_y] = [1, 2, 3, 4];
        let here = head(p.sea, c, 0, 0).named("head");
        // (1) An edge's flux is pushed by the difference of the heads on its two sides.
        let east = (p.keep * c.here(flux_x) + p.push_x * (here - head(p.sea, c, 1, 0))).named("(1) east");
        let west = (p.keep * c.at(flux_x, -1, 0) + p.push_x * (head(p.sea, c, -1, 0) - here)).named("(1) west");
        let south = (p.keep * c.here(flux_y) + p.push_y * (here - head(p.sea, c, 0, 1))).named("(1) south");
        let north = (p.keep * c.at(flux_y, 0, -1) + p.push_y * (head(p.sea, c, 0, -1) - here)).named("(1) north");
        // (2) What flows out during dt must be there.
        let zero = R::of(0.0);
        let out = (east.positive() - west.min(zero)) + (south.positive() - north.min(zero));
        let out = out.named("out");
        let depth = c.here(water);
        let afford = depth.lt(p.dt * out).pick(depth / (p.dt * out), R::of(1.0)).named("(2) afford");
        // The sediment that a unit of raw outflow carries: concentration times what the cell can afford.
        let concentration = (c.here(sediment) / depth.max(R::of(1e-6))).named("(2) concentration");
        ([east.flushed(), south.flushed(), afford, afford * concentration], [])
    }
}

/// Level of the surface, fresh or salt, m.
#[inline(always)]
pub(super) fn head<R: Real>(sea: R, c: &impl Cell<R>, dx: isize, dy: isize) -> R {
    let [height, water] = [0, 1];
    c.at(height, dx, dy).max(sea) + c.at(water, dx, dy)
}

rule_params! {
    /// Parameters of [`Erode`].
    pub struct ErodeParams {
        /// Time step, s.
        dt,
        /// East-west cell size, m.
        dx,
        /// North-south cell size, m.
        dy,
        /// `1 / (2 dx)`, 1/m.
        slope_x,
        /// `1 / (2 dy)`, 1/m.
        slope_y,
        /// Rain, m/s.
        rain,
        /// Share of the water that is left after evaporation during dt, 1.
        keep,
        /// Depth below which water does not move sediment, m.
        dry,
        /// Square of the speed limit, m2/s2.
        speed2_max,
        /// Square of the least sine of the slope, 1.
        sine2_min,
        /// Square of the largest sine of the slope, 1.
        sine2_max,
        /// Capacity, m per (m/s).
        capacity,
        /// `1 / ramp depth`, 1/m.
        ramp,
        /// Share of the missing load that is dug during dt, 1.
        dig,
        /// Share of the surplus load that settles during dt, 1.
        settle,
        /// Largest share of the drop to the lowest neighbour that is dug at once, 1.
        dig_limit,
        /// Level of the sea, m.
        sea,
    }
}

/// Equations (3) to (8): water and sediment move, the ground is dug and built up, water rains and evaporates. With `BY_ROCK` what
/// is dug depends on the layer `erodibility`.
pub struct Erode<const BY_ROCK: bool = false>;

/// What the rule reads; the last one only by rock.
const ERODE: [Read; 8] = [
    read("height", 1),
    read("water", 0),
    read("sediment", 0),
    read("raw_x", 1),
    read("raw_y", 1),
    read("afford", 1),
    read("afford_sediment", 1),
    read("erodibility", 0),
];

impl<const BY_ROCK: bool> Rule for Erode<BY_ROCK> {
    const NAME: &'static str = if BY_ROCK { "hydraulic_erode_by_rock" } else { "hydraulic_erode" };
    const READS: &'static [Read] = if BY_ROCK { &ERODE } else { ERODE.split_at(7).0 };
    const WRITES: &'static [&'static str] = &["height", "water", "sediment", "flux_x", "flux_y"];
    const TALLIES: &'static [Tally] = &SHARED_BY_SIGNED;
    type Params = ErodeParams<()>;
    type Out<R: Real> = [R; 5];
    type Sums<R: Real> = [R; 9];

    #[inline(always)]
    fn cell<R: Real>(p: &ErodeParams<R>, c: &impl Cell<R>) -> ([R; 5], [R; 9]) {
        let [height, water, sediment] = [0, 1, 2];
        let (east, east_load) = edge_x(c, 0);
        let (west, west_load) = edge_x(c, -1);
        let (south, south_load) = edge_y(c, 0);
        let (north, north_load) = edge_y(c, -1);

        let (h_east, h_west) = (c.at(height, 1, 0), c.at(height, -1, 0));
        let (h_south, h_north) = (c.at(height, 0, 1), c.at(height, 0, -1));
        let half = R::of(0.5);
        let flows = Flows {
            gain: (west - east) + (north - south),
            load_gain: (west_load - east_load) + (north_load - south_load),
            qx: half * p.dx * (west + east),
            qy: half * p.dy * (north + south),
            gx: p.slope_x * (h_east - h_west),
            gy: p.slope_y * (h_south - h_north),
            lowest: h_east.min(h_west).min(h_south.min(h_north)),
            dig: if BY_ROCK { Dig::by_rock(p, c.here(7)) } else { Dig::everywhere(p) },
        };
        let ([new_height, new_water, new_load], sums) =
            exchange(p, c.here(height), c.here(water), c.here(sediment), &flows);
        ([new_height, new_water, new_load, east, south], sums)
    }

    #[inline(always)]
    fn boundary_outflow<R: Real>(p: &ErodeParams<R>, c: &impl Cell<R>, side: Side) -> Option<[R; 9]> {
        let (flow, load) = match side {
            Side::West => negated(edge_x(c, -1)),
            Side::East => edge_x(c, 0),
            Side::North => negated(edge_y(c, -1)),
            Side::South => edge_y(c, 0),
        };
        Some(boundary_sums(p, flow, load))
    }
}

/// What the edges of a cell bring, and the ground around it.
pub(super) struct Flows<R> {
    /// Inflows minus outflows of water, m/s.
    pub(super) gain: R,
    /// The same of sediment, m/s.
    pub(super) load_gain: R,
    /// Mean discharge through the cell over its width, eastward and southward, m2/s.
    pub(super) qx: R,
    pub(super) qy: R,
    /// Slope, 1.
    pub(super) gx: R,
    pub(super) gy: R,
    /// Lowest neighbour, m.
    pub(super) lowest: R,
    pub(super) dig: Dig<R>,
}

/// How much of what it could carry water digs.
pub(super) struct Dig<R> {
    /// Share of the missing load that is dug, 1.
    pub(super) share: R,
    /// Largest share of the drop to the lowest neighbour, 1.
    pub(super) limit: R,
}

impl<R: Real> Dig<R> {
    /// The same in all rock.
    #[inline(always)]
    pub(super) fn everywhere(p: &ErodeParams<R>) -> Self {
        Self { share: p.dig, limit: p.dig_limit }
    }

    /// In rock that wears `erodibility` times as fast as loose ground. Both are multiplied, so that where the limiter is in force
    /// hard rock is dug more slowly, too; soft rock fills the load and keeps to the limit.
    #[inline(always)]
    pub(super) fn by_rock(p: &ErodeParams<R>, erodibility: R) -> Self {
        let (one, factor) = (R::of(1.0), erodibility.positive());
        Self {
            share: (p.dig * factor).min(one).named("(7) share"),
            limit: (p.dig_limit * factor.min(one)).named("(7) limit"),
        }
    }
}

/// Equations (3) to (8) of a cell of ground `h`, water `depth` and load `sediment`: its new values of them, and the sums of
/// [`SHARED_BY_SIGNED`].
#[inline(always)]
pub(super) fn exchange<R: Real>(p: &ErodeParams<R>, h: R, depth: R, sediment: R, flows: &Flows<R>) -> ([R; 3], [R; 9]) {
    let (zero, one) = (R::of(0.0), R::of(1.0));
    // (3) Water moves.
    let moved = (depth + p.dt * flows.gain).named("(3) moved");
    let wet = moved.positive().named("(3) wet");

    // (4) Velocity from the mean flux through the cell and the mean depth; (5) slope. Speed and sine are only
    // needed as the root of the product of their squares, which costs one division and one root.
    let mean = (R::of(0.5) * (depth + wet)).named("(4) mean_depth");
    let (qx, qy, gx, gy) = (flows.qx, flows.qy, flows.gx, flows.gy);
    let q2 = (qx.named("(4) flow_x") * qx + qy.named("(4) flow_y") * qy).named("(4) flow_squared");
    let g2 = (gx.named("(5) slope_x") * gx + gy.named("(5) slope_y") * gy).named("(5) slope_squared");
    let mean2 = (mean.max(p.dry) * mean.max(p.dry)).named("(4) depth_squared");
    let inverse = one / (mean2 * (one + g2));
    let speed2 = (q2 * (one + g2) * inverse).named("(4) speed_squared");
    let sine2 = (g2 * mean2 * inverse).clamp(p.sine2_min, p.sine2_max).named("(5) sine_squared");
    let flowing = p.dry.lt(mean);
    let capped2 = flowing.pick(speed2.min(p.speed2_max), zero).named("(4) capped_squared");

    // (6) Capacity grows with depth, so that channels win over films.
    let capacity = p.capacity * (capped2 * sine2).sqrt() * (mean * p.ramp).min(one);
    let capacity = capacity.named("(6) capacity");

    // (7) Sediment moves with the water, then ground and water exchange it.
    let carried = sediment + p.dt * flows.load_gain;
    let carried = carried.named("(7) carried");
    let load = carried.positive().named("(7) load");
    let missing = (capacity - load).named("(7) missing");
    let wish = (flows.dig.share * missing.positive()).named("(7) wish");
    let dug = wish.min(flows.dig.limit * (h - flows.lowest.named("lowest")).positive()).named("(7) may_dig");
    let settled = p.settle * (-missing).positive();
    let at_sea = h.lt(p.sea);
    let refused = at_sea.pick(zero, wish - dug);
    // In the sea the river ends: its water joins the sea and all its load settles.
    let dug = at_sea.pick(zero, dug).named("(7) dug");
    let settled = at_sea.pick(load, settled).named("(7) settled");
    let new_height = ((h - dug) + settled.min(spare(h, load))).no_contract().named("(7) new_height");
    // The load takes what the ground really gave after rounding, so that nothing is made of it.
    let new_load = (load + (h - new_height)).flushed().named("(7) new_load");

    // (8) Evaporation and rain.
    let kept = (wet * at_sea.pick(zero, p.keep)).named("(8) kept");
    let fallen = at_sea.pick(zero, p.rain * p.dt);
    let new_water = (kept + fallen).flushed().named("(8) new_water");

    let lost = (wet - kept).named("(8) lost");
    let sums = [
        new_water - kept,
        at_sea.pick(zero, lost),
        at_sea.pick(lost, zero),
        wet - moved,
        refused,
        flowing.pick(p.speed2_max.lt(speed2).one(), zero),
        (h - new_height).positive(),
        zero,
        load - carried,
    ];
    ([new_height, new_water, new_load], sums)
}

/// The sums of what leaves over an open rim.
#[inline(always)]
pub(super) fn boundary_sums<R: Real>(p: &ErodeParams<R>, flow: R, load: R) -> [R; 9] {
    let zero = R::of(0.0);
    [zero, zero, p.dt * flow, zero, zero, zero, zero, p.dt * load, zero]
}

/// The part of a load that may settle on ground of height `h`: all but what rounding may add to the height, so that the
/// load, from which the rounded change is taken, never becomes negative.
#[inline(always)]
pub(super) fn spare<R: Real>(h: R, load: R) -> R {
    (load - R::of(f32::EPSILON) * (h.abs() + load)).positive()
}

/// The accounts of all forms.
pub(super) const SHARED: [Tally; 7] = [
    RAIN,
    EVAPORATED,
    DRAINED,
    WATER_CLAMPED,
    Tally {
        account: "hydraulic.dig_limited",
        unit: TallyUnit::Thickness,
        sign: 0,
        meaning: "Digging that the limiter refused, lest cells undercut their neighbours",
    },
    Tally {
        account: "hydraulic.speed_capped",
        unit: TallyUnit::Count,
        sign: 0,
        meaning: "Cell-steps in which water ran faster than max_speed, the speed that sediment feels at most: usual on slopes where \
                  steps are shorter than cell size over max_speed",
    },
    Tally {
        account: "hydraulic.dug",
        unit: TallyUnit::Thickness,
        sign: 0,
        meaning: "Ground that water dug up, each time that it did",
    },
];

/// The accounts of the forms whose sediment moves with the flux.
pub(super) const SHARED_BY_SIGNED: [Tally; 9] = [
    SHARED[0],
    SHARED[1],
    SHARED[2],
    SHARED[3],
    SHARED[4],
    SHARED[5],
    SHARED[6],
    Tally {
        account: "ground.left",
        unit: TallyUnit::Thickness,
        sign: -1,
        meaning: "Sediment that left over an open rim",
    },
    Tally {
        account: "ground.clamped",
        unit: TallyUnit::Thickness,
        sign: 1,
        meaning: "Sediment added where rounding had made a load negative",
    },
];

const RAW_X: usize = 3;
const RAW_Y: usize = 4;
const AFFORD: usize = 5;
const AFFORD_SEDIMENT: usize = 6;

/// Flux of water and of sediment through the eastern edge of the cell `at` columns east.
///
/// The donor decides: raw flux to the east is scaled by what the western cell affords, and the other way round. Both
/// cells of an edge compute the same numbers from the same operands, so what one loses the other gains to the bit.
#[inline(always)]
fn edge_x<R: Real>(c: &impl Cell<R>, at: isize) -> (R, R) {
    let raw = c.at(RAW_X, at, 0);
    let (forth, back) = (raw.positive(), raw.min(R::of(0.0)));
    (
        forth * c.at(AFFORD, at, 0) + back * c.at(AFFORD, at + 1, 0),
        forth * c.at(AFFORD_SEDIMENT, at, 0) + back * c.at(AFFORD_SEDIMENT, at + 1, 0),
    )
}

/// As [`edge_x`] for the southern edge of the cell `at` rows south.
#[inline(always)]
fn edge_y<R: Real>(c: &impl Cell<R>, at: isize) -> (R, R) {
    let raw = c.at(RAW_Y, 0, at);
    let (forth, back) = (raw.positive(), raw.min(R::of(0.0)));
    (
        forth * c.at(AFFORD, 0, at) + back * c.at(AFFORD, 0, at + 1),
        forth * c.at(AFFORD_SEDIMENT, 0, at) + back * c.at(AFFORD_SEDIMENT, 0, at + 1),
    )
}

#[inline(always)]
fn negated<R: Real>((a, b): (R, R)) -> (R, R) {
    (-a, -b)
}

rule_params! {
    /// Parameters of [`Spring`].
    pub struct SpringParams {
        /// Water that the strongest spring gives during dt, m.
        gain,
    }
}

/// Springs rise where the layer `springs` says so.
pub struct Spring;

impl Rule for Spring {
    const NAME: &'static str = "hydraulic_spring";
    const READS: &'static [Read] = &[read("water", 0), read("springs", 0)];
    const WRITES: &'static [&'static str] = &["water"];
    const TALLIES: &'static [Tally] = &[Tally {
        account: "water.springs",
        unit: TallyUnit::Thickness,
        sign: 1,
        meaning: "Water that rose from springs",
    }];
    type Params = SpringParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 1];

    #[inline(always)]
    fn cell<R: Real>(p: &SpringParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 1]) {
        let risen = p.gain * c.here(1).clamp(R::of(0.0), R::of(1.0));
        ([c.here(0) + risen], [risen])
    }
}
