"""The work of Eyot's rules in plain vectorised numpy: whole arrays, single precision, one thread."""

import numpy as np

import common

TINY, FLUSH = np.float32(1e-6), np.float32(1e-30)


def flushed(a):
    """No subnormal numbers, which would slow the processor down."""
    return np.where(np.abs(a) < FLUSH, 0, a)


def around(a, beyond="edge"):
    """Western, eastern, northern and southern neighbours of every cell; beyond the walls the nearest or 0."""
    p = np.pad(a, 1, mode=beyond)
    return p[1:-1, :-2], p[1:-1, 2:], p[:-2, 1:-1], p[2:, 1:-1]


def positive(a):
    return np.maximum(a, 0)


class Case:
    accounts = ()

    def __init__(self, fields, p):
        self.f, self.p = dict(fields), p
        self.sums = dict.fromkeys(self.accounts, 0.0)

    def advance(self, steps):
        for _ in range(steps):
            self.step(self.f, self.p)

    def fields(self):
        return self.f

    def ledger(self):
        return self.sums

    def count(self, account, values):
        # Rows in single precision, their sum in double: as the other implementations do.
        self.sums[account] += float(values.sum(axis=1).sum(dtype=np.float64))


class Signed(Case):
    accounts = ("water.rain", "water.evaporated", "water.drained", "water.clamped", "hydraulic.dig_limited",
                "hydraulic.speed_capped")

    def step(self, f, p):
        h, d, s = f["height"], f["water"], f["sediment"]
        head = np.maximum(h, p.sea) + d
        raw_x = np.zeros_like(h)
        raw_y = np.zeros_like(h)
        raw_x[:, :-1] = flushed(p.friction * f["flux_x"][:, :-1] + p.push * (head[:, :-1] - head[:, 1:]))
        raw_y[:-1] = flushed(p.friction * f["flux_y"][:-1] + p.push * (head[:-1] - head[1:]))
        forth_x, back_x = positive(raw_x), np.minimum(raw_x, 0)
        forth_y, back_y = positive(raw_y), np.minimum(raw_y, 0)
        out = forth_x + forth_y
        out[:, 1:] -= back_x[:, :-1]
        out[1:] -= back_y[:-1]
        out *= p.dt
        afford = np.divide(d, out, out=np.ones_like(d), where=d < out)

        def limited(afford):
            """Fluxes through the four edges of every cell, scaled by what the donor affords."""
            _, afford_e, _, afford_s = around(afford)
            east = forth_x * afford + back_x * afford_e
            south = forth_y * afford + back_y * afford_s
            west, north = np.zeros_like(east), np.zeros_like(south)
            west[:, 1:], north[1:] = east[:, :-1], south[:-1]
            return west, east, north, south

        west, east, north, south = limited(afford)
        moved = d + p.dt * ((west - east) + (north - south))
        wet = positive(moved)
        mean = 0.5 * (d + wet)
        qx, qy = 0.5 * p.dx * (west + east), 0.5 * p.dx * (north + south)
        h_w, h_e, h_n, h_s = around(h)
        gx, gy = p.slope * (h_e - h_w), p.slope * (h_s - h_n)
        g2 = gx * gx + gy * gy
        speed2 = (qx * qx + qy * qy) / np.square(np.maximum(mean, p.dry))
        sine2 = np.clip(g2 / (1 + g2), p.sine2_min, p.sine2_max)
        flowing = mean > p.dry
        speed2_felt = np.where(flowing, np.minimum(speed2, p.speed2_max), 0)
        capacity = p.capacity * np.sqrt(speed2_felt * sine2) * np.minimum(mean * p.ramp, 1)

        west_s, east_s, north_s, south_s = limited(afford * s / np.maximum(d, TINY))
        load = positive(s + p.dt * ((west_s - east_s) + (north_s - south_s)))
        lowest = np.minimum(np.minimum(h_e, h_w), np.minimum(h_s, h_n))
        missing = capacity - load
        wish = p.dig * positive(missing)
        dug = np.minimum(wish, p.dig_limit * positive(h - lowest))
        at_sea = h < p.sea
        self.count("hydraulic.dig_limited", np.where(at_sea, 0, wish - dug))
        dug = np.where(at_sea, 0, dug)
        settled = np.where(at_sea, load, p.settle * positive(-missing))
        kept = np.where(at_sea, 0, wet * p.keep)
        fallen = np.where(at_sea, 0, p.fallen)
        f.update(height=(h - dug) + settled, water=flushed(kept + fallen), sediment=flushed((load + dug) - settled),
                 flux_x=east, flux_y=south)
        lost = wet - kept
        self.count("water.rain", fallen)
        self.count("water.evaporated", np.where(at_sea, 0, lost))
        self.count("water.drained", np.where(at_sea, lost, 0))
        self.count("water.clamped", wet - moved)
        self.count("hydraulic.speed_capped", flowing & (speed2 > p.speed2_max))


class Classic(Case):
    def step(self, f, p):
        h, d, s = f["height"], f["water"], f["sediment"]
        head = h + d
        names = ("outflow_west", "outflow_east", "outflow_north", "outflow_south")
        flows = [positive(p.friction * f[n] + p.push * (head - b)) for n, b in zip(names, around(head))]
        wanted = p.dt * ((flows[0] + flows[1]) + (flows[2] + flows[3]))
        k = np.divide(d, wanted, out=np.ones_like(d), where=d < wanted)
        west, east, north, south = flows = [flushed(k * flow) for flow in flows]
        f.update(zip(names, flows))

        from_w, from_e = around(east, "constant")[0], around(west, "constant")[1]
        from_n, from_s = around(south, "constant")[2], around(north, "constant")[3]
        gain = ((from_w + from_e) + (from_n + from_s)) - ((west + east) + (north + south))
        wet = positive(d + p.dt * gain)
        mean = 0.5 * (d + wet)
        per_depth = np.where(mean > p.dry, 0.5 / np.maximum(mean, p.dry), 0)
        u = p.dx * ((from_w - west) + (east - from_e)) * per_depth
        v = p.dx * ((from_n - north) + (south - from_s)) * per_depth
        h_w, h_e, h_n, h_s = around(h)
        gx, gy = p.slope * (h_e - h_w), p.slope * (h_s - h_n)
        g2 = gx * gx + gy * gy
        sine2 = np.clip(g2 / (1 + g2), p.sine2_min, p.sine2_max)
        speed2 = np.minimum(u * u + v * v, p.speed2_max)
        missing = p.capacity * np.sqrt(speed2 * sine2) * np.minimum(mean * p.ramp, 1) - s
        lowest = np.minimum(np.minimum(h_e, h_w), np.minimum(h_s, h_n))
        dug = np.minimum(p.dig * positive(missing), p.dig_limit * positive(h - lowest))
        settled = p.settle * positive(-missing)
        s = (s + dug) - settled

        # What is here now was upstream a step ago, at most one cell away: bilinear interpolation, written as nine
        # weights of which four are not zero, is twice as fast here as indexing with arrays.
        a, b = np.clip(p.dt / p.dx * u, -1, 1), np.clip(p.dt / p.dx * v, -1, 1)
        across = positive(a), 1 - np.abs(a), positive(-a)
        padded = np.pad(s, 1, mode="edge")
        rows, columns = s.shape
        mixed = sum(padded[j:j + rows, i:i + columns] * across[i] * w
                    for j, w in enumerate((positive(b), 1 - np.abs(b), positive(-b))) for i in range(3))
        f.update(height=(h - dug) + settled, water=flushed(wet * p.keep + p.fallen),
                 sediment=flushed(mixed))


class Thermal(Case):
    def step(self, f, p):
        h = f["height"]
        padded = np.pad(h, 1, mode="edge")
        rows, columns = h.shape
        change = np.zeros_like(h)
        for dy in (0, 1, 2):
            for dx in (0, 1, 2):
                if (dx, dy) != (1, 1):
                    diagonal = dx != 1 and dy != 1
                    stay, rate = (p.stay_d, p.rate_d) if diagonal else (p.stay, p.rate)
                    difference = padded[dy:dy + rows, dx:dx + columns] - h
                    change += rate * (difference - np.clip(difference, -stay, stay))
        f["height"] = h + change


class Reef(Case):
    accounts = ("ground.reef", "limestone.worn")

    def step(self, f, p):
        h, old, memory, c = f["height"], f["limestone"], f["growth"], f["carbon"]
        depth = p.sea - h
        wet = depth > 0
        gain = sum(np.where(n_wet, n - c, 0) for n, n_wet in zip(around(c), around(wet)))
        c = np.clip(c + p.spread * gain, 0, 1)
        c[depth > p.open_sea] = 1
        c[[0, -1]] = c[:, [0, -1]] = 1
        c = np.where(wet, flushed(c), 0)

        floor = np.where(old > 0, np.minimum(f["reef_floor"], h), h)
        stone = np.minimum(old, h - floor)
        inside = (depth > p.shallow) & (depth < p.deep)
        rate = np.where(inside, p.growth * c * c * np.exp(np.minimum(-depth * p.per_light_depth, 0)), 0)
        grown = np.minimum(rate * p.years, positive(depth - p.shallow))
        left = positive(c - grown * p.uptake / np.maximum(depth, np.float32(0.01)))
        now = np.minimum(rate / p.growth, 1)
        f.update(height=(h + grown) - p.sink, limestone=stone + grown, carbon=flushed(left),
                 growth=flushed(memory + np.float32(0.02) * (now - memory)), reef_floor=floor - p.sink)
        self.count("ground.reef", grown)
        self.count("limestone.worn", old - stone)


if __name__ == "__main__":
    common.main("numpy", {"classic": Classic, "signed": Signed, "thermal": Thermal, "reef": Reef})
