/* source: where frames come from: a worker that holds the connection, or a film that lies in the page itself. */
import type { State } from "../../client/src/index.js";

export type ToWorker = { op: "connect"; url: string; token: string } | { op: "send"; message: object } | { op: "seen"; number: string };
export type FromWorker = { op: "frame"; buffer: ArrayBuffer } | { op: "state"; state: State; why: string };

export interface Source {
  /** Frames that have come since the last call, in order. */
  take(): ArrayBuffer[];
  send(message: object): void;
  seen(number: bigint): void;
  /** Is there a daemon that can be asked? */
  readonly live: boolean;
}

/** A connection in a worker. */
export class LiveSource implements Source {
  readonly live = true;
  private readonly worker = new Worker("worker.js");
  private queue: ArrayBuffer[] = [];
  constructor(url: string, token: string, onState: (state: State, why: string) => void) {
    this.worker.onmessage = ({ data }: MessageEvent<FromWorker>) => {
      if (data.op === "frame") this.queue.push(data.buffer);
      else onState(data.state, data.why);
    };
    this.post({ op: "connect", url, token });
  }
  private post(m: ToWorker): void { this.worker.postMessage(m); }
  take(): ArrayBuffer[] {
    const taken = this.queue;
    if (taken.length > 0) this.queue = [];
    return taken;
  }
  send(message: object): void { this.post({ op: "send", message }); }
  seen(number: bigint): void { this.post({ op: "seen", number: number.toString() }); }
}
