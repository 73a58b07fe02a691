#!/usr/bin/env node
// A client of collided without its library: a ball swings through a block over LCM, and what touches is printed.
//
//     ./plain_client.mjs collided.lcm [PORT]      (Node 18; nothing else is needed: the definitions are read as they stand)
//
// What the messages mean: ../README.md. Datagrams of LCM: "LC02", a number, the channel, a zero octet, the message.
import { createSocket } from "node:dgram";
import { randomBytes } from "node:crypto";
import { readFileSync } from "node:fs";

const [GROUP, PORT] = ["239.255.76.67", Number(process.argv[3] ?? 7667)];
const text = readFileSync(process.argv[2], "ascii").replace(/\/\/.*/g, "");
const types = {}; // by message: its fields, each a type, a name, and for an array the field that has its length
for (const [, name, body] of text.matchAll(/struct (\w+)\s*\{([^]*?)\n\}/g))
  types[name] = [...body.matchAll(/^\s*(\w+) (\w+)(?:\[(\w+)\])?;/gm)].map(([, type, field, length]) => ({ type, field, length }));
const constant = (name) => Number(text.match(new RegExp(`\\b${name} = (\\d+)`))[1]);

/** LCM's hash of a definition, with which each of its messages begins. */
function fingerprint(name) {
  let v = 0x12345678n;
  const add = (octet) => (v = BigInt.asIntN(64, ((v << 8n) ^ (v >> 55n)) + BigInt(octet)));
  const word = (w) => [w.length, ...Buffer.from(w)].forEach(add);
  for (const { type, field, length } of types[name]) {
    [field, type].forEach(word);
    length ? ([1, 1].forEach(add), word(length)) : add(0); // how many dimensions, and that the length of one varies
  }
  return BigInt.asUintN(64, (v << 1n) | BigInt.asUintN(1, v >> 63n));
}
const size = { byte: 1, int32_t: 4, int64_t: 8, double: 8 };
const write = { byte: "writeUInt8", int32_t: "writeInt32BE", int64_t: "writeBigInt64BE", double: "writeDoubleBE" };

function encode(name, values) {
  const number = (type, value) => {
    const octets = Buffer.alloc(size[type]);
    octets[write[type]](type === "int64_t" ? BigInt(value) : value);
    return octets;
  };
  const one = (type, v) => type === "string" ? Buffer.concat([number("int32_t", Buffer.byteLength(v) + 1), Buffer.from(v + "\0")]) : number(type, v);
  const head = Buffer.alloc(8);
  head.writeBigUInt64BE(fingerprint(name));
  const parts = types[name].map(({ type, field, length }) => {
    const counts = types[name].find((of) => of.length === field); // of an array: its length is written for it
    const value = counts ? (values[counts.field] ?? []).length : values[field] ?? (length ? [] : type === "string" ? "" : 0);
    return Buffer.concat((length ? value : [value]).map((v) => one(type, v)));
  });
  return Buffer.concat([head, ...parts]);
}

function decode(name, data) {
  if (data.readBigUInt64BE(0) !== fingerprint(name)) throw new Error(`a ${name} of another definition`);
  let at = 8;
  const number = (type) => data[write[type].replace("write", "read")]((at += size[type]) - size[type]);
  const string = () => { const n = number("int32_t"); return data.toString("utf8", at, (at += n) - 1); };
  const values = {};
  for (const { type, field, length } of types[name]) {
    const one = () => (type === "string" ? string() : number(type));
    values[field] = length ? Array.from({ length: values[length] }, one) : one();
  }
  return values;
}

const me = randomBytes(8).readBigInt64BE() | 1n, mine = BigInt.asUintN(64, me).toString(16).padStart(16, "0");
let sequence = BigInt(Date.now()) * 1000n, datagrams = 0; // of messages of all kinds, ever growing
let last = 0n; // the newest batch that was read
const waiting = new Map(); // by sequence: what is neither acknowledged nor refused
const wire = createSocket({ type: "udp4", reuseAddr: true, recvBufferSize: 4 << 20 });

function send(name, message) {
  const head = Buffer.from(`LC02\0\0\0\0collided.in.${name}\0`);
  head.writeUInt32BE(datagrams++, 4);
  wire.send(Buffer.concat([head, message]), PORT, GROUP);
}
const fill = (name, values) => encode(name, { version: 1, client_id: me, sequence: ++sequence, ...values });

/** Sends a message again and again until its Ack or Reject comes: LCM loses datagrams. */
function announce(name, values) {
  const message = fill(name, values), number = sequence;
  const again = (wait) => { send(name, message); waiting.set(number, setTimeout(again, wait, Math.min(2 * wait, 1000))); };
  again(50);
}
const settled = (number) => (clearTimeout(waiting.get(number)), waiting.delete(number));

const subscribe = () => announce("Subscription", { subscription_id: 1, facts: constant("FACT_TOUCH"), select_a: "*", select_b: "*" });
const [BEGIN, END] = ["EVENT_BEGIN", "EVENT_END"].map(constant);
wire.on("message", (data) => {
  const end = data.indexOf(0, 8), channel = data.toString("latin1", 8, end), message = data.subarray(end + 1);
  if (channel === `collided.out.Ack.${mine}`) decode("Ack", message).sequences.forEach(settled);
  if (channel === `collided.out.Reject.${mine}`) {
    const reject = decode("Reject", message);
    settled(reject.sequence);
    console.error("refused:", reject.text);
  }
  if (channel !== `collided.out.EventBatch.${mine}.1`) return;
  const batch = decode("EventBatch", message);
  if (batch.batch > last + (batch.heartbeat ? 0n : 1n) && !batch.snapshot) {
    console.log(`lost: batches after ${last}`);
    subscribe(); // anew: a snapshot comes
  }
  last = batch.batch;
  batch.kinds.forEach((kind, i) => {
    if (kind !== BEGIN && kind !== END) return;
    console.log(kind === BEGIN ? "begin" : "end", batch.names_a[i], batch.names_b[i], batch.lo[i].toFixed(6), batch.hi[i].toFixed(6));
  });
});

function create(body_id, name, motion, kind, shape_sizes, radius) {
  const here = [0, 0, 0, 1, 0, 0, 0]; // position, and a quaternion (w, x, y, z)
  announce("Body", { body_id, name, motion: constant(motion), category: 1, mask: -1, pose: here, shape_types: [constant(kind)],
    shape_sizes, shape_radii: [radius], shape_poses: here, shape_geometries: [0] });
}
wire.bind(PORT, GROUP, () => {
  wire.setMulticastTTL(0); // nothing leaves the machine
  wire.addMembership(GROUP);
  const hello = () => announce("Client", { name: "plain", lease_ns: 2e9 });
  hello();
  create(1, "ball", "MOTION_MOVING", "SHAPE_SPHERE", [0, 0, 0], 0.05);
  create(2, "block", "MOTION_FIXED", "SHAPE_BOX", [0.2, 0.2, 0.2], 0);
  subscribe();
  const begun = performance.now(), heartbeat = setInterval(hello, 600); // under a new sequence, every third of the lease
  let known = false; // once all is acknowledged: poses of a body that is not known yet are refused
  const moving = setInterval(() => {
    const seconds = (performance.now() - begun) / 1000;
    known ||= waiting.size === 0;
    if (seconds < 6) {
      if (known)
        send("PoseBatch", fill("PoseBatch", { stamp_ns: BigInt(Date.now()) * 1000000n, bodies: [1],
          positions: [Math.cos(2 * seconds), 0, 0], orientations: [1, 0, 0, 0] }));
      return;
    }
    [heartbeat, moving].forEach(clearInterval);
    [...waiting.keys()].forEach(settled);
    send("Client", fill("Client", { removed: 1, name: "plain" }));
    setTimeout(() => wire.close(), 50);
  }, 10);
});
