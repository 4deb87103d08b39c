import type { Delivery, Extra } from "./frames";
import { serverNow } from "./server_time";

/** A tuple as the page knows it; the store changes it in place. */
export class Tuple {
  value: string | null = null; // null: not text, or too long; see size
  sequence = 0;
  time = 0; // user time, or write time; seconds
  media = "";
  creator = 0;
  write = 0;
  expire = 0;
  present = true; // the owner is there
  absentSince = 0; // seconds; 0: not known
  size = 0;
  /** How many subscriptions hold it. */
  holders = 0;
  #parsedFrom: string | null = null;
  #parsed: unknown = null;

  constructor(
    readonly id: string, // OWNER:KEY
    readonly owner: number,
    readonly key: string,
  ) {}

  /** The value as a JSON object; an empty one if it is none. */
  get json(): Record<string, unknown> {
    const value = this.jsonValue;
    return typeof value === "object" && value !== null && !Array.isArray(value) ? (value as Record<string, unknown>) : {};
  }

  /** The value as JSON; undefined if it is none. */
  get jsonValue(): unknown {
    if (this.#parsedFrom !== this.value) {
      this.#parsedFrom = this.value;
      this.#parsed = parseJson(this.value);
    }
    return this.#parsed;
  }
}

function parseJson(text: string | null): unknown {
  if (text === null || text === "") return undefined;
  try {
    return JSON.parse(text);
  } catch {
    return undefined;
  }
}

export interface StoreListener {
  added?(tuple: Tuple): void;
  changed?(tuple: Tuple): void;
  removed?(tuple: Tuple): void;
}

/** The tuples that one subscription holds, by the numbers of the server. */
export class Held {
  #numbers = new Map<number, Tuple>();
  /** Tuples from before the line was lost that the server has not sent again. */
  #old = new Set<Tuple>();

  constructor(private readonly store: Store) {}

  get size(): number {
    return this.#numbers.size;
  }

  get tuples(): Iterable<Tuple> {
    return this.#numbers.values();
  }

  /** Forgets the numbers, but keeps the tuples until `snapshot` shows which remain. */
  restart(): void {
    for (const tuple of this.#numbers.values()) this.#old.add(tuple);
    this.#numbers.clear();
  }

  take(delivery: Delivery): void {
    for (const [number, name] of Object.entries(delivery.k ?? {})) this.#introduce(Number(number), name);
    for (const [number, value, sequence, time, extra] of delivery.set ?? []) {
      const tuple = this.#numbers.get(number);
      if (tuple) this.store.set(tuple, value, sequence, time, extra);
    }
    for (const [number] of delivery.gone ?? []) this.#remove(number);
    if (delivery.snapshot !== undefined) this.dropOld((tuple) => tuple.owner === delivery.snapshot);
    for (const owner of delivery.absent ?? []) this.#mark(owner, false);
    for (const owner of delivery.present ?? []) this.#mark(owner, true);
  }

  /** Drops tuples from before the line was lost. */
  dropOld(which: (tuple: Tuple) => boolean): void {
    for (const tuple of this.#old) {
      if (!which(tuple)) continue;
      this.#old.delete(tuple);
      this.store.release(tuple);
    }
  }

  clear(): void {
    this.dropOld(() => true);
    for (const tuple of this.#numbers.values()) this.store.release(tuple);
    this.#numbers.clear();
  }

  #introduce(number: number, name: string): void {
    this.#remove(number);
    const tuple = this.store.hold(name);
    if (!tuple) return;
    if (this.#old.delete(tuple)) this.store.release(tuple);
    this.#numbers.set(number, tuple);
  }

  #remove(number: number): void {
    const tuple = this.#numbers.get(number);
    if (!tuple) return;
    this.#numbers.delete(number);
    this.store.release(tuple);
  }

  #mark(owner: number, present: boolean): void {
    for (const tuple of this.#numbers.values()) {
      if (tuple.owner === owner) this.store.mark(tuple, present);
    }
  }
}

/** All tuples of all subscriptions, each once. */
export class Store {
  readonly tuples = new Map<string, Tuple>();
  #listeners: StoreListener[] = [];

  /** `dirty` is called for each change; it asks for a redraw. */
  constructor(private readonly dirty: () => void) {}

  get(id: string): Tuple | undefined {
    return this.tuples.get(id);
  }

  listen(listener: StoreListener): () => void {
    this.#listeners.push(listener);
    for (const tuple of this.tuples.values()) listener.added?.(tuple);
    return () => {
      this.#listeners = this.#listeners.filter((other) => other !== listener);
    };
  }

  /** The tuple of `OWNER:KEY`, one holder more; null if this is not a name. */
  hold(name: string): Tuple | null {
    let tuple = this.tuples.get(name);
    if (!tuple) {
      const colon = name.indexOf(":");
      const owner = Number(name.slice(0, colon));
      if (colon < 1 || !Number.isInteger(owner)) return null;
      tuple = new Tuple(name, owner, name.slice(colon + 1));
      this.tuples.set(name, tuple);
      for (const listener of this.#listeners) listener.added?.(tuple);
      this.dirty();
    }
    tuple.holders++;
    return tuple;
  }

  release(tuple: Tuple): void {
    if (--tuple.holders > 0) return;
    this.tuples.delete(tuple.id);
    for (const listener of this.#listeners) listener.removed?.(tuple);
    this.dirty();
  }

  set(tuple: Tuple, value: string | null, sequence: number, time: number, extra?: Extra): void {
    tuple.value = value;
    tuple.sequence = sequence;
    tuple.time = time;
    tuple.size = extra?.size ?? 0;
    if (extra) describe(tuple, extra);
    for (const listener of this.#listeners) listener.changed?.(tuple);
    this.dirty();
  }

  mark(tuple: Tuple, present: boolean): void {
    tuple.present = present;
    tuple.absentSince = present ? 0 : serverNow();
    this.dirty();
  }
}

function describe(tuple: Tuple, extra: Extra): void {
  if (extra.m !== undefined) tuple.media = extra.m;
  if (extra.c !== undefined) tuple.creator = extra.c;
  if (extra.w !== undefined) tuple.write = extra.w;
  if (extra.e !== undefined) tuple.expire = extra.e;
  if (extra.p !== undefined) tuple.present = extra.p;
}
