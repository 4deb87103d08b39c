import type { Clock } from "./clock";
import type { Message } from "./frames";
import { kept, keptWhileReading, type Passing, readPassing, type TrafficKind, types } from "./traffic";

/** A network stops by itself when no tool renews within this time. */
const lease = 60;
const renewal = 25_000;
/** What came within this time is shown together: a busy bus would draw for each telegram. */
const batch = 200;
/** The same for every page of this server: the network then sends each telegram once. */
export const watcher = "page";

export interface WatchPorts {
  /** Calls for each message of a type until the result is called. */
  listen(type: string, call: (message: Message) => void): () => void;
  send(request: Record<string, unknown>, failed: (why: string) => void): void;
  /** The connection is up. */
  live(): boolean;
  hidden(): boolean;
  changed(): void;
  refused(why: string): void;
  ended(): void;
}

/** What passes on one network, from when the user watches it until the user stops. It outlives the view. */
export class Watch {
  running = false;
  /** The user reads: rows stay longer. */
  reading = false;
  passing: Passing[] = [];
  /** The last time in which it saw nothing, though the user did not stop it: seconds since 1970. */
  missed: { from: number; to: number } | null = null;
  #incoming: Passing[] = [];
  #lastId = 0;
  #renewed = 0;
  /** When the line was lost; 0 while it is up. */
  #lost = 0;
  #stops: (() => void)[] = [];
  #stopRenewal = () => {};

  constructor(
    private readonly owner: number,
    private readonly network: string,
    private readonly kind: TrafficKind,
    private readonly clock: Clock,
    private readonly ports: WatchPorts,
  ) {}

  start(): void {
    if (this.running) return;
    this.running = true;
    this.#renewed = this.clock.now();
    this.#lost = this.ports.live() ? 0 : this.#renewed;
    this.missed = null;
    this.#stops = [
      this.ports.listen(types[this.kind].message, (message) => this.#took(message)),
      this.ports.listen(types[this.kind].reply, (message) => this.#replied(message)),
    ];
    this.renew();
    this.ports.changed();
  }

  stop(): void {
    this.running = false;
    this.#stopRenewal();
    for (const stop of this.#stops.splice(0)) stop();
    this.ports.changed();
  }

  /** The line to the server is lost: nothing arrives until the next renewal. */
  interrupt(): void {
    if (this.running) this.#lost ||= this.clock.now();
  }

  /** Asks the network to go on: at once after a reconnection, and before its lease ends; not while the page is hidden. */
  renew(): void {
    if (!this.running) return;
    this.#stopRenewal();
    this.#stopRenewal = this.clock.after(renewal, () => this.renew());
    if (this.ports.hidden()) {
      if (this.clock.now() - this.#renewed > lease * 1000) this.#end(() => this.ports.ended());
      return;
    }
    if (!this.ports.live()) return;
    this.#noteMissed();
    this.#renewed = this.clock.now();
    this.ports.send({ id: watcher, do: "monitor", seconds: lease }, (why) => this.#end(() => this.ports.refused(why)));
  }

  /** A page that sleeps renews too late; then, and without a line, traffic has passed unseen. */
  #noteMissed(): void {
    const now = this.clock.now();
    const leaseEnds = this.#renewed + lease * 1000;
    const from = Math.min(this.#lost || leaseEnds, leaseEnds);
    if (from < now) this.missed = { from: from / 1000, to: now / 1000 };
    this.#lost = 0;
  }

  #end(say: () => void): void {
    if (!this.running) return;
    this.stop();
    say();
  }

  #isFrom(message: Message): boolean {
    return message.from === this.owner && (!message.network || message.network === this.network);
  }

  #took(message: Message): void {
    if (!this.#isFrom(message)) return;
    const one = readPassing(this.kind, message.value ?? "", ++this.#lastId);
    if (!one) return;
    if (this.#incoming.length === 0) this.clock.after(batch, () => this.#show());
    this.#incoming.push(one);
  }

  #show(): void {
    this.passing = [...this.passing, ...this.#incoming].slice(-(this.reading ? keptWhileReading : kept));
    this.#incoming = [];
    this.ports.changed();
  }

  #replied(message: Message): void {
    const reply = this.#isFrom(message) ? replyOf(message) : null;
    if (reply?.id !== watcher) return;
    if (reply.ok !== true) this.#end(() => this.ports.refused(String(reply.why ?? "")));
  }
}

/** The reply of a tool; null if it is none. */
export function replyOf(message: Message): Record<string, unknown> | null {
  try {
    const reply: unknown = JSON.parse(message.value ?? "");
    return typeof reply === "object" && reply !== null ? (reply as Record<string, unknown>) : null;
  } catch {
    return null;
  }
}
