/* film: a session that lies in the page itself, so that one HTML file shows it from disk: the frames of the protocol, one
 * behind the other, in base64 (gzip, where it says so). Played by their stamps; seeking back begins anew. */
import { Kind, World, decode, type Frame } from "../../client/src/index.js";
import type { Source } from "./source.js";

function octetsOf(element: HTMLElement): Uint8Array<ArrayBuffer> {
  const text = atob((element.textContent ?? "").trim()), out = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) out[i] = text.charCodeAt(i);
  return out;
}

/** The octets of an element of the page, in base64; null if there is no such element. */
export function embeddedOctets(id: string): ArrayBuffer | null {
  const element = document.getElementById(id);
  return element ? octetsOf(element).buffer : null;
}

async function unpacked(element: HTMLElement): Promise<ArrayBuffer> {
  const octets = octetsOf(element);
  if (element.dataset["packed"] !== "gzip") return octets.buffer;
  return new Response(new Blob([octets]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
}

export class FilmSource implements Source {
  readonly live = false;
  playing = true;
  atS = 0;
  readonly lengthS: number;
  private next = 0;
  private readonly stamps: number[] = [];
  private last = performance.now();

  private constructor(private readonly buffers: ArrayBuffer[], frames: Frame[], private readonly world: World) {
    // Frames that begin a scene come at once: time begins with the first poses.
    const first = frames.find((f) => f.kind === Kind.poses)?.stampNs ?? 0n;
    for (const f of frames) {
      const at = Number(f.stampNs - first) / 1e9;
      this.stamps.push(Math.max(this.stamps[this.stamps.length - 1] ?? 0, f.kind === Kind.poses || f.kind === Kind.contacts || f.kind === Kind.events || f.kind === Kind.vertices ? at : 0));
    }
    this.lengthS = this.stamps[this.stamps.length - 1] ?? 0;
  }

  static async open(element: HTMLElement, world: World): Promise<FilmSource> {
    const whole = await unpacked(element), buffers: ArrayBuffer[] = [], frames: Frame[] = [];
    const view = new DataView(whole);
    for (let at = 0; at + 32 <= whole.byteLength;) {
      const octets = view.getUint32(at + 4, true), buffer = whole.slice(at, at + octets), frame = decode(buffer);
      if (frame) {
        buffers.push(buffer);
        frames.push(frame);
      }
      at += octets;
    }
    return new FilmSource(buffers, frames, world);
  }

  seek(s: number): void {
    if (s < this.atS) { // what was taken in cannot be taken out: begin anew
      this.next = 0;
      this.world.forget();
    }
    this.atS = s;
  }

  take(): ArrayBuffer[] {
    const now = performance.now(), out: ArrayBuffer[] = [];
    if (this.playing) this.atS = Math.min(this.lengthS, this.atS + (now - this.last) / 1000);
    this.last = now;
    if (this.playing && this.atS >= this.lengthS) this.playing = false;
    while (this.next < this.buffers.length && this.stamps[this.next]! <= this.atS) out.push(this.buffers[this.next++]!);
    return out;
  }
  send(): void { /* nobody is there */ }
  seen(): void { /* nobody is there */ }
}
