/* panel: the body or pair that is selected: its interval, ages, axis, rules, and whether its proof holds. Text only. */
import {
  Fact, Flag, achievedNames, factWord, isUnknown, numberOf, shapeNames, type AnswerFrame, type Body, type Checker, type Contact, type World,
} from "../../client/src/index.js";
import { claimOf, prove, type Verdict } from "../../client/src/checker.js";
import { ageText, lengthText, secondsText } from "./format.js";
import type { Selection } from "./view.js";

export interface Asker { ask(what: string, members: object): Promise<AnswerFrame>; readonly live: boolean }

function element<K extends keyof HTMLElementTagNameMap>(tag: K, className = "", text = ""): HTMLElementTagNameMap[K] {
  const e = document.createElement(tag);
  if (className) e.className = className;
  if (text) e.textContent = text;
  return e;
}

/** Names and values, which change where their text does. */
class Facts {
  readonly list = element("dl", "facts");
  private readonly values = new Map<string, HTMLElement>();
  set(name: string, text: string): HTMLElement {
    let dd = this.values.get(name);
    if (!dd) {
      dd = element("dd");
      this.list.append(element("dt", "", name), dd);
      this.values.set(name, dd);
    }
    if (dd.textContent !== text) dd.textContent = text;
    return dd;
  }
}

export function flagWords(flags: number): string[] {
  const words: [number, string][] = [[Flag.stale, "stale"], [Flag.unknown, "unknown"], [Flag.pending, "pending"], [Flag.fixed, "fixed"],
    [Flag.soft, "soft"], [Flag.swept, "swept"], [Flag.oneWay, "one-way"]];
  return words.filter(([bit]) => (flags & bit) !== 0).map(([, word]) => word);
}

const vector = (v: ArrayLike<number>): string => Array.from(v, (x) => x.toFixed(6)).join("  ");
const bits = (v: ArrayLike<number>): string => Array.from(v, String).join("  ");

/** The interval on a logarithmic scale from 1 um to 100 m; what is negative is a depth, and is left of the middle. */
function drawScale(canvas: HTMLCanvasElement, c: Contact, colour: string): void {
  const ratio = Math.min(2, devicePixelRatio), w = canvas.clientWidth, h = canvas.clientHeight, g = canvas.getContext("2d");
  if (!g || w === 0) return;
  canvas.width = w * ratio;
  canvas.height = h * ratio;
  g.scale(ratio, ratio);
  const style = getComputedStyle(canvas), decades = 8, deep = Math.min(c.lo, c.hi) < 0;
  const x = (m: number): number => {
    const a = Math.max(0, Math.min(1, (Math.log10(Math.max(Math.abs(m), 1e-6)) + 6) / decades));
    return 4 + (w - 8) * (deep ? 0.5 + (Math.sign(m) * a) / 2 : a);
  };
  g.strokeStyle = style.getPropertyValue("--line");
  g.fillStyle = style.getPropertyValue("--soft");
  g.font = `10px ${style.fontFamily}`;
  g.textAlign = "center";
  for (const m of deep ? [-1, -1e-3, 1e-3, 1] : [1e-6, 1e-4, 1e-2, 1, 100]) {
    g.beginPath();
    g.moveTo(x(m), 4);
    g.lineTo(x(m), 18);
    g.stroke();
    g.fillText(Math.abs(m) >= 1 ? `${m} m` : Math.abs(m) >= 1e-3 ? `${m * 1e3} mm` : `${Math.round(m * 1e6)} µm`, Math.max(14, Math.min(w - 14, x(m))), 30);
  }
  g.fillStyle = colour;
  const from = x(Number.isFinite(c.lo) ? c.lo : -100), to = x(Number.isFinite(c.hi) ? c.hi : 100);
  g.fillRect(Math.min(from, to) - 1.5, 6, Math.abs(to - from) + 3, 10);
}

export class Panel {
  private shown = "";
  private facts = new Facts();
  private readonly big = element("p", "big");
  private readonly width = element("p", "empty");
  private readonly scale = element("canvas", "scale-bar");
  private readonly verdict = element("p", "verdict");
  private readonly text = element("pre");
  private contact: Contact | null = null;
  private body: Body | null = null;

  constructor(private readonly into: HTMLElement, private readonly title: HTMLElement, private readonly world: World,
    private readonly selection: Selection, private readonly asker: Asker, private readonly checker: () => Checker | null,
    private readonly onSelect: (s: Selection) => void) {
    this.text.id = "answer";
    this.text.setAttribute("role", "status");
    this.verdict.id = "verdict";
    this.verdict.setAttribute("role", "status");
    this.scale.setAttribute("aria-hidden", "true");
  }

  /** The pair that is shown where nobody selected one: the nearest, predicted ones by what they come to. */
  private nearest(): Contact | null {
    let best: Contact | null = null;
    for (const c of this.world.contacts.values())
      if (Number.isFinite(c.lo) && (!best || c.lo < best.lo)) best = c;
    return best;
  }

  private begin(key: string, title: string): boolean {
    if (this.shown === key) return false;
    this.shown = key;
    this.title.textContent = title;
    this.text.textContent = "";
    this.verdict.textContent = "";
    delete this.verdict.dataset["verdict"];
    this.facts = new Facts();
    this.into.replaceChildren();
    return true;
  }

  private button(text: string, id: string, act: () => void): HTMLButtonElement {
    const b = element("button", "", text);
    b.type = "button";
    b.id = id;
    b.addEventListener("click", act);
    return b;
  }

  update(): void {
    const chosen = this.selection.contact === null ? undefined : this.world.contacts.get(this.selection.contact);
    const body = this.selection.body === null ? undefined : this.world.bodies.get(this.selection.body);
    if (chosen) this.showPair(chosen, true);
    else if (body) this.showBody(body);
    else if (this.selection.contact !== null && this.contact) this.ended();
    else {
      const c = this.nearest();
      if (c) this.showPair(c, false);
      else if (this.begin("none", "Nearest pair"))
        this.into.append(element("p", "empty", "No pair is touching, near, predicted or unknown. Select a body in the picture or in the table."));
    }
  }

  private ended(): void {
    if (this.big.textContent !== "it has ended") this.big.textContent = "it has ended";
  }

  private async explain(a: string, b: string): Promise<void> {
    this.text.textContent = "asking …";
    try {
      const f = await this.asker.ask("explain", { a, b });
      this.text.textContent = f.status === "ok" ? f.text : `${f.status}: ${f.text}`;
    } catch (e) {
      this.text.textContent = e instanceof Error ? e.message : String(e);
    }
  }

  private prove(): void {
    const c = this.contact, checker = this.checker();
    if (!c) return;
    if (!checker) {
      this.verdict.textContent = "this browser gives no WebAssembly: it cannot be checked here";
      return;
    }
    const verdict = prove(checker, this.world, c);
    const begin = performance.now();
    let rounds = 0;
    for (; rounds < 2000 && performance.now() - begin < 5; rounds++) prove(checker, this.world, c);
    const each = (1000 * (performance.now() - begin)) / rounds;
    this.verdict.dataset["verdict"] = verdict;
    const words: Record<Verdict, string> = {
      proven: `proven by code in your browser, in ${each.toFixed(1)} µs: the axis keeps them ${lengthText(c.lo)} apart, the points are ${lengthText(c.hi)} from each other`,
      refused: "REFUSED: axis and points do not prove this interval. It is not what the daemon computed",
      unsupported: "cannot be proven by an axis and two points: one of them is not convex. It is the daemon's word",
      missing: "cannot be checked: poses, shapes or geometry of it are not here, or nothing is known",
    };
    this.verdict.textContent = words[verdict] + this.kernelText(checker, c);
  }

  /** What the small checker that a machine has proven makes of the same axis and points. */
  private kernelText(checker: Checker, c: Contact): string {
    const claim = claimOf(this.world, c);
    if (typeof claim === "string") return "";
    const k = checker.kernel(claim);
    return k.lo > -Infinity || k.hi < Infinity ? `. The kernel proves ${lengthText(k.lo)} … ${lengthText(k.hi)}` : "";
  }

  private showPair(c: Contact, selected: boolean): void {
    const a = this.world.nameOf(c.bodyA), b = this.world.nameOf(c.bodyB);
    if (this.begin(`pair ${c.id} ${selected}`, selected ? "Selected pair" : "Nearest pair")) {
      const actions = element("div", "actions");
      const explain = this.button("explain", "explain", () => void this.explain(a, b));
      explain.disabled = !this.asker.live;
      actions.append(explain, this.button("prove", "prove", () => this.prove()),
        this.button("A", "select-a", () => this.onSelect({ body: this.contact!.bodyA, contact: null })),
        this.button("B", "select-b", () => this.onSelect({ body: this.contact!.bodyB, contact: null })));
      actions.children[2]!.setAttribute("aria-label", "select body A");
      actions.children[3]!.setAttribute("aria-label", "select body B");
      this.into.append(element("p", "pair-name", `${a} – ${b}`), this.big, this.width, this.scale, actions, this.verdict, this.text, this.facts.list);
    }
    this.contact = c;
    const unknown = c.fact === Fact.unknown, word = factWord(c.fact);
    const big = unknown ? "unknown" : `${lengthText(c.lo)} … ${lengthText(c.hi)}`;
    if (this.big.textContent !== big) this.big.textContent = big;
    const width = unknown ? "a pose is past its deadline, or its client is gone: it is not free space" :
      `interval ${lengthText(c.hi - c.lo)} wide, ${achievedNames[c.achieved] ?? "wide"}`;
    if (this.width.textContent !== width) this.width.textContent = width;
    drawScale(this.scale, c, getComputedStyle(this.into).getPropertyValue(
      c.fact === Fact.begin ? "--touching" : c.fact === Fact.near ? "--near" : unknown ? "--unknown" : "--predicted"));
    const f = this.facts;
    const state = f.set("is", c.fact === Fact.predicted ? `predicted in ${secondsText(c.loS)} … ${secondsText(c.hiS)}${c.estimated ? ", velocity estimated" : ""}` : word);
    state.className = "state";
    state.dataset["state"] = word;
    f.set("closing", Number.isFinite(c.closing) ? `${c.closing.toFixed(3)} m/s` : "–");
    f.set("ages", `A ${ageText(c.ageA)}, B ${ageText(c.ageB)}`);
    f.set("axis A → B", vector(c.axis));
    f.set("point A", vector(c.pointA));
    f.set("point B", vector(c.pointB));
    f.set("shapes", `A ${this.shapeText(c.bodyA, c.shapeA)}, B ${this.shapeText(c.bodyB, c.shapeB)}`);
    f.set("tick", c.tick.toString());
  }

  private shapeText(body: number, index: number): string {
    const def = this.world.bodies.get(body), found = def ? this.world.shapeOf(def, index) : null;
    return found ? `#${index} ${shapeNames[found.shape.type] ?? "?"}` : `#${index}`;
  }

  private showBody(body: Body): void {
    if (this.begin(`body ${body.id}`, "Selected body")) {
      const actions = element("div", "actions"), other = element("input");
      other.type = "text";
      other.id = "other";
      other.setAttribute("aria-label", "name of another body");
      other.placeholder = "another body";
      const explain = this.button("explain", "explain", () => void this.explain(body.name, other.value));
      explain.disabled = !this.asker.live;
      actions.append(other, explain);
      this.into.append(element("p", "pair-name", body.name), this.big, this.width, actions, this.text, this.facts.list);
      this.width.textContent = "";
      if (this.asker.live) void this.exact(body);
    }
    this.body = body;
    const flags = this.world.flagsOf(body), words = flagWords(flags), f = this.facts;
    const big = isUnknown(flags) ? words.filter((w) => w === "stale" || w === "unknown").join(", ") : words.includes("fixed") ? "fixed" : "moving";
    if (this.big.textContent !== big) this.big.textContent = big;
    f.set("owner", body.owner || "–");
    f.set("group", body.group || "–");
    f.set("flags", words.join(", ") || "none");
    f.set("deadline", body.deadlineS > 0 ? secondsText(body.deadlineS) : "none");
    f.set("position", vector(this.world.positionOf(body)));
    f.set("shapes", body.shapes.map((s) => `#${s.index} ${shapeNames[s.type] ?? "?"} ${s.half.filter((x) => x !== 0).map((x) => lengthText(x)).join(" × ")}${s.radius > 0 ? ` r ${lengthText(s.radius)}` : ""}`).slice(0, 24).join("; "));
    const pairs = [...this.world.contacts.values()].filter((c) => c.bodyA === body.id || c.bodyB === body.id).sort((x, y) => x.lo - y.lo);
    f.set("pairs", pairs.length === 0 ? "none is told" : pairs.slice(0, 8).map((c) => `${this.world.nameOf(c.bodyA === body.id ? c.bodyB : c.bodyA)}: ${factWord(c.fact)} ${Number.isFinite(c.lo) ? lengthText(c.lo) : ""}`).join("; "));
  }

  /** The pose to the last bit, from the daemon. */
  private async exact(body: Body): Promise<void> {
    try {
      const f = await this.asker.ask("body", { a: body.name }), hit = f.hits?.[0];
      if (this.body !== body || this.shown !== `body ${body.id}` || !hit) return;
      this.facts.set("pose when asked", `${bits(hit.position ?? hit.point_a ?? [])}  |  ${bits(hit.orientation ?? [])}`);
      this.facts.set("age when asked", ageText(numberOf(hit.age_s)));
    } catch { /* the connection is told of elsewhere */ }
  }
}
