/* checker: verify.wasm (collided_verify of the C library and the kernel of collided_check.h, compiled), and the claims that they check. A Checker belongs
 * to one thread; nothing is fetched: the octets of verify.wasm are handed over. */
import { NONE, Shape, type GeometryFrame, type ShapeDef } from "./protocol.js";
import { type Contact, type World } from "./world.js";

/** What became of a check. "proven": the axis and the points prove the interval. "refused": they do not, so that what
 * was told is not what the daemon computed. "unsupported": no axis and points prove it (half of a compound, meshes).
 * "missing": shapes, poses or geometry are not here. */
export type Verdict = "proven" | "refused" | "unsupported" | "missing";

/** One side of a claim. `hull`: its points, three numbers each. */
export interface ClaimSide {
  shape: ShapeDef; children: ShapeDef[]; hull: Float64Array | null; pose: ArrayLike<number>;
}
/** That the signed distance of two shapes is within [lo, hi], and what proves it. */
export interface Claim {
  a: ClaimSide; b: ClaimSide; lo: number; hi: number; axis: ArrayLike<number>; pointA: ArrayLike<number>;
  pointB: ArrayLike<number>;
}

interface Exports {
  memory: WebAssembly.Memory;
  checker_room(words: number): number;
  checker_check(words: number, count: number): number;
  checker_kernel(words: number, count: number, allowed: number): number;
  checker_kernel_proven(): number;
  checker_kernel_machine(): number;
}

/** What the kernel says: a collided_check_status (0 = proven), and what the axis and the points prove of the signed distance,
 * infinite where nothing, in metres. */
export interface KernelAnswer { status: number; lo: number; hi: number }

const SHAPE_WORDS = 14, CLAIM_WORDS = 11;

function wordsOf(s: ClaimSide): number {
  return SHAPE_WORDS * (1 + s.children.length) + (s.hull?.length ?? 0) + 7;
}

/** Writes a claim as checker.c reads it. */
class Writer {
  at = 0;
  constructor(readonly out: Float64Array) {}
  put(x: number): void { this.out[this.at++] = x; }
  all(xs: ArrayLike<number>): void {
    this.out.set(xs, this.at);
    this.at += xs.length;
  }
  shape(s: ShapeDef, n: number): void {
    this.put(s.type);
    if (s.type === Shape.compound) this.all([0, 0, 0]); else this.all(s.half);
    this.put(s.radius);
    this.all(s.pose);
    this.put(s.deviation);
    this.put(n);
  }
  side(s: ClaimSide): void {
    this.shape(s.shape, s.children.length > 0 ? s.children.length : (s.hull?.length ?? 0) / 3);
    for (const child of s.children) this.shape(child, 0);
    if (s.hull) this.all(s.hull);
    this.all(s.pose);
  }
}

function writeClaim(out: Float64Array, claim: Claim): void {
  const w = new Writer(out);
  w.side(claim.a);
  w.side(claim.b);
  w.put(claim.lo);
  w.put(claim.hi);
  w.all(claim.axis);
  w.all(claim.pointA);
  w.all(claim.pointB);
}

export class Checker {
  private constructor(private readonly wasm: Exports) {}

  /** Makes a checker of the octets of verify.wasm, which imports nothing. */
  static async create(octets: BufferSource): Promise<Checker> {
    const { instance } = await WebAssembly.instantiate(octets, {});
    return new Checker(instance.exports as unknown as Exports);
  }

  /** The status of collided_verify for a claim in words, as checker.c says: 0 = proven. */
  checkWords(words: Float64Array): number {
    const at = this.wasm.checker_room(words.length);
    if (at === 0) return 1;
    new Float64Array(this.wasm.memory.buffer, at, words.length).set(words);
    return this.wasm.checker_check(at, words.length);
  }

  /** Does the kernel, which is proven by machine, prove a claim in words? A claim may be short by less than `allowed` (m): points
   * that were rounded to doubles are, by about 1e-15 of their coordinates. Throws where the machine does not compute as is assumed. */
  kernelWords(words: Float64Array, allowed = 0): KernelAnswer {
    if (this.wasm.checker_kernel_machine() !== 1) throw new Error("this machine does not compute as the proofs of the kernel assume");
    const at = this.wasm.checker_room(words.length);
    if (at === 0) return { status: 13, lo: -Infinity, hi: Infinity };
    new Float64Array(this.wasm.memory.buffer, at, words.length).set(words);
    const status = this.wasm.checker_kernel(at, words.length, allowed);
    const [lo, hi] = new Float64Array(this.wasm.memory.buffer, this.wasm.checker_kernel_proven(), 2) as unknown as [number, number];
    return { status, lo, hi };
  }

  /** The same of a claim. */
  kernel(claim: Claim, allowed = 0): KernelAnswer {
    const words = new Float64Array(wordsOf(claim.a) + wordsOf(claim.b) + CLAIM_WORDS);
    writeClaim(words, claim);
    return this.kernelWords(words, allowed);
  }

  check(claim: Claim): Verdict {
    const count = wordsOf(claim.a) + wordsOf(claim.b) + CLAIM_WORDS, at = this.wasm.checker_room(count);
    if (at === 0) return "unsupported";
    writeClaim(new Float64Array(this.wasm.memory.buffer, at, count), claim);
    const status = this.wasm.checker_check(at, count);
    // 1 is a bad argument: a shape, pose or number that cannot be; 3 is rejected; 7 is unsupported.
    return status === 0 ? "proven" : status === 7 ? "unsupported" : "refused";
  }
}

function sideOf(world: World, body: number, shape: number, pose: Float64Array): ClaimSide | null | "unsupported" {
  const def = world.bodies.get(body);
  const found = def ? world.shapeOf(def, shape) : null;
  if (!found) return null;
  const { type, geometry } = found.shape;
  if (type === Shape.mesh || type === Shape.heightField) return "unsupported"; // no axis proves what is not convex
  if (found.children.some((c) => c.type === Shape.hull)) return "unsupported"; // collided_verify has no room for them
  let hull: Float64Array | null = null;
  if (type === Shape.hull) {
    const g: GeometryFrame | undefined = geometry === NONE ? undefined : world.geometries.get(geometry);
    if (!g) return null;
    hull = g.numbers;
  }
  return { shape: found.shape, children: found.children, hull, pose };
}

/** The claim that a contact makes, with the shapes that the scene has; or why there is none. */
export function claimOf(world: World, c: Contact): Claim | "missing" | "unsupported" {
  if (!c.checkable || !(c.hi < Infinity || c.lo > -Infinity)) return "missing";
  const a = sideOf(world, c.bodyA, c.shapeA, c.poseA), b = sideOf(world, c.bodyB, c.shapeB, c.poseB);
  if (a === null || b === null) return "missing";
  if (a === "unsupported" || b === "unsupported") return "unsupported";
  return { a, b, lo: c.lo, hi: c.hi, axis: c.axis, pointA: c.pointA, pointB: c.pointB };
}

/** Checks what is told of a pair. */
export function prove(checker: Checker, world: World, c: Contact): Verdict {
  const claim = claimOf(world, c);
  return typeof claim === "string" ? claim : checker.check(claim);
}

