/* timeline: the last seconds of begins and ends, impacts, predictions and gaps, a lane a pair, on a canvas. Kinds differ
 * by shape: touching a full bar, near a thin one, unknown a hatched one, impacts a diamond, predictions a triangle,
 * which is hollow where it was averted, gaps a hatched band over all lanes. */
import { Fact, type EventRecord, type World } from "../../client/src/index.js";

const SPAN_S = 20;
const LANES = 7;
const opens: Record<number, number> = { [Fact.begin]: Fact.end, [Fact.near]: Fact.far, [Fact.unknown]: Fact.known };

interface Bar { fact: number; from: number; to: number }
interface Lane { name: string; last: number; bars: Bar[]; points: { fact: number; at: number }[] }

function seconds(e: EventRecord, now: bigint): number { return Number(e.stampNs - now) / 1e9; }

/** Lanes of the pairs that something happened to last, and the gaps; times in seconds before `now`. */
export function lanesOf(world: World, now: bigint): { lanes: Lane[]; gaps: number[] } {
  const lanes = new Map<string, Lane>(), open = new Map<string, Bar>(), gaps: number[] = [];
  for (const e of world.events) {
    const at = seconds(e, now);
    if (e.kind === Fact.gap) {
      if (at > -SPAN_S) gaps.push(at);
      continue;
    }
    const [a, b] = [world.nameOf(e.bodyA), world.nameOf(e.bodyB)], name = a < b ? `${a} – ${b}` : `${b} – ${a}`;
    let lane = lanes.get(name);
    if (!lane) lanes.set(name, lane = { name, last: at, bars: [], points: [] });
    lane.last = Math.max(lane.last, at);
    if (opens[e.kind] !== undefined) {
      const bar = { fact: e.kind, from: e.snapshot ? -Infinity : at, to: Infinity };
      open.set(`${e.id} ${opens[e.kind]}`, bar);
      lane.bars.push(bar);
    } else if (e.kind === Fact.end || e.kind === Fact.far || e.kind === Fact.known) {
      const bar = open.get(`${e.id} ${e.kind}`);
      if (bar) bar.to = at;
      else lane.bars.push({ fact: e.kind === Fact.end ? Fact.begin : e.kind === Fact.far ? Fact.near : Fact.unknown, from: -Infinity, to: at });
    } else lane.points.push({ fact: e.kind, at });
  }
  const seen = [...lanes.values()].filter((l) => l.last > -SPAN_S || l.bars.some((b) => b.to > -SPAN_S));
  seen.sort((x, y) => y.last - x.last);
  return { lanes: seen.slice(0, LANES), gaps };
}

function hatch(g: CanvasRenderingContext2D, x: number, y: number, w: number, h: number): void {
  g.save();
  g.beginPath();
  g.rect(x, y, w, h);
  g.clip();
  g.beginPath();
  for (let i = x - h; i < x + w; i += 6) {
    g.moveTo(i, y + h);
    g.lineTo(i + h, y);
  }
  g.stroke();
  g.restore();
}

function mark(g: CanvasRenderingContext2D, fact: number, x: number, y: number): void {
  const r = 5;
  g.beginPath();
  if (fact === Fact.impact) {
    g.moveTo(x, y - r - 1); g.lineTo(x + r + 1, y); g.lineTo(x, y + r + 1); g.lineTo(x - r - 1, y);
  } else {
    g.moveTo(x - r, y + r); g.lineTo(x + r, y + r); g.lineTo(x, y - r);
  }
  g.closePath();
  if (fact === Fact.averted) g.stroke(); else g.fill();
}

export class Timeline {
  private readonly g: CanvasRenderingContext2D | null;
  constructor(private readonly canvas: HTMLCanvasElement, private readonly world: World) { this.g = canvas.getContext("2d"); }

  /** Draws the lanes up to the newest stamp. */
  draw(): void {
    const g = this.g, ratio = Math.min(2, devicePixelRatio), w = this.canvas.clientWidth, h = this.canvas.clientHeight;
    if (!g || w === 0) return;
    if (this.canvas.width !== Math.round(w * ratio) || this.canvas.height !== Math.round(h * ratio)) {
      this.canvas.width = Math.round(w * ratio);
      this.canvas.height = Math.round(h * ratio);
    }
    const style = getComputedStyle(this.canvas), colour = (n: string): string => style.getPropertyValue(n).trim();
    const of: Record<number, string> = { [Fact.begin]: colour("--touching"), [Fact.near]: colour("--near"), [Fact.unknown]: colour("--unknown") };
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    g.clearRect(0, 0, w, h);
    g.font = `12px ${style.fontFamily}`;
    g.textBaseline = "middle";
    const left = Math.min(260, w * 0.3), foot = 20, right = 12, width = w - left - right, x = (t: number): number => left + width * (1 + Math.max(-SPAN_S, Math.min(0, t)) / SPAN_S);
    g.strokeStyle = colour("--line");
    g.fillStyle = colour("--soft");
    g.textAlign = "center";
    for (let t = -SPAN_S; t <= 0; t += 5) {
      g.beginPath();
      g.moveTo(Math.round(x(t)) + 0.5, 0);
      g.lineTo(Math.round(x(t)) + 0.5, h - foot);
      g.stroke();
      g.fillText(t === 0 ? "now" : `${t} s`, Math.min(x(t), w - 16), h - foot / 2);
    }
    const { lanes, gaps } = lanesOf(this.world, this.world.stampNs), row = (h - foot) / LANES;
    g.textAlign = "left";
    if (lanes.length === 0) g.fillText("nothing has happened yet", left + 8, row / 2);
    lanes.forEach((lane, i) => {
      const y = row * (i + 0.5);
      g.fillStyle = colour("--ink");
      let name = lane.name;
      while (name.length > 4 && g.measureText(name).width > left - 14) name = `${name.slice(0, -2)}…`;
      g.fillText(name, 0, y);
      for (const b of lane.bars) {
        const from = x(b.from), to = x(b.to), thick = b.fact === Fact.begin ? 10 : b.fact === Fact.near ? 3 : 10;
        if (to <= left) continue;
        g.fillStyle = g.strokeStyle = of[b.fact] ?? colour("--ink");
        if (b.fact === Fact.unknown) hatch(g, from, y - thick / 2, to - from, thick);
        else g.fillRect(from, y - thick / 2, Math.max(1.5, to - from), thick);
      }
      g.fillStyle = g.strokeStyle = colour("--predicted");
      for (const p of lane.points) if (p.at > -SPAN_S) mark(g, p.fact, x(p.at), y);
    });
    g.strokeStyle = colour("--touching");
    for (const t of gaps) hatch(g, x(t) - 3, 0, 6, h - foot);
  }
}
