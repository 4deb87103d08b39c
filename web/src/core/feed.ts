import type { Clock } from "./clock";
import type { Answer, Frame, FrameError } from "./frames";
import { Held, type Store, type Tuple } from "./store";

/** What a view wants to see. Equal wants share one subscription. */
export interface Want {
  pattern: string; // `6541:proxy.**`, `*:*.*.*.status`
  full?: boolean; // also media type, creator, times
  min?: number; // milliseconds between two values of a tuple
  active?: boolean; // creates demand: wakes sensors
  brief?: boolean; // ends with its last user: one of many, such as those of the rows that are shown
}

export type WantState = "asked" | "loading" | "ready" | "failed";

interface Subscriber {
  request(fields: Record<string, unknown>, call?: (answer: Answer) => void): void;
  readonly live: boolean;
}

/** How long a subscription outlives its last user, so that going back shows values at once. */
const linger = 10_000;
/** A server that is busy is asked again after that. */
const busyPause = 3_000;
/** After a reconnection, owners that have not sent a snapshot by then are gone. */
const patience = 5_000;

/** One subscription, as long as a view wants it. */
export class Subscription {
  users = 0;
  state: WantState = "asked";
  error: FrameError | null = null;
  number: number | null = null;
  readonly held: Held;
  readonly snapshots = new Set<number>();
  /** Grows with each request, and when the last one no longer counts: its answer is then too late. */
  turn = 0;
  stopLinger = () => {};
  stopPatience = () => {};

  constructor(
    readonly want: Want,
    store: Store,
  ) {
    this.held = new Held(store);
  }

  /** The whole snapshot of these owners has arrived. */
  complete(owners: Iterable<number>): boolean {
    if (this.state === "failed") return true;
    if (this.state === "asked") return false;
    const only = Number(this.want.pattern.split(":", 1)[0]);
    for (const owner of owners) {
      if ((Number.isNaN(only) || only === owner) && !this.snapshots.has(owner)) return false;
    }
    return true;
  }

  /** Forgets the numbers of the lost line; what it delivered stays visible until the next snapshot. */
  interrupt(): void {
    this.turn++;
    this.number = null;
    this.state = "asked";
    this.snapshots.clear();
    this.held.restart();
    this.stopPatience();
  }
}

/**
 * Keeps the subscriptions that the views want: shares them, makes them again after a reconnection, and drops them while
 * the page is hidden.
 */
export class Feed {
  #wanted = new Map<string, Subscription>();
  #numbered = new Map<number, Subscription>();
  #hidden = false;

  constructor(
    private readonly store: Store,
    private readonly line: () => Subscriber,
    private readonly clock: Clock,
    private readonly dirty: () => void,
  ) {}

  /** The subscription for `want`; call `drop` once when it is not needed any more. */
  want(want: Want): Subscription {
    const name = JSON.stringify([want.pattern, want.full ?? false, want.min ?? 0, want.active ?? false, want.brief ?? false]);
    let subscription = this.#wanted.get(name);
    if (!subscription) {
      subscription = new Subscription(want, this.store);
      this.#wanted.set(name, subscription);
      this.#subscribe(subscription);
    }
    subscription.stopLinger();
    subscription.users++;
    return subscription;
  }

  drop(subscription: Subscription): void {
    if (--subscription.users > 0) return;
    // Demand ends at once: it costs battery.
    const { active, brief } = subscription.want;
    subscription.stopLinger = this.clock.after(active || brief ? 0 : linger, () => this.#end(subscription));
  }

  /** Asks again for what failed. */
  retry(): void {
    for (const subscription of this.#wanted.values()) {
      if (subscription.state === "failed") this.#subscribe(subscription);
    }
  }

  /** Every subscription that exists. */
  get subscriptions(): Iterable<Subscription> {
    return this.#wanted.values();
  }

  connected(): void {
    if (this.#hidden) return;
    for (const subscription of this.#wanted.values()) this.#subscribe(subscription);
  }

  disconnected(): void {
    this.#numbered.clear();
    for (const subscription of this.#wanted.values()) subscription.interrupt();
    this.dirty();
  }

  hide(hidden: boolean): void {
    if (this.#hidden === hidden) return;
    this.#hidden = hidden;
    if (!hidden) {
      this.connected();
      return;
    }
    for (const subscription of this.#wanted.values()) {
      if (subscription.number !== null) this.line().request({ do: "unsubscribe", subscription: subscription.number });
    }
    this.disconnected();
  }

  take(frame: Frame): void {
    if (frame.s === undefined) return;
    const subscription = this.#numbered.get(frame.s);
    if (!subscription) return;
    subscription.held.take({ ...frame, s: frame.s });
    if (frame.snapshot !== undefined) subscription.snapshots.add(frame.snapshot);
    if (subscription.state === "loading" && frame.snapshot !== undefined) subscription.state = "ready";
    this.dirty();
  }

  #subscribe(subscription: Subscription): void {
    if (!this.line().live || this.#hidden || subscription.number !== null) return;
    const { pattern, full, min, active } = subscription.want;
    const fields: Record<string, unknown> = { do: "subscribe", pattern, min: min ?? 50 };
    if (full) fields.full = true;
    if (active) fields.active = true;
    else fields.passive = true;
    const turn = ++subscription.turn;
    this.line().request(fields, (answer) => this.#answered(subscription, turn, answer));
  }

  #answered(subscription: Subscription, turn: number, answer: Answer): void {
    const late = turn !== subscription.turn;
    if (answer.ok !== true || answer.subscription === undefined) {
      if (!late && answer.error?.code !== "unreachable") this.#fail(subscription, answer.error ?? { code: "failed", text: "" });
      return;
    }
    if (late) {
      this.line().request({ do: "unsubscribe", subscription: answer.subscription });
      return;
    }
    subscription.number = answer.subscription;
    subscription.state = "loading";
    subscription.error = null;
    this.#numbered.set(answer.subscription, subscription);
    subscription.stopPatience = this.clock.after(patience, () => this.#dropAbsent(subscription));
    this.dirty();
  }

  #fail(subscription: Subscription, error: FrameError): void {
    subscription.state = "failed";
    subscription.error = error;
    if (error.code === "busy") {
      const { turn } = subscription;
      this.clock.after(busyPause, () => turn === subscription.turn && this.#subscribe(subscription));
    }
    this.dirty();
  }

  #dropAbsent(subscription: Subscription): void {
    subscription.held.dropOld((tuple: Tuple) => !subscription.snapshots.has(tuple.owner));
  }

  #end(subscription: Subscription): void {
    subscription.turn++;
    subscription.stopPatience();
    for (const [name, other] of this.#wanted) {
      if (other === subscription) this.#wanted.delete(name);
    }
    if (subscription.number !== null) {
      this.#numbered.delete(subscription.number);
      this.line().request({ do: "unsubscribe", subscription: subscription.number });
    }
    subscription.held.clear();
  }
}
