// test_recorded.mjs BIN: a robot cell is recorded, and collided-web --file shows the recording: it plays, pauses, steps, is sought
// forward and back; a place is the same each time that it is come to; at its end bodies are where the session left them; what is
// damaged is shown up to there; a live server is not controlled.
import { execFileSync } from "node:child_process";
import { copyFileSync, mkdtempSync, rmSync, statSync, truncateSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { Socket } from "./client.mjs";
import { check, ctl, equal, run, serve, start, until, uri } from "./harness.mjs";

const folder = mkdtempSync(join(tmpdir(), "collided-recorded-"));
process.on("exit", () => rmSync(folder, { recursive: true, force: true }));
const recording = join(folder, "session.lcmlog");
const daemon = start("collided", "--links", uri, "--record", recording);
await until("a daemon is ready", () => daemon.err.includes("is ready"));
const actors = ["vehicle_simulator", "arm_controller"].map((n) => start(n, "--connect", uri, "--seconds", "600"));
await until("they are there", () => ctl("query", "bodies").stdout.includes("vehicle"));
await new Promise((ok) => setTimeout(ok, 6000)); // so long is the session; nothing is waited for
daemon.kill("SIGINT");
await daemon.ended;
for (const a of actors) a.kill("SIGINT");

async function open(server) {
  const s = new Socket(server.port);
  await s.opened;
  s.send({ op: "hello", token: server.token });
  s.hello = (await s.next(1)).json;
  s.send({ op: "subscribe" });
  s.playback = async (what, fits) => {
    await s.until(what, () => {
      const last = s.frames.filter((f) => f.kind === 7).at(-1);
      return last && last.json.playback && fits(last.json.playback);
    });
    return s.frames.filter((f) => f.kind === 7).at(-1).json.playback;
  };
  s.control = (what, more = {}) => s.send({ op: "control", do: what, ...more });
  let id = 0;
  s.body = async (a) => {
    const number = ++id;
    s.send({ op: "ask", id: number, what: "body", a });
    await s.until(`body ${a}`, () => s.frames.some((f) => f.kind === 8 && f.json.id === number));
    return s.frames.find((f) => f.kind === 8 && f.json.id === number).json;
  };
  s.seek = async (ns) => { // where it stands then: the last tick that is not later
    s.frames.length = 0;
    s.control("seek", { at_ns: String(ns) });
    const p = await s.playback(`it is at ${ns}`, (x) => x.state !== "playing" && BigInt(x.at_ns) <= ns && BigInt(x.at_ns) > ns - 500000000n);
    return { p, vehicle: JSON.stringify((await s.body("vehicle")).hits) };
  };
  return s;
}

let server = await serve("--file", recording);
let s = await open(server);
const begin = BigInt(s.hello.recording?.begin_ns ?? 0), end = BigInt(s.hello.recording?.end_ns ?? 0), span = end - begin;

async function it_begins_paused_with_its_span() {
  check("control", s.hello.control === true);
  check("span", span > 4000000000n, `${span}`);
  const p = await s.playback("a status", () => true);
  equal("state", p.state, "paused");
  equal("at", BigInt(p.at_ns), begin);
}

async function it_plays_and_pauses() {
  s.frames.length = 0;
  s.control("play");
  await s.playback("it plays", (p) => p.state === "playing" && BigInt(p.at_ns) > begin + 1000000000n);
  check("poses come", s.frames.filter((f) => f.kind === 4).length > 5);
  check("the scene came", s.frames.some((f) => f.kind === 2));
  s.control("pause");
  const p = await s.playback("it pauses", (x) => x.state === "paused");
  await new Promise((ok) => setTimeout(ok, 1500));
  const later = await s.playback("it stands", () => true);
  equal("where it stands", later.at_ns, p.at_ns);
  s.control("step");
  await s.playback("a step", (x) => x.tick === p.tick + 1 && x.state === "paused");
}

async function a_place_is_the_same_each_time() {
  const at = begin + span / 2n, first = await s.seek(at), late = await s.seek(begin + (span * 9n) / 10n), again = await s.seek(at);
  equal("tick", again.p.tick, first.p.tick);
  equal("pose", again.vehicle, first.vehicle);
  check("it had moved meanwhile", late.vehicle !== first.vehicle);
  const near = await s.seek(at + 700000000n); // within what is played on to
  await s.seek(begin);
  const far = await s.seek(at + 700000000n);
  equal("pose, come to in two ways", near.vehicle, far.vehicle);
}

async function its_end_is_the_sessions() {
  s.control("seek", { at_ns: String(end) });
  await s.playback("the end", (p) => p.state === "ended" && BigInt(p.at_ns) === end);
  const hit = (await s.body("vehicle")).hits[0];
  const mcap = join(folder, "session.mcap");
  execFileSync(join(process.argv[2], "collidectl"), ["export", recording, "--mcap", mcap, "--rate", "1000"]);
  const { readFileSync } = await import("node:fs");
  const text = readFileSync(mcap, "latin1"), at = text.lastIndexOf('"child_frame_id":"body:vehicle"');
  const t = JSON.parse(text.slice(text.indexOf("{", at), text.indexOf("}", at) + 1));
  check("where the export has it", [t.x, t.y, t.z].every((v, i) => v === hit.position[i]), `${JSON.stringify(t)} ${hit.position}`);
  s.control("play"); // from its beginning again
  await s.playback("it plays again", (p) => p.state === "playing" && BigInt(p.at_ns) < begin + span / 2n);
}

async function many_seeks_end_at_the_last() {
  for (let i = 0; i < 60; i++) s.control("seek", { at_ns: String(begin + (span * BigInt((i * 37) % 100)) / 100n) });
  s.control("pause");
  await s.seek(begin + span / 3n);
  check("it lives", server.child.exitCode === null);
}

async function it_ends_in_order_and_so_does_its_child() {
  const children = () => execFileSync("ps", ["-o", "comm=", "--ppid", String(server.child.pid)], { encoding: "utf8" }).trim();
  equal("one child", children(), "collided");
  server.child.kill("SIGTERM");
  equal("status", (await server.child.ended).code, 0);
}

async function damage_is_told_and_what_came_before_is_shown() {
  const half = join(folder, "half.lcmlog");
  copyFileSync(recording, half);
  truncateSync(half, Math.floor(statSync(half).size / 2) + 3);
  server = await serve("--file", half);
  s = await open(server);
  check("it is shorter", BigInt(s.hello.recording.end_ns) < end && BigInt(s.hello.recording.end_ns) > begin);
  await until("it is told", () => server.child.err.includes("damaged"));
  server.child.kill("SIGTERM");
  await server.child.ended;
  const none = start("collided-web", "--file", join(folder, "none"), "--port", "1");
  equal("no such file", (await none.ended).code, 66);
}

await run([it_begins_paused_with_its_span, it_plays_and_pauses, a_place_is_the_same_each_time, its_end_is_the_sessions, many_seeks_end_at_the_last, it_ends_in_order_and_so_does_its_child, damage_is_told_and_what_came_before_is_shown]);
