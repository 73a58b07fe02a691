// fake: a server of collided.web.v1 that a test has in hand: it serves the built page, sends the frames that the test makes,
// and keeps what the page says. Written by PROTOCOL.md, not by the page's code.
import { createServer } from "node:http";
import { readFileSync, existsSync } from "node:fs";
import { join } from "node:path";
import { WebSocketServer } from "ws";

/** Octets, one array behind the other, each at a multiple of 8. */
class Octets {
  parts = [];
  size = 0;
  put(array) {
    const b = Buffer.from(array.buffer, array.byteOffset, array.byteLength);
    this.parts.push(b, Buffer.alloc(-b.length & 7));
    this.size += (b.length + 7) & ~7;
    return this;
  }
  u32(...x) { return this.put(Uint32Array.from(x)); }
  f64(...x) { return this.put(Float64Array.from(x)); }
}

export function frame(kind, tick, stamp, number, body) {
  const head = Buffer.alloc(32);
  head.writeUInt16LE(0xc011, 0);
  head[2] = kind;
  head[3] = 1;
  head.writeUInt32LE(32 + body.size, 4);
  head.writeBigUInt64LE(BigInt(tick), 8);
  head.writeBigInt64LE(BigInt(stamp), 16);
  head.writeBigUInt64LE(BigInt(number), 24);
  return Buffer.concat([head, ...body.parts]);
}

export function json(value) {
  const text = Buffer.from(JSON.stringify(value));
  return new Octets().put(Buffer.concat([text, Buffer.alloc(-text.length & 7, " ")]));
}

const NONE = 0xffffffff;

/** Bodies: { id, name, group, owner, flags, deadline, pose, shapes: [{ type, half, radius, pose, geometry }] }. */
export function scene(revision, bodies, { everything = true, gone = [], geometries = [] } = {}) {
  const strings = [];
  let at = 0, shapeCount = 0;
  const text = (s) => {
    const b = Buffer.from(s);
    strings.push(b);
    at += b.length;
    return [at - b.length, b.length];
  };
  const body = Buffer.alloc(104 * bodies.length), shapes = [];
  bodies.forEach((b, i) => {
    const o = 104 * i;
    [b.id, b.flags ?? 0, shapeCount, b.shapes.length, ...text(b.name), ...text(b.group ?? ""), ...text(b.owner ?? "test")]
      .forEach((x, k) => body.writeUInt32LE(x, o + 4 * k));
    body.writeDoubleLE(b.deadline ?? 0, o + 40);
    b.pose.forEach((x, k) => body.writeDoubleLE(x, o + 48 + 8 * k));
    b.shapes.forEach((s, k) => {
      const d = Buffer.alloc(112);
      [s.type, s.geometry ?? NONE, k, NONE].forEach((x, j) => d.writeUInt32LE(x, 4 * j));
      [...s.half, s.radius ?? 0, 0, ...(s.pose ?? [0, 0, 0, 1, 0, 0, 0])].forEach((x, j) => d.writeDoubleLE(x, 16 + 8 * j));
      shapes.push(d);
    });
    shapeCount += b.shapes.length;
  });
  const g = Buffer.alloc(24 * geometries.length);
  geometries.forEach(({ number, kind }, i) => { g.writeUInt32LE(number, 24 * i); g.writeUInt32LE(kind, 24 * i + 4); });
  return new Octets().u32(revision, everything ? 1 : 0, gone.length, bodies.length, shapeCount, geometries.length, at, 0)
    .put(Uint32Array.from(gone)).put(body).put(Buffer.concat(shapes)).put(g).put(Buffer.concat(strings));
}

export function geometry(number, kind, numbers, indices, question) {
  return new Octets().u32(number, kind, numbers.length, indices.length, question, 0).put(Float64Array.from(numbers))
    .put(Uint32Array.from(indices));
}

/** Poses: [id, flags, pose]. */
export function poses(list, origin = [0, 0, 0], { skipped = 0, revision = 1 } = {}) {
  const values = new Float32Array(8 * list.length);
  list.forEach(([, flags, p], i) => values.set([p[0] - origin[0], p[1] - origin[1], p[2] - origin[2], flags, p[3], p[4], p[5], p[6]], 8 * i));
  return new Octets().f64(...origin).u32(list.length, 1, skipped, revision).put(Uint32Array.from(list.map((x) => x[0]))).put(values);
}

const contactDefaults = { tick: 1, closing: 0, ageA: 0.001, ageB: 0.001, loS: NaN, hiS: NaN, start: 0, shapeA: 0, shapeB: 0, fact: 4, achieved: 0, marks: 2 };
export function contacts(list, { everything = true, gone = [], skipped = 0 } = {}) {
  const all = list.map((c) => ({ ...contactDefaults, ...c })), o = new Octets().u32(all.length, gone.length, everything ? 1 : 0, skipped, all.length, 0);
  o.put(BigInt64Array.from(gone.map(BigInt))).put(BigInt64Array.from(all.map((c) => BigInt(c.id)))).put(BigInt64Array.from(all.map((c) => BigInt(c.tick))));
  for (const k of ["lo", "hi", "closing", "ageA", "ageB", "loS", "hiS"]) o.put(Float64Array.from(all.map((c) => c[k])));
  o.put(BigInt64Array.from(all.map((c) => BigInt(c.start))));
  for (const k of ["axis", "pointA", "pointB", "poseA", "poseB"]) o.put(Float64Array.from(all.flatMap((c) => c[k])));
  for (const k of ["a", "b", "shapeA", "shapeB"]) o.put(Uint32Array.from(all.map((c) => c[k])));
  for (const k of ["fact", "achieved", "marks"]) o.put(Uint8Array.from(all.map((c) => c[k])));
  return o;
}

export function events(first, list, missed = 0) {
  const d = Buffer.alloc(120 * list.length), head = new Octets().put(BigUint64Array.from([BigInt(first)])).u32(list.length, missed);
  list.forEach((e, i) => {
    const o = 120 * i;
    [e.id ?? 1, e.tick ?? 1, e.stamp].forEach((x, k) => d.writeBigInt64LE(BigInt(x), o + 8 * k));
    [e.lo ?? 0, e.hi ?? 0, 0, 0, 0, NaN, NaN].forEach((x, k) => d.writeDoubleLE(x, o + 24 + 8 * k));
    [e.a, e.b, 0, 0].forEach((x, k) => d.writeUInt32LE(x, o + 88 + 4 * k));
    d[o + 104] = e.kind;
  });
  return head.put(d);
}

const types = { html: "text/html; charset=utf-8", js: "text/javascript", css: "text/css", wasm: "application/wasm", txt: "text/plain" };
const policy = (host) => `default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; img-src 'self' data: blob:; ` +
  `connect-src 'self' ws://${host}; worker-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'`;

export class Fake {
  epoch = "1";
  token = "";
  said = [];
  sockets = new Set();
  stamp = BigInt(Date.now()) * 1000000n;
  tick = 0;
  /** Called with each message of the page, beside what is answered here. */
  onMessage = () => {};
  opening = () => [];

  constructor(root) {
    this.http = createServer((request, reply) => {
      const name = request.url === "/" ? "index.html" : request.url.slice(1), file = join(root, name);
      if (!/^[a-zA-Z-]+\.[a-z]+$/.test(name) || !existsSync(file)) return reply.writeHead(404).end();
      reply.writeHead(200, { "content-type": types[name.split(".").pop()], "content-security-policy": policy(request.headers.host) });
      reply.end(readFileSync(file));
    });
    this.ws = new WebSocketServer({ server: this.http, path: "/ws", perMessageDeflate: false });
    this.ws.on("connection", (socket) => this.#greet(socket));
  }
  async listen() {
    await new Promise((ok) => this.http.listen(0, "127.0.0.1", ok));
    this.port = this.http.address().port;
    this.url = `http://127.0.0.1:${this.port}/`;
  }
  close() {
    for (const s of this.sockets) s.terminate();
    this.http.close();
    this.http.closeAllConnections();
  }
  #greet(socket) {
    socket.number = 0;
    socket.on("close", () => this.sockets.delete(socket));
    socket.on("message", (data) => {
      const m = JSON.parse(data.toString());
      this.said.push(m);
      if (m.op === "hello") {
        if (m.token !== this.token) return socket.close(4401, "token");
        this.sockets.add(socket);
        this.hello(socket);
        for (const [kind, body] of this.opening()) this.sendTo(socket, kind, body);
      }
      this.onMessage(m, socket);
    });
  }
  hello(socket) {
    this.sendTo(socket, 1, json({ protocol: "collided.web.v1", release: "0.1.0", connected: true, epoch: this.epoch, daemon: "fake", uri: "dds://0",
      rate_hz: 30, range_m: 0.5, horizon_s: 1, control: false, recording: null, causes: ["motion"] }));
  }
  sendTo(socket, kind, body) { socket.send(frame(kind, this.tick, this.stamp, ++socket.number, body)); }
  send(kind, body) { for (const s of this.sockets) this.sendTo(s, kind, body); }
  status(more = {}) {
    return json({ connected: true, health: "ready", limits: "", daemon: "fake", release: "0.1.0", links: "", epoch: this.epoch, started_ns: "0",
      counters: { pairs_by_gjk: 5, reject_old_pose: 2, "events_of_s": 7, "client_name_00000000000000ab_robot": 1, tick_p50_ns: 1000, tick_p90_ns: 1500, tick_p99_ns: 2000, tick_most_ns: 3000 },
      web: {}, playback: null, ...more });
  }
}

/** A ball and a box 0.3 m apart along x, as the daemon would tell of them, at `far` m from the origin. */
export function ballAndBox(far = 0) {
  const ball = { id: 1, name: "ball", owner: "left", pose: [far - 0.5, 0, 0.2, 1, 0, 0, 0], shapes: [{ type: 0, half: [0, 0, 0], radius: 0.2 }] };
  const box = { id: 2, name: "box", owner: "right", pose: [far + 0.25, 0, 0.2, 1, 0, 0, 0], shapes: [{ type: 2, half: [0.25, 0.2, 0.1] }] };
  const pair = { id: 7, a: 1, b: 2, lo: 0.3 - 1e-9, hi: 0.3 + 1e-9, axis: [1, 0, 0], pointA: [far - 0.3, 0, 0.2], pointB: [far, 0, 0.2], poseA: ball.pose, poseB: box.pose };
  return { ball, box, pair };
}
