"""The work of Eyot's rules in numba: parallel over rows, fused, no temporaries, padded arrays, single precision.

Each case runs all its steps inside one compiled function. Arrays have a border of ghost cells, so that the loops over
columns have no branches and become vector instructions. Sums for the ledger are kept in single precision along a row
and in double precision over the rows, as in Eyot.
"""

import math

import numba
import numpy as np
from numba import njit, prange

import common

F = np.float32
ZERO, HALF, ONE, TINY, FLUSH = F(0), F(0.5), F(1), F(1e-6), F(1e-30)

options = dict(fastmath=True, error_model="numpy", cache=True)
row_kernel = njit(**options)
parallel_kernel = njit(parallel=True, **options)


@row_kernel
def flushed(v):
    """No subnormal numbers, which would slow the processor down."""
    return v if abs(v) >= FLUSH else ZERO


@row_kernel
def repeat_sides(row):
    row[0], row[-1] = row[1], row[-2]


@row_kernel
def repeat_rows(a):
    a[0], a[-1] = a[1], a[-2]


# ---------------------------------------------------------------- hydraulic, signed fluxes


@row_kernel
def signed_flux_row(p, h_n, h, h_s, d_n, d, d_s, s, fx, fy_n, fy, raw_x, raw_y, afford, afford_s):
    for x in range(1, h.size - 1):
        head = max(h[x], p.sea) + d[x]
        east = p.friction * fx[x] + p.push * (head - (max(h[x + 1], p.sea) + d[x + 1]))
        west = p.friction * fx[x - 1] + p.push * ((max(h[x - 1], p.sea) + d[x - 1]) - head)
        south = p.friction * fy[x] + p.push * (head - (max(h_s[x], p.sea) + d_s[x]))
        north = p.friction * fy_n[x] + p.push * ((max(h_n[x], p.sea) + d_n[x]) - head)
        out = p.dt * (max(east, ZERO) - min(west, ZERO) + max(south, ZERO) - min(north, ZERO))
        share = d[x] / out if d[x] < out else ONE
        raw_x[x], raw_y[x] = flushed(east), flushed(south)
        afford[x] = share
        afford_s[x] = share * s[x] / max(d[x], TINY)


@row_kernel
def signed_erode_row(p, h_n, h, h_s, d, s, raw_x, raw_yn, raw_y, af_n, af, af_s, as_n, as_, as_s, h_new, fx, fy):
    evaporated, drained, clamped, limited, capped, rained = ZERO, ZERO, ZERO, ZERO, ZERO, ZERO
    for x in range(1, h.size - 1):
        forth, back = max(raw_x[x], ZERO), min(raw_x[x], ZERO)
        east, east_s = forth * af[x] + back * af[x + 1], forth * as_[x] + back * as_[x + 1]
        forth, back = max(raw_x[x - 1], ZERO), min(raw_x[x - 1], ZERO)
        west, west_s = forth * af[x - 1] + back * af[x], forth * as_[x - 1] + back * as_[x]
        forth, back = max(raw_y[x], ZERO), min(raw_y[x], ZERO)
        south, south_s = forth * af[x] + back * af_s[x], forth * as_[x] + back * as_s[x]
        forth, back = max(raw_yn[x], ZERO), min(raw_yn[x], ZERO)
        north, north_s = forth * af_n[x] + back * af[x], forth * as_n[x] + back * as_[x]

        moved = d[x] + p.dt * ((west - east) + (north - south))
        wet = max(moved, ZERO)
        mean = HALF * (d[x] + wet)
        qx, qy = HALF * p.dx * (west + east), HALF * p.dx * (north + south)
        gx, gy = p.slope * (h[x + 1] - h[x - 1]), p.slope * (h_s[x] - h_n[x])
        g2 = gx * gx + gy * gy
        mean2 = max(mean, p.dry) * max(mean, p.dry)
        inverse = ONE / (mean2 * (ONE + g2))
        speed2 = (qx * qx + qy * qy) * (ONE + g2) * inverse
        sine2 = min(max(g2 * mean2 * inverse, p.sine2_min), p.sine2_max)
        flowing = mean > p.dry
        speed2_felt = min(speed2, p.speed2_max) if flowing else ZERO
        capacity = p.capacity * math.sqrt(speed2_felt * sine2) * min(mean * p.ramp, ONE)

        load = max(s[x] + p.dt * ((west_s - east_s) + (north_s - south_s)), ZERO)
        lowest = min(min(h[x + 1], h[x - 1]), min(h_s[x], h_n[x]))
        missing = capacity - load
        wish = p.dig * max(missing, ZERO)
        dug = min(wish, p.dig_limit * max(h[x] - lowest, ZERO))
        settled = p.settle * max(-missing, ZERO)
        at_sea = h[x] < p.sea
        limited += ZERO if at_sea else wish - dug
        dug = ZERO if at_sea else dug
        settled = load if at_sea else settled
        kept = ZERO if at_sea else wet * p.keep
        fallen = ZERO if at_sea else p.fallen

        h_new[x] = (h[x] - dug) + settled
        d[x] = flushed(kept + fallen)
        s[x] = flushed((load + dug) - settled)
        fx[x], fy[x] = east, south
        rained += fallen
        evaporated += ZERO if at_sea else wet - kept
        drained += wet - kept if at_sea else ZERO
        clamped += wet - moved
        capped += ONE if flowing and speed2 > p.speed2_max else ZERO
    return rained, evaporated, drained, clamped, limited, capped


@parallel_kernel
def signed_steps(steps, p, h, h_new, d, s, fx, fy, raw_x, raw_y, afford, afford_s, sums):
    rows = h.shape[0] - 1
    for _ in range(steps):
        for y in prange(1, rows):
            signed_flux_row(p, h[y - 1], h[y], h[y + 1], d[y - 1], d[y], d[y + 1], s[y], fx[y], fy[y - 1], fy[y],
                            raw_x[y], raw_y[y], afford[y], afford_s[y])
            raw_x[y, -2] = ZERO  # Walls; what lies beyond them is never used.
        raw_y[-2] = ZERO
        rained, evaporated, drained, clamped, limited, capped = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for y in prange(1, rows):
            row = signed_erode_row(p, h[y - 1], h[y], h[y + 1], d[y], s[y], raw_x[y], raw_y[y - 1], raw_y[y],
                                   afford[y - 1], afford[y], afford[y + 1], afford_s[y - 1], afford_s[y],
                                   afford_s[y + 1], h_new[y], fx[y], fy[y])
            repeat_sides(h_new[y])
            repeat_sides(d[y])
            rained += row[0]
            evaporated += row[1]
            drained += row[2]
            clamped += row[3]
            limited += row[4]
            capped += row[5]
        repeat_rows(h_new)
        repeat_rows(d)
        sums[0] += rained
        sums[1] += evaporated
        sums[2] += drained
        sums[3] += clamped
        sums[4] += limited
        sums[5] += capped
        h, h_new = h_new, h


# ---------------------------------------------------------------- hydraulic as published in 2007


@row_kernel
def classic_flux_row(p, h_n, h, h_s, d_n, d, d_s, west, east, north, south):
    for x in range(1, h.size - 1):
        head = h[x] + d[x]
        w = max(p.friction * west[x] + p.push * (head - (h[x - 1] + d[x - 1])), ZERO)
        e = max(p.friction * east[x] + p.push * (head - (h[x + 1] + d[x + 1])), ZERO)
        n = max(p.friction * north[x] + p.push * (head - (h_n[x] + d_n[x])), ZERO)
        s = max(p.friction * south[x] + p.push * (head - (h_s[x] + d_s[x])), ZERO)
        wanted = p.dt * ((w + e) + (n + s))
        k = d[x] / wanted if d[x] < wanted else ONE
        west[x], east[x] = flushed(k * w), flushed(k * e)
        north[x], south[x] = flushed(k * n), flushed(k * s)


@row_kernel
def classic_erode_row(p, h_n, h, h_s, d, s, west, east, north, south, south_of_n, north_of_s, h_new, u, v):
    for x in range(1, h.size - 1):
        from_w, from_e, from_n, from_s = east[x - 1], west[x + 1], south_of_n[x], north_of_s[x]
        gain = ((from_w + from_e) + (from_n + from_s)) - ((west[x] + east[x]) + (north[x] + south[x]))
        wet = max(d[x] + p.dt * gain, ZERO)
        mean = HALF * (d[x] + wet)
        per_depth = HALF / max(mean, p.dry) if mean > p.dry else ZERO
        vx = p.dx * ((from_w - west[x]) + (east[x] - from_e)) * per_depth
        vy = p.dx * ((from_n - north[x]) + (south[x] - from_s)) * per_depth
        gx, gy = p.slope * (h[x + 1] - h[x - 1]), p.slope * (h_s[x] - h_n[x])
        g2 = gx * gx + gy * gy
        sine2 = min(max(g2 / (ONE + g2), p.sine2_min), p.sine2_max)
        speed2 = min(vx * vx + vy * vy, p.speed2_max)
        missing = p.capacity * math.sqrt(speed2 * sine2) * min(mean * p.ramp, ONE) - s[x]
        lowest = min(min(h[x + 1], h[x - 1]), min(h_s[x], h_n[x]))
        dug = min(p.dig * max(missing, ZERO), p.dig_limit * max(h[x] - lowest, ZERO))
        settled = p.settle * max(-missing, ZERO)
        h_new[x] = (h[x] - dug) + settled
        d[x] = flushed(wet * p.keep + p.fallen)
        s[x] = flushed((s[x] + dug) - settled)
        u[x], v[x] = vx, vy


@row_kernel
def classic_advect_row(p, s_n, s, s_s, u, v, s_new):
    # At most one cell upstream: bilinear interpolation as nine weights, of which four are not zero, is free of
    # branches and gathers.
    scale = p.dt / p.dx
    for x in range(1, s.size - 1):
        a, b = min(max(scale * u[x], -ONE), ONE), min(max(scale * v[x], -ONE), ONE)
        w, e, mx = max(a, ZERO), max(-a, ZERO), ONE - abs(a)
        n, so, my = max(b, ZERO), max(-b, ZERO), ONE - abs(b)
        north = (s_n[x - 1] * w + s_n[x + 1] * e) + s_n[x] * mx
        south = (s_s[x - 1] * w + s_s[x + 1] * e) + s_s[x] * mx
        here = (s[x - 1] * w + s[x + 1] * e) + s[x] * mx
        s_new[x] = flushed((north * n + south * so) + here * my)


@parallel_kernel
def classic_steps(steps, p, h, h_new, d, s, s_new, west, east, north, south, u, v):
    rows = h.shape[0] - 1
    for _ in range(steps):
        for y in prange(1, rows):
            classic_flux_row(p, h[y - 1], h[y], h[y + 1], d[y - 1], d[y], d[y + 1], west[y], east[y], north[y],
                             south[y])
        for y in prange(1, rows):
            classic_erode_row(p, h[y - 1], h[y], h[y + 1], d[y], s[y], west[y], east[y], north[y], south[y],
                              south[y - 1], north[y + 1], h_new[y], u[y], v[y])
            repeat_sides(h_new[y])
            repeat_sides(d[y])
            repeat_sides(s[y])
        repeat_rows(h_new)
        repeat_rows(d)
        repeat_rows(s)
        for y in prange(1, rows):
            classic_advect_row(p, s[y - 1], s[y], s[y + 1], u[y], v[y], s_new[y])
        h, h_new = h_new, h
        s, s_new = s_new, s


# ---------------------------------------------------------------- thermal


@row_kernel
def excess(difference, stay):
    return difference - min(max(difference, -stay), stay)


@row_kernel
def slump_row(p, h_n, h, h_s, h_new):
    for x in range(1, h.size - 1):
        o = h[x]
        near = (excess(h[x + 1] - o, p.stay) + excess(h[x - 1] - o, p.stay)) + (
            excess(h_s[x] - o, p.stay) + excess(h_n[x] - o, p.stay))
        far = (excess(h_s[x + 1] - o, p.stay_d) + excess(h_n[x - 1] - o, p.stay_d)) + (
            excess(h_s[x - 1] - o, p.stay_d) + excess(h_n[x + 1] - o, p.stay_d))
        h_new[x] = o + (p.rate * near + p.rate_d * far)


@parallel_kernel
def thermal_steps(steps, p, h, h_new):
    rows = h.shape[0] - 1
    for _ in range(steps):
        for y in prange(1, rows):
            slump_row(p, h[y - 1], h[y], h[y + 1], h_new[y])
            repeat_sides(h_new[y])
        repeat_rows(h_new)
        h, h_new = h_new, h


# ---------------------------------------------------------------- reef


@row_kernel
def spread_row(p, c_n, c, c_s, h_n, h, h_s, c_new):
    for x in range(1, c.size - 1):
        o = c[x]
        gain_x = (c[x + 1] - o if h[x + 1] < p.sea else ZERO) + (c[x - 1] - o if h[x - 1] < p.sea else ZERO)
        gain_y = (c_s[x] - o if h_s[x] < p.sea else ZERO) + (c_n[x] - o if h_n[x] < p.sea else ZERO)
        depth = p.sea - h[x]
        spread = min(max(o + p.spread * (gain_x + gain_y), ZERO), ONE)
        spread = ONE if depth > p.open_sea else spread
        c_new[x] = flushed(spread) if depth > ZERO else ZERO


@row_kernel
def hold_open(p, c, h, x):
    """The rim is open sea."""
    c[x] = ONE if h[x] < p.sea else ZERO


LOG2_E, LN2_HIGH, LN2_LOW, LOWEST = F(1.442695), F(0.6933594), F(-2.1219444e-4), F(-87.3)
E6, E5, E4, E3, E2, E1 = F(1.9875692e-4), F(1.3981999e-3), F(8.333452e-3), F(4.1665796e-2), F(1.6666665e-1), F(0.5)


@row_kernel
def exp_negative(x):
    """e^x for x <= 0 (Cephes). `math.exp` is a call for each cell, which made the whole step about four times slower."""
    x = max(x, LOWEST)
    k = np.floor(x * LOG2_E + HALF)
    r = x - k * LN2_HIGH - k * LN2_LOW
    m = (((((E6 * r + E5) * r + E4) * r + E3) * r + E2) * r + E1) * (r * r) + r + ONE
    return m * np.int32((np.int32(k) + 127) << 23).view(np.float32)


@row_kernel
def grow_row(p, h, stone, memory, c, floor):
    """Exponential light; returns what grew, sank and was worn."""
    grown_sum, worn = ZERO, ZERO
    for x in range(1, h.size - 1):
        base = min(floor[x], h[x]) if stone[x] > ZERO else h[x]
        left = min(stone[x], h[x] - base)
        depth = p.sea - h[x]
        lit = exp_negative(-max(depth, ZERO) * p.per_light_depth)
        rate = p.growth * c[x] * c[x] * lit if depth > p.shallow and depth < p.deep else ZERO
        grown = min(rate * p.years, max(depth - p.shallow, ZERO))
        worn += stone[x] - left
        grown_sum += grown
        now = min(rate / p.growth, ONE)
        c[x] = flushed(max(c[x] - grown * p.uptake / max(depth, F(0.01)), ZERO))
        memory[x] = flushed(memory[x] + F(0.02) * (now - memory[x]))
        h[x] = (h[x] + grown) - p.sink
        stone[x] = left + grown
        floor[x] = base - p.sink
    return grown_sum, worn


@parallel_kernel
def reef_steps(steps, p, h, stone, memory, c, c_new, floor, sums):
    rows = h.shape[0] - 1
    for _ in range(steps):
        for y in prange(1, rows):
            spread_row(p, c[y - 1], c[y], c[y + 1], h[y - 1], h[y], h[y + 1], c_new[y])
            hold_open(p, c_new[y], h[y], 1)
            hold_open(p, c_new[y], h[y], -2)
        for x in range(1, h.shape[1] - 1):
            c_new[1, x] = ONE if h[1, x] < p.sea else ZERO
            c_new[-2, x] = ONE if h[-2, x] < p.sea else ZERO
        grown, worn = 0.0, 0.0
        for y in prange(1, rows):
            row = grow_row(p, h[y], stone[y], memory[y], c_new[y], floor[y])
            repeat_sides(h[y])
            repeat_sides(c_new[y])
            grown += row[0]
            worn += row[1]
        repeat_rows(h)
        repeat_rows(c_new)
        sums[0] += grown
        sums[1] += worn
        c, c_new = c_new, c


# ---------------------------------------------------------------- the cases


class Case:
    """State of one case: padded arrays by name; `flips` are written to a second array each step."""

    flips = ()
    scratch = ()
    accounts = ()

    def __init__(self, fields, p):
        self.p = p
        self.size = fields["height"].shape[0]
        self.sums = np.zeros(len(self.accounts))
        # Fluxes are zero beyond the walls, everything else is as it is at the wall.
        self.a = {n: np.pad(v, 1, mode="constant" if "flow" in n or "flux" in n else "edge")
                  for n, v in fields.items()}
        for name in (*(f + "_new" for f in self.flips), *self.scratch):
            self.a[name] = np.zeros_like(self.a["height"])

    def advance(self, steps):
        self.step(steps)
        if steps % 2:
            for name in self.flips:
                self.a[name], self.a[name + "_new"] = self.a[name + "_new"], self.a[name]

    def fields(self):
        return {n: v[1:-1, 1:-1] for n, v in self.a.items()}

    def ledger(self):
        return dict(zip(self.accounts, self.sums.tolist()))


class Signed(Case):
    flips = ("height",)
    scratch = ("raw_x", "raw_y", "afford", "afford_s")
    accounts = ("water.rain", "water.evaporated", "water.drained", "water.clamped", "hydraulic.dig_limited",
                "hydraulic.speed_capped")

    def step(self, steps):
        a = self.a
        signed_steps(steps, self.p, a["height"], a["height_new"], a["water"], a["sediment"], a["flux_x"], a["flux_y"],
                     a["raw_x"], a["raw_y"], a["afford"], a["afford_s"], self.sums)


class Classic(Case):
    flips = ("height", "sediment")
    scratch = ("u", "v")

    def step(self, steps):
        a = self.a
        classic_steps(steps, self.p, a["height"], a["height_new"], a["water"], a["sediment"], a["sediment_new"],
                      a["outflow_west"], a["outflow_east"], a["outflow_north"], a["outflow_south"], a["u"], a["v"])


class Thermal(Case):
    flips = ("height",)

    def step(self, steps):
        thermal_steps(steps, self.p, self.a["height"], self.a["height_new"])


class Reef(Case):
    flips = ("carbon",)
    accounts = ("ground.reef", "limestone.worn")

    def step(self, steps):
        a = self.a
        reef_steps(steps, self.p, a["height"], a["limestone"], a["growth"], a["carbon"], a["carbon_new"],
                   a["reef_floor"], self.sums)


if __name__ == "__main__":
    common.main("numba", {"classic": Classic, "signed": Signed, "thermal": Thermal, "reef": Reef},
                numba.set_num_threads, numba.threading_layer)
