import type { Tuple } from "./store";

/**
 * What a counter of a network counts: what was lost, what is odd but harmless, what flows, and texts that are no numbers. The names
 * are in docs/tuple-keys.md and in the documents of the networks; unknown ones count as flow.
 */
export type CounterKind = "loss" | "oddity" | "flow" | "fact";

const losses =
  /^(dropped|undeliver|undecodable|unreadable|lost|failed|garbage|damaged|skipped|expired|unsent)|-(lost|expired|failures|dropped)(-|$)|^(bad|refused)-|^share-(dropped|refused)|^telegrams-refused|^not-acknowledged|^data-secure-(plain|no-|unknown|wrong|old|other|refused)|^secure-(plain|early-|wrong|replays|other|forbidden|old|bad)/;
const oddities =
  /^(unknown|undeclared|implausible|unusable|unanswered|unacknowledged|unconfirmed|unassigned|missing|wrong|foreign|repeat|duplicates|doubled|broken|long-frames|short-frames|forbidden|late|reconnects|other-frames|bus-repetitions|joined-again|renames)/;
/** Numbers that say how much there is now, or what it is: they have no rate. */
const levels = /^(attempts|next-attempt|devices|line|port|waiting|pending|telegrams-waiting|share-clients|replay|rounds|starts)/;

export function kindOf(name: string, value: string): CounterKind {
  if (!/^-?\d+(\.\d+)?$/.test(value)) return "fact";
  if (levels.test(name)) return "fact";
  if (losses.test(name)) return "loss";
  return oddities.test(name) ? "oddity" : "flow";
}

/** The counter that says how much arrives, the most telling one first. */
const arriving = ["readings", "telegrams-received", "messages-received", "packets-read", "datagrams", "records"];

export function arrivalsOf(counters: ReadonlyMap<string, Tuple>): Tuple | undefined {
  for (const name of arriving) {
    const counter = counters.get(name);
    if (counter && Number(counter.value) > 0) return counter;
  }
  return counters.get("readings");
}

/** Everything that one network lost since its start. */
export function lossesOf(counters: ReadonlyMap<string, Tuple>): number {
  let sum = 0;
  for (const [name, tuple] of counters) {
    if (kindOf(name, tuple.value ?? "") === "loss") sum += Number(tuple.value);
  }
  return sum;
}

interface Sample {
  value: number;
  time: number;
  rate: number;
}

/** Counters come once a second: a shorter time may hold no change of one that grows steadily. */
const firstPeriod = 2;

/** How much counters grow in a second, smoothed over some five samples. */
export class CounterRates {
  readonly #samples = new Map<string, Sample>();

  /** Takes a sample of each; call it about once a second. `now` in seconds. */
  sample(tuples: Iterable<Tuple>, now: number): void {
    for (const tuple of tuples) {
      const value = Number(tuple.value);
      if (tuple.value === null || tuple.value === "" || Number.isNaN(value)) continue;
      const before = this.#samples.get(tuple.id);
      if (!before || value < before.value) {
        this.#samples.set(tuple.id, { value, time: now, rate: Number.NaN }); // the first one, or the island was started again
        continue;
      }
      if (now - before.time < (Number.isNaN(before.rate) ? firstPeriod : 0.5)) continue;
      const rate = (value - before.value) / (now - before.time);
      before.rate = Number.isNaN(before.rate) ? rate : before.rate + 0.3 * (rate - before.rate);
      before.value = value;
      before.time = now;
    }
  }

  /** NaN until there are two samples. */
  of(tuple: Tuple | undefined): number {
    return (tuple && this.#samples.get(tuple.id)?.rate) ?? Number.NaN;
  }
}
