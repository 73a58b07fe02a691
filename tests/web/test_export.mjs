// test_export.mjs BIN: a robot cell is recorded while somebody watches it, and the recording exported: what the MCAP file has is
// what the watcher was told; @mcap/core reads it by its index, with its CRCs; its messages are of Foxglove's schemas; what is cut
// off and what is flipped are told apart; the same recording gives the same file; damaged recordings and wrong calls are refused.
import assert from "node:assert/strict";
import { existsSync, mkdtempSync, readFileSync, rmSync, statSync, truncateSync, writeFileSync, copyFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { spawnSync } from "node:child_process";
import Ajv from "ajv";
import { createRequire } from "node:module";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { bin, start, until, uri } from "./harness.mjs";

const foxglove = createRequire(import.meta.url)("@foxglove/schemas/jsonschema");
const folder = mkdtempSync(join(tmpdir(), "collided-export-"));
process.on("exit", () => rmSync(folder, { recursive: true, force: true }));
const recording = join(folder, "session.lcmlog"), file = join(folder, "session.mcap");
const ctl = (...args) => spawnSync(join(bin, "collidectl"), args, { encoding: "utf8" });

const daemon = start("collided", "--links", uri, "--record", recording);
await until("a daemon is ready", () => daemon.err.includes("is ready"));
const watcher = start("collidectl", "--connect", uri, "watch", "--json", "--facts", "touch,distance", "--range", "0.1", "--rate", "10");
await until("the watcher is told", () => watcher.out.includes("snapshot") || watcher.out.includes("heartbeat"));
const vehicle = start("vehicle_simulator", "--connect", uri, "--seconds", "600");
const arm = start("arm_controller", "--connect", uri, "--seconds", "600");
await until("pairs come near, and go", () => ["near", "far"].every((k) => watcher.out.split(`"event":"${k}"`).length > 3));
for (const child of [arm, vehicle]) {
  child.kill("SIGINT");
  await child.ended;
}
daemon.kill("SIGINT");
await daemon.ended;
watcher.kill("SIGINT");
await watcher.ended;

const exported = ctl("export", recording, "--mcap", file);
assert.equal(exported.status, 0, exported.stderr);

// ---- read by its index ----

const source = (bytes) => ({ size: async () => BigInt(bytes.length), read: async (at, size) => bytes.subarray(Number(at), Number(at + size)) });
const bytes = new Uint8Array(readFileSync(file));
const reader = await McapIndexedReader.Initialize({ readable: source(bytes) });
const messages = [];
for await (const m of reader.readMessages({ validateCrcs: true })) messages.push(m);
const topic = (m) => reader.channelsById.get(m.channelId).topic;
assert.equal(BigInt(messages.length), reader.statistics.messageCount);
for (const [id, count] of reader.statistics.channelMessageCounts)
  assert.equal(BigInt(messages.filter((m) => m.channelId === id).length), count);
assert.ok(reader.chunkIndexes.length >= 1 && reader.statistics.chunkCount === reader.chunkIndexes.length);
for (let i = 1; i < messages.length; i++) assert.ok(messages[i].logTime >= messages[i - 1].logTime);
const middle = (reader.statistics.messageStartTime + reader.statistics.messageEndTime) / 2n;
let later = 0;
for await (const m of reader.readMessages({ startTime: middle })) {
  assert.ok(m.logTime >= middle);
  later++;
}
assert.equal(later, messages.filter((m) => m.logTime >= middle).length);
const metadata = [];
for await (const m of reader.readMetadata({ name: "collided" })) metadata.push(m);
assert.equal(metadata[0].metadata.get("recording"), "session.lcmlog");
assert.equal(metadata[0].metadata.get("damaged"), "");

// ---- by the schemas ----

const decode = (m) => JSON.parse(new TextDecoder("utf-8", { fatal: true }).decode(m.data));
const known = Object.fromEntries(Object.values(foxglove).map((s) => [s.title, s]));
const of = {}, told = new Map();
for (const m of messages) {
  const channel = reader.channelsById.get(m.channelId);
  if (channel.messageEncoding !== "json") {
    assert.ok(channel.topic.startsWith("/collided/raw/"), channel.topic);
    (of.raw ??= []).push(m);
    continue;
  }
  const schema = reader.schemasById.get(channel.schemaId), value = decode(m);
  if (!told.has(schema.id)) {
    const ajv = new Ajv({ strict: false }), ours = ajv.compile(JSON.parse(new TextDecoder().decode(schema.data)));
    const upstream = known[schema.name] && new Ajv({ strict: false }).compile(known[schema.name]);
    assert.ok(upstream || schema.name.startsWith("collided."), schema.name);
    told.set(schema.id, [ours, upstream]);
  }
  for (const check of told.get(schema.id)) assert.ok(!check || check(value), `${schema.name}: ${JSON.stringify(check?.errors)}`);
  (of[channel.topic] ??= []).push({ at: m.logTime, value });
}
for (const t of ["scene", "transforms", "contacts", "distances", "events", "log"]) assert.ok(of[`/collided/${t}`]?.length, t);

// Frames hang together, and every body of the scene has shapes and a place.
const scene = of["/collided/scene"].map((m) => m.value.entities).reduce((a, b) => (b.length > a.length ? b : a));
const placed = new Set(of["/collided/transforms"].flatMap((m) => m.value.transforms).map((t) => t.child_frame_id));
assert.ok(scene.length > 10, `${scene.length} bodies`);
for (const e of scene) {
  assert.ok(placed.has(e.frame_id) && e.frame_locked, e.frame_id);
  assert.ok(["cubes", "spheres", "cylinders", "triangles"].some((k) => e[k].length), `${e.id} is drawn`);
}
assert.ok(scene.some((e) => e.triangles.length), "a hull is drawn");
for (const t of of["/collided/transforms"].flatMap((m) => m.value.transforms)) {
  const { x, y, z, w } = t.rotation;
  assert.ok(Math.abs(Math.hypot(x, y, z, w) - 1) < 1e-9);
}

// ---- what the watcher was told, tick by tick ----

const key = (e) => `${e.tick} ${e.event ?? e.kind} ${[`${e.a}:${e.shape_a}`, `${e.b}:${e.shape_b}`].sort().join(" ")} ${e.cause}`;
// Near is told again with each new interval: the first of a contact is the event.
const near = new Set();
const watched = watcher.out.trim().split("\n").map((l) => JSON.parse(l)).filter((e) => {
  const is = e.event === "far" || (e.event === "near" && !near.has(e.contact));
  if (e.event === "near") near.add(e.contact);
  return is && !e.snapshot;
});
const events = new Map(of["/collided/events"].map((m) => [key(m.value), m.value]));
assert.ok(watched.length >= 6);
for (const w of watched) {
  const e = events.get(key(w));
  assert.ok(e || w.cause !== "motion", `in the file: ${JSON.stringify(w)}`);
  if (e && w.lo !== null) assert.ok(e.lo <= w.hi && w.lo <= e.hi, `${JSON.stringify(w)} and ${JSON.stringify(e)} are of one truth`);
}
const begun = new Set(watched.map(key)), invented = [...events.values()].filter((e) => ["near", "far"].includes(e.kind) && e.cause === "motion" && !begun.has(key(e)) && !e.snapshot);
assert.deepEqual(invented, []);

// ---- damage ----

async function fault(data) {
  const stream = new McapStreamReader({ validateCrcs: true });
  let got = 0;
  try {
    stream.append(data);
    for (let r; (r = stream.nextRecord()); ) got += r.type === "Message";
  } catch (e) {
    return { got, what: /crc/i.test(e.message) ? "flipped" : `other: ${e.message}` };
  }
  return { got, what: stream.done() ? "whole" : "cut off" };
}
assert.deepEqual(await fault(bytes), { got: messages.length, what: "whole" });
for (let i = 1; i <= 60; i++) {
  const at = Math.floor((bytes.length - 1) * i / 60) - (i % 7);
  const cut = await fault(bytes.subarray(0, at));
  assert.equal(cut.what, "cut off", `at ${at} of ${bytes.length}`);
  await assert.rejects(McapIndexedReader.Initialize({ readable: source(bytes.subarray(0, at)) }));
}
for (const index of reader.chunkIndexes) {
  const flipped = bytes.slice();
  flipped[Number(index.chunkStartOffset) + 60 + Math.floor(Number(index.uncompressedSize) / 2)] ^= 4;
  assert.equal((await fault(flipped)).what, "flipped");
}

// ---- again, and wrong ----

const again = join(folder, "again.mcap");
assert.equal(ctl("export", recording, "--mcap", again).status, 0);
assert.ok(readFileSync(again).equals(readFileSync(file)), "the same recording gives the same file");
assert.equal(ctl("export", recording, "--mcap", again).status, 73, "a file that is there is not written over");
const wrong = join(folder, "wrong.mcap");
assert.equal(ctl("export", recording).status, 64);
assert.equal(ctl("export", join(folder, "none"), "--mcap", wrong).status, 66);
writeFileSync(join(folder, "text"), "no recording");
assert.equal(ctl("export", join(folder, "text"), "--mcap", wrong).status, 65);
assert.equal(ctl("export", recording, "--mcap", join(folder, "no", "where")).status, 73);
assert.ok(!existsSync(wrong));
const half = join(folder, "half.lcmlog"), part = join(folder, "half.mcap");
copyFileSync(recording, half);
truncateSync(half, Math.floor(statSync(half).size / 2) + 3);
const damaged = ctl("export", half, "--mcap", part);
assert.equal(damaged.status, 65, damaged.stderr);
assert.match(damaged.stderr, /what came before it is in the file/);
const halved = await fault(new Uint8Array(readFileSync(part)));
assert.equal(halved.what, "whole");
assert.ok(halved.got > 100 && halved.got < messages.length);
console.log(`${messages.length} messages, ${scene.length} bodies, ${events.size} events, ${watched.length} of them watched`);
process.exit(0);
