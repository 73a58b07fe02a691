// What collided-web serves, to whom, and how it stands what pages do: its protocol octet by octet, the gate, slow readers.
import http from "node:http";
import fs from "node:fs";
import { Socket } from "./client.mjs";
import { check, ctl, domain, equal, run, serve, start, until, uri } from "./harness.mjs";

const daemon = start("collided", "--links", uri, "--heartbeat", "0.2");
const vehicle = start("vehicle_simulator", "--connect", uri);
const { child: server, port, token } = await serve();

async function open(options = {}) {
  const s = new Socket(port, options);
  await s.opened;
  return s;
}

async function known(subscribe = {}) {
  const s = await open();
  s.send({ op: "hello", token });
  s.hello = (await s.next(1)).json;
  if (subscribe) s.send({ op: "subscribe", ...subscribe });
  return s;
}

const get = (path, headers = {}) => new Promise((ok, no) => http.get({ host: "127.0.0.1", port, path, headers }, (r) => {
  let body = "";
  r.on("data", (d) => (body += d));
  r.on("end", () => ok({ status: r.statusCode, headers: r.headers, body }));
}).on("error", no));

async function scene(s, ...names) { // until those are there
  const bodies = new Map();
  await s.until(`bodies ${names}`, () => {
    for (const f of s.frames.filter((x) => x.kind === 2).splice(0)) {
      if (f.all) bodies.clear();
      for (const b of f.bodies) bodies.set(b.name, b);
    }
    return names.every((n) => bodies.has(n));
  });
  return bodies;
}

async function the_page_comes_with_its_guards() {
  const page = await get("/");
  equal("status of /", page.status, 200);
  check("it is a page", page.body.startsWith("<!DOCTYPE html>"));
  check("policy", page.headers["content-security-policy"].startsWith("default-src 'none'; script-src 'self'"));
  check("policy names no other host", !/https?:/.test(page.headers["content-security-policy"]));
  equal("nosniff", page.headers["x-content-type-options"], "nosniff");
  equal("referrer", page.headers["referrer-policy"], "no-referrer");
  equal("no cookie", page.headers["set-cookie"], undefined);
  check("the token is not in the page", !page.body.includes(token));
  for (const [path] of page.body.matchAll(/(?<=(?:src|href)=")[^"]+/g))
    equal(`what the page names: ${path}`, (await get(`/${path}`)).status, 200);
  equal("no such file", (await get("/nothing")).status, 404);
  for (const path of ["/../../etc/passwd", "/..%2f..%2fetc/passwd", "//etc/passwd", "/plain/../../etc/passwd"])
    check(`no file of the machine: ${path}`, !(await get(path)).body.includes("root:"));
}

// DNS rebinding, pages of others, and who knows no token.
async function host_origin_and_token() {
  const own = `127.0.0.1:${port}`;
  for (const [host, status] of [[own, 200], [`localhost:${port}`, 200], [`[::1]:${port}`, 200], ["evil.example", 403],
    [`127.0.0.1.evil.example:${port}`, 403], ["127.0.0.1:x", 403]])
    equal(`GET with Host ${host}`, (await get("/", { Host: host })).status, status);
  const matrix = [[own, null, 101], [own, `http://${own}`, 101], [own, "http://evil.example", 0], [own, "null", 0],
    [own, `https://${own}`, 0], [own, `http://localhost:${port}`, 0], ["evil.example", "http://evil.example", 0],
    [`localhost:${port}`, `http://localhost:${port}`, 101]];
  for (const [Host, Origin, wanted] of matrix) {
    const s = await open({ headers: { Host, Origin } });
    equal(`upgrade with Host ${Host}, Origin ${Origin}`, s.head === 101 ? 101 : 0, wanted);
    s.close();
  }
  for (const [first, code] of [[{ op: "hello", token: "0".repeat(32) }, 4401], [{ op: "hello" }, 4401],
    [{ op: "subscribe" }, 4401], [{ op: "hello", token: token.slice(1) }, 4401], ["no JSON", 4400]]) {
    const s = await open();
    s.send(first);
    await s.until("the end", () => s.closed);
    equal(`first message ${JSON.stringify(first)}`, s.closed.code, code);
    equal("nothing was said before", s.frames.length, 0);
    s.close();
  }
  const silent = await open();
  await silent.until("who says nothing is sent away", () => silent.closed, 15000);
  equal("who says nothing", silent.closed.code, 4401);
}

async function frames_are_as_the_page_on_the_protocol_says() {
  const s = await known();
  equal("protocol", s.hello.protocol, "collided.web.v1");
  check("epoch is a text", /^\d{19}$/.test(s.hello.epoch), s.hello.epoch);
  const bodies = await scene(s, "vehicle", "table", "parcel_west");
  const shape = bodies.get("parcel_west").shapes[0];
  equal("the owner is told", bodies.get("vehicle").owner, "vehicle_simulator");
  check("shapes have a size", shape.half.some((x) => x > 0) || shape.radius > 0);
  check("the table stands", (bodies.get("table").flags & 8) === 8);
  const first = await s.next(4, (f) => f.ids.length > 0);
  const id = bodies.get("vehicle").id;
  const moved = await s.next(4, (f) => !f.all && f.ids.includes(id));
  const pose = moved.poses[moved.ids.indexOf(id)];
  check("the vehicle is on its lane", Math.abs(moved.origin[1] + pose[1] - 0.6) < 1e-6, String(pose));
  check("a unit quaternion", Math.abs(Math.hypot(...pose.slice(4)) - 1) < 1e-6);
  check("what stands is told once", !moved.ids.includes(bodies.get("table").id));
  const c = await s.next(5, (f) => f.contacts.some((x) => x.kind !== 6));
  const pair = c.contacts.find((x) => x.kind !== 6);
  check("an interval", pair.lo <= pair.hi);
  check("a unit axis", Math.abs(Math.hypot(...pair.axis) - 1) < 1e-9);
  const e = await s.next(6);
  check("events are numbered", e.first >= 1n && e.events.length > 0);
  const status = (await s.next(7, (f) => f.json.web.bodies > 0)).json;
  check("counters", status.counters.bodies >= 3);
  await s.next(7);
  check("numbers of frames", s.frames.every((f, i) => i === 0 || f.number > s.frames[i - 1].number));
  check("lengths", [first, moved, c, e, ...s.frames].every((f) => f.size === f.octets && f.size % 8 === 0 &&
    f.magic === 0xc011 && f.version === 1));
  s.close();
}

async function answers_are_those_of_collidectl() {
  const s = await known(null);
  await scene(s, "vehicle", "table");
  s.send({ op: "ask", id: 7, what: "explain", a: "vehicle", b: "table" });
  const { json } = await s.next(8);
  equal("id", json.id, 7);
  equal("status", json.status, "ok");
  const own = ctl("query", "explain", "vehicle", "table").stdout;
  equal("the first line", json.text.split("\n")[0].trim(), own.split("\n")[0].trim());
  s.send({ op: "ask", id: 8, what: "distance", a: "table", b: "table2" });
  check("no such body", (await s.next(8)).json.status !== "ok");
  s.send({ op: "ask", id: 9, what: "body", a: "table" });
  const body = (await s.next(8)).json.hits[0];
  equal("one body", body.name_a, "table");
  equal("seven numbers", body.position.length + body.orientation.length, 7);
  s.send({ op: "ask", id: 10, what: "body", a: "*" });
  equal("a pattern is no name", (await s.next(8)).json.hits.length, 0);
  s.send({ op: "control", do: "pause" });
  await s.until("the end", () => s.closed);
  equal("nothing is controlled", s.closed.code, 4403);
}

// Whatever a page says, the server answers by a code and goes on.
async function malformed_messages_end_one_connection() {
  const bad = ["", "{", "[]", "null", "{}", '{"op":5}', '{"op":"fly"}', '{"op":"ask","id":-1,"what":"explain"}',
    '{"op":"ask","id":1,"what":"steal","a":"x","b":"y"}', '{"op":"view","at":[1,2]}', '{"op":"view","at":[1,2,1e13]}',
    '{"op":"subscribe","rate_hz":0}', '{"op":"subscribe","rate_hz":"fast"}', '{"op":"seen","number":"-1"}',
    '{"op":"subscribe"}}', `{"op":"hello","token":"${"a".repeat(200)}"}`, "\u0000\u0001", '{"op":"view","at":[[1,2,3]]}'];
  for (const message of bad) {
    const s = await known(null);
    s.send(message);
    await s.until(`the end after ${message}`, () => s.closed || (message === "" && s.frames.some((f) => f.kind === 7)));
    check(`code after ${message}`, message === "" || [4400, 1007].includes(s.closed.code), JSON.stringify(s.closed));
    s.close();
  }
  const long = await known(null);
  long.raw(1, Buffer.alloc(4096, 32), false);
  long.raw(0, Buffer.alloc(4096, 32), true);
  await long.until("the end", () => long.closed);
  equal("a long message", long.closed.code, 1009);
  check("the server lives", server.exitCode === null);
}

// A page that reads nothing: its memory is bounded, and another page's frames come as before.
async function a_slow_reader_hurts_nobody() {
  const resident = () => Number(fs.readFileSync(`/proc/${server.pid}/statm`, "utf8").split(" ")[1]) * 4096;
  const other = await known();
  await other.next(4);
  const before = resident();
  const slow = await known();
  slow.socket.pause();
  let frames = 0;
  await other.until("three hundred frames of poses", () => {
    frames += other.frames.filter((f) => f.kind === 4).length;
    other.frames.length = 0;
    return frames > 300;
  }, 60000);
  check("memory of a slow reader", resident() - before < 9 << 20, `${resident() - before} bytes`);
  slow.close();
  other.close();
}

// What a page draws is what it is sent: one that tells that it has seen nothing gets three frames of poses.
async function who_tells_what_it_draws_gets_no_more() {
  const s = await known({ contacts: false, events: false });
  s.send({ op: "seen", number: "0" });
  const frame = await s.next(4);
  await s.next(7);
  await s.next(7);
  await s.next(7);
  const unseen = s.frames.filter((f) => f.kind === 4);
  check("no more than three or so wait", unseen.length <= 8, `${unseen.length}`);
  const last = unseen.at(-1) ?? frame;
  s.frames.length = 0;
  s.send({ op: "seen", number: String(last.number) });
  const next = await s.next(4);
  check("what was left out is counted", next.skipped > 0, `${next.skipped}`);
  s.close();
}

async function the_origin_follows_the_view() {
  const s = await known({ contacts: false });
  const bodies = await scene(s, "vehicle");
  s.send({ op: "view", at: [10000.4, -5, 0] });
  const f = await s.next(4, (x) => x.origin[0] === 10000);
  equal("all poses come with a new origin", f.all, 1);
  const at = f.poses[f.ids.indexOf(bodies.get("table")?.id ?? bodies.get("vehicle").id)];
  check("positions are relative to it", at[0] < -9000, String(at));
  s.close();
}

// The promise: nobody looks, nothing is asked of the daemon.
async function nobody_looks_and_nothing_is_asked() {
  const subscriptions = () => Number(/"subscriptions":\s*(\d+)/.exec(ctl("--timeout", "5", "status", "--json").stdout)?.[1]);
  await until("no subscription is left", async () => subscriptions() === 0);
  const s = await known();
  await s.next(4);
  await until("two are there", async () => subscriptions() === 2);
  s.close();
  await until("they go", async () => subscriptions() === 0);
}

async function a_stopped_publisher_is_unknown_within_its_deadline() {
  const s = await known();
  const bodies = await scene(s, "vehicle");
  await s.next(4);
  process.kill(vehicle.pid, "SIGSTOP");
  const id = bodies.get("vehicle").id;
  const stale = await s.next(4, (f) => f.ids.includes(id) && (f.poses[f.ids.indexOf(id)][3] & 1) === 1);
  check("it is told", stale.ids.includes(id));
  await s.next(5, (f) => f.contacts.some((c) => c.kind === 6 && c.lo === -Infinity && c.hi === Infinity));
  process.kill(vehicle.pid, "SIGCONT");
  await s.next(4, (f) => f.ids.includes(id) && (f.poses[f.ids.indexOf(id)][3] & 1) === 0);
  s.close();
}

async function a_killed_daemon_is_told_and_its_successor_followed() {
  const s = await known();
  await scene(s, "vehicle");
  daemon.kill("SIGKILL");
  await daemon.ended;
  await s.next(7, (f) => !f.json.connected && f.json.health === "silent", 30000);
  start("collided", "--links", uri, "--heartbeat", "0.2");
  s.frames.length = 0;
  const hello = await s.next(1, () => true, 30000);
  check("another epoch", hello.json.epoch !== s.hello.epoch);
  await scene(s, "vehicle", "table");
  s.close();
}

async function it_ends_in_order() {
  const s = await known();
  await s.next(4);
  server.kill("SIGTERM");
  const { code } = await server.ended;
  equal("exit status", code, 0);
  await s.until("the connection is over", () => s.closed);
}

console.log(`domain ${domain}`);
await run([the_page_comes_with_its_guards, host_origin_and_token, frames_are_as_the_page_on_the_protocol_says,
  answers_are_those_of_collidectl, malformed_messages_end_one_connection, who_tells_what_it_draws_gets_no_more,
  the_origin_follows_the_view, nobody_looks_and_nothing_is_asked, a_slow_reader_hurts_nobody,
  a_stopped_publisher_is_unknown_within_its_deadline, a_killed_daemon_is_told_and_its_successor_followed,
  it_ends_in_order]);
