/* connection: a WebSocket to collided-web that comes back by itself. It says hello with the token, subscribes, hands
 * frames over in their order, asks questions, and after a loss begins anew: a server that is back sends everything. */
import { Kind, ProtocolError, SUBPROTOCOL, decode, type AnswerFrame, type Frame, type GeometryFrame } from "./protocol.js";

/** What is used of a WebSocket: that of a browser, or of the npm package ws, which Node 18 needs. */
export interface Socket {
  binaryType: string;
  onopen: ((e: never) => unknown) | null;
  onclose: ((e: never) => unknown) | null;
  onerror: ((e: never) => unknown) | null;
  onmessage: ((e: never) => unknown) | null;
  readonly readyState: number;
  send(text: string): void;
  close(code?: number, reason?: string): void;
}
export type SocketMaker = new (url: string, protocol: string) => Socket;

export interface Subscription {
  rate_hz?: number; range_m?: number; poses?: boolean; contacts?: boolean; events?: boolean;
}
export interface Options {
  /** ws://HOST:PORT/ws */
  url: string;
  token?: string;
  subscribe?: Subscription;
  /** The WebSocket to be used where there is none: Node 18. */
  WebSocket?: SocketMaker;
  /** s: the waits between attempts begin with the first, and double up to the second. Default 0.25 and 5. */
  retry?: [number, number];
  /** Each frame, in order; `buffer` is the caller's own from then on. A throw ends the connection, and it is made anew. */
  onFrame?: (frame: Frame, buffer: ArrayBuffer) => void;
  /** The connection's state, in a word and a sentence. */
  onState?: (state: State, why: string) => void;
}
/** "refused": the token is wrong, or a message was: it is not tried again. */
export type State = "connecting" | "open" | "lost" | "refused" | "closed";

interface CloseLike { code: number; reason: string }
interface MessageLike { data: unknown }

const OPEN = 1;
/** s after which a question that is not answered has failed. */
const ANSWER_S = 10;

export class Connection {
  private socket: Socket | null = null;
  private ended = false;
  private tries = 0;
  private timer: ReturnType<typeof setTimeout> | null = null;
  private question = 0;
  private readonly waiting = new Map<number, {
    resolve: (f: AnswerFrame | GeometryFrame) => void; reject: (e: Error) => void; timer: ReturnType<typeof setTimeout>;
  }>();
  private readonly queue: Frame[] = [];
  private wake: (() => void) | null = null;
  private iterated = false;
  state: State = "connecting";

  constructor(private readonly options: Options) { this.connect(); }

  private tell(state: State, why: string): void {
    this.state = state;
    this.options.onState?.(state, why);
  }

  private connect(): void {
    const Maker = this.options.WebSocket ?? (globalThis as { WebSocket?: unknown }).WebSocket as SocketMaker | undefined;
    if (!Maker) throw new Error("there is no WebSocket here: hand one over, as of the package ws");
    this.tell("connecting", this.options.url);
    const socket = new Maker(this.options.url, SUBPROTOCOL);
    this.socket = socket;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.send({ op: "hello", token: this.options.token ?? "" });
      this.subscribe(this.options.subscribe ?? {});
    };
    socket.onmessage = (e: never) => this.receive(socket, (e as MessageLike).data);
    socket.onerror = () => undefined; // a close follows, and tells
    socket.onclose = (e: never) => this.closed(socket, e as CloseLike);
  }

  private receive(socket: Socket, data: unknown): void {
    if (socket !== this.socket || this.ended) return;
    try {
      if (!(data instanceof ArrayBuffer)) throw new ProtocolError("a text frame");
      const frame = decode(data);
      if (!frame) return;
      if (frame.kind === Kind.hello) {
        this.tries = 0;
        this.tell("open", this.options.url);
      }
      this.answer(frame);
      if (this.iterated) {
        this.queue.push(frame);
        this.wake?.();
      }
      this.options.onFrame?.(frame, data);
    } catch (e) {
      socket.close(4000, "");
      this.closed(socket, { code: 4000, reason: e instanceof Error ? e.message : String(e) });
    }
  }

  private answer(frame: Frame): void {
    if (frame.kind !== Kind.answer && frame.kind !== Kind.geometry) return;
    const f = frame as AnswerFrame | GeometryFrame, id = f.kind === Kind.answer ? f.id : f.question;
    const w = this.waiting.get(id);
    if (!w) return;
    clearTimeout(w.timer);
    this.waiting.delete(id);
    w.resolve(f);
  }

  private failAll(why: string): void {
    for (const w of this.waiting.values()) {
      clearTimeout(w.timer);
      w.reject(new Error(why));
    }
    this.waiting.clear();
  }

  private closed(socket: Socket, e: CloseLike): void {
    if (socket !== this.socket) return;
    this.socket = null;
    const why = e.reason || (e.code === 1006 ? "the server is not there" : `closed (${e.code})`);
    this.failAll(why);
    if (this.ended) return;
    if (e.code === 4400 || e.code === 4401) { // the same again would be refused again
      this.ended = true;
      this.tell("refused", e.code === 4401 ? "the token is wrong" : why);
      this.wake?.();
      return;
    }
    this.tell("lost", why);
    const [first, most] = this.options.retry ?? [0.25, 5];
    const wait = Math.min(most, first * 2 ** this.tries++);
    this.timer = setTimeout(() => this.connect(), 1000 * wait);
  }

  /** Sends a message of the page; false if there is no connection, and nothing was sent. */
  send(message: object): boolean {
    if (!this.socket || this.socket.readyState !== OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  /** What to send from now on, also after the connection was made anew. */
  subscribe(what: Subscription): void {
    this.options.subscribe = what;
    this.send({ op: "subscribe", ...what });
  }

  /** Says what the view looks at (m, world): positions come relative to an origin near it. */
  view(at: [number, number, number]): void { this.send({ op: "view", at }); }

  /** Says that this frame was drawn: the server then sends no more poses than are drawn. */
  seen(number: bigint): void { this.send({ op: "seen", number: number.toString() }); }

  /** Asks the daemon; rejected if the connection is lost, or nothing comes within 10 s. */
  ask(what: "explain" | "distance" | "body" | "geometry", members: object): Promise<AnswerFrame | GeometryFrame> {
    this.question = (this.question + 1) >>> 0;
    const id = this.question;
    return new Promise((resolve, reject) => {
      const timer = setTimeout(() => {
        this.waiting.delete(id);
        reject(new Error(`no answer within ${ANSWER_S} s`));
      }, 1000 * ANSWER_S);
      this.waiting.set(id, { resolve, reject, timer });
      if (this.send({ op: "ask", id, what, ...members })) return;
      clearTimeout(timer);
      this.waiting.delete(id);
      reject(new Error("there is no connection"));
    });
  }

  /** Why two bodies are checked against each other, or not. */
  async explain(a: string, b: string): Promise<string> {
    const f = await this.ask("explain", { a, b }) as AnswerFrame;
    if (f.status !== "ok") throw new Error(f.text || f.status);
    return f.text;
  }

  /** Moves in a recording, where the server allows it. */
  control(what: "pause" | "play" | "step" | "seek" | "speed", members: object = {}): void {
    this.send({ op: "control", do: what, ...members });
  }

  /** The frames from now on, across losses, until close(), or a refusal. */
  async *frames(): AsyncGenerator<Frame, void, void> {
    this.iterated = true;
    for (;;) {
      const frame = this.queue.shift();
      if (frame) yield frame;
      else if (this.ended) return;
      else {
        await new Promise<void>((resolve) => { this.wake = resolve; });
        this.wake = null;
      }
    }
  }

  /** Ends the connection for good. */
  close(): void {
    this.ended = true;
    if (this.timer) clearTimeout(this.timer);
    const socket = this.socket;
    this.socket = null;
    socket?.close(1000, "");
    this.failAll("closed");
    this.tell("closed", "");
    this.wake?.();
  }
}
