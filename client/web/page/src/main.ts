/* main: the page. Takes frames in as they come, draws at requestAnimationFrame what is newest, and brings the tables up to
 * date, one a frame, so that no frame takes long. */
import {
  Checker, Connection, Fact, Flag, Kind, World, decode, factNames, factWord, isUnknown, prove, type AnswerFrame, type Body, type Contact, type State,
  type Verdict,
} from "../../client/src/index.js";
import { embeddedOctets, FilmSource } from "./film.js";
import { ageText, clockText, countText, lengthText, secondsText } from "./format.js";
import { Panel, flagWords, type Asker } from "./panel.js";
import { LiveSource, type Source } from "./source.js";
import * as status from "./status.js";
import { Table, ROWS_MOST, type Row } from "./table.js";
import { Timeline } from "./timeline.js";
import { View, themeOf, type Selection } from "./view.js";

const need = <T extends HTMLElement>(id: string): T => document.getElementById(id) as T;
/** Proofs that are checked in a frame: at about 1 us each. */
const PROOFS_A_FRAME = 300;
const TABLE_EVERY_MS = 250;

class Page implements Asker {
  readonly world = new World();
  readonly selection: Selection = { body: null, contact: null };
  view: View | null = null;
  checker: Checker | null = null;
  readonly verdicts = new Map<bigint, { version: number; verdict: Verdict }>();
  /** Script time of the last frames, ms, for whoever measures. */
  readonly frameMs: number[] = [];
  /** What was told and is not proven, the newest hundred, for whoever reports it. */
  readonly refusals: string[] = [];
  private source!: Source;
  private state: State = "connecting";
  private why = "";
  private question = 0;
  private epoch = "";
  private readonly waiting = new Map<number, { resolve: (f: AnswerFrame) => void; timer: ReturnType<typeof setTimeout> }>();
  private readonly asked = new Set<number>();
  private readonly timeline = new Timeline(need<HTMLCanvasElement>("timeline"), this.world);
  private readonly panel: Panel;
  private readonly tables: { at: number; update: () => void }[] = [];
  private counters: status.Counters = new Map();
  private countersBefore: status.Counters = new Map();
  private countersAt = 0n;
  private countersSpan = 1;
  private lastStatus: unknown = null;
  private sorted: Body[] = [];
  private sortedVersion = -1;
  private provenNext: Contact[] = [];
  private lastView = [NaN, NaN, NaN];
  private lastSeen = 0n;
  private lastSpoken = 0;
  private lastFrame = 0;
  private spokenEvent = 0n;
  private lastArrival = performance.now();

  constructor() {
    this.panel = new Panel(need("selected"), need("selected-title"), this.world, this.selection, this, () => this.checker, (s) => this.select(s));
    this.makeTables();
    this.listen();
  }

  get live(): boolean { return this.source.live; }

  async start(): Promise<void> {
    const film = document.getElementById("film");
    const theme = (): ReturnType<typeof themeOf> => themeOf(document.body);
    try {
      this.view = new View(this.world, need("picture"), need("labels"), this.selection, theme());
    } catch {
      need("picture").hidden = true;
      need("tools").hidden = true;
      need("no-picture").hidden = false;
    }
    if (film) this.source = await FilmSource.open(film, this.world);
    else {
      const token = new URLSearchParams(location.hash.slice(1)).get("t") ?? "";
      const url = new URL("ws", location.href);
      url.protocol = url.protocol.replace("http", "ws");
      url.hash = "";
      this.source = new LiveSource(url.href, token, (state, why) => this.connectionIs(state, why));
    }
    matchMedia("(prefers-color-scheme: light)").addEventListener("change", () => location.reload());
    const loop = (): void => {
      this.frame();
      requestAnimationFrame(loop);
    };
    requestAnimationFrame(loop);
    setInterval(() => { if (document.hidden) this.takeFrames(); }, 500); // a hidden page is not drawn, but goes on
    try {
      const octets = embeddedOctets("checker") ?? await (await fetch("verify.wasm")).arrayBuffer();
      this.checker = await Checker.create(octets);
    } catch (e) {
      console.warn("nothing can be checked here:", e);
    }
  }

  private connectionIs(state: State, why: string): void {
    this.state = state;
    this.why = why;
    if (state === "open") this.world.connectionBegins();
    if (state === "lost" || state === "refused") this.asked.clear();
  }

  ask(what: string, members: object): Promise<AnswerFrame> {
    this.question = (this.question + 1) >>> 0;
    const id = this.question;
    return new Promise((resolve, reject) => {
      const timer = setTimeout(() => {
        this.waiting.delete(id);
        reject(new Error("no answer within 10 s"));
      }, 10000);
      this.waiting.set(id, { resolve, timer });
      this.source.send({ op: "ask", id, what, ...members });
    });
  }

  select(s: Selection): void {
    this.selection.body = s.body;
    this.selection.contact = s.contact;
    this.view?.changed();
    for (const t of this.tables) t.at = 0;
  }

  private takeFrames(): void {
    for (const buffer of this.source.take()) {
      const frame = decode(buffer);
      if (!frame) continue;
      this.lastArrival = performance.now();
      if (frame.kind === Kind.hello) this.greet(frame.epoch);
      this.world.apply(frame);
      if (frame.kind === Kind.poses || frame.kind === Kind.contacts) this.lastSeen = frame.number;
    }
    for (const f of this.world.answers.splice(0)) {
      const w = this.waiting.get(f.id);
      if (!w) continue;
      clearTimeout(w.timer);
      this.waiting.delete(f.id);
      w.resolve(f);
    }
    for (const number of this.world.wanted)
      if (!this.asked.has(number) && this.source.live) {
        this.asked.add(number);
        this.question = (this.question + 1) >>> 0;
        this.source.send({ op: "ask", id: this.question, what: "geometry", number });
      }
  }

  private greet(epoch: string): void {
    this.world.connectionBegins();
    this.asked.clear();
    if (this.epoch && this.epoch !== epoch) this.say(`another daemon: epoch ${epoch}`);
    this.epoch = epoch;
    this.source.send({ op: "subscribe", rate_hz: 30, poses: true, contacts: true, events: true });
  }

  private frame(): void {
    const begin = performance.now();
    this.takeFrames();
    this.proveSome();
    const drawn = this.view?.draw() ?? true;
    this.updateTables(begin);
    if (this.lastSeen !== 0n && drawn) {
      this.source.seen(this.lastSeen);
      this.lastSeen = 0n;
    }
    this.tellView();
    this.frameMs.push(performance.now() - begin);
    if (this.frameMs.length > 1000) this.frameMs.splice(0, 500);
  }

  /** Brings tables up to date that are due, the oldest first: as many as take about a millisecond, or, where frames are slow,
   * a tenth of a frame. */
  private updateTables(begin: number): void {
    const allowed = Math.max(1, 0.1 * (begin - this.lastFrame)), from = performance.now();
    this.lastFrame = begin;
    do {
      const now = performance.now(), due = this.tables.reduce((x, y) => (y.at < x.at ? y : x));
      if (now - due.at < TABLE_EVERY_MS) return;
      due.at = now;
      due.update();
    } while (performance.now() - from < allowed);
  }

  private tellView(): void {
    const at = this.view?.lookedAt();
    if (!at || !at.every(Number.isFinite) || Math.hypot(...at.map((x, k) => x - this.lastView[k]!)) < 1) return;
    this.lastView = at;
    this.source.send({ op: "view", at });
  }

  /** Checks what has changed, as many as fit into a frame; all are reached in turn. */
  private proveSome(): void {
    if (!this.checker || !need<HTMLInputElement>("check-all").checked) return;
    if (this.provenNext.length === 0) {
      this.provenNext = [...this.world.contacts.values()].filter((c) => this.verdicts.get(c.id)?.version !== c.version);
      if (this.verdicts.size > 2 * this.world.contacts.size + 100)
        for (const id of this.verdicts.keys()) if (!this.world.contacts.has(id)) this.verdicts.delete(id);
    }
    for (let i = 0; i < PROOFS_A_FRAME && this.provenNext.length > 0; i++) {
      const c = this.provenNext.pop()!, verdict = prove(this.checker, this.world, c);
      if (verdict === "refused" && this.verdicts.get(c.id)?.verdict !== "refused") {
        this.refusals.push(`${factWord(c.fact)} ${this.world.nameOf(c.bodyA)} #${c.shapeA} ${this.world.nameOf(c.bodyB)} #${c.shapeB}: ` +
          `[${c.lo}, ${c.hi}] at tick ${c.tick}, axis ${c.axis}, points ${c.pointA}; ${c.pointB}, poses ${c.poseA}; ${c.poseB}`);
        if (this.refusals.length > 100) this.refusals.shift();
        this.say(`refused: the interval of ${this.world.nameOf(c.bodyA)} and ${this.world.nameOf(c.bodyB)} is not proven`);
      }
      this.verdicts.set(c.id, { version: c.version, verdict });
    }
  }

  private makeTables(): void {
    const pairs = new Table(need("pairs"), "Pairs", [{ title: "pair", name: true }, { title: "is", state: true }, { title: "lo", number: true },
      { title: "hi", number: true }, { title: "closing", number: true }, { title: "ages A, B" }, { title: "in", number: true }, { title: "proof", verdict: true }],
    "No pair is touching, near, predicted or unknown.", (key) => this.select({ body: null, contact: BigInt(key) }));
    const bodies = new Table(need("bodies"), "Bodies", [{ title: "body", name: true }, { title: "is", state: true }, { title: "owner" }, { title: "group" },
      { title: "x, m", number: true }, { title: "y, m", number: true }, { title: "z, m", number: true }, { title: "shapes", number: true }],
    "There are no bodies.", (key) => this.select({ body: Number(key), contact: null }));
    const events = new Table(need("events"), "Events", [{ title: "time" }, { title: "event", state: true }, { title: "A" }, { title: "B" },
      { title: "lo", number: true }, { title: "hi", number: true }, { title: "cause" }, { title: "tick", number: true }], "Nothing has happened yet.");
    const streams = new Table(need("streams"), "Streams", status.streamColumns, "There are no streams.");
    const clients = new Table(need("clients"), "Clients", status.clientColumns, "There are no clients.");
    const latency = new Table(need("latency"), "Latency", status.latencyColumns, "No status has come yet.");
    const stages = new Table(need("stages"), "Pairs by stage", status.stageColumns, "No pair was looked at.");
    const drops = new Table(need("drops"), "Drops by cause", status.dropColumns, "Nothing was dropped or refused.");
    const c = (): [status.Counters, status.Counters, number] => [this.counters, this.countersBefore, this.countersSpan];
    for (const update of [
      () => this.header(), () => this.panel.update(), () => this.timeline.draw(), () => pairs.show(this.pairRows(), this.world.contacts.size),
      () => bodies.show(...this.bodyRows()), () => events.show(this.eventRows(), this.world.events.length), () => this.speak(),
      () => streams.show(status.streamRows(...c())), () => clients.show(status.clientRows(...c())), () => latency.show(status.latencyRows(this.counters)),
      () => stages.show(status.stageRows(...c())), () => drops.show(status.dropRows(...c())),
    ]) this.tables.push({ at: 0, update });
  }

  private pairRows(): Row[] {
    let list = [...this.world.contacts.values()];
    const order = (c: Contact): number => (c.fact === Fact.unknown ? 1e300 : c.lo);
    list = list.sort((a, b) => order(a) - order(b)).slice(0, ROWS_MOST);
    return list.map((c) => ({
      key: String(c.id), state: factWord(c.fact), selected: c.id === this.selection.contact,
      cells: [`${this.world.nameOf(c.bodyA)} – ${this.world.nameOf(c.bodyB)}`, factWord(c.fact), lengthText(c.lo), lengthText(c.hi),
        Number.isFinite(c.closing) ? `${c.closing.toFixed(3)} m/s` : "–", `${ageText(c.ageA)}, ${ageText(c.ageB)}`,
        Number.isNaN(c.loS) ? "" : secondsText(c.loS), this.verdicts.get(c.id)?.verdict ?? ""],
    }));
  }

  private bodyRows(): [Row[], number] {
    if (this.sortedVersion !== this.world.sceneVersion) {
      this.sorted = [...this.world.bodies.values()].sort((a, b) => (a.name < b.name ? -1 : 1));
      this.sortedVersion = this.world.sceneVersion;
    }
    const find = need<HTMLInputElement>("find-body").value, found = find ? this.sorted.filter((b) => b.name.includes(find)) : this.sorted;
    return [found.slice(0, ROWS_MOST).map((b) => {
      const flags = this.world.flagsOf(b), words = flagWords(flags), [x, y, z] = this.world.positionOf(b);
      return {
        key: String(b.id), state: isUnknown(flags) ? "stale" : "", selected: b.id === this.selection.body,
        cells: [b.name, words.join(", ") || "moving", b.owner, b.group, x.toFixed(3), y.toFixed(3), z.toFixed(3), String(b.shapes.length)],
      };
    }), found.length];
  }

  private eventRows(): Row[] {
    const all = this.world.events, causes = this.world.hello?.causes ?? [];
    return all.slice(-ROWS_MOST).reverse().map((e) => ({
      key: String(e.number), state: e.kind === Fact.begin ? "touching" : factNames[e.kind] ?? "",
      cells: e.kind === Fact.gap ? [clockText(e.stampNs), `gap: ${e.id} batches lost`, "", "", "", "", "", String(e.tick)] :
        [clockText(e.stampNs), factNames[e.kind] ?? `kind ${e.kind}`, this.world.nameOf(e.bodyA), this.world.nameOf(e.bodyB), lengthText(e.lo),
          lengthText(e.hi), causes[e.cause] ?? "", String(e.tick)],
    }));
  }

  private takeStatus(): void {
    const s = this.world.status;
    if (!s || s === this.lastStatus) return;
    this.lastStatus = s;
    this.countersBefore = this.counters;
    this.counters = status.countersOf(s);
    this.countersSpan = Math.max(1e-3, Number(s.stampNs - this.countersAt) / 1e9);
    this.countersAt = s.stampNs;
  }

  /** Nearest distance, soonest impact, and the oldest pose of all pairs. */
  private gist(): { nearest: number; soonest: number; oldest: number; touching: number } {
    const g = { nearest: Infinity, soonest: Infinity, oldest: -1, touching: 0 };
    for (const c of this.world.contacts.values()) {
      if (Number.isFinite(c.lo) && c.fact !== Fact.predicted) g.nearest = Math.min(g.nearest, c.lo);
      if (c.fact === Fact.predicted) g.soonest = Math.min(g.soonest, c.loS);
      if (c.fact === Fact.begin) g.touching++;
      g.oldest = Math.max(g.oldest, c.ageA, c.ageB);
    }
    return g;
  }

  private header(): void {
    this.takeStatus();
    const s = this.world.status, silent = performance.now() - this.lastArrival > 3000 && this.source.live, health = need("health");
    const connected = this.state === "open" || !this.source.live;
    const word = !this.source.live ? "film" : !connected ? "silent" : silent ? "silent" : s?.health ?? "starting";
    const limits = s?.limits ? `: ${s.limits}` : "";
    const text = word === "silent" ? (connected ? "daemon not heard" : "no connection") : `${word}${limits}`;
    if (health.textContent !== text) health.textContent = text;
    health.dataset["health"] = word === "film" ? "ready" : word;
    const notice = need("notice");
    const why = this.state === "refused" ? `The server refuses this page: ${this.why}. Open the address that collided-web printed.` :
      this.state === "lost" || this.state === "connecting" && this.world.hello ? `No connection to collided-web: ${this.why}. It is tried again; what is shown is old.` :
      s && !s.connected ? "The daemon is not heard. What is shown is old; it is looked for." :
      this.refusedNow() > 0 ? `${this.refusedNow()} of the intervals shown are NOT proven by their axis and points.` : "";
    notice.hidden = why === "";
    if (notice.textContent !== why) notice.textContent = why;
    const g = this.gist(), w = this.world, c = this.counters;
    const figures: [string, string][] = [
      ["nearest", lengthText(g.nearest === Infinity ? NaN : g.nearest)], ["touching", countText(g.touching)],
      ["soonest impact", g.soonest === Infinity ? "–" : secondsText(g.soonest)], ["oldest pose", ageText(g.oldest)],
      ["tick p50, p99", c.has("tick_p50_ns") ? `${secondsText(c.get("tick_p50_ns")! / 1e9)}, ${secondsText(c.get("tick_p99_ns")! / 1e9)}` : "–"],
      ["frames skipped", countText(w.skippedPoses + w.skippedContacts)], ["events missed", countText(w.missedEvents + Number(w.lostFrames))],
      ["tick", w.tick.toString()],
    ];
    const list = need("figures");
    figures.forEach(([name, value], i) => {
      let row = list.children[i] as HTMLElement | undefined;
      if (!row) {
        row = document.createElement("div");
        row.append(document.createElement("dt"), document.createElement("dd"));
        row.firstElementChild!.textContent = name;
        list.append(row);
      }
      const dd = row.lastElementChild!;
      if (dd.textContent !== value) dd.textContent = value;
    });
    const about = `${w.hello ? `release ${w.hello.release}, ${w.hello.uri}, epoch ${w.hello.epoch}. ` : ""}` +
      `${w.contactsLeftOut > 0 ? `${countText(w.contactsLeftOut)} pairs are left out, since there are too many. ` : ""}` +
      `${this.view && this.view.pairsDrawn < w.contacts.size ? `The picture has the nearest ${this.view.pairsDrawn} of ${countText(w.contacts.size)} pairs. ` : ""}` +
      "Not safety-rated: do not let a human's safety depend on it alone.";
    if (need("about").textContent !== about) need("about").textContent = about;
    this.showPlayback();
  }

  private refusedNow(): number {
    let n = 0;
    for (const id of this.world.contacts.keys()) if (this.verdicts.get(id)?.verdict === "refused") n++;
    return n;
  }

  private showPlayback(): void {
    const film = this.source instanceof FilmSource ? this.source : null, p = this.world.status?.playback, r = this.world.hello?.recording;
    need("playback").hidden = !film && !(p && r);
    if (need("playback").hidden) return;
    const span = film ? film.lengthS : Number(BigInt(r!.end_ns) - BigInt(r!.begin_ns)) / 1e9;
    const at = film ? film.atS : Number(BigInt(p!.at_ns) - BigInt(r!.begin_ns)) / 1e9;
    const position = need<HTMLInputElement>("position");
    if (document.activeElement !== position || film?.playing) position.value = String(Math.round((1000 * at) / Math.max(span, 1e-9)));
    need("position-text").textContent = `${at.toFixed(2)} of ${span.toFixed(2)} s`;
    const word = (film ? film.playing : p!.state === "playing") ? "pause" : "play";
    if (need("play").textContent !== word) need("play").textContent = word;
  }

  private play(): void {
    if (this.source instanceof FilmSource) this.source.playing = !this.source.playing;
    else this.source.send({ op: "control", do: this.world.status?.playback?.state === "playing" ? "pause" : "play" });
  }

  private seek(share: number): void {
    if (this.source instanceof FilmSource) return this.source.seek(share * this.source.lengthS);
    const r = this.world.hello?.recording;
    if (!r) return;
    const span = BigInt(r.end_ns) - BigInt(r.begin_ns);
    this.source.send({ op: "control", do: "seek", at_ns: String(BigInt(r.begin_ns) + (span * BigInt(Math.round(share * 1e6))) / 1000000n) });
  }

  private say(text: string): void {
    need("spoken").textContent = text;
    this.lastSpoken = performance.now();
  }

  /** Contacts that begin are read out, at most one in two seconds, with how many there were. */
  private speak(): void {
    if (performance.now() - this.lastSpoken < 2000) return;
    const begun = this.world.events.filter((e) => e.kind === Fact.begin && !e.snapshot && e.number > this.spokenEvent), last = begun[begun.length - 1];
    if (!last) return;
    this.spokenEvent = last.number;
    this.say(`${this.world.nameOf(last.bodyA)} touches ${this.world.nameOf(last.bodyB)}${begun.length > 1 ? `, and ${begun.length - 1} more contacts began` : ""}`);
  }

  private listen(): void {
    const canvas = need<HTMLCanvasElement>("picture");
    let down: [number, number] | null = null;
    canvas.addEventListener("pointerdown", (e) => { down = [e.offsetX, e.offsetY]; });
    canvas.addEventListener("pointerup", (e) => {
      if (!down || Math.hypot(e.offsetX - down[0], e.offsetY - down[1]) > 4) return;
      this.pick(e.offsetX, e.offsetY);
    });
    canvas.addEventListener("keydown", (e) => { if (this.key(e.key)) e.preventDefault(); });
    need("frame-all").addEventListener("click", () => this.view?.frame());
    need<HTMLInputElement>("show-pairs").addEventListener("change", (e) => {
      if (this.view) this.view.showMarks = (e.target as HTMLInputElement).checked;
      this.view?.changed();
    });
    need<HTMLInputElement>("show-ghosts").addEventListener("change", (e) => {
      if (this.view) this.view.showGhosts = (e.target as HTMLInputElement).checked;
      this.view?.changed();
    });
    need("play").addEventListener("click", () => this.play());
    need<HTMLInputElement>("position").addEventListener("input", (e) => this.seek(Number((e.target as HTMLInputElement).value) / 1000));
  }

  /** Selects what is at this point: a body; of the pair that is selected, once more, its other body. */
  private pick(x: number, y: number): void {
    const body = this.view?.bodiesAt([[x, y]])[0] ?? null;
    this.select({ body: body?.id ?? null, contact: null });
  }

  private key(key: string): boolean {
    const v = this.view;
    if (!v) return false;
    switch (key) {
      case "ArrowLeft": v.orbit(-0.1, 0, 1); return true;
      case "ArrowRight": v.orbit(0.1, 0, 1); return true;
      case "ArrowUp": v.orbit(0, 0.1, 1); return true;
      case "ArrowDown": v.orbit(0, -0.1, 1); return true;
      case "+": case "=": v.orbit(0, 0, 0.87); return true;
      case "-": v.orbit(0, 0, 1.15); return true;
      case "f": case "F": v.frame(); return true;
      case "Escape": this.select({ body: null, contact: null }); return true;
      case "[": case "]": {
        const all = [...this.world.bodies.values()].sort((a, b) => (a.name < b.name ? -1 : 1));
        const at = all.findIndex((b) => b.id === this.selection.body), next = all[(at + (key === "]" ? 1 : all.length - 1 + (at < 0 ? 1 : 0))) % all.length];
        if (next) this.select({ body: next.id, contact: null });
        return true;
      }
      default: return false;
    }
  }
}

const page = new Page();
void page.start();
/** For tests, and for whoever looks in the console. */
(globalThis as { collided?: unknown }).collided = { page, Connection, Flag };
