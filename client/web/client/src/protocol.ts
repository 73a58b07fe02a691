/* protocol: the frames of collided.web.v1 (../../PROTOCOL.md) as objects. Arrays are views of the frame, not copies.
 * Everything is checked against the frame's length; what does not fit is a ProtocolError. No input and no output. */

export const SUBPROTOCOL = "collided.web.v1";
export const NO_BODY = 0xffffffff;
export const NONE = 0xffffffff;

/** Kinds of frames. */
export const Kind = {
  hello: 1, scene: 2, geometry: 3, poses: 4, contacts: 5, events: 6, status: 7, answer: 8, vertices: 10,
} as const;

/** Bits of a body's flags. */
export const Flag = { stale: 1, unknown: 2, pending: 4, fixed: 8, soft: 16, swept: 32, oneWay: 64 } as const;

/** Numbers of the kinds of shapes. */
export const Shape = {
  sphere: 0, capsule: 1, box: 2, cylinder: 3, cone: 4, ellipsoid: 5, halfspace: 6, hull: 7, mesh: 8, heightField: 9,
  compound: 10,
} as const;

/** What a pair is, in a contacts frame, and what an event tells. */
export const Fact = {
  begin: 1, end: 3, near: 4, far: 5, unknown: 6, known: 7, impact: 8, predicted: 9, averted: 10, gap: 255,
} as const;

/** Names of what contacts and events tell. */
export const factNames: Readonly<Record<number, string>> = {
  1: "begin", 2: "update", 3: "end", 4: "near", 5: "far", 6: "unknown", 7: "known", 8: "impact", 9: "predicted",
  10: "averted", 255: "gap",
};
/** Names of what an interval is, beside what was asked. */
export const achievedNames = ["certain", "within", "wide", "stopped"] as const;
/** Names of the kinds of shapes. */
export const shapeNames = ["sphere", "capsule", "box", "cylinder", "cone", "ellipsoid", "half-space", "hull", "mesh",
  "height field", "compound"] as const;

/** A frame that is not one of collided.web.v1. */
export class ProtocolError extends Error {
  override name = "ProtocolError";
}

/** What each frame begins with. `tick`, `stampNs` and `number` are exact. */
export interface Header { kind: number; tick: bigint; stampNs: bigint; number: bigint }

export interface Hello extends Header {
  kind: 1; protocol: string; release: string; connected: boolean; epoch: string; daemon: string; uri: string;
  rate_hz: number; range_m: number; horizon_s: number; control: boolean;
  recording: null | { file: string; begin_ns: string; end_ns: string; ticks: number | string };
  causes: (string | null)[];
}

export interface ShapeDef {
  type: number; geometry: number; index: number; parent: number; half: [number, number, number]; radius: number;
  deviation: number; pose: Float64Array;
}
export interface BodyDef {
  id: number; flags: number; name: string; group: string; owner: string; deadlineS: number; pose: Float64Array;
  shapes: ShapeDef[];
}
export interface GeometryNote { number: number; kind: number; hash: bigint; vertexNumbers: number; indices: number }
export interface SceneFrame extends Header {
  kind: 2; revision: number; everything: boolean; gone: Uint32Array; bodies: BodyDef[]; geometries: GeometryNote[];
}
/** Geometry: of hulls three numbers a point, and faces; of meshes points and triangles; of height fields spacing of
 * columns, of rows, base, then heights, and `indices` are columns, rows. `of` is 1, 2, 3 for these; 0 = not known. */
export interface GeometryFrame extends Header {
  kind: 3; geometry: number; of: number; question: number; numbers: Float64Array; indices: Uint32Array;
  faces: Uint32Array;
}
export interface PosesFrame extends Header {
  kind: 4; origin: Float64Array; everything: boolean; skipped: number; revision: number; ids: Uint32Array;
  values: Float32Array;
}
/** Columns of the pairs that are new or have changed; three, or seven, numbers a pair where it is a vector, or pose. */
export interface ContactsFrame extends Header {
  kind: 5; count: number; everything: boolean; skipped: number; total: number; leftOut: number; gone: BigInt64Array;
  id: BigInt64Array; claimTick: BigInt64Array; lo: Float64Array; hi: Float64Array; closing: Float64Array;
  ageA: Float64Array; ageB: Float64Array; loS: Float64Array; hiS: Float64Array; startNs: BigInt64Array;
  axis: Float64Array; pointA: Float64Array; pointB: Float64Array; poseA: Float64Array; poseB: Float64Array;
  bodyA: Uint32Array; bodyB: Uint32Array; shapeA: Uint32Array; shapeB: Uint32Array; fact: Uint8Array;
  achieved: Uint8Array; marks: Uint8Array;
}
export interface EventRecord {
  number: bigint; id: bigint; tick: bigint; stampNs: bigint; lo: number; hi: number; closing: number; ageA: number;
  ageB: number; loS: number; hiS: number; startNs: bigint; bodyA: number; bodyB: number; shapeA: number;
  shapeB: number; kind: number; cause: number; achieved: number; estimated: boolean; snapshot: boolean;
}
export interface EventsFrame extends Header { kind: 6; first: bigint; missed: number; events: EventRecord[] }
export interface StatusFrame extends Header {
  kind: 7; connected: boolean; health: string; limits: string; daemon: string; release: string; links: string;
  epoch: string; started_ns: string; counters: Record<string, number | string>; web: Record<string, number>;
  playback: null | { state: "playing" | "paused" | "ended"; at_ns: string; tick: number | string; speed: number };
}
export interface AnswerHit {
  name_a?: string; name_b?: string; lo?: number | string; hi?: number | string; axis?: number[]; point_a?: number[];
  point_b?: number[]; age_s?: number; stale?: boolean; achieved?: number | string; position?: number[];
  orientation?: number[];
}
export interface AnswerFrame extends Header {
  kind: 8; id: number; status: string; text: string; hits: AnswerHit[];
}
export interface VerticesFrame extends Header {
  kind: 10; origin: Float64Array; body: number; shape: number; first: number; skipped: number; revision: number;
  positions: Float32Array;
}
export type Frame = Hello | SceneFrame | GeometryFrame | PosesFrame | ContactsFrame | EventsFrame | StatusFrame |
  AnswerFrame | VerticesFrame;

/** Walks along a frame: each array is taken where it lies, and none reaches beyond the end. */
class Cursor {
  readonly view: DataView;
  at = 32;
  constructor(readonly buffer: ArrayBuffer, readonly base: number, readonly end: number) {
    this.view = new DataView(buffer, base, end);
  }
  private room(bytes: number): number {
    if (bytes > this.end - this.at) throw new ProtocolError("an array reaches beyond the frame's end");
    const at = this.base + this.at;
    this.at += (bytes + 7) & ~7;
    return at;
  }
  u32(): number {
    if (this.at + 4 > this.end) throw new ProtocolError("the frame is too short");
    this.at += 4;
    return this.view.getUint32(this.at - 4, true);
  }
  u64(): bigint {
    if (this.at + 8 > this.end) throw new ProtocolError("the frame is too short");
    this.at += 8;
    return this.view.getBigUint64(this.at - 8, true);
  }
  u8s(n: number): Uint8Array { return new Uint8Array(this.buffer, this.room(n), n); }
  u32s(n: number): Uint32Array { return new Uint32Array(this.buffer, this.room(4 * n), n); }
  f32s(n: number): Float32Array { return new Float32Array(this.buffer, this.room(4 * n), n); }
  f64s(n: number): Float64Array { return new Float64Array(this.buffer, this.room(8 * n), n); }
  i64s(n: number): BigInt64Array { return new BigInt64Array(this.buffer, this.room(8 * n), n); }
  bytes(n: number): DataView { return new DataView(this.buffer, this.room(n), n); }
}

const utf8 = new TextDecoder();

function text(bytes: Uint8Array, at: number, length: number): string {
  if (at + length > bytes.length) throw new ProtocolError("a name lies beyond the strings");
  return utf8.decode(bytes.subarray(at, at + length));
}

function json(c: Cursor): Record<string, unknown> {
  try {
    const value: unknown = JSON.parse(utf8.decode(c.u8s(c.end - 32)));
    if (typeof value === "object" && value !== null) return value as Record<string, unknown>;
  } catch { /* told below */ }
  throw new ProtocolError("the frame's text is no JSON object");
}

function doubles(v: DataView, at: number, n: number): Float64Array {
  const out = new Float64Array(n);
  for (let i = 0; i < n; i++) out[i] = v.getFloat64(at + 8 * i, true);
  return out;
}

function shapeAt(v: DataView, at: number): ShapeDef {
  return {
    type: v.getUint32(at, true), geometry: v.getUint32(at + 4, true), index: v.getUint32(at + 8, true),
    parent: v.getUint32(at + 12, true),
    half: [v.getFloat64(at + 16, true), v.getFloat64(at + 24, true), v.getFloat64(at + 32, true)],
    radius: v.getFloat64(at + 40, true), deviation: v.getFloat64(at + 48, true), pose: doubles(v, at + 56, 7),
  };
}

function scene(h: Header, c: Cursor): SceneFrame {
  const revision = c.u32(), everything = c.u32() === 1, goneCount = c.u32(), bodyCount = c.u32(), shapeCount = c.u32();
  const geometryCount = c.u32(), octets = c.u32();
  c.u32();
  const gone = c.u32s(goneCount), body = c.bytes(104 * bodyCount), shape = c.bytes(112 * shapeCount);
  const geometry = c.bytes(24 * geometryCount), strings = c.u8s(octets);
  const bodies: BodyDef[] = [], geometries: GeometryNote[] = [];
  for (let i = 0; i < bodyCount; i++) {
    const at = 104 * i, u = (o: number): number => body.getUint32(at + o, true), first = u(8), count = u(12);
    if (first + count > shapeCount) throw new ProtocolError("a body's shapes lie beyond the frame's");
    const shapes: ShapeDef[] = [];
    for (let k = 0; k < count; k++) shapes.push(shapeAt(shape, 112 * (first + k)));
    bodies.push({
      id: u(0), flags: u(4), name: text(strings, u(16), u(20)), group: text(strings, u(24), u(28)),
      owner: text(strings, u(32), u(36)), deadlineS: body.getFloat64(at + 40, true), pose: doubles(body, at + 48, 7),
      shapes,
    });
  }
  for (let i = 0; i < geometryCount; i++)
    geometries.push({
      number: geometry.getUint32(24 * i, true), kind: geometry.getUint32(24 * i + 4, true),
      hash: geometry.getBigInt64(24 * i + 8, true), vertexNumbers: geometry.getUint32(24 * i + 16, true),
      indices: geometry.getUint32(24 * i + 20, true),
    });
  return { ...h, kind: 2, revision, everything, gone, bodies, geometries };
}

function geometry(h: Header, c: Cursor): GeometryFrame {
  const number = c.u32(), of = c.u32(), v = c.u32(), i = c.u32(), question = c.u32(), f = c.u32();
  return { ...h, kind: 3, geometry: number, of, question, numbers: c.f64s(v), indices: c.u32s(i), faces: c.u32s(3 * f) };
}

function poses(h: Header, c: Cursor): PosesFrame {
  const origin = c.f64s(3), n = c.u32(), everything = c.u32() === 1, skipped = c.u32(), revision = c.u32();
  return { ...h, kind: 4, origin, everything, skipped, revision, ids: c.u32s(n), values: c.f32s(8 * n) };
}

function contacts(h: Header, c: Cursor): ContactsFrame {
  const n = c.u32(), r = c.u32(), everything = c.u32() === 1, skipped = c.u32(), total = c.u32(), leftOut = c.u32();
  return {
    ...h, kind: 5, count: n, everything, skipped, total, leftOut, gone: c.i64s(r), id: c.i64s(n),
    claimTick: c.i64s(n), lo: c.f64s(n), hi: c.f64s(n), closing: c.f64s(n), ageA: c.f64s(n), ageB: c.f64s(n),
    loS: c.f64s(n), hiS: c.f64s(n), startNs: c.i64s(n), axis: c.f64s(3 * n), pointA: c.f64s(3 * n),
    pointB: c.f64s(3 * n), poseA: c.f64s(7 * n), poseB: c.f64s(7 * n), bodyA: c.u32s(n), bodyB: c.u32s(n),
    shapeA: c.u32s(n), shapeB: c.u32s(n), fact: c.u8s(n), achieved: c.u8s(n), marks: c.u8s(n),
  };
}

function events(h: Header, c: Cursor): EventsFrame {
  const first = c.u64(), n = c.u32(), missed = c.u32(), v = c.bytes(120 * n), all: EventRecord[] = [];
  for (let i = 0, at = 0; i < n; i++, at += 120) {
    const f = (o: number): number => v.getFloat64(at + o, true), u = (o: number): number => v.getUint32(at + o, true);
    const q = (o: number): bigint => v.getBigInt64(at + o, true), b = (o: number): number => v.getUint8(at + o);
    all.push({
      number: first + BigInt(i), id: q(0), tick: q(8), stampNs: q(16), lo: f(24), hi: f(32), closing: f(40),
      ageA: f(48), ageB: f(56), loS: f(64), hiS: f(72), startNs: q(80), bodyA: u(88), bodyB: u(92), shapeA: u(96),
      shapeB: u(100), kind: b(104), cause: b(105), achieved: b(106), estimated: (b(107) & 1) !== 0,
      snapshot: (u(108) & 1) !== 0,
    });
  }
  return { ...h, kind: 6, first, missed, events: all };
}

function vertices(h: Header, c: Cursor): VerticesFrame {
  const origin = c.f64s(3), body = c.u32(), shape = c.u32(), first = c.u32(), v = c.u32(), skipped = c.u32();
  const revision = c.u32();
  return { ...h, kind: 10, origin, body, shape, first, skipped, revision, positions: c.f32s(3 * v) };
}

/** The frame that begins at `base` (a multiple of 8) of the buffer; its length is in it. Null for kinds that this
 * version does not know, which are to be passed over. Throws a ProtocolError for what is no frame. */
export function decode(buffer: ArrayBuffer, base = 0): Frame | null {
  if (buffer.byteLength - base < 32) throw new ProtocolError("shorter than a header");
  const v = new DataView(buffer, base), octets = v.getUint32(4, true);
  if (v.getUint16(0, true) !== 0xc011) throw new ProtocolError("no frame of collided.web");
  if (octets < 32 || octets % 8 !== 0 || octets > buffer.byteLength - base)
    throw new ProtocolError(`a frame of ${octets} octets in ${buffer.byteLength - base}`);
  if (v.getUint8(3) !== 1) return null;
  const kind = v.getUint8(2), c = new Cursor(buffer, base, octets);
  const h: Header = {
    kind, tick: v.getBigUint64(8, true), stampNs: v.getBigInt64(16, true), number: v.getBigUint64(24, true),
  };
  switch (kind) {
    case Kind.hello: case Kind.status: case Kind.answer: return { ...json(c), ...h } as unknown as Frame;
    case Kind.scene: return scene(h, c);
    case Kind.geometry: return geometry(h, c);
    case Kind.poses: return poses(h, c);
    case Kind.contacts: return contacts(h, c);
    case Kind.events: return events(h, c);
    case Kind.vertices: return vertices(h, c);
    default: return null;
  }
}

/** A number of an answer: those that are not finite come as text. */
export function numberOf(x: number | string | undefined): number {
  if (typeof x === "number") return x;
  return x === "inf" ? Infinity : x === "-inf" ? -Infinity : NaN;
}
