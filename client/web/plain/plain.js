// plain: the world as tables, read from collided.web.v1 (PROTOCOL.md) without a library. Names are put in as text alone.
"use strict";
const bodies = new Map(), contacts = new Map(), events = [];
let hello = { event_kinds: [], causes: [] }, status = {}, dirty = true;
const text = new TextDecoder();

function names(view, at, strings) {
  return text.decode(new Uint8Array(view.buffer, strings + view.getUint32(at, true), view.getUint32(at + 4, true)));
}

function takeScene(view) {
  const [all, gone, count, shapes, geometries] = [36, 40, 44, 48, 52].map((at) => view.getUint32(at, true));
  if (all) bodies.clear();
  for (let i = 0; i < gone; i++) bodies.delete(view.getUint32(64 + 4 * i, true));
  const first = 64 + Math.ceil((4 * gone) / 8) * 8, strings = first + 104 * count + 112 * shapes + 24 * geometries;
  for (let i = 0; i < count; i++) {
    const at = first + 104 * i;
    bodies.set(view.getUint32(at, true), {
      flags: view.getUint32(at + 4, true), shapes: view.getUint32(at + 12, true),
      name: names(view, at + 16, strings), group: names(view, at + 24, strings), owner: names(view, at + 32, strings),
      position: [0, 1, 2].map((k) => view.getFloat64(at + 48 + 8 * k, true)) });
  }
}

function takePoses(view) {
  const origin = [0, 1, 2].map((k) => view.getFloat64(32 + 8 * k, true)), n = view.getUint32(56, true);
  const poses = 72 + Math.ceil((4 * n) / 8) * 8;
  for (let i = 0; i < n; i++) {
    const body = bodies.get(view.getUint32(72 + 4 * i, true));
    if (!body) continue;
    body.position = origin.map((o, k) => o + view.getFloat32(poses + 32 * i + 4 * k, true));
    body.flags = view.getFloat32(poses + 32 * i + 12, true);
  }
}

function takeContacts(view) {
  const n = view.getUint32(32, true), gone = view.getUint32(36, true);
  if (view.getUint32(40, true)) contacts.clear();
  for (let i = 0; i < gone; i++) contacts.delete(view.getBigInt64(56 + 8 * i, true));
  let at = 56 + 8 * gone;
  const column = (size) => { const from = at; at += Math.ceil((size * n) / 8) * 8; return from; };
  const id = column(8), tick = column(8), lo = column(8), hi = column(8), closing = column(8), ageA = column(8);
  const ageB = column(8), loS = column(8), hiS = column(8), start = column(8);
  column(24), column(24), column(24), column(56), column(56);
  const a = column(4), b = column(4), shapeA = column(4), shapeB = column(4), kind = column(1);
  for (let i = 0; i < n; i++) {
    const f64 = (from) => view.getFloat64(from + 8 * i, true);
    contacts.set(view.getBigInt64(id + 8 * i, true), { lo: f64(lo), hi: f64(hi), closing: f64(closing),
      age: Math.max(f64(ageA), f64(ageB)), loS: f64(loS), a: view.getUint32(a + 4 * i, true),
      b: view.getUint32(b + 4 * i, true), kind: view.getUint8(kind + i) });
  }
}

function takeEvents(view) {
  const n = view.getUint32(40, true), missed = view.getUint32(44, true);
  if (missed) events.push({ what: `${missed} events missed`, a: "", b: "", lo: NaN, time: "" });
  for (let i = 0; i < n; i++) {
    const at = 48 + 120 * i, kind = view.getUint8(at + 104);
    const name = (place) => (bodies.get(view.getUint32(place, true)) || { name: "" }).name;
    events.push({ time: new Date(Number(view.getBigInt64(at + 16, true) / 1000000n)).toISOString().slice(11, 23),
      what: kind === 255 ? `${view.getBigInt64(at, true)} batches were lost` : hello.event_kinds[kind] || `kind ${kind}`,
      a: name(at + 88), b: name(at + 92), lo: view.getFloat64(at + 24, true) });
  }
  events.splice(0, events.length - 50);
}

function json(buffer) {
  return JSON.parse(text.decode(new Uint8Array(buffer, 32)));
}

function take(buffer) {
  const view = new DataView(buffer), kind = view.getUint8(2);
  if (view.getUint16(0, true) !== 0xc011) return;
  if (kind === 1) { hello = json(buffer); bodies.clear(); contacts.clear(); }
  if (kind === 2) takeScene(view);
  if (kind === 4) takePoses(view);
  if (kind === 5) takeContacts(view);
  if (kind === 6) takeEvents(view);
  if (kind === 7) status = json(buffer);
  dirty = true;
}

function fill(id, rows) {
  document.getElementById(id).replaceChildren(...rows.map((cells) => {
    const row = document.createElement("tr");
    row.dataset.state = cells.state || "";
    for (const cell of cells) row.insertCell().textContent = cell;
    return row;
  }));
}

const number = (x, digits = 4) => (Number.isFinite(x) ? x.toFixed(digits) : "");
const states = { 1: "touching", 4: "near", 6: "unknown", 9: "will meet" };

function bodyState(flags) {
  const words = [];
  if (flags & 3) words.push("unknown: its pose is too old");
  if (flags & 4) words.push("pending");
  words.push(flags & 8 ? "fixed" : "moving");
  return words.join(", ");
}

function draw() {
  if (!dirty) return;
  dirty = false;
  const name = (id) => (bodies.get(id) || { name: "?" }).name;
  fill("pairs", [...contacts.values()].sort((x, y) => x.lo - y.lo).slice(0, 200).map((c) => Object.assign(
    [name(c.a), name(c.b), states[c.kind] || c.kind, number(c.lo, 6), number(c.hi, 6), number(c.closing, 3),
      c.age < 0 ? "" : number(c.age, 3), number(c.loS, 3)], { state: states[c.kind] })));
  fill("bodies", [...bodies.values()].slice(0, 500).map((b) =>
    [b.name, b.owner, bodyState(b.flags), b.shapes, ...b.position.map((x) => number(x))]));
  fill("events", events.slice().reverse().map((e) => [e.time, e.what, e.a, e.b, number(e.lo, 6)]));
  document.getElementById("state").textContent =
    `${status.health || "connecting"}${status.limits ? `: ${status.limits}` : ""}. ${bodies.size} bodies, ` +
    `${contacts.size} pairs; ${(status.web || {}).skipped || 0} states skipped`;
}

function connect() {
  const token = new URLSearchParams(location.hash.slice(1)).get("t") || "";
  const socket = new WebSocket(`ws://${location.host}/ws`, ["collided.web.v1"]);
  socket.binaryType = "arraybuffer";
  socket.onopen = () => {
    socket.send(JSON.stringify({ op: "hello", token }));
    socket.send(JSON.stringify({ op: "subscribe", rate_hz: 5 }));
  };
  socket.onmessage = (m) => take(m.data);
  socket.onclose = (e) => {
    status = { health: "not connected", limits: e.reason || `code ${e.code}` };
    dirty = true;
    if (e.code !== 4401) setTimeout(connect, 1000);
  };
}

setInterval(draw, 200);
connect();
