/* world: what a connection has told so far: bodies with their shapes and poses, geometry, what holds of pairs, events,
 * status. Frames are applied in their order; nothing is guessed. No input and no output. */
import {
  Fact, Flag, Kind, NONE, NO_BODY, Shape, type AnswerFrame, type BodyDef, type ContactsFrame, type EventRecord,
  type EventsFrame, type Frame, type GeometryFrame, type Hello, type PosesFrame, type SceneFrame, type ShapeDef,
  type StatusFrame, type VerticesFrame,
} from "./protocol.js";

/** A body. Its newest pose is at 8 x slot of World.poses. */
export interface Body extends BodyDef { slot: number }

/** A pair of which something holds. `values`: lo, hi, closing speed, ages of A and B, lo_s, hi_s, axis[3], point_a[3],
 * point_b[3], pose of A[7], pose of B[7]. */
export class Contact {
  readonly values = new Float64Array(30);
  bodyA = NO_BODY;
  bodyB = NO_BODY;
  shapeA = 0;
  shapeB = 0;
  fact = 0;
  achieved = 0;
  estimated = false;
  checkable = false;
  tick = 0n;
  startNs = 0n;
  /** Rises with each change. */
  version = 0;
  constructor(readonly id: bigint) {}
  get lo(): number { return this.values[0]!; }
  get hi(): number { return this.values[1]!; }
  get closing(): number { return this.values[2]!; }
  get ageA(): number { return this.values[3]!; }
  get ageB(): number { return this.values[4]!; }
  get loS(): number { return this.values[5]!; }
  get hiS(): number { return this.values[6]!; }
  get axis(): Float64Array { return this.values.subarray(7, 10); }
  get pointA(): Float64Array { return this.values.subarray(10, 13); }
  get pointB(): Float64Array { return this.values.subarray(13, 16); }
  get poseA(): Float64Array { return this.values.subarray(16, 23); }
  get poseB(): Float64Array { return this.values.subarray(23, 30); }

  take(f: ContactsFrame, i: number): void {
    const v = this.values;
    v[0] = f.lo[i]!; v[1] = f.hi[i]!; v[2] = f.closing[i]!; v[3] = f.ageA[i]!; v[4] = f.ageB[i]!;
    v[5] = f.loS[i]!; v[6] = f.hiS[i]!;
    for (let k = 0; k < 3; k++) {
      v[7 + k] = f.axis[3 * i + k]!; v[10 + k] = f.pointA[3 * i + k]!; v[13 + k] = f.pointB[3 * i + k]!;
    }
    for (let k = 0; k < 7; k++) { v[16 + k] = f.poseA[7 * i + k]!; v[23 + k] = f.poseB[7 * i + k]!; }
    this.bodyA = f.bodyA[i]!; this.bodyB = f.bodyB[i]!; this.shapeA = f.shapeA[i]!; this.shapeB = f.shapeB[i]!;
    this.fact = f.fact[i]!; this.achieved = f.achieved[i]!; this.estimated = (f.marks[i]! & 1) !== 0;
    this.checkable = (f.marks[i]! & 2) !== 0;
    this.tick = f.claimTick[i]!; this.startNs = f.startNs[i]!;
    this.version++;
  }
}

/** The vertices of one shape of a soft body: less World.origin as it was when they came. */
export interface SoftShape { body: number; shape: number; positions: Float32Array; origin: Float64Array; version: number }

/** How many events are kept. */
export const EVENTS_KEPT = 4096;

export class World {
  hello: Hello | null = null;
  status: StatusFrame | null = null;
  readonly bodies = new Map<number, Body>();
  readonly geometries = new Map<number, GeometryFrame>();
  readonly contacts = new Map<bigint, Contact>();
  readonly soft = new Map<string, SoftShape>();
  readonly events: EventRecord[] = [];
  readonly answers: AnswerFrame[] = [];
  /** Eight numbers a slot: position less origin, flags, quaternion w, x, y, z. */
  poses = new Float32Array(8 * 64);
  readonly origin = new Float64Array(3);
  /** Slots that have been in use: those below this. */
  slots = 0;
  /** Rise when the scene, poses, contacts, events, geometry, soft bodies change. */
  sceneVersion = 0;
  poseVersion = 0;
  contactVersion = 0;
  eventVersion = 0;
  geometryVersion = 0;
  softVersion = 0;
  /** The newest tick and stamp told, and which frame told it. */
  tick = 0n;
  stampNs = 0n;
  lastNumber = 0n;
  /** States and events that this connection was not sent, and frames whose numbers are not there. */
  skippedPoses = 0;
  skippedContacts = 0;
  missedEvents = 0;
  lostFrames = 0n;
  /** Of all contacts: how many there are, and how many the server left out. */
  contactsTotal = 0;
  contactsLeftOut = 0;
  /** Numbers of geometries that shapes name and that have not come: to be asked for. */
  readonly wanted = new Set<number>();
  private readonly goneNames = new Map<number, string>();
  private readonly freeSlots: number[] = [];

  /** The name of a body, also of one that has gone. */
  nameOf(id: number): string {
    if (id === NO_BODY) return "*";
    return this.bodies.get(id)?.name ?? this.goneNames.get(id) ?? `#${id}`;
  }

  /** The shape that contacts name by this number, and the children that follow it, if it is a compound. */
  shapeOf(body: BodyDef, index: number): { shape: ShapeDef; children: ShapeDef[] } | null {
    const at = body.shapes.findIndex((s) => s.index === index && s.parent === NONE);
    if (at < 0) return null;
    const shape = body.shapes[at]!;
    return { shape, children: shape.type === Shape.compound ? body.shapes.filter((s) => s.parent === at) : [] };
  }

  flagsOf(body: Body): number { return this.poses[8 * body.slot + 3]!; }

  /** Where a body is, as far as poses are sent for drawing: f32 less the origin. */
  positionOf(body: Body): [number, number, number] {
    const at = 8 * body.slot, p = this.poses;
    return [p[at]! + this.origin[0]!, p[at + 1]! + this.origin[1]!, p[at + 2]! + this.origin[2]!];
  }

  /** Takes a frame in. */
  apply(frame: Frame): void {
    if (this.lastNumber !== 0n && frame.number > this.lastNumber + 1n)
      this.lostFrames += frame.number - this.lastNumber - 1n;
    this.lastNumber = frame.number;
    if (frame.tick > this.tick) this.tick = frame.tick;
    if (frame.stampNs > this.stampNs) this.stampNs = frame.stampNs;
    switch (frame.kind) {
      case Kind.hello: return this.applyHello(frame as Hello);
      case Kind.scene: return this.applyScene(frame as SceneFrame);
      case Kind.geometry: return this.applyGeometry(frame as GeometryFrame);
      case Kind.poses: return this.applyPoses(frame as PosesFrame);
      case Kind.contacts: return this.applyContacts(frame as ContactsFrame);
      case Kind.events: return this.applyEvents(frame as EventsFrame);
      case Kind.status: this.status = frame as StatusFrame; return;
      case Kind.answer: this.answers.push(frame as AnswerFrame); return;
      case Kind.vertices: return this.applyVertices(frame as VerticesFrame);
    }
  }

  /** Before a new connection: its frames are numbered anew, and begin with everything. */
  connectionBegins(): void { this.lastNumber = 0n; }

  /** Forgets everything that was told, for a recording that is shown from its beginning again. */
  forget(): void {
    for (const id of [...this.bodies.keys()]) this.removeBody(id);
    this.contacts.clear();
    this.soft.clear();
    this.events.length = 0;
    this.tick = this.stampNs = this.lastNumber = 0n;
    this.sceneVersion++;
    this.contactVersion++;
    this.eventVersion++;
    this.softVersion++;
  }

  private applyHello(f: Hello): void {
    if (this.hello && this.hello.epoch !== f.epoch) { // another daemon: nothing of the old one holds
      this.tick = f.tick;
      this.stampNs = f.stampNs;
      this.contacts.clear();
      this.contactVersion++;
      this.events.length = 0;
      this.eventVersion++;
    }
    this.hello = f;
  }

  private removeBody(id: number): void {
    const body = this.bodies.get(id);
    if (!body) return;
    this.bodies.delete(id);
    this.goneNames.set(id, body.name);
    if (this.goneNames.size > 4 * EVENTS_KEPT) this.goneNames.delete(this.goneNames.keys().next().value!);
    this.poses.fill(0, 8 * body.slot, 8 * body.slot + 8);
    this.freeSlots.push(body.slot);
    for (const s of body.shapes) this.soft.delete(`${id} ${s.index}`);
  }

  private takeSlot(): number {
    const free = this.freeSlots.pop();
    if (free !== undefined) return free;
    if (8 * (this.slots + 1) > this.poses.length) {
      const larger = new Float32Array(2 * this.poses.length);
      larger.set(this.poses);
      this.poses = larger;
    }
    return this.slots++;
  }

  private writePose(slot: number, flags: number, pose: Float64Array): void {
    const p = this.poses, at = 8 * slot;
    for (let k = 0; k < 3; k++) p[at + k] = pose[k]! - this.origin[k]!;
    p[at + 3] = flags;
    for (let k = 0; k < 4; k++) p[at + 4 + k] = pose[3 + k]!;
  }

  private applyScene(f: SceneFrame): void {
    if (f.everything) {
      for (const id of [...this.bodies.keys()]) this.removeBody(id);
      this.wanted.clear();
      this.geometries.clear();
    }
    for (const id of f.gone) this.removeBody(id);
    for (const def of f.bodies) {
      const slot = this.bodies.get(def.id)?.slot ?? this.takeSlot();
      this.bodies.set(def.id, { ...def, slot });
      this.writePose(slot, def.flags, def.pose);
      for (const s of def.shapes)
        if (s.geometry !== NONE && !this.geometries.has(s.geometry)) this.wanted.add(s.geometry);
    }
    this.sceneVersion++;
    this.poseVersion++;
  }

  private applyGeometry(f: GeometryFrame): void {
    this.wanted.delete(f.geometry);
    if (f.of === 0) return;
    this.geometries.set(f.geometry, f);
    this.geometryVersion++;
  }

  /** Moves what is kept relative to the origin, for bodies that the next frame does not name. */
  private moveOrigin(to: Float64Array): void {
    const d = [0, 1, 2].map((k) => this.origin[k]! - to[k]!);
    if (d.every((x) => x === 0)) return;
    for (const body of this.bodies.values())
      for (let k = 0; k < 3; k++) this.poses[8 * body.slot + k] = this.poses[8 * body.slot + k]! + d[k]!;
    this.origin.set(to);
    this.sceneVersion++;
    this.contactVersion++;
  }

  private applyPoses(f: PosesFrame): void {
    this.skippedPoses += f.skipped;
    this.moveOrigin(f.origin);
    const p = this.poses, v = f.values;
    for (let i = 0; i < f.ids.length; i++) {
      const body = this.bodies.get(f.ids[i]!);
      if (!body) continue; // it has gone meanwhile
      const at = 8 * body.slot, from = 8 * i;
      for (let k = 0; k < 8; k++) p[at + k] = v[from + k]!;
    }
    this.poseVersion++;
  }

  private applyContacts(f: ContactsFrame): void {
    this.skippedContacts += f.skipped;
    this.contactsTotal = f.total;
    this.contactsLeftOut = f.leftOut;
    if (f.everything) {
      const named = new Set<bigint>(f.id);
      for (const id of this.contacts.keys()) if (!named.has(id)) this.contacts.delete(id);
    }
    for (const id of f.gone) this.contacts.delete(id);
    for (let i = 0; i < f.count; i++) {
      const id = f.id[i]!;
      let contact = this.contacts.get(id);
      if (!contact) this.contacts.set(id, contact = new Contact(id));
      contact.take(f, i);
    }
    this.contactVersion++;
  }

  private applyEvents(f: EventsFrame): void {
    this.missedEvents += f.missed;
    const newest = this.events[this.events.length - 1]?.number ?? 0n;
    for (const e of f.events) if (e.number > newest || f.first <= 1n) this.events.push(e);
    if (this.events.length > EVENTS_KEPT) this.events.splice(0, this.events.length - EVENTS_KEPT);
    this.eventVersion++;
  }

  private applyVertices(f: VerticesFrame): void {
    const key = `${f.body} ${f.shape}`, need = 3 * f.first + f.positions.length;
    let s = this.soft.get(key);
    if (!s || s.positions.length < need) {
      const positions = new Float32Array(need);
      if (s) positions.set(s.positions);
      s = { body: f.body, shape: f.shape, positions, origin: new Float64Array(f.origin), version: s?.version ?? 0 };
      this.soft.set(key, s);
    }
    s.positions.set(f.positions, 3 * f.first);
    s.origin.set(f.origin);
    s.version++;
    this.softVersion++;
  }
}

/** Is what is said of this body unknown, since its pose is past its deadline or its client is gone? */
export function isUnknown(flags: number): boolean { return (flags & (Flag.stale | Flag.unknown)) !== 0; }

/** What holds of a pair, in a word. */
export function factWord(fact: number): string {
  return fact === Fact.begin ? "touching" : fact === Fact.near ? "near" : fact === Fact.unknown ? "unknown" :
    fact === Fact.impact ? "impact" : fact === Fact.predicted ? "predicted" : "?";
}
