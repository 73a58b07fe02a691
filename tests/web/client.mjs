// client: a WebSocket client of the tests, on net alone, so that they need no package: it can be as impolite as a test
// wants. And what the frames of collided.web.v1 say, read by PROTOCOL.md and not by the page's code.
import net from "node:net";
import crypto from "node:crypto";

export class Socket {
  constructor(port, { host = "127.0.0.1", headers = {}, path = "/ws", protocol = "collided.web.v1" } = {}) {
    this.frames = [];
    this.waiters = [];
    this.closed = null;
    this.buffer = Buffer.alloc(0);
    this.head = null;
    this.socket = net.connect(port, host);
    const key = crypto.randomBytes(16).toString("base64");
    const all = { Host: `127.0.0.1:${port}`, Upgrade: "websocket", Connection: "Upgrade", "Sec-WebSocket-Key": key,
      "Sec-WebSocket-Version": "13", ...(protocol ? { "Sec-WebSocket-Protocol": protocol } : {}), ...headers };
    const lines = Object.entries(all).filter(([, v]) => v !== null).map(([k, v]) => `${k}: ${v}\r\n`).join("");
    this.socket.write(`GET ${path} HTTP/1.1\r\n${lines}\r\n`);
    this.socket.on("data", (d) => this.#take(d));
    this.socket.on("error", () => this.#end(1006, "error"));
    this.socket.on("close", () => this.#end(1006, ""));
    this.opened = new Promise((ok) => (this.onhead = ok));
  }

  #end(code, reason) {
    if (!this.closed) this.closed = { code, reason };
    this.onhead?.(this.head || 0);
    this.#wake();
  }

  #wake() {
    for (const w of this.waiters.splice(0)) w();
  }

  #take(data) {
    this.buffer = Buffer.concat([this.buffer, data]);
    if (this.head === null) {
      const end = this.buffer.indexOf("\r\n\r\n");
      if (end < 0) return;
      this.text = this.buffer.subarray(0, end).toString();
      this.head = Number(this.text.split(" ")[1]);
      this.buffer = this.buffer.subarray(end + 4);
      this.onhead(this.head);
    }
    if (this.head !== 101) return;
    for (;;) {
      if (this.buffer.length < 2) return;
      let size = this.buffer[1] & 127, at = 2;
      if (size === 126 && this.buffer.length >= 4) [size, at] = [this.buffer.readUInt16BE(2), 4];
      else if (size === 127 && this.buffer.length >= 10) [size, at] = [Number(this.buffer.readBigUInt64BE(2)), 10];
      else if (size > 125) return;
      if (this.buffer.length < at + size) return;
      const opcode = this.buffer[0] & 15, payload = this.buffer.subarray(at, at + size);
      this.buffer = this.buffer.subarray(at + size);
      if (opcode === 8) {
        this.closed = { code: payload.length > 1 ? payload.readUInt16BE(0) : 1005, reason: payload.subarray(2).toString() };
        this.#wake();
      } else if (opcode === 2) {
        this.frames.push(read(payload));
        this.#wake();
      }
    }
  }

  raw(opcode, payload, final = true) {
    const size = payload.length, mask = crypto.randomBytes(4);
    const head = size < 126 ? [0x80 | size] : [0x80 | 126, size >> 8, size & 255];
    const masked = Buffer.from(payload.map((b, i) => b ^ mask[i & 3]));
    this.socket.write(Buffer.concat([Buffer.from([(final ? 0x80 : 0) | opcode, ...head]), mask, masked]));
  }

  send(message) {
    this.raw(1, Buffer.from(typeof message === "string" ? message : JSON.stringify(message)));
  }

  async until(what, fits, ms = 20000) {
    const ends = Date.now() + ms;
    for (;;) {
      const found = fits(this);
      if (found) return found;
      if (Date.now() > ends) throw new Error(`${what}: not within ${ms} ms; ${this.frames.length} frames, closed: ` +
        JSON.stringify(this.closed));
      await new Promise((ok) => { this.waiters.push(ok); setTimeout(ok, 50); });
    }
  }

  next(kind, fits = () => true, ms) {
    return this.until(`a frame of kind ${kind}`, () => {
      const i = this.frames.findIndex((f) => f.kind === kind && fits(f));
      return i < 0 ? null : this.frames.splice(i, 1)[0];
    }, ms);
  }

  close() {
    this.socket.destroy();
  }
}

export function read(payload) {
  const bytes = new Uint8Array(payload.length);
  bytes.set(payload);
  const v = new DataView(bytes.buffer);
  const f = { kind: v.getUint8(2), version: v.getUint8(3), size: v.getUint32(4, true), tick: v.getBigUint64(8, true),
    stamp: v.getBigInt64(16, true), number: v.getBigUint64(24, true), magic: v.getUint16(0, true), octets: bytes.length };
  if ([1, 7, 8].includes(f.kind)) f.json = JSON.parse(Buffer.from(bytes.buffer, 32).toString());
  if (f.kind === 2) Object.assign(f, readScene(v, bytes.buffer));
  if (f.kind === 3) Object.assign(f, readGeometry(v, bytes.buffer));
  if (f.kind === 4) Object.assign(f, readPoses(v, bytes.buffer));
  if (f.kind === 5) Object.assign(f, readContacts(v, bytes.buffer));
  if (f.kind === 6) Object.assign(f, readEvents(v));
  return f;
}

const padded = (n) => Math.ceil(n / 8) * 8;
const doubles = (v, at, n) => Array.from({ length: n }, (_, i) => v.getFloat64(at + 8 * i, true));

function readScene(v, buffer) {
  const [revision, all, r, n, m, g, octets] = [32, 36, 40, 44, 48, 52, 56].map((at) => v.getUint32(at, true));
  const gone = Array.from({ length: r }, (_, i) => v.getUint32(64 + 4 * i, true));
  const bodiesAt = 64 + padded(4 * r), shapesAt = bodiesAt + 104 * n, geometriesAt = shapesAt + 112 * m;
  const strings = geometriesAt + 24 * g;
  if (padded(strings + octets) !== buffer.byteLength) throw new Error("a scene is of another length");
  const text = (at) => Buffer.from(buffer, strings + v.getUint32(at, true), v.getUint32(at + 4, true)).toString();
  const shape = (i) => {
    const at = shapesAt + 112 * i;
    return { type: v.getUint32(at, true), geometry: v.getUint32(at + 4, true), number: v.getUint32(at + 8, true),
      parent: v.getUint32(at + 12, true), half: doubles(v, at + 16, 3), radius: v.getFloat64(at + 40, true),
      deviation: v.getFloat64(at + 48, true), pose: doubles(v, at + 56, 7) };
  };
  const bodies = Array.from({ length: n }, (_, i) => {
    const at = bodiesAt + 104 * i, first = v.getUint32(at + 8, true);
    return { id: v.getUint32(at, true), flags: v.getUint32(at + 4, true), name: text(at + 16), group: text(at + 24),
      owner: text(at + 32), deadline: v.getFloat64(at + 40, true), pose: doubles(v, at + 48, 7),
      shapes: Array.from({ length: v.getUint32(at + 12, true) }, (_, k) => shape(first + k)) };
  });
  const geometries = Array.from({ length: g }, (_, i) => ({ number: v.getUint32(geometriesAt + 24 * i, true),
    kind: v.getUint32(geometriesAt + 24 * i + 4, true), hash: v.getBigInt64(geometriesAt + 24 * i + 8, true) }));
  return { revision, all, gone, bodies, geometries };
}

function readGeometry(v, buffer) {
  const [number, type, vertices, indices, question] = [32, 36, 40, 44, 48].map((at) => v.getUint32(at, true));
  return { geometry: number, type, question, vertices: doubles(v, 56, vertices),
    indices: Array.from(new Uint32Array(buffer, 56 + 8 * vertices, indices)) };
}

function readPoses(v, buffer) {
  const n = v.getUint32(56, true), at = 72 + padded(4 * n);
  const ids = new Uint32Array(buffer, 72, n), numbers = new Float32Array(buffer, at, 8 * n);
  return { origin: doubles(v, 32, 3), all: v.getUint32(60, true), skipped: v.getUint32(64, true),
    revision: v.getUint32(68, true), ids: Array.from(ids), poses: Array.from(ids, (_, i) => Array.from(numbers.subarray(8 * i, 8 * i + 8))) };
}

function readContacts(v, buffer) {
  const [n, r, all, skipped, total, left] = [32, 36, 40, 44, 48, 52].map((at) => v.getUint32(at, true));
  let at = 56;
  const gone = Array.from({ length: r }, (_, i) => v.getBigInt64(at + 8 * i, true));
  at += 8 * r;
  const column = (size) => { const from = at; at += padded(size * n); return from; };
  const c = { id: column(8), tick: column(8), lo: column(8), hi: column(8), closing: column(8), ageA: column(8),
    ageB: column(8), loS: column(8), hiS: column(8), start: column(8), axis: column(24), pointA: column(24),
    pointB: column(24), poseA: column(56), poseB: column(56), a: column(4), b: column(4), shapeA: column(4),
    shapeB: column(4), kind: column(1), achieved: column(1), flags: column(1) };
  if (at !== buffer.byteLength) throw new Error("contacts are of another length");
  const f64 = (from, i) => v.getFloat64(from + 8 * i, true), u32 = (from, i) => v.getUint32(from + 4 * i, true);
  const contacts = Array.from({ length: n }, (_, i) => ({ id: v.getBigInt64(c.id + 8 * i, true),
    tick: v.getBigInt64(c.tick + 8 * i, true), lo: f64(c.lo, i), hi: f64(c.hi, i), closing: f64(c.closing, i),
    ageA: f64(c.ageA, i), ageB: f64(c.ageB, i), loS: f64(c.loS, i), hiS: f64(c.hiS, i),
    axis: doubles(v, c.axis + 24 * i, 3), pointA: doubles(v, c.pointA + 24 * i, 3), pointB: doubles(v, c.pointB + 24 * i, 3),
    poseA: doubles(v, c.poseA + 56 * i, 7), poseB: doubles(v, c.poseB + 56 * i, 7), a: u32(c.a, i), b: u32(c.b, i),
    shapeA: u32(c.shapeA, i), shapeB: u32(c.shapeB, i), kind: v.getUint8(c.kind + i), achieved: v.getUint8(c.achieved + i),
    flags: v.getUint8(c.flags + i) }));
  return { all, skipped, total, left, gone, contacts };
}

function readEvents(v) {
  const n = v.getUint32(40, true);
  return { first: v.getBigUint64(32, true), missed: v.getUint32(44, true), events: Array.from({ length: n }, (_, i) => {
    const at = 48 + 120 * i;
    return { contact: v.getBigInt64(at, true), lo: v.getFloat64(at + 24, true), hi: v.getFloat64(at + 32, true),
      a: v.getUint32(at + 88, true), b: v.getUint32(at + 92, true), kind: v.getUint8(at + 104),
      cause: v.getUint8(at + 105), snapshot: v.getUint32(at + 108, true) };
  }) };
}
