/* view: the picture: bodies, soft bodies, ghosts of what is predicted, marks of pairs, labels; the camera; and which body
 * is under a pixel. Draws only when something has changed. Coordinates are the world's less World.origin; z is up. */
import {
  BufferAttribute, BufferGeometry, Color, LineSegments, Mesh, PerspectiveCamera, Scene, ShaderMaterial, SRGBColorSpace, Vector3,
  WebGLRenderTarget, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { Fact, Flag, Shape, factWord, type Body, type Contact, type SoftShape, type World } from "../../client/src/index.js";
import { lengthText, secondsText } from "./format.js";
import { Instances, drawn, type Instance, type Theme } from "./instances.js";
import { MARKS_MOST, Marks } from "./marks.js";
import { Shading } from "./shapes.js";

/** Predicted pairs whose two bodies are drawn as ghosts: the soonest. */
const GHOST_PAIRS = 32;
const LABELS = 6;

export interface Selection { body: number | null; contact: bigint | null }

function cssColour(style: CSSStyleDeclaration, name: string): Color {
  return new Color().setStyle(style.getPropertyValue(name).trim() || "#808080", SRGBColorSpace).convertLinearToSRGB();
}

/** The colours of the style sheet: what is shown follows the scheme that the reader's system has. */
export function themeOf(element: Element): Theme {
  const s = getComputedStyle(element), c = (n: string): Color => cssColour(s, n);
  return {
    palette: Array.from({ length: 10 }, (_, i) => c(`--body-${i}`)), ink: c("--ink"), paper: c("--scene"),
    hot: c("--touching"), warm: c("--near"), violet: c("--predicted"), cold: c("--undecided"),
  };
}

/** A colour for each owner, the same each time; what is fixed has the last one. */
export function colourOf(body: Body, flags: number): number {
  if ((flags & Flag.fixed) !== 0) return 9;
  let h = 2166136261;
  for (const ch of body.owner) h = Math.imul(h ^ ch.codePointAt(0)!, 16777619);
  return (h >>> 8) % 9;
}

/** Lines at z = 0 of the world, ten a side; placed and scaled to what is looked at, by powers of ten of a metre. */
function grid(theme: Theme): LineSegments {
  const points: number[] = [], n = 20;
  for (let i = -n; i <= n; i++) points.push(i, -n, 0, i, n, 0, -n, i, 0, n, i, 0);
  const g = new BufferGeometry();
  g.setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
  const lines = new LineSegments(g, new ShaderMaterial({
    uniforms: { ink: { value: theme.ink } }, glslVersion: "300 es", transparent: true, depthWrite: false,
    vertexShader: "out vec2 at; void main() { at = position.xy / 20.0; gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); }",
    fragmentShader: "precision highp float; in vec2 at; uniform vec3 ink; out vec4 colour; void main() { colour = vec4(ink, 0.2 * max(0.0, 1.0 - 1.6 * length(at))); }",
  }));
  lines.frustumCulled = false;
  return lines;
}

/** Does a processor draw, since there is no graphics card that a browser takes? Then pictures are to be cheap and few. */
function isSoftware(): boolean {
  const c = document.createElement("canvas").getContext("webgl2", { failIfMajorPerformanceCaveat: true });
  c?.getExtension("WEBGL_lose_context")?.loseContext();
  return c === null;
}

export class View {
  readonly renderer: WebGLRenderer;
  readonly camera = new PerspectiveCamera(42, 1, 0.01, 1000);
  private readonly scene = new Scene();
  private readonly controls: OrbitControls;
  private readonly bodies: Instances;
  private readonly ghosts: Instances;
  private readonly marks: Marks;
  private readonly software: boolean;
  private notBefore = 0;
  private readonly grid: LineSegments;
  private readonly target = new WebGLRenderTarget(1, 1);
  private readonly softMeshes = new Map<string, { mesh: Mesh; version: number; eye: ShaderMaterial; number: ShaderMaterial }>();
  private readonly labels: HTMLElement[] = [];
  private readonly seen = { scene: -1, geometry: -1, pose: -1, contact: -1, soft: -1, slots: -1 };
  private looks = new Uint8Array(4 * 64);
  private shownContacts: Contact[] = [];
  private labelled: Contact[] = [];
  private dirty = true;
  private framed = false;
  private reach = 1;
  private readonly lastOrigin = new Float64Array(3);
  /** Of the last picture. */
  drawCalls = 0;
  showMarks = true;
  showGhosts = true;

  constructor(private readonly world: World, private readonly canvas: HTMLCanvasElement, overlay: HTMLElement,
    private readonly selection: Selection, readonly theme: Theme) {
    this.software = isSoftware();
    this.renderer = new WebGLRenderer({ canvas, antialias: !this.software, powerPreference: "high-performance" });
    this.renderer.outputColorSpace = SRGBColorSpace;
    this.renderer.setClearColor(theme.paper.clone().convertSRGBToLinear(), 1);
    this.bodies = new Instances(theme, false);
    this.ghosts = new Instances(theme, true);
    this.marks = new Marks(theme);
    this.grid = grid(theme);
    this.scene.add(this.grid, this.bodies.group, this.ghosts.group, this.marks.group);
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(3, -4, 2.5);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = !matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.controls.dampingFactor = 0.15;
    this.controls.addEventListener("change", () => { this.dirty = true; });
    for (let i = 0; i < LABELS; i++) {
      const label = document.createElement("div");
      label.className = "label";
      label.hidden = true;
      overlay.append(label);
      this.labels.push(label);
    }
    new ResizeObserver(() => { this.resize(); this.dirty = true; }).observe(canvas);
    this.resize();
  }

  private resize(): void {
    const ratio = Math.min(2, devicePixelRatio), w = Math.max(1, this.canvas.clientWidth), h = Math.max(1, this.canvas.clientHeight);
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(w, h, false);
    this.target.setSize(Math.round(w * ratio), Math.round(h * ratio));
    this.camera.aspect = w / h;
    this.camera.updateProjectionMatrix();
    this.bodies.setPixelRatio(ratio);
    this.ghosts.setPixelRatio(ratio);
    this.marks.resize(w * ratio, h * ratio, ratio);
  }

  /** The bodies that a view has to show, and how far they reach: half-spaces have no end, and do not count. */
  private extent(only: Body | null): { middle: Vector3; reach: number } | null {
    const low = new Vector3(Infinity, Infinity, Infinity), high = low.clone().negate(), p = this.world.poses;
    for (const body of only ? [only] : this.world.bodies.values()) {
      let reach = 0;
      for (const s of body.shapes) {
        if (s.type === Shape.halfspace || s.type === Shape.compound) continue;
        let r = Math.hypot(...s.half);
        const g = s.type >= Shape.hull ? this.world.geometries.get(s.geometry) : undefined;
        if (g && g.of < 3) for (let i = 0; i + 2 < g.numbers.length; i += 3)
          r = Math.max(r, Math.hypot(g.numbers[i]!, g.numbers[i + 1]!, g.numbers[i + 2]!));
        reach = Math.max(reach, r + s.radius + Math.hypot(s.pose[0]!, s.pose[1]!, s.pose[2]!));
      }
      if (reach === 0) continue;
      const at = new Vector3().fromArray(p, 8 * body.slot), r = new Vector3(reach, reach, reach);
      if (!Number.isFinite(at.x)) continue;
      low.min(at.clone().sub(r));
      high.max(at.clone().add(r));
    }
    if (!(low.x <= high.x)) return null;
    return { middle: low.clone().add(high).multiplyScalar(0.5), reach: Math.max(1e-9, low.distanceTo(high) / 2) };
  }

  /** Puts the camera where all bodies, or this one, can be seen. */
  frame(only: Body | null = null): void {
    const e = this.extent(only);
    if (!e) return;
    const direction = this.framed ? this.camera.position.clone().sub(this.controls.target).normalize() :
      new Vector3(0.62, -0.92, 0.55).normalize();
    this.framed = true;
    this.controls.target.copy(e.middle);
    this.camera.position.copy(e.middle).addScaledVector(direction, (e.reach * (only ? 2.6 : 1.55)) / Math.tan((this.camera.fov * Math.PI) / 360) / Math.min(1, this.camera.aspect) * 0.33);
    this.controls.update();
    this.dirty = true;
  }

  /** Looks from `eye` at `at`, both in the world: for tests and films. */
  look(eye: [number, number, number], at: [number, number, number]): void {
    this.followOrigin();
    const o = this.world.origin;
    this.camera.position.set(eye[0] - o[0]!, eye[1] - o[1]!, eye[2] - o[2]!);
    this.controls.target.set(at[0] - o[0]!, at[1] - o[1]!, at[2] - o[2]!);
    this.framed = this.dirty = true;
    this.controls.update();
    this.camera.updateMatrixWorld();
  }

  /** Turns the camera around what it looks at (radians), and moves it nearer by a factor. */
  orbit(turn: number, tilt: number, nearer: number): void {
    const d = this.camera.position.clone().sub(this.controls.target), length = d.length() * nearer;
    const azimuth = Math.atan2(d.y, d.x) + turn;
    const elevation = Math.max(-1.5, Math.min(1.5, Math.asin(d.z / d.length()) + tilt));
    d.set(Math.cos(azimuth) * Math.cos(elevation), Math.sin(azimuth) * Math.cos(elevation), Math.sin(elevation)).multiplyScalar(length);
    this.camera.position.copy(this.controls.target).add(d);
    this.controls.update();
    this.dirty = true;
  }

  /** What the view looks at, in the world. */
  lookedAt(): [number, number, number] {
    const t = this.controls.target, o = this.world.origin;
    return [t.x + o[0]!, t.y + o[1]!, t.z + o[2]!];
  }

  changed(): void { this.dirty = true; this.seen.contact = -1; }

  private followOrigin(): void {
    const d = new Vector3(...[0, 1, 2].map((k) => this.lastOrigin[k]! - this.world.origin[k]!) as [number, number, number]);
    if (d.lengthSq() === 0) return;
    this.camera.position.add(d);
    this.controls.target.add(d);
    this.lastOrigin.set(this.world.origin);
    this.controls.update();
  }

  private takeScene(): void {
    const all: Instance[] = [];
    for (const body of this.world.bodies.values())
      if (!(this.flags(body) & Flag.soft) || !this.hasSoft(body)) drawn(body, body.slot, all);
    this.bodies.fill(all, this.world.geometries);
    if (!this.framed) this.frame();
    this.reach = this.extent(null)?.reach ?? 1;
  }

  private hasSoft(body: Body): boolean {
    return body.shapes.some((s) => this.world.soft.has(`${body.id} ${s.index}`));
  }

  private flags(body: Body): number { return this.world.poses[8 * body.slot + 3]!; }

  private takeLooks(): void {
    const w = this.world;
    if (4 * w.slots > this.looks.length) this.looks = new Uint8Array(8 * w.slots);
    this.looks.fill(0);
    for (const b of w.bodies.values()) this.looks[4 * b.slot + 1] = colourOf(b, this.flags(b));
    const tone = (id: number, t: number): void => {
      const b = w.bodies.get(id);
      if (b) this.looks[4 * b.slot] = Math.max(this.looks[4 * b.slot]!, t);
    };
    for (const c of w.contacts.values()) {
      const t = c.fact === Fact.begin ? 3 : c.fact === Fact.predicted ? 2 : c.fact === Fact.near ? 1 : 0;
      tone(c.bodyA, t);
      tone(c.bodyB, t);
    }
    const selected = (id: number | null | undefined): void => {
      const b = id === null || id === undefined ? undefined : w.bodies.get(id);
      if (b) this.looks[4 * b.slot + 2] = 1;
    };
    selected(this.selection.body);
    const pair = this.selection.contact === null ? undefined : w.contacts.get(this.selection.contact);
    selected(pair?.bodyA);
    selected(pair?.bodyB);
    this.bodies.setLooks(this.looks, w.slots);
  }

  private takeContacts(): void {
    const w = this.world;
    let list = [...w.contacts.values()];
    if (list.length > MARKS_MOST) list = list.sort((a, b) => a.lo - b.lo).slice(0, MARKS_MOST);
    this.shownContacts = list;
    const order = (c: Contact): number => c.id === this.selection.contact ? -Infinity : c.fact === Fact.predicted ? c.lo - 0.05 : c.lo;
    this.labelled = list.filter((c) => Number.isFinite(c.values[10]!)).sort((a, b) => order(a) - order(b)).slice(0, LABELS);
    const strong = new Set(this.labelled.map((c) => c.id));
    for (const c of list) if (c.fact === Fact.begin || c.fact === Fact.predicted) strong.add(c.id);
    this.marks.fill(this.showMarks ? list : [], w.origin, strong);
    const soon = this.showGhosts ? list.filter((c) => c.fact === Fact.predicted && Number.isFinite(c.values[16]!))
      .sort((a, b) => a.loS - b.loS).slice(0, GHOST_PAIRS) : [];
    const ghosts: Instance[] = [], poses = new Float32Array(8 * 2 * Math.max(1, soon.length));
    soon.forEach((c, i) => {
      for (const side of [0, 1]) {
        const body = w.bodies.get(side ? c.bodyB : c.bodyA), slot = 2 * i + side, from = side ? 23 : 16;
        if (!body || (this.flags(body) & Flag.fixed) !== 0) continue; // it is where it is
        for (let k = 0; k < 3; k++) poses[8 * slot + k] = c.values[from + k]! - w.origin[k]!;
        for (let k = 0; k < 4; k++) poses[8 * slot + 4 + k] = c.values[from + 3 + k]!;
        drawn(body, slot, ghosts);
      }
    });
    this.ghosts.fill(ghosts, w.geometries);
    this.ghosts.setPoses(poses, 2 * soon.length);
  }

  private softMesh(key: string, s: SoftShape): void {
    const body = this.world.bodies.get(s.body), shape = body?.shapes.find((x) => x.index === s.shape);
    const geometry = shape ? this.world.geometries.get(shape.geometry) : undefined;
    if (!body || !geometry || geometry.of !== 2) return;
    let m = this.softMeshes.get(key);
    if (!m) {
      const g = new BufferGeometry();
      g.setAttribute("position", new BufferAttribute(new Float32Array(s.positions.length), 3));
      g.setIndex(new BufferAttribute(new Uint32Array(geometry.indices), 1));
      g.setAttribute("normal", new BufferAttribute(new Float32Array(s.positions.length), 3));
      const [eye, number] = this.bodies.programs(Shading.flat, body.slot);
      m = { mesh: new Mesh(g, eye), version: -1, eye, number };
      m.mesh.frustumCulled = false;
      this.softMeshes.set(key, m);
      this.scene.add(m.mesh);
    }
    const at = m.mesh.geometry.getAttribute("position") as BufferAttribute;
    for (let i = 0; i < s.positions.length && i < at.array.length; i++)
      at.array[i] = s.positions[i]! + s.origin[i % 3]! - this.world.origin[i % 3]!;
    at.needsUpdate = true;
    m.version = s.version;
  }

  private takeSoft(): void {
    for (const [key, m] of this.softMeshes)
      if (!this.world.soft.has(key)) {
        m.mesh.removeFromParent();
        m.mesh.geometry.dispose();
        m.eye.dispose();
        m.number.dispose();
        this.softMeshes.delete(key);
      }
    for (const [key, s] of this.world.soft) if (this.softMeshes.get(key)?.version !== s.version) this.softMesh(key, s);
  }

  private placeLabels(): void {
    const w = this.world, v = new Vector3(), width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    const taken: [number, number][] = [];
    this.labels.forEach((label, i) => {
      const c = this.showMarks ? this.labelled[i] : undefined;
      if (c) {
        for (let k = 0; k < 3; k++) v.setComponent(k, (c.values[10 + k]! + c.values[13 + k]!) / 2 - w.origin[k]!);
        v.project(this.camera);
      }
      const x = Math.round(((v.x + 1) / 2) * width), y = Math.round(((1 - v.y) / 2) * height);
      const free = c && v.z < 1 && x > 0 && y > 0 && x < width - 40 && y < height && !taken.some(([tx, ty]) => Math.abs(tx - x) < 150 && Math.abs(ty - y) < 26);
      label.hidden = !free;
      if (!free || !c) return;
      taken.push([x, y]);
      const what = c.fact === Fact.predicted ? `predicted in ${secondsText(c.loS)}` : c.fact === Fact.unknown ? "unknown" :
        c.fact === Fact.begin ? `touching ${lengthText(c.lo)}` : lengthText(c.lo);
      if (label.textContent !== what) label.textContent = what;
      label.dataset["fact"] = factWord(c.fact);
      label.style.transform = `translate(${x + 10}px, ${y - 26}px)`;
    });
  }

  /** Draws what has changed since the last time; false if nothing had. */
  draw(): boolean {
    const w = this.world, s = this.seen;
    this.followOrigin();
    if (this.controls.enableDamping) this.controls.update();
    const scene = s.scene !== w.sceneVersion || s.geometry !== w.geometryVersion || (s.soft !== w.softVersion && w.soft.size !== this.softMeshes.size);
    const contact = s.contact !== w.contactVersion || scene, pose = s.pose !== w.poseVersion || scene, soft = s.soft !== w.softVersion || scene;
    if (!this.dirty && !scene && !contact && !pose && !soft) return false;
    const begin = performance.now();
    if (begin < this.notBefore) return false; // drawing takes half of the time at most
    if (scene) this.takeScene();
    if (soft) this.takeSoft();
    if (pose) this.bodies.setPoses(w.poses, w.slots);
    if (contact) this.takeContacts();
    if (contact || scene) this.takeLooks();
    Object.assign(s, { scene: w.sceneVersion, geometry: w.geometryVersion, pose: w.poseVersion, contact: w.contactVersion, soft: w.softVersion });
    this.dirty = false;
    const d = this.camera.position.distanceTo(this.controls.target), step = 10 ** Math.round(Math.log10(d / 6));
    const corner = (k: number): number => Math.round(this.lookedAt()[k]! / step) * step - w.origin[k]!;
    this.grid.position.set(corner(0), corner(1), -w.origin[2]!);
    this.grid.scale.setScalar(step);
    this.camera.near = Math.max(d / 500, 1e-7);
    this.camera.far = d * 20 + this.reach * 20;
    this.camera.updateProjectionMatrix();
    this.renderer.render(this.scene, this.camera);
    this.drawCalls = this.renderer.info.render.calls;
    this.placeLabels();
    const took = performance.now() - begin;
    this.notBefore = took > 12 ? performance.now() + Math.min(took, 1000) : 0;
    return true;
  }

  /** How many pairs the picture has, which may be fewer than the table. */
  get pairsDrawn(): number { return this.shownContacts.length; }

  /** The bodies at these points of the canvas (CSS pixels), by numbers drawn into a buffer of their own; null = none. */
  bodiesAt(points: readonly [number, number][]): (Body | null)[] {
    this.bodies.setPoses(this.world.poses, this.world.slots);
    this.bodies.asNumbers(true);
    this.ghosts.asNumbers(true);
    this.marks.group.visible = this.grid.visible = false;
    for (const m of this.softMeshes.values()) m.mesh.material = m.number;
    this.renderer.setRenderTarget(this.target);
    this.renderer.setClearColor(0, 0);
    this.renderer.clear();
    this.renderer.render(this.scene, this.camera);
    const ratio = this.renderer.getPixelRatio(), out = new Uint8Array(4), bySlot = new Map<number, Body>();
    for (const b of this.world.bodies.values()) bySlot.set(b.slot, b);
    const found = points.map(([x, y]) => {
      this.renderer.readRenderTargetPixels(this.target, Math.round(x * ratio), this.target.height - 1 - Math.round(y * ratio), 1, 1, out);
      const n = out[0]! + 256 * out[1]! + 65536 * out[2]!;
      return n === 0 ? null : bySlot.get(n - 1) ?? null;
    });
    this.renderer.setRenderTarget(null);
    this.renderer.setClearColor(this.theme.paper.clone().convertSRGBToLinear(), 1);
    this.bodies.asNumbers(false);
    this.ghosts.asNumbers(false);
    this.marks.group.visible = this.grid.visible = true;
    for (const m of this.softMeshes.values()) m.mesh.material = m.eye;
    this.dirty = true;
    return found;
  }

  /** Where a point of the world is on the canvas, CSS pixels. */
  project(at: [number, number, number]): [number, number] {
    const o = this.world.origin, v = new Vector3(at[0] - o[0]!, at[1] - o[1]!, at[2] - o[2]!).project(this.camera);
    return [((v.x + 1) / 2) * this.canvas.clientWidth, ((1 - v.y) / 2) * this.canvas.clientHeight];
  }
}
