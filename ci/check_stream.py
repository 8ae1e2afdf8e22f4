"""The network stream, read by the client in `clients/python` and through the WebSocket library of others: both end with the files
of the run, late ones too; a rude one is closed alone; pages from elsewhere stay out; Ctrl-C leaves what can be gone on with.

Usage: python check_stream.py EYOT
"""

import csv
import json
import pathlib
import signal
import struct
import subprocess
import sys
import tempfile
import threading

from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from checks import check, finish

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "clients/python"))
sys.dont_write_bytecode = True
import eyot_stream  # noqa: E402

CLIENT = ROOT / "clients/python/eyot_stream.py"
MONTHS = 24


def serve(eyot, folder, *arguments):
    """A server that works, its address, and the events that follow."""
    command = [eyot, "serve", *arguments, "--listen", "127.0.0.1:0", "--json"]
    server = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True)
    first = json.loads(server.stdout.readline())
    check("serve", "says first where it serves", first["event"] == "serving" and first["url"].endswith(f":{first['port']}/"))
    check("serve", "says where control is", first["control"].startswith(first["url"] + "?token="), first)
    return server, first["url"]


def drain(server, until):
    """Reads events to one of these, and the rest on a thread, so that the server is not held up."""
    for line in server.stdout:
        if json.loads(line)["event"] == until:
            break
    threading.Thread(target=server.stdout.read, daemon=True).start()


def follow(url, mirror):
    """Through another WebSocket library, to the close; its code."""
    with connect(url, max_size=None) as socket:
        try:
            while True:
                mirror.take(socket.recv())
        except ConnectionClosed as end:
            return end.rcvd.code


def state(mirror):
    layers = {name: values.tobytes() for name, values in mirror.layers.items()}
    return mirror.hello, mirror.moment, mirror.colonies, mirror.algae, layers, mirror.end


def glb_extras(path):
    data = path.read_bytes()
    (length,) = struct.unpack_from("<I", data, 12)
    return [n["extras"] for n in json.loads(data[20 : 20 + length])["nodes"] if "extras" in n]


def whole(eyot, folder):
    steps = f"colonies.steps={MONTHS}"
    server, url = serve(
        eyot, folder, "reef", "--size", "32", "--set", steps, "--layers", "height,coral_cover", "--wait", "3", "--linger"
    )
    theirs, late = eyot_stream.Mirror(), eyot_stream.Mirror()
    codes = []
    other = threading.Thread(target=lambda: codes.append(follow(url, theirs)))
    other.start()
    ours = [sys.executable, str(CLIENT), url]
    first = subprocess.Popen([*ours, "--save", "first.json"], cwd=folder, stdout=subprocess.PIPE, text=True)
    # The third one lets the run begin.
    short = subprocess.run([*ours, "--moments", "3"], cwd=folder, capture_output=True, text=True, timeout=600)
    check("client", "prints a line for each moment", short.returncode == 0 and len(short.stdout.splitlines()) == 3, short)
    drain(server, "done")
    # A page from elsewhere, and somebody who sends what is no record.
    try:
        with connect(url, origin="https://evil.example"):
            check("stream", "a foreign page stays out", False)
    except InvalidStatus as refusal:
        check("stream", "a foreign page stays out", refusal.response.status_code == 403)
    with connect(url, max_size=None) as rude:
        rude.send(b"garbage")
        try:
            while True:
                rude.recv()
        except ConnectionClosed as end:
            check("stream", "garbage is closed", end.rcvd.code == 1007, end)
    # Linger: whoever comes after the end sees it.
    stream = eyot_stream.Stream(url)
    while late.end is None or late.moment is None:
        late.take(stream.receive())
    server.send_signal(signal.SIGINT)
    check("serve", "lingers until Ctrl-C, and is done then", server.wait(60) == 0)
    other.join(60)
    lines = first.communicate(timeout=60)[0].splitlines()
    check("client", "follows to the end", first.returncode == 0 and len(lines) == MONTHS + 1, lines[-1:])
    check("stream", "is closed when done", codes == [1000], codes)
    check("stream", "both libraries and the late one agree", state(theirs)[:5] == state(late)[:5])
    saved = json.loads((folder / "first.json").read_text())
    check("client", "saves what it saw", saved["colonies"] == list(theirs.colonies.values()) and saved["end"][0] == "done")

    out = folder / "reef"
    with open(out / "census.csv", newline="") as file:
        rows = list(csv.reader(file))
    check("stream", "the census is that of the file", [float(v) for v in rows[-1]] == theirs.moment["census"])
    check("stream", "its columns too", rows[0] == theirs.hello["columns"])
    species = [s["name"] for s in theirs.hello["species"]]
    bodies = {e["id"]: (e["species"], e["age_months"], round(e["radius_m"], 5)) for e in glb_extras(out / "corals.glb") if "species" in e}
    seen = {i: (species[c["species"]], MONTHS - c["settled"], round(c["radius"], 5)) for i, c in theirs.colonies.items()}
    check("stream", "the colonies are those of corals.glb", seen == bodies and len(seen) > 10, len(seen))
    height = theirs.layer("height")
    check("stream", "the sea floor came", len(height) == 32 * 32 and -8.0 < min(height) < max(height) < -2.0)
    longest = max(max(c["rays"]) - c["reach"] for c in theirs.colonies.values())
    check("stream", "no ray is longer than the reach", longest == 0.0)


def stopped(eyot, folder):
    arguments = ["--size", "32", "--set", "colonies.steps=60", "--rate", "5"]
    server, url = serve(eyot, folder, "reef", "--out", "halves", "--wait", "1", *arguments)
    stream, mirror = eyot_stream.Stream(url), eyot_stream.Mirror()
    while mirror.moment is None or mirror.moment["step"] < 5:
        mirror.take(stream.receive())
    server.send_signal(signal.SIGINT)
    try:
        while True:
            mirror.take(stream.receive())
    except eyot_stream.Closed as end:
        check("serve", "Ctrl-C closes with 1001", end.args[0] == 1001, end)
    check("serve", "and leaves a checkpoint", server.wait(60) == 130 and (folder / "halves/checkpoint.eyot").exists())
    check("stream", "says so", mirror.end and mirror.end[0] == "stopped", mirror.end)
    server, url = serve(eyot, folder, "--resume", "--out", "halves", "--wait", "1")
    again = eyot_stream.Mirror()
    check("stream", "goes on from there", follow(url, again) == 1000 and again.moment["steps_done"] == 60)
    check("serve", "is done", server.wait(60) == 0 and (folder / "halves/run.json").exists())


def main():
    eyot = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as folder:
        whole(eyot, pathlib.Path(folder))
        stopped(eyot, pathlib.Path(folder))
    finish()


if __name__ == "__main__":
    main()
