import type { Clock } from "./clock";
import * as words from "../words/frame";
import { type Answer, type Frame, parseFrame } from "./frames";

/** An open WebSocket, or what stands for one in a test. */
export interface Wire {
  send(text: string): void;
  close(): void;
}

export interface WireEvents {
  opened(): void;
  received(text: string): void;
  closed(): void;
}

export type OpenWire = (events: WireEvents) => Wire;

export type LineState = "connecting" | "live" | "lost";

export interface ConnectionEvents {
  state(state: LineState): void;
  frame(frame: Frame): void;
}

type Call = (answer: Answer) => void;

/** The server speaks at least every 5 s. */
export const silenceLimit = 12_000;
const retryStep = 250;
const longestRetry = 750;

/**
 * Keeps one WebSocket to the server: opens it again when it closes or is silent, and matches answers to requests.
 * Requests of a lost line are answered with the code `unreachable`; the user decides whether to repeat them.
 */
export class Connection {
  #wire: Wire | null = null;
  #state: LineState = "connecting";
  #pending = new Map<number, { call: Call; follows: boolean }>();
  #lastId = 0;
  #attempts = 0;
  #stopSilence = () => {};
  #stopRetry = () => {};
  #generation = 0;

  constructor(
    private readonly openWire: OpenWire,
    private readonly clock: Clock,
    private readonly events: ConnectionEvents,
  ) {}

  get live(): boolean {
    return this.#state === "live";
  }

  start(): void {
    this.#stopRetry();
    const generation = ++this.#generation;
    const current = (call: () => void) => {
      if (generation === this.#generation) call();
    };
    this.#watchSilence();
    this.#wire = this.openWire({
      opened: () => current(() => this.#opened()),
      received: (text) => current(() => this.#received(text)),
      closed: () => current(() => this.#lost()),
    });
  }

  /** Opens the line anew, at once: the caller changed. */
  restart(): void {
    this.#lost();
    this.#attempts = 0;
    this.start();
  }

  /** Sends a request; `call` gets its answer. With `follows`, also the states of the command until the final one. */
  request(fields: Record<string, unknown>, call: Call = () => {}, follows = false): void {
    const id = ++this.#lastId;
    if (!this.live || !this.#wire) {
      call(unreachable(id));
      return;
    }
    this.#pending.set(id, { call, follows });
    this.#wire.send(JSON.stringify({ id, ...fields }));
  }

  #opened(): void {
    this.#attempts = 0;
    this.#watchSilence();
    this.#change("live");
  }

  #received(text: string): void {
    this.#watchSilence();
    const frame = parseFrame(text);
    if (!frame) return;
    if (frame.id !== undefined && frame.s === undefined) this.#answer(frame as Answer);
    else this.events.frame(frame);
  }

  #answer(answer: Answer): void {
    const waiting = this.#pending.get(answer.id);
    if (!waiting) return;
    if (answer.ok === false || answer.final || !waiting.follows) this.#pending.delete(answer.id);
    waiting.call(answer);
  }

  #watchSilence(): void {
    this.#stopSilence();
    this.#stopSilence = this.clock.after(silenceLimit, () => this.#lost());
  }

  #lost(): void {
    this.#generation++;
    this.#stopSilence();
    this.#wire?.close();
    this.#wire = null;
    this.#change("lost");
    const pending = [...this.#pending];
    this.#pending.clear();
    for (const [id, waiting] of pending) waiting.call(unreachable(id));
    this.#attempts++;
    this.#stopRetry = this.clock.after(Math.min(this.#attempts * retryStep, longestRetry), () => this.start());
  }

  #change(state: LineState): void {
    if (this.#state === state) return;
    this.#state = state;
    this.events.state(state);
  }
}

function unreachable(id: number): Answer {
  return { id, ok: false, error: { code: "unreachable", text: words.lineUnreachable } };
}

/** The WebSocket of the page's own server. */
export function openBrowserWire(url: string): OpenWire {
  return (events) => {
    const socket = new WebSocket(url);
    socket.onopen = () => events.opened();
    socket.onmessage = (event) => events.received(String(event.data));
    socket.onclose = () => events.closed();
    return { send: (text) => socket.send(text), close: () => socket.close() };
  };
}
