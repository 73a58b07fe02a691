/* marks: what is drawn of pairs: the segment between the witness points, the interval as a bar along the axis, an arrow
 * along the axis, and the points themselves. Two instanced draws, widths in pixels. */
import {
  BufferAttribute, Color, DoubleSide, InstancedBufferAttribute, InstancedBufferGeometry, Mesh, Object3D, ShaderMaterial,
  Vector2,
} from "three";
import { Fact, type Contact } from "../../client/src/index.js";
import type { Theme } from "./instances.js";

/** At most so many pairs are drawn, the nearest; the table has all. */
export const MARKS_MOST = 1000;

const segmentShader = /* glsl */ `
precision highp float;
in vec3 from, to;
in vec4 tint; // rgb, alpha
in vec4 form; // width at from, width at to (px), dashed, length in px if > 0
uniform vec2 resolution;
out vec4 c;
out float along;
flat out float dashed;
void main() {
  vec4 a = projectionMatrix * modelViewMatrix * vec4(from, 1.0);
  vec4 b = projectionMatrix * modelViewMatrix * vec4(to, 1.0);
  if (form.w > 0.0) { // an arrow: so many pixels long, whatever the distance
    float unit = 2.0 * max(a.w, 1e-6) / (projectionMatrix[1][1] * resolution.y);
    b = projectionMatrix * modelViewMatrix * vec4(from + normalize(to - from) * unit * form.w, 1.0);
  }
  float near = 1e-4; // what lies behind the eye is cut off
  if (a.w < near) a = mix(b, a, (b.w - near) / max(b.w - a.w, 1e-9));
  if (b.w < near) b = mix(a, b, (a.w - near) / max(a.w - b.w, 1e-9));
  vec2 pa = a.xy / a.w * resolution, pb = b.xy / b.w * resolution;
  vec2 d = pb - pa;
  float l = length(d);
  d = l > 1e-6 ? d / l : vec2(1.0, 0.0);
  float end = position.x, width = mix(form.x, form.y, end);
  vec4 p = mix(a, b, end);
  p.xy += (vec2(-d.y, d.x) * position.y * width) / resolution * p.w;
  p.z -= 0.0005 * p.w; // before what it lies on
  along = end * l * 0.5;
  dashed = form.z;
  c = tint;
  gl_Position = p;
}`;
const segmentColour = /* glsl */ `
precision highp float;
in vec4 c;
in float along;
flat in float dashed;
out vec4 colour;
void main() {
  if (dashed > 0.5 && mod(along, 9.0) > 5.0) discard;
  colour = c;
}`;
const dotShader = /* glsl */ `
precision highp float;
in vec3 at;
in vec4 tint; // alpha: the radius, px
uniform vec2 resolution;
uniform float pixel;
out vec4 c;
out vec2 p;
void main() {
  vec4 v = projectionMatrix * modelViewMatrix * vec4(at, 1.0);
  v.xy += position.xy * 2.0 * tint.a * pixel / resolution * v.w;
  v.z -= 0.0006 * v.w;
  p = position.xy;
  c = tint;
  gl_Position = v;
}`;
const dotColour = /* glsl */ `
precision highp float;
in vec4 c;
in vec2 p;
uniform vec3 paper;
out vec4 colour;
void main() {
  float r = length(p);
  if (r > 1.0) discard;
  colour = vec4(r > 0.62 ? paper : c.rgb, 1.0);
}`;

class Table {
  private at = 0;
  readonly mesh: Mesh;
  private capacity = 64;
  constructor(private readonly corners: BufferAttribute, private readonly columns: [string, number][], material: ShaderMaterial) {
    this.mesh = new Mesh(this.make(), material);
    this.mesh.frustumCulled = false;
  }
  private make(): InstancedBufferGeometry {
    const g = new InstancedBufferGeometry();
    g.setAttribute("position", this.corners);
    g.setIndex([0, 1, 2, 2, 1, 3]);
    for (const [name, size] of this.columns)
      g.setAttribute(name, new InstancedBufferAttribute(new Float32Array(size * this.capacity), size));
    return g;
  }
  begin(rows: number): void {
    this.at = 0;
    if (rows > this.capacity) {
      this.capacity = 2 ** Math.ceil(Math.log2(rows));
      this.mesh.geometry.dispose();
      this.mesh.geometry = this.make();
    }
  }
  add(...values: ArrayLike<number>[]): void {
    this.columns.forEach(([name, size], k) => {
      const a = this.mesh.geometry.getAttribute(name).array as Float32Array, v = values[k]!;
      for (let i = 0; i < size; i++) a[this.at * size + i] = v[i]!;
    });
    this.at++;
  }
  end(): void {
    for (const [name] of this.columns) this.mesh.geometry.getAttribute(name).needsUpdate = true;
    (this.mesh.geometry as InstancedBufferGeometry).instanceCount = this.at;
    this.mesh.visible = this.at > 0;
  }
}

/** The colour of what holds of a pair; a refused proof is told by its own. */
export function tint(theme: Theme, c: Contact): Color {
  if (c.fact === Fact.predicted || c.fact === Fact.impact) return theme.violet;
  if (c.fact === Fact.begin) return theme.hot;
  if (c.fact === Fact.unknown) return theme.ink;
  return c.achieved >= 2 ? theme.cold : theme.warm;
}

export class Marks {
  readonly group = new Object3D();
  private readonly segments: Table;
  private readonly dots: Table;
  private readonly uniforms;

  constructor(private readonly theme: Theme) {
    this.uniforms = { resolution: { value: new Vector2(1, 1) }, pixel: { value: 1 }, paper: { value: theme.paper } };
    const common = { uniforms: this.uniforms, glslVersion: "300 es" as const, side: DoubleSide, transparent: true, depthWrite: false };
    const strip = new BufferAttribute(new Float32Array([0, -1, 0, 0, 1, 0, 1, -1, 0, 1, 1, 0]), 3);
    const square = new BufferAttribute(new Float32Array([-1, -1, 0, -1, 1, 0, 1, -1, 0, 1, 1, 0]), 3);
    this.segments = new Table(strip, [["from", 3], ["to", 3], ["tint", 4], ["form", 4]],
      new ShaderMaterial({ ...common, vertexShader: segmentShader, fragmentShader: segmentColour }));
    this.dots = new Table(square, [["at", 3], ["tint", 4]],
      new ShaderMaterial({ ...common, vertexShader: dotShader, fragmentShader: dotColour }));
    this.segments.mesh.renderOrder = 1;
    this.dots.mesh.renderOrder = 2;
    this.group.add(this.segments.mesh, this.dots.mesh);
  }

  resize(width: number, height: number, pixel: number): void {
    this.uniforms.resolution.value.set(width, height);
    this.uniforms.pixel.value = pixel;
  }

  /** Draws these pairs, relative to the origin. Those that are strong have arrows and large points. */
  fill(contacts: readonly Contact[], origin: Float64Array, strongOnes: ReadonlySet<bigint>): void {
    this.segments.begin(4 * contacts.length);
    this.dots.begin(2 * contacts.length);
    const px = this.uniforms.pixel.value, a = [0, 0, 0], b = [0, 0, 0], lo = [0, 0, 0], hi = [0, 0, 0], mid = [0, 0, 0], tip = [0, 0, 0];
    for (const c of contacts) {
      const v = c.values, colour = tint(this.theme, c), strong = strongOnes.has(c.id);
      if (!(Math.abs(v[10]!) < Infinity) || !(Math.abs(v[13]!) < Infinity)) continue; // no points are told
      for (let k = 0; k < 3; k++) {
        a[k] = v[10 + k]! - origin[k]!; b[k] = v[13 + k]! - origin[k]!;
        mid[k] = (a[k]! + b[k]!) / 2; tip[k] = mid[k]! + v[7 + k]!;
        if (Number.isFinite(c.lo) && Number.isFinite(c.hi)) {
          lo[k] = a[k]! + v[7 + k]! * c.lo; hi[k] = a[k]! + v[7 + k]! * c.hi;
        }
      }
      const rgb: number[] = [colour.r, colour.g, colour.b, strong ? 1 : 0.45], dashed = c.fact >= Fact.unknown ? 1 : 0;
      const w = (strong ? 2.4 : 1) * px;
      this.segments.add(a, b, rgb, [w, w, dashed, 0]);
      if (Number.isFinite(c.lo) && Number.isFinite(c.hi) && c.hi > c.lo)
        this.segments.add(lo, hi, [colour.r, colour.g, colour.b, 0.45], [6 * px, 6 * px, 0, 0]);
      if (strong) this.segments.add(mid, tip, rgb, [5 * px, 0, 0, 15 * px]);
      const dot: number[] = [colour.r, colour.g, colour.b, strong ? 4.5 : 2.2];
      this.dots.add(a, dot);
      this.dots.add(b, dot);
    }
    this.segments.end();
    this.dots.end();
  }
}
