#!/usr/bin/env python3
"""A client of Eyot's network stream that needs nothing but Python 3.9: one file, to be copied and changed.

    eyot serve reef --rate 2                          in one terminal
    python3 eyot_stream.py                            in another: a line for each moment
    python3 eyot_stream.py URL?token=TEXT --step 12   twelve steps, then wait; the server prints that URL
    python3 eyot_stream.py URL?token=TEXT --set sea_level=-5   where the server has --allow-changes
    python3 eyot_stream.py --until-end --save reef.json

The book's page "The network stream" lists the records. `Mirror` puts the state together, `Stream` is the connection; whoever has
another WebSocket library at hand needs only `decode` and `Mirror`.
"""

import argparse
import array
import base64
import hashlib
import json
import os
import socket
import struct
import sys
from urllib.parse import urlsplit

MAGIC, VERSION = b"EYST", 2
HELLO, SNAPSHOT, STEP, COLONIES, ALGAE, GONE, TILE, STATUS, END, REFUSED, CHANGED = range(1, 12)
PAUSE, RESUME, DO_STEPS, SET = 32, 33, 34, 35
STATUSES = ["runs", "paused", "waits for clients", "writes its files"]
ENDINGS = ["done", "stopped", "failed"]
MOST_RECORD = 16 << 20


class Wrong(Exception):
    """The server sent what it should not."""


class Closed(Exception):
    """The server closed the connection: code and reason."""


class Bytes:
    """Numbers and texts out of a record, in order; little-endian, without padding."""

    def __init__(self, data, at):
        self.data, self.at = data, at

    def take(self, form):
        form = "<" + form
        if self.at + struct.calcsize(form) > len(self.data):
            raise Wrong(f"byte {self.at}: the record is too short")
        values = struct.unpack_from(form, self.data, self.at)
        self.at += struct.calcsize(form)
        return values if len(values) > 1 else values[0]

    def text(self):
        length = self.take("H")
        return self.take(f"{length}s").decode() if length else ""

    def floats(self, count):
        end = self.at + 4 * count
        if end > len(self.data):
            raise Wrong(f"byte {self.at}: the record is too short")
        values = array.array("f", self.data[self.at : end])
        if sys.byteorder == "big":
            values.byteswap()
        self.at = end
        return values


def decode(data):
    """The kind of a record, how many of the same moment follow, and what it says."""
    if len(data) < 16 or data[:4] != MAGIC:
        raise Wrong("this is no record of Eyot")
    version, kind, length, more = struct.unpack_from("<HHII", data, 4)
    if version != VERSION:
        raise Wrong(f"version {version}; this client speaks {VERSION}")
    if length != len(data) or length > MOST_RECORD:
        raise Wrong(f"a record of {length} bytes came as {len(data)}")
    reader = READERS.get(kind)
    if reader is None:
        raise Wrong(f"kind {kind}, which there is not")
    b = Bytes(data, 16)
    body = reader(b)
    if b.at != len(data):
        raise Wrong(f"{len(data) - b.at} bytes too many")
    return kind, more, body


def hello(b):
    names = ["seed", "width", "height", "cell_x_m", "cell_y_m", "sea_level_m", "every", "rays", "may"]
    h = dict(zip(names, b.take("QIIdddQHH")))
    species, layers, columns = b.take("HHH6x")
    h["engine"], h["recipe"] = b.text(), b.text()
    h["species"] = [dict(name=b.text(), **dict(zip(["form", "shape", "red", "green", "blue"], b.take("5B")))) for _ in range(species)]
    h["layers"] = [dict(name=b.text(), unit=b.text(), **dict(zip(["low", "high", "stagger"], b.take("ffB")))) for _ in range(layers)]
    h["columns"] = [b.text() for _ in range(columns)]
    return h


def moment(b):
    names = ["number", "steps_done", "step", "of", "recipe_step", "temperature_c", "colonies", "algae"]
    m = dict(zip(names, b.take("QQQQIfII")))
    count, m["sea_level_m"] = b.take("If")
    m["census"] = list(struct.unpack(f"<{count}d", b.take(f"{8 * count}s"))) if count else []
    return m


def colonies(b):
    count, why, rays = b.take("IHH")
    names = ["id", "settled", "species", "bleached", "x", "y", "radius", "height", "bleaching", "reach"]
    return why, [dict(zip(names, b.take("QiHHffffff")), rays=list(b.floats(rays))) for _ in range(count)]


def algae(b):
    count, why = b.take("IH2x")
    return why, [dict(zip(["id", "settled", "x", "y", "radius", "height"], b.take("Qi4xffff"))) for _ in range(count)]


def gone(b):
    count = b.take("I4x")
    return [b.take("Q") for _ in range(count)]


def tile(b):
    layer, x, y, width, height = b.take("H2xIIII4x")
    return layer, x, y, width, height, b.floats(width * height)


READERS = {
    HELLO: hello,
    SNAPSHOT: moment,
    STEP: moment,
    COLONIES: colonies,
    ALGAE: algae,
    GONE: gone,
    TILE: tile,
    STATUS: lambda b: STATUSES[b.take("I")],
    END: lambda b: (ENDINGS[b.take("I")], b.text()),
    REFUSED: lambda b: b.text(),
    CHANGED: lambda b: dict(zip(["recipe_step", "step"], b.take("I4xQ")), set=b.text()),
}


def order(kind, steps=None):
    """A message to the server: PAUSE, RESUME, or DO_STEPS with their number."""
    body = b"" if steps is None else struct.pack("<Q", steps)
    return MAGIC + struct.pack("<HHII", VERSION, kind, 16 + len(body), 0) + body


def change(path, value):
    """A message to the server: set `hydraulic.rain`, `sea_level` or `layer.water` to a value; an empty path takes a table of several."""
    body = b""
    for text in (path, json.dumps(value)):
        body += struct.pack("<H", len(text.encode())) + text.encode()
    return MAGIC + struct.pack("<HHII", VERSION, SET, 16 + len(body), 0) + body


class Mirror:
    """The state of the run, put together from records."""

    def __init__(self):
        self.hello = self.moment = self.end = self.status = self.refused = self.changed = None
        self.colonies, self.algae, self.layers = {}, {}, {}
        self.more = self.snapshots = 0

    def take(self, data):
        """Takes a record. True if it completes a moment, so that the state may be looked at."""
        kind, more, body = decode(data)
        part = kind in (COLONIES, ALGAE, GONE, TILE)
        if part != (self.more > 0) or part and self.more != more + 1:
            raise Wrong(f"{self.more} records of a moment are missing")
        self.more = more
        if kind == HELLO:
            self.hello = body
        elif kind == STATUS:
            self.status = body
        elif kind == END:
            self.end = body
        elif kind == REFUSED:
            self.refused = body
        elif kind == CHANGED:
            self.changed = body
        if kind in (HELLO, STATUS, END, REFUSED, CHANGED):
            return False
        if kind == SNAPSHOT:
            self.colonies, self.algae, self.layers = {}, {}, {}
            self.moment, self.snapshots = body, self.snapshots + 1
        elif kind == STEP:
            if body["number"] != self.moment["number"] + 1:
                raise Wrong(f"moment {body['number']} after {self.moment['number']}")
            self.moment = body
        elif kind in (COLONIES, ALGAE):
            everybody = self.colonies if kind == COLONIES else self.algae
            everybody.update((one["id"], one) for one in body[1])
        elif kind == GONE:
            for one in body:
                if self.colonies.pop(one, None) is None and self.algae.pop(one, None) is None:
                    raise Wrong(f"{one} is gone, but never was there")
        elif kind == TILE:
            layer, x, y, width, height, values = body
            columns = self.hello["width"]
            if x + width > columns or y + height > self.hello["height"]:
                raise Wrong("a tile beyond the grid")
            field = self.layers.setdefault(layer, array.array("f", bytes(4 * columns * self.hello["height"])))
            for row in range(height):
                begin = (y + row) * columns + x
                field[begin : begin + width] = values[row * width : (row + 1) * width]
        if more:
            return False
        if (len(self.colonies), len(self.algae)) != (self.moment["colonies"], self.moment["algae"]):
            raise Wrong("somebody is missing")
        return True

    def layer(self, name):
        """The values of a layer, row by row from the north, or None."""
        return self.layers.get([one["name"] for one in self.hello["layers"]].index(name))


class Stream:
    """A WebSocket (RFC 6455) as far as this protocol needs it."""

    def __init__(self, url):
        place = urlsplit(url)
        self.socket = socket.create_connection((place.hostname, place.port or 80))
        self.file = self.socket.makefile("rb")
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall(
            f"GET {place.path or '/'}{'?' * bool(place.query)}{place.query} HTTP/1.1\r\nHost: {place.netloc}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            f"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {key}\r\n\r\n".encode()
        )
        answer = self.file.readline().decode().strip()
        headers = {}
        for line in iter(self.file.readline, b"\r\n"):
            if not line:
                break
            name, _, value = line.decode().partition(":")
            headers[name.strip().lower()] = value.strip()
        wanted = hashlib.sha1((key + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11").encode()).digest()
        if " 101 " not in f"{answer} " or headers.get("sec-websocket-accept") != base64.b64encode(wanted).decode():
            raise ConnectionError(f"the server does not let us in: {answer}")

    def frame(self, opcode, payload):
        """Sends a frame; those of clients are masked."""
        head = bytes([0x80 | opcode])
        n = len(payload)
        head += bytes([0x80 | n]) if n < 126 else bytes([0x80 | 126]) + struct.pack(">H", n)
        mask = os.urandom(4)
        self.socket.sendall(head + mask + bytes(c ^ mask[i % 4] for i, c in enumerate(payload)))

    def read(self, count):
        data = self.file.read(count)
        if len(data) < count:
            raise ConnectionError("the connection broke")
        return data

    def send(self, data):
        self.frame(2, data)

    def receive(self):
        """The next record."""
        while True:
            first, length = self.read(2)
            if length == 126:
                (length,) = struct.unpack(">H", self.read(2))
            elif length == 127:
                (length,) = struct.unpack(">Q", self.read(8))
            if length > MOST_RECORD:
                raise Wrong(f"a message of {length} bytes")
            data = self.read(length)
            if first == 0x82:
                return data
            if first == 0x88:
                self.frame(8, data[:2])
                raise Closed(int.from_bytes(data[:2], "big"), data[2:].decode())
            if first == 0x89:
                self.frame(10, data)
            elif first != 0x8A:
                raise Wrong("a frame that this protocol does not have")


def main():
    parser = argparse.ArgumentParser(description="Follows a run of `eyot serve`.")
    parser.add_argument("url", nargs="?", default="ws://127.0.0.1:13968/")
    parser.add_argument("--pause", action="store_true", help="ask the run to wait")
    parser.add_argument("--resume", action="store_true", help="ask it to go on")
    parser.add_argument("--step", type=int, metavar="N", help="ask it to do so many steps, then wait")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="ask for a change; the value is JSON, or else a text")
    parser.add_argument("--moments", type=int, metavar="N", help="end after so many moments")
    parser.add_argument("--until-end", action="store_true", help="end when the run has ended, though the server goes on")
    parser.add_argument("--save", metavar="FILE", help="write the last state as JSON")
    args = parser.parse_args()
    stream, mirror, seen = Stream(args.url), Mirror(), 0
    for asked, message in [
        (args.pause, order(PAUSE)),
        (args.resume, order(RESUME)),
        (args.step, order(DO_STEPS, args.step or 1)),
    ]:
        if asked:
            stream.send(message)
    for text in args.set:
        path, _, value = text.partition("=")
        try:
            value = json.loads(value)
        except ValueError:
            pass  # A bare word is a text.
        stream.send(change(path.strip(), value))
    try:
        while (args.moments is None or seen < args.moments) and not (args.until_end and mirror.end):
            complete = mirror.take(stream.receive())
            if mirror.refused:
                print("refused:", mirror.refused, file=sys.stderr)
                mirror.refused = None
            if mirror.changed:
                print("changed after step {step}: {set}".format(**mirror.changed), flush=True)
                mirror.changed = None
            if complete:
                seen += 1
                m, cover = mirror.moment, dict(zip(mirror.hello["columns"], mirror.moment["census"])).get("coral_cover")
                text = f"step {m['step']} of {m['of']}: {m['colonies']} colonies, {m['algae']} algae"
                if cover is not None:
                    text += f", {cover:.1%} coral, {m['temperature_c']:.1f} C"
                print(text, flush=True)
    except Closed as end:
        print("closed by the server:", *end.args, file=sys.stderr)
    if args.save and mirror.moment:
        state = {"hello": mirror.hello, "moment": mirror.moment, "end": mirror.end}
        state["colonies"], state["algae"] = list(mirror.colonies.values()), list(mirror.algae.values())
        # What is not a number is no JSON.
        if state["moment"]["temperature_c"] != state["moment"]["temperature_c"]:
            state["moment"] = {**state["moment"], "temperature_c": None}
        with open(args.save, "w", encoding="utf-8") as file:
            json.dump(state, file)
    return 0 if mirror.moment else 1


if __name__ == "__main__":
    sys.exit(main())
