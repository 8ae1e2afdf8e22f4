// Runs a recipe in WebAssembly and by the native command, and compares the fingerprints of their worlds.
//
// node check.mjs PROGRAM.wasm EYOT RECIPE.toml
import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

const [program, eyot, recipe] = process.argv.slice(2);
const size = 64;
const changes = ["step.erosion.steps=12", "step.growth.steps=12", "view.enabled=false"];

const { instance } = await WebAssembly.instantiate(readFileSync(program), {});
const wasm = instance.exports;

function text(string) {
    const bytes = new TextEncoder().encode(string);
    // The memory moves when it grows.
    const at = wasm.eyot_text(bytes.length);
    new Uint8Array(wasm.memory.buffer, at, bytes.length).set(bytes);
}

function message() {
    const length = wasm.eyot_message_bytes();
    return new TextDecoder().decode(new Uint8Array(wasm.memory.buffer, wasm.eyot_message(), length));
}

function fail(why) {
    console.error(why);
    process.exit(1);
}

function run() {
    try {
        return wasm.eyot_run(size);
    } catch (e) {
        return fail(`${e}: ${message()}`);
    }
}

text("nonsense = 1");
if (run() !== 0 || !message().includes("nonsense")) fail("a bad recipe is not refused");

const begun = performance.now();
text([readFileSync(recipe, "utf8"), ...changes].join("\0"));
if (run() !== 1) fail(message());
const seconds = (performance.now() - begun) / 1000;
const print = BigInt.asUintN(64, wasm.eyot_fingerprint()).toString(16).padStart(16, "0");

text("height");
const cells = wasm.eyot_layer();
const values = new Float32Array(wasm.memory.buffer, wasm.eyot_values(), cells);
if (cells !== size * size || !values.every(Number.isFinite)) fail(`a layer of ${cells} values: ${message()}`);
const highest = values.reduce((a, b) => Math.max(a, b));
if (!(highest > 100)) fail(`the island is ${highest} m high`);

const out = mkdtempSync(join(tmpdir(), "eyot-"));
let said;
try {
    const set = changes.flatMap((change) => ["--set", change]);
    const args = ["run", recipe, "--size", String(size), ...set, "--out", join(out, "island")];
    said = spawnSync(eyot, args, { encoding: "utf8" }).stderr;
} finally {
    rmSync(out, { recursive: true });
}
const native = /fingerprint ([0-9a-f]+)/.exec(said)?.[1];
if (native !== print) fail(`fingerprint ${print} in WebAssembly, ${native} natively:\n${said}`);
console.log(`the same fingerprint ${print} in WebAssembly, ${seconds.toFixed(1)} s, ${highest.toFixed(1)} m high`);
