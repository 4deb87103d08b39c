import type { Store, Tuple } from "./store";

/** Sets a second of each tuple, from the sequence numbers: also sets that the server merged count. */
export class Rates {
  readonly #touched = new Set<Tuple>();
  readonly #last = new Map<Tuple, { sequence: number; rate: number }>();
  readonly #stop: () => void;
  #before: number;

  constructor(store: Store, now: number) {
    this.#before = now;
    this.#stop = store.listen({
      added: (tuple) => this.#last.set(tuple, { sequence: tuple.sequence, rate: 0 }),
      changed: (tuple) => this.#touched.add(tuple),
      removed: (tuple) => {
        this.#last.delete(tuple);
        this.#touched.delete(tuple);
      },
    });
  }

  /** Takes a sample; call it about once a second. Rates are smoothed over some five samples. */
  sample(now: number): void {
    const seconds = Math.max(now - this.#before, 1) / 1000;
    this.#before = now;
    for (const [tuple, entry] of this.#last) {
      if (!this.#touched.has(tuple)) {
        entry.rate = entry.rate < 0.02 ? 0 : entry.rate * 0.8;
        continue;
      }
      const first = entry.sequence === 0;
      const sets = tuple.sequence >= entry.sequence ? tuple.sequence - entry.sequence : 1;
      entry.sequence = tuple.sequence;
      if (!first) entry.rate += 0.2 * (sets / seconds - entry.rate);
    }
    this.#touched.clear();
  }

  /** What comes next tells of a time that is not known: the line was lost. */
  interrupt(): void {
    for (const entry of this.#last.values()) entry.sequence = 0;
  }

  of(tuple: Tuple): number {
    return this.#last.get(tuple)?.rate ?? 0;
  }

  /** All tuples that are being set. */
  *moving(): Iterable<{ tuple: Tuple; rate: number }> {
    for (const [tuple, { rate }] of this.#last) {
      if (rate >= 0.05) yield { tuple, rate };
    }
  }

  /** The tuples that are set most often. */
  top(count: number): { tuple: Tuple; rate: number }[] {
    const found: { tuple: Tuple; rate: number }[] = [];
    for (const { tuple, rate } of this.moving()) {
      if (found.length === count && rate <= (found[count - 1]?.rate ?? 0)) continue;
      found.push({ tuple, rate });
      found.sort((a, b) => b.rate - a.rate);
      found.length = Math.min(found.length, count);
    }
    return found;
  }

  end(): void {
    this.#stop();
  }
}
