"""The work of Eyot's rules in plain parallel numba: what one writes who knows numba, and stops when it is fast.

One loop nest a stage over whole preallocated arrays, `prange` over rows, neighbours by index with the rim's cases where
they arise. No ghost cells, no kernels for rows, no fusing of stages. All numbers are single precision, which takes some
care in numba (a literal 0.5 or 0 makes an expression double). `numba_steps.py` is what an expert makes of it.
"""

import math

import numba
import numpy as np
from numba import njit, prange

import common

F = np.float32
ZERO, HALF, ONE, TINY, FLUSH = F(0), F(0.5), F(1), F(1e-6), F(1e-30)

kernel = njit(parallel=True, fastmath=True, error_model="numpy", cache=True)


@njit(fastmath=True, error_model="numpy", cache=True)
def flushed(v):
    """No subnormal numbers, which would slow the processor down."""
    return v if abs(v) >= FLUSH else ZERO


# ---------------------------------------------------------------- hydraulic, signed fluxes


@kernel
def signed_fluxes(p, h, d, flux_x, flux_y, raw_x, raw_y):
    rows, columns = h.shape
    for y in prange(rows):
        for x in range(columns):
            head = max(h[y, x], p.sea) + d[y, x]
            if x < columns - 1:
                there = max(h[y, x + 1], p.sea) + d[y, x + 1]
                raw_x[y, x] = flushed(p.friction * flux_x[y, x] + p.push * (head - there))
            if y < rows - 1:
                there = max(h[y + 1, x], p.sea) + d[y + 1, x]
                raw_y[y, x] = flushed(p.friction * flux_y[y, x] + p.push * (head - there))


@kernel
def signed_afford(p, d, raw_x, raw_y, afford):
    rows, columns = d.shape
    for y in prange(rows):
        for x in range(columns):
            out = max(raw_x[y, x], ZERO) + max(raw_y[y, x], ZERO)
            if x > 0:
                out -= min(raw_x[y, x - 1], ZERO)
            if y > 0:
                out -= min(raw_y[y - 1, x], ZERO)
            out *= p.dt
            afford[y, x] = d[y, x] / out if d[y, x] < out else ONE


@kernel
def signed_limit(d, s, raw_x, raw_y, afford, flux_x, flux_y, load_x, load_y):
    """What flows through the eastern and southern edges: water, and the sediment in it."""
    rows, columns = d.shape
    for y in prange(rows):
        for x in range(columns):
            own = s[y, x] / max(d[y, x], TINY)
            afforded, content = afford[y, x], own
            if x < columns - 1:
                if raw_x[y, x] < ZERO:
                    afforded, content = afford[y, x + 1], s[y, x + 1] / max(d[y, x + 1], TINY)
                flux_x[y, x] = raw_x[y, x] * afforded
                load_x[y, x] = flux_x[y, x] * content
            afforded, content = afford[y, x], own
            if y < rows - 1:
                if raw_y[y, x] < ZERO:
                    afforded, content = afford[y + 1, x], s[y + 1, x] / max(d[y + 1, x], TINY)
                flux_y[y, x] = raw_y[y, x] * afforded
                load_y[y, x] = flux_y[y, x] * content


@kernel
def signed_erode(p, h, d, s, flux_x, flux_y, load_x, load_y, h_new):
    rows, columns = h.shape
    rained, evaporated, drained, clamped, limited, capped = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for y in prange(rows):
        for x in range(columns):
            east, east_s = flux_x[y, x], load_x[y, x]
            west = flux_x[y, x - 1] if x > 0 else ZERO
            west_s = load_x[y, x - 1] if x > 0 else ZERO
            south, south_s = flux_y[y, x], load_y[y, x]
            north = flux_y[y - 1, x] if y > 0 else ZERO
            north_s = load_y[y - 1, x] if y > 0 else ZERO
            h_w, h_e = h[y, max(x - 1, 0)], h[y, min(x + 1, columns - 1)]
            h_n, h_s = h[max(y - 1, 0), x], h[min(y + 1, rows - 1), x]

            moved = d[y, x] + p.dt * ((west - east) + (north - south))
            wet = max(moved, ZERO)
            mean = HALF * (d[y, x] + wet)
            capacity = ZERO
            if mean > p.dry:
                qx, qy = HALF * p.dx * (west + east), HALF * p.dx * (north + south)
                gx, gy = p.slope * (h_e - h_w), p.slope * (h_s - h_n)
                g2 = gx * gx + gy * gy
                speed2 = (qx * qx + qy * qy) / (mean * mean)
                if speed2 > p.speed2_max:
                    speed2 = p.speed2_max
                    capped += 1.0
                sine2 = min(max(g2 / (ONE + g2), p.sine2_min), p.sine2_max)
                capacity = p.capacity * math.sqrt(speed2 * sine2) * min(mean * p.ramp, ONE)

            load = max(s[y, x] + p.dt * ((west_s - east_s) + (north_s - south_s)), ZERO)
            lowest = min(min(h_e, h_w), min(h_s, h_n))
            wish = p.dig * max(capacity - load, ZERO)
            dug = min(wish, p.dig_limit * max(h[y, x] - lowest, ZERO))
            settled = p.settle * max(load - capacity, ZERO)
            clamped += wet - moved
            if h[y, x] < p.sea:
                h_new[y, x] = h[y, x] + load
                d[y, x], s[y, x] = ZERO, ZERO
                drained += wet
            else:
                h_new[y, x] = (h[y, x] - dug) + settled
                kept = wet * p.keep
                d[y, x] = flushed(kept + p.fallen)
                s[y, x] = flushed((load + dug) - settled)
                limited += wish - dug
                rained += p.fallen
                evaporated += wet - kept
    return rained, evaporated, drained, clamped, limited, capped


# ---------------------------------------------------------------- hydraulic as published in 2007


@kernel
def classic_outflow(p, h, d, west, east, north, south):
    rows, columns = h.shape
    for y in prange(rows):
        for x in range(columns):
            head = h[y, x] + d[y, x]
            w, e, n, s = ZERO, ZERO, ZERO, ZERO
            if x > 0:
                w = max(p.friction * west[y, x] + p.push * (head - (h[y, x - 1] + d[y, x - 1])), ZERO)
            if x < columns - 1:
                e = max(p.friction * east[y, x] + p.push * (head - (h[y, x + 1] + d[y, x + 1])), ZERO)
            if y > 0:
                n = max(p.friction * north[y, x] + p.push * (head - (h[y - 1, x] + d[y - 1, x])), ZERO)
            if y < rows - 1:
                s = max(p.friction * south[y, x] + p.push * (head - (h[y + 1, x] + d[y + 1, x])), ZERO)
            wanted = p.dt * ((w + e) + (n + s))
            k = d[y, x] / wanted if d[y, x] < wanted else ONE
            west[y, x], east[y, x] = flushed(k * w), flushed(k * e)
            north[y, x], south[y, x] = flushed(k * n), flushed(k * s)


@kernel
def classic_move(p, d, west, east, north, south, mean, u, v):
    rows, columns = d.shape
    for y in prange(rows):
        for x in range(columns):
            from_w = east[y, x - 1] if x > 0 else ZERO
            from_e = west[y, x + 1] if x < columns - 1 else ZERO
            from_n = south[y - 1, x] if y > 0 else ZERO
            from_s = north[y + 1, x] if y < rows - 1 else ZERO
            w, e, n, s = west[y, x], east[y, x], north[y, x], south[y, x]
            wet = max(d[y, x] + p.dt * (((from_w + from_e) + (from_n + from_s)) - ((w + e) + (n + s))), ZERO)
            m = HALF * (d[y, x] + wet)
            d[y, x] = wet
            mean[y, x] = m
            u[y, x] = HALF * p.dx * ((from_w - w) + (e - from_e)) / m if m > p.dry else ZERO
            v[y, x] = HALF * p.dx * ((from_n - n) + (s - from_s)) / m if m > p.dry else ZERO


@kernel
def classic_erode(p, h, s, mean, u, v, h_new):
    rows, columns = h.shape
    for y in prange(rows):
        for x in range(columns):
            h_w, h_e = h[y, max(x - 1, 0)], h[y, min(x + 1, columns - 1)]
            h_n, h_s = h[max(y - 1, 0), x], h[min(y + 1, rows - 1), x]
            gx, gy = p.slope * (h_e - h_w), p.slope * (h_s - h_n)
            g2 = gx * gx + gy * gy
            sine2 = min(max(g2 / (ONE + g2), p.sine2_min), p.sine2_max)
            speed2 = min(u[y, x] * u[y, x] + v[y, x] * v[y, x], p.speed2_max)
            missing = p.capacity * math.sqrt(speed2 * sine2) * min(mean[y, x] * p.ramp, ONE) - s[y, x]
            if missing > ZERO:
                lowest = min(min(h_e, h_w), min(h_s, h_n))
                change = min(p.dig * missing, p.dig_limit * max(h[y, x] - lowest, ZERO))
            else:
                change = p.settle * missing
            h_new[y, x] = h[y, x] - change
            s[y, x] = flushed(s[y, x] + change)


@kernel
def classic_advect(p, s, u, v, s_new):
    """What is here now was upstream a step ago, at most one cell away: bilinear interpolation."""
    rows, columns = s.shape
    scale = p.dt / p.dx
    for y in prange(rows):
        for x in range(columns):
            away_x = min(max(scale * u[y, x], -ONE), ONE)
            away_y = min(max(scale * v[y, x], -ONE), ONE)
            # Counted from the cell: single precision is too coarse for places on a large grid.
            i, j = int(math.floor(-away_x)), int(math.floor(-away_y))
            a, b = -away_x - F(i), -away_y - F(j)
            x0, x1 = min(max(x + i, 0), columns - 1), min(max(x + i + 1, 0), columns - 1)
            y0, y1 = min(max(y + j, 0), rows - 1), min(max(y + j + 1, 0), rows - 1)
            s_new[y, x] = ((ONE - a) * (ONE - b) * s[y0, x0] + a * (ONE - b) * s[y0, x1]
                           + (ONE - a) * b * s[y1, x0] + a * b * s[y1, x1])


@kernel
def classic_weather(p, d, s):
    rows, columns = d.shape
    for y in prange(rows):
        for x in range(columns):
            d[y, x] = flushed(d[y, x] * p.keep + p.fallen)
            s[y, x] = flushed(s[y, x])


# ---------------------------------------------------------------- thermal


@njit(fastmath=True, error_model="numpy", cache=True)
def excess(difference, stay):
    return difference - min(max(difference, -stay), stay)


@kernel
def slump(p, h, h_new):
    rows, columns = h.shape
    for y in prange(rows):
        n, s = max(y - 1, 0), min(y + 1, rows - 1)
        for x in range(columns):
            w, e = max(x - 1, 0), min(x + 1, columns - 1)
            o = h[y, x]
            near = (excess(h[y, e] - o, p.stay) + excess(h[y, w] - o, p.stay)
                    + excess(h[s, x] - o, p.stay) + excess(h[n, x] - o, p.stay))
            far = (excess(h[s, e] - o, p.stay_d) + excess(h[n, w] - o, p.stay_d)
                   + excess(h[s, w] - o, p.stay_d) + excess(h[n, e] - o, p.stay_d))
            h_new[y, x] = o + (p.rate * near + p.rate_d * far)


class Case:
    accounts, scratch = (), ()

    def __init__(self, fields, p):
        self.f, self.p = {n: v.copy() for n, v in fields.items()}, p
        for name in self.scratch:
            self.f[name] = np.zeros_like(fields["height"])
        self.sums = np.zeros(len(self.accounts))

    def advance(self, steps):
        for _ in range(steps):
            self.step(self.p, self.f)

    def flip(self, name):
        self.f[name], self.f[name + "_new"] = self.f[name + "_new"], self.f[name]

    def fields(self):
        return self.f

    def ledger(self):
        return dict(zip(self.accounts, self.sums.tolist()))


class Signed(Case):
    scratch = ("raw_x", "raw_y", "afford", "load_x", "load_y", "height_new")
    accounts = ("water.rain", "water.evaporated", "water.drained", "water.clamped", "hydraulic.dig_limited",
                "hydraulic.speed_capped")

    def step(self, p, f):
        h, d, s = f["height"], f["water"], f["sediment"]
        signed_fluxes(p, h, d, f["flux_x"], f["flux_y"], f["raw_x"], f["raw_y"])
        signed_afford(p, d, f["raw_x"], f["raw_y"], f["afford"])
        signed_limit(d, s, f["raw_x"], f["raw_y"], f["afford"], f["flux_x"], f["flux_y"], f["load_x"], f["load_y"])
        self.sums += signed_erode(p, h, d, s, f["flux_x"], f["flux_y"], f["load_x"], f["load_y"], f["height_new"])
        self.flip("height")


class Classic(Case):
    scratch = ("mean", "u", "v", "height_new", "sediment_new")

    def step(self, p, f):
        outflows = f["outflow_west"], f["outflow_east"], f["outflow_north"], f["outflow_south"]
        classic_outflow(p, f["height"], f["water"], *outflows)
        classic_move(p, f["water"], *outflows, f["mean"], f["u"], f["v"])
        classic_erode(p, f["height"], f["sediment"], f["mean"], f["u"], f["v"], f["height_new"])
        self.flip("height")
        classic_advect(p, f["sediment"], f["u"], f["v"], f["sediment_new"])
        self.flip("sediment")
        classic_weather(p, f["water"], f["sediment"])


class Thermal(Case):
    scratch = ("height_new",)

    def step(self, p, f):
        slump(p, f["height"], f["height_new"])
        self.flip("height")


if __name__ == "__main__":
    common.main("numba plain", {"classic": Classic, "signed": Signed, "thermal": Thermal},
                numba.set_num_threads, numba.threading_layer)
