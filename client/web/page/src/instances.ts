/* instances: many bodies in few draws: one instanced draw a kind of shape or geometry. Poses lie in one texture, two
 * texels a body, which is all that a frame uploads; the vertex shader turns the vertices. A second texture says how
 * each body is to look. Three programs: for the eye, for ghosts, and one that writes each body's number (picking). */
import {
  BufferGeometry, Color, DataTexture, DoubleSide, FloatType, InstancedBufferAttribute, InstancedBufferGeometry, Mesh,
  NearestFilter, Object3D, RGBAFormat, ShaderMaterial, UnsignedByteType, Vector2,
} from "three";
import { NONE, Shape, type BodyDef, type GeometryFrame, type ShapeDef } from "../../client/src/index.js";
import { Shading, meshKey, meshOf } from "./shapes.js";

const WIDTH = 1024; // texels a row; a power of two, and even

const vertexShader = /* glsl */ `
precision highp float;
precision highp sampler2D;
in vec4 localP; // where the shape is in its body, and the body's slot
in vec4 localQ;
in vec4 size; // half extents, radius
uniform sampler2D poses, looks;
uniform int shading;
uniform float slot0; // of a mesh that is no instance: its slot; -1 otherwise
out vec3 seen, normalSeen, inShape;
flat out vec4 look;
flat out float flags, slot;
vec3 turn(vec4 q, vec3 v) { return v + 2.0 * cross(q.xyz, cross(q.xyz, v) + q.w * v); }
void main() {
  bool alone = slot0 >= 0.0;
  slot = alone ? slot0 : localP.w;
  int s = int(slot), t = 2 * s;
  vec4 p = texelFetch(poses, ivec2(t % ${WIDTH}, t / ${WIDTH}), 0);
  vec4 r = texelFetch(poses, ivec2((t + 1) % ${WIDTH}, (t + 1) / ${WIDTH}), 0); // w x y z
  look = texelFetch(looks, ivec2(s % ${WIDTH}, s / ${WIDTH}), 0) * 255.0;
  flags = p.w;
  vec3 world;
  if (alone) {
    world = position;
    normalSeen = normalize(normalMatrix * normal);
    inShape = position;
  } else {
    vec3 v = position * size.xyz + normal * size.w;
    inShape = v;
    vec3 n = shading == ${Shading.ellipsoid} ? normalize(normal / max(size.xyz, vec3(1e-30))) : normal;
    vec4 q = vec4(r.yzw, r.x);
    world = turn(q, turn(localQ, v) + localP.xyz) + p.xyz;
    normalSeen = normalize(normalMatrix * turn(q, turn(localQ, n)));
  }
  vec4 view = modelViewMatrix * vec4(world, 1.0);
  seen = view.xyz;
  gl_Position = projectionMatrix * view;
}`;

const eyeShader = /* glsl */ `
precision highp float;
in vec3 seen, normalSeen, inShape;
flat in vec4 look; // tone, colour, selected, -
flat in float flags, slot;
uniform int shading;
uniform bool ghost;
uniform vec3 palette[10], ink, paper, hot, warm, violet;
uniform float pixel;
out vec4 colour;
void main() {
  int f = int(flags + 0.5);
  vec3 n = shading == ${Shading.flat} ? normalize(cross(dFdx(seen), dFdy(seen))) : normalize(normalSeen);
  if (!gl_FrontFacing && shading != ${Shading.flat}) n = -n;
  vec2 at = gl_FragCoord.xy / pixel;
  vec3 base = palette[int(look.y + 0.5)];
  float light = 0.52 + 0.36 * max(0.0, dot(n, normalize(vec3(0.35, 0.75, 0.55)))) + 0.16 * max(0.0, n.z);
  float rim = pow(1.0 - max(0.0, dot(n, normalize(-seen))), 3.0);
  if (ghost) { // a pose that is not yet: violet, every other pixel of a screen
    if (mod(floor(at.x / 2.0) + floor(at.y / 2.0), 2.0) < 0.5) discard;
    colour = vec4(mix(violet * light, violet, 0.5), 1.0);
    return;
  }
  if (shading == ${Shading.ground}) {
    vec2 g = abs(fract(inShape.xy - 0.5) - 0.5) / max(fwidth(inShape.xy), vec2(1e-6));
    float line = 1.0 - min(min(g.x, g.y), 1.0);
    vec2 fw = fwidth(inShape.xy);
    line *= 1.0 - smoothstep(0.15, 0.6, max(fw.x, fw.y));
    float far = smoothstep(6.0, 40.0, length(inShape.xy));
    colour = vec4(mix(mix(paper, ink, 0.045), mix(paper, ink, 0.15), line * 0.8) * mix(1.0, 0.985, far), 1.0);
    return;
  }
  vec3 c = base * light;
  if ((f & 3) != 0) { // unknown: no colour, hatched
    c = mix(paper, ink, 0.42) * (0.75 + 0.3 * light);
    if (mod(at.x + at.y, 9.0) < 3.5) c = mix(paper, ink, 0.08);
  } else if ((f & 4) != 0) { // not decided yet: dotted
    vec2 d = mod(at, 7.0) - 3.5;
    if (dot(d, d) < 3.0) c = mix(c, ink, 0.5);
  }
  float tone = look.x;
  if (tone > 2.5) c = mix(c, hot, 0.34 + 0.5 * rim);
  else if (tone > 1.5) c = mix(c, violet, 0.14 + 0.5 * rim);
  else if (tone > 0.5) c = mix(c, warm, 0.10 + 0.45 * rim);
  if (look.z > 0.5) c = mix(c, ink, 0.25 + 0.75 * smoothstep(0.15, 0.55, rim));
  colour = vec4(c, 1.0);
}`;

const numberShader = /* glsl */ `
precision highp float;
in vec3 seen, normalSeen, inShape;
flat in vec4 look;
flat in float flags, slot;
out vec4 colour;
void main() {
  int n = int(slot + 0.5) + 1;
  colour = vec4(float(n & 255), float((n >> 8) & 255), float((n >> 16) & 255), 255.0) / 255.0;
}`;

export interface Theme { palette: Color[]; ink: Color; paper: Color; hot: Color; warm: Color; violet: Color; cold: Color }

/** One shape that is to be drawn: where it is in its body, and in which slot the body's pose is. */
export interface Instance { slot: number; shape: ShapeDef; pose: ArrayLike<number> }

/** The pose of a compound's child in the body: that of the compound, then its own. */
export function composed(outer: ArrayLike<number>, inner: ArrayLike<number>): Float64Array {
  const [w, x, y, z] = [outer[3]!, outer[4]!, outer[5]!, outer[6]!];
  const [px, py, pz] = [inner[0]!, inner[1]!, inner[2]!];
  const cx = y * pz - z * py + w * px, cy = z * px - x * pz + w * py, cz = x * py - y * px + w * pz;
  const [v, a, b, c] = [inner[3]!, inner[4]!, inner[5]!, inner[6]!];
  return Float64Array.of(
    outer[0]! + px + 2 * (y * cz - z * cy), outer[1]! + py + 2 * (z * cx - x * cz), outer[2]! + pz + 2 * (x * cy - y * cx),
    w * v - x * a - y * b - z * c, w * a + x * v + y * c - z * b, w * b - x * c + y * v + z * a, w * c + x * b - y * a + z * v);
}

/** The shapes of a body as they are drawn: the children of compounds in place of these; a compound's rounding is added. */
export function drawn(body: BodyDef, slot: number, out: Instance[]): void {
  for (const s of body.shapes) {
    if (s.type === Shape.compound) continue;
    const parent = s.parent === NONE ? null : body.shapes[s.parent];
    if (!parent) out.push({ slot, shape: s, pose: s.pose });
    else out.push({ slot, shape: { ...s, radius: s.radius + parent.radius }, pose: composed(parent.pose, s.pose) });
  }
}

class Batch {
  readonly mesh: Mesh;
  private capacity = 0;
  constructor(private readonly shared: BufferGeometry, readonly eye: ShaderMaterial, readonly number: ShaderMaterial) {
    this.mesh = new Mesh(new InstancedBufferGeometry(), eye);
    this.mesh.frustumCulled = false;
  }
  fill(instances: Instance[]): void {
    let g = this.mesh.geometry as InstancedBufferGeometry;
    if (instances.length > this.capacity) {
      g.dispose();
      g = new InstancedBufferGeometry();
      g.index = this.shared.index;
      g.setAttribute("position", this.shared.getAttribute("position"));
      g.setAttribute("normal", this.shared.getAttribute("normal"));
      this.capacity = Math.max(16, 2 ** Math.ceil(Math.log2(instances.length)));
      for (const name of ["localP", "localQ", "size"])
        g.setAttribute(name, new InstancedBufferAttribute(new Float32Array(4 * this.capacity), 4));
      this.mesh.geometry = g;
    }
    const [p, q, s] = ["localP", "localQ", "size"].map((n) => g.getAttribute(n) as InstancedBufferAttribute);
    instances.forEach(({ slot, shape, pose }, i) => {
      p!.setXYZW(i, pose[0]!, pose[1]!, pose[2]!, slot);
      q!.setXYZW(i, pose[4]!, pose[5]!, pose[6]!, pose[3]!);
      const h = shape.half, far = 60;
      if (shape.type === Shape.halfspace) s!.setXYZW(i, far, far, 1, shape.radius);
      else if (shape.type >= Shape.hull) s!.setXYZW(i, 1, 1, 1, shape.radius);
      else s!.setXYZW(i, h[0], h[1], h[2], shape.radius);
    });
    p!.needsUpdate = q!.needsUpdate = s!.needsUpdate = true;
    g.instanceCount = instances.length;
    this.mesh.visible = instances.length > 0;
  }
  dispose(): void {
    this.mesh.removeFromParent();
    this.mesh.geometry.dispose();
  }
}

/** Bodies, or ghosts: what is drawn by poses of one texture. */
export class Instances {
  readonly group = new Object3D();
  private readonly batches = new Map<string, Batch>();
  private readonly meshes = new Map<string, { geometry: BufferGeometry; shading: number }>();
  private readonly materials = new Map<number, [ShaderMaterial, ShaderMaterial]>();
  private poses = Instances.texture(1, FloatType);
  private looks = Instances.texture(1, UnsignedByteType);
  private readonly uniforms;

  constructor(theme: Theme, private readonly ghost: boolean) {
    this.uniforms = {
      poses: { value: this.poses }, looks: { value: this.looks }, ghost: { value: ghost }, pixel: { value: 1 },
      palette: { value: theme.palette }, ink: { value: theme.ink }, paper: { value: theme.paper },
      hot: { value: theme.hot }, warm: { value: theme.warm }, violet: { value: theme.violet },
      resolution: { value: new Vector2() },
    };
  }

  private static texture(rows: number, type: typeof FloatType | typeof UnsignedByteType): DataTexture {
    const data = type === FloatType ? new Float32Array(4 * WIDTH * rows) : new Uint8Array(4 * WIDTH * rows);
    const t = new DataTexture(data, WIDTH, rows, RGBAFormat, type);
    t.minFilter = t.magFilter = NearestFilter;
    t.needsUpdate = true;
    return t;
  }

  /** The programs for a way of shading; `slot` is that of a single mesh, or -1 for instances. */
  programs(shading: number, slot = -1): [ShaderMaterial, ShaderMaterial] {
    const known = slot < 0 ? this.materials.get(shading) : undefined;
    if (known) return known;
    const uniforms = { ...this.uniforms, shading: { value: shading }, slot0: { value: slot } };
    const common = { vertexShader, uniforms, glslVersion: "300 es" as const, side: DoubleSide };
    const pair: [ShaderMaterial, ShaderMaterial] =
      [new ShaderMaterial({ ...common, fragmentShader: eyeShader }), new ShaderMaterial({ ...common, fragmentShader: numberShader })];
    if (slot < 0) this.materials.set(shading, pair);
    return pair;
  }

  setPixelRatio(ratio: number): void { this.uniforms.pixel.value = ratio; }

  /** Takes what is to be drawn, in place of what was. Shapes whose geometry has not come are left out. */
  fill(all: Instance[], geometries: ReadonlyMap<number, GeometryFrame>): void {
    const byKey = new Map<string, Instance[]>();
    for (const i of all) {
      const key = meshKey(i.shape.type, i.shape.radius, i.shape.geometry);
      const list = byKey.get(key);
      if (list) list.push(i); else byKey.set(key, [i]);
    }
    for (const [key, batch] of this.batches)
      if (!byKey.has(key)) {
        batch.dispose();
        this.batches.delete(key);
        if (key.startsWith("g")) {
          this.meshes.get(key)?.geometry.dispose();
          this.meshes.delete(key);
        }
      }
    for (const [key, list] of byKey) {
      const s = list[0]!.shape;
      let mesh = this.meshes.get(key);
      if (!mesh) {
        const made = meshOf(s.type, s.radius, geometries.get(s.geometry));
        if (!made) continue;
        this.meshes.set(key, mesh = made);
      }
      let batch = this.batches.get(key);
      if (!batch) {
        const [eye, number] = this.programs(mesh.shading);
        this.batches.set(key, batch = new Batch(mesh.geometry, eye, number));
        this.group.add(batch.mesh);
      }
      batch.fill(list);
    }
  }

  /** Uploads poses (eight numbers a slot), as far as there are. */
  setPoses(values: Float32Array, slots: number): void {
    const rows = Math.max(1, Math.ceil((2 * slots) / WIDTH));
    if (rows > this.poses.image.height) {
      this.poses.dispose();
      this.uniforms.poses.value = this.poses = Instances.texture(2 ** Math.ceil(Math.log2(rows)), FloatType);
    }
    (this.poses.image.data as Float32Array).set(values.subarray(0, 8 * slots));
    this.poses.needsUpdate = true;
  }

  /** How bodies look, four octets a slot: tone, colour, selected, 0. */
  setLooks(values: Uint8Array, slots: number): void {
    const rows = Math.max(1, Math.ceil(slots / WIDTH));
    if (rows > this.looks.image.height) {
      this.looks.dispose();
      this.uniforms.looks.value = this.looks = Instances.texture(2 ** Math.ceil(Math.log2(rows)), UnsignedByteType);
    }
    (this.looks.image.data as Uint8Array).set(values.subarray(0, 4 * slots));
    this.looks.needsUpdate = true;
  }

  /** Draws numbers in place of looks, or looks again. */
  asNumbers(on: boolean): void {
    this.group.visible = !(this.ghost && on);
    for (const b of this.batches.values()) b.mesh.material = on ? b.number : b.eye;
  }
}
