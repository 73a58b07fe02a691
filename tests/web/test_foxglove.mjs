// test_foxglove.mjs BIN: Foxglove's own client library against collided-web, under both names of its protocol: channels, messages by
// Foxglove's schemas, services with collidectl's answers; Host, Origin and token; what is malformed; a daemon that
// is killed; and nothing is asked of the daemon while nobody subscribes.
import assert from "node:assert/strict";
import { createRequire } from "node:module";
import Ajv from "ajv";
import WebSocket from "ws";
import protocol from "@foxglove/ws-protocol";
import { ctl, serve, start, until, uri } from "./harness.mjs";

const { FoxgloveClient } = protocol;
const schemas = createRequire(import.meta.url)("@foxglove/schemas/jsonschema");
const known = Object.fromEntries(Object.values(schemas).map((s) => [s.title, s]));
const daemon = start("collided", "--links", uri);
await until("a daemon is ready", () => daemon.err.includes("is ready"));
start("vehicle_simulator", "--connect", uri, "--seconds", "600");
start("arm_controller", "--connect", uri, "--seconds", "600");
const server = await serve();
const address = `ws://127.0.0.1:${server.port}/foxglove/${server.token}`;
const status = () => JSON.parse(ctl("status", "--json").stdout);
const counter = (name) => Number(status().counters?.[name] ?? status()[name] ?? NaN);

async function connect(name, url = address) {
  const ws = new WebSocket(url, [name]);
  const client = new FoxgloveClient({ ws });
  const s = { ws, client, channels: [], services: [], messages: new Map(), statuses: [], failures: [], responses: [], info: null, closed: null };
  client.on("serverInfo", (i) => (s.info = i));
  client.on("advertise", (c) => s.channels.push(...c));
  client.on("advertiseServices", (c) => s.services.push(...c));
  client.on("status", (m) => s.statuses.push(m));
  client.on("serviceCallFailure", (m) => s.failures.push(m));
  client.on("serviceCallResponse", (m) => s.responses.push(m));
  client.on("error", (e) => (s.error = e));
  ws.addEventListener?.("close", (e) => (s.closed = e));
  client.on("close", (e) => (s.closed ??= e ?? true));
  client.on("message", (m) => {
    const value = JSON.parse(new TextDecoder("utf-8", { fatal: true }).decode(m.data));
    (s.messages.get(m.subscriptionId) ?? s.messages.set(m.subscriptionId, []).get(m.subscriptionId)).push({ at: m.timestamp, value });
  });
  await until("it is greeted", () => (s.info && s.channels.length && s.services.length) || s.closed || s.error);
  return s;
}
const subscribe = (s, topic) => s.client.subscribe(s.channels.find((c) => c.topic === topic).id);

async function both_names_are_spoken_and_messages_are_of_the_schemas() {
  for (const protocol of ["foxglove.sdk.v1", "foxglove.websocket.v1"]) {
    const s = await connect(protocol);
    assert.equal(s.ws.protocol, protocol);
    assert.ok(/^[0-9]+$/.test(s.info.sessionId) && s.info.capabilities.includes("services"));
    const of = Object.fromEntries(s.channels.map((c) => [c.topic, subscribe(s, c.topic)]));
    for (const t of Object.keys(of)) await until(`${protocol} ${t}`, () => (s.messages.get(of[t]) ?? []).length >= (t.endsWith("scene") ? 1 : 3));
    for (const c of s.channels) {
      const ours = new Ajv({ strict: false }).compile(JSON.parse(c.schema));
      const theirs = known[c.schemaName] && new Ajv({ strict: false }).compile(known[c.schemaName]);
      assert.ok(theirs || c.schemaName.startsWith("collided."), c.schemaName);
      let before = 0n;
      for (const m of s.messages.get(of[c.topic])) {
        assert.ok(ours(m.value) && (!theirs || theirs(m.value)), `${c.topic}: ${JSON.stringify(ours.errors ?? theirs?.errors)}`);
        assert.ok(m.at >= before);
        before = m.at;
      }
    }
    const scene = s.messages.get(of["/collided/scene"]).at(-1).value.entities.map((e) => e.id).sort();
    const bodies = ctl("query", "bodies", "--json").stdout.trim().split("\n").flatMap((l) => JSON.parse(l).hits ?? [JSON.parse(l)]).map((h) => h.a ?? h.name_a ?? h.name).filter(Boolean).sort();
    assert.deepEqual(scene, bodies);
    const moved = s.messages.get(of["/collided/transforms"]).map((m) => JSON.stringify(m.value.transforms.find((t) => t.child_frame_id === "body:vehicle").translation));
    assert.ok(new Set(moved).size > 1, "the vehicle moves");
    for (const id of Object.values(of)) s.client.unsubscribe(id);
    s.client.close();
  }
}

async function services_answer_as_collidectl_does() {
  const s = await connect("foxglove.sdk.v1"), service = (name) => s.services.find((x) => x.name === name).id;
  const call = (name, request, callId, encoding = "json") =>
    s.client.sendServiceCallRequest({ serviceId: typeof name === "number" ? name : service(name), callId, encoding, data: new DataView(new TextEncoder().encode(JSON.stringify(request)).buffer) });
  const answer = async (id) => {
    const r = await until(`answer ${id}`, () => s.responses.find((x) => x.callId === id));
    return JSON.parse(new TextDecoder().decode(r.data));
  };
  call("/collided/explain", { a: "base_link", b: "wedge" }, 1);
  const lines = (t) => t.trim().replaceAll(/[0-9.e-]+ s old/g, "some s old").split("\n").map((l) => l.trim()).filter(Boolean);
  assert.deepEqual(lines((await answer(1)).text), lines(ctl("query", "explain", "base_link", "wedge").stdout));
  call("/collided/distance", { a: "base_link", b: "wedge" }, 2);
  const distance = await answer(2);
  assert.ok(distance.status === "ok" && distance.lo <= distance.hi && distance.hi - distance.lo <= 1.01e-4, JSON.stringify(distance));
  call("/collided/distance", { a: "base_link", b: "nobody" }, 3);
  assert.notEqual((await answer(3)).status, "ok");
  call(77, { a: "x", b: "y" }, 4);
  call("/collided/explain", { a: "x" }, 5);
  call("/collided/explain", { a: "x", b: "y" }, 6, "cdr");
  await until("three are refused", () => s.failures.length === 3);
  s.client.close();
}

async function who_may_not_is_refused() {
  const refused = (url, options = {}) => new Promise((ok) => {
    const ws = new WebSocket(url, ["foxglove.sdk.v1"], options);
    ws.on("unexpected-response", (_, r) => ok(r.statusCode));
    ws.on("open", () => ok(101));
    ws.on("error", () => ok(0));
  });
  const base = `ws://127.0.0.1:${server.port}`;
  assert.equal(await refused(`${base}/foxglove/${"0".repeat(32)}`), 403);
  assert.equal(await refused(`${base}/foxglove`), 403);
  assert.equal(await refused(address, { origin: "http://evil.example" }), 403);
  assert.equal(await refused(address, { headers: { Host: "evil.example" } }), 403);
  assert.equal(await refused(address, { origin: `http://127.0.0.1:${server.port}` }), 101);
}

async function what_is_malformed_is_said_and_hurts_nobody() {
  const s = await connect("foxglove.websocket.v1");
  for (const text of ["{", "[]", "{\"op\":\"subscribe\",\"subscriptions\":[{\"id\":1,\"channelId\":99}]}", "{\"op\":\"fly\"}", "{\"op\":\"subscribe\",\"subscriptions\":7}", "null", "{\"op\":\"unsubscribe\",\"subscriptionIds\":[5,-1,1e9]}"]) s.ws.send(text);
  for (const bytes of [[], [2], [2, 1, 0, 0, 0, 1, 0, 0, 0, 255, 255, 255, 255], [9, 9]]) s.ws.send(Uint8Array.from(bytes));
  await until("it is said", () => s.statuses.length >= 4 && s.failures.length >= 1);
  for (let i = 0; i < 2000; i++) s.ws.send(Uint8Array.from({ length: i % 40 }, () => Math.floor(Math.random() * 256)));
  for (let i = 0; i < 2000; i++) s.ws.send("{\"op\":\"subscribe\",\"subscriptions\":[{\"id\":".slice(0, i % 41));
  const other = await connect("foxglove.sdk.v1");
  assert.ok(other.info && server.child.exitCode === null);
  other.client.close();
  s.ws.send("x".repeat(5000));
  await until("too much closes it", () => s.closed);
  s.client.close();
}

async function nobody_subscribes_and_nothing_is_asked() {
  const name = `scene_batches`, s = await connect("foxglove.sdk.v1");
  await until("the last one's subscriptions have ended", async () => {
    const before = counter(name);
    await new Promise((ok) => setTimeout(ok, 1500));
    return counter(name) === before;
  });
  const id = subscribe(s, "/collided/transforms");
  await until("poses come", () => (s.messages.get(id) ?? []).length > 5);
  assert.ok(counter(name) > 0);
  s.client.close();
}

async function another_daemon_is_another_session() {
  const s = await connect("foxglove.sdk.v1");
  subscribe(s, "/collided/scene");
  daemon.kill("SIGKILL");
  await daemon.ended;
  const next = start("collided", "--links", uri);
  await until("a daemon is ready", () => next.err.includes("is ready"));
  await until("it is told to connect again", () => s.closed);
  const again = await connect("foxglove.sdk.v1");
  assert.notEqual(again.info.sessionId, s.info.sessionId);
  again.client.close();
}

for (const test of [both_names_are_spoken_and_messages_are_of_the_schemas, services_answer_as_collidectl_does, who_may_not_is_refused, what_is_malformed_is_said_and_hurts_nobody, nobody_subscribes_and_nothing_is_asked, another_daemon_is_another_session]) {
  await test();
  console.log(`ok ${test.name}`);
}
server.child.kill("SIGTERM");
assert.equal((await server.child.ended).code, 0);
process.exit(0);
