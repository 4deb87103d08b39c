// One point over time: what the history knows, joined with what arrives.

/** `series` of an answer of `GET /api/v1/history` (docs/history.md). */
export interface PastSeries {
  key: string;
  kind?: "number" | "words" | "text";
  unit?: string;
  words?: string[];
  before?: [number, number | string];
  t?: number[];
  v?: (number | null)[];
  first?: (number | null)[];
  min?: (number | null)[];
  max?: (number | null)[];
  mean?: (number | null)[];
  last?: (number | null)[];
  n?: number[];
  texts?: [number, string][];
  gaps?: [number, number][];
}

/** A value, or those of one bucket. In a gap, nothing is known until the next sample. */
export interface Sample {
  t: number; // seconds
  until: number; // end of a bucket; `t` of one value
  gap: boolean;
  value: number; // the last one, which holds after it; NaN where it is no number
  first: number;
  low: number;
  high: number;
  mean: number; // by the time in which each value was in force
  text: string; // of states
  count: number;
}

/** `low` and `high` that differ mark a bucket of several values. */
export interface Drawn {
  t: number[];
  value: (number | null)[];
  low: (number | null)[];
  high: (number | null)[];
}

/** From `from` until `to` the state had this word; an empty one is a gap. */
export interface Span {
  from: number;
  to: number;
  word: string;
}

export interface Tick {
  t: number;
  text: string;
}

function sampleAt(t: number, text: string, value = text === "" ? Number.NaN : Number(text)): Sample {
  return { t, until: t, gap: false, value, first: value, low: value, high: value, mean: value, text, count: 1 };
}

function gapAt(t: number): Sample {
  return { ...sampleAt(t, ""), gap: true, count: 0 };
}

/** Seconds after which a measured value counts as held until the next one, and not as on its way to it. */
export const slow = 60;

/** The history keeps times in milliseconds, so that a value that arrived live is there under a time that is a little different. */
const resolution = 0.001;

/** Samples that never reach the plot again are dropped when so many more were added. */
const most = 6000;

export class Track {
  #samples: Sample[] = [];
  #ticks: Tick[] = [];
  /** Seconds of a bucket: live values within one are drawn as one. */
  width = 0;
  /** Where the answer of the history ended. */
  #known = 0;

  constructor(public kind: "number" | "state") {}

  get empty(): boolean {
    return this.#samples.length === 0;
  }

  /** Takes what the history answered for `[.., to)`; what arrived since stays. */
  fill(past: PastSeries, to: number, width: number): void {
    const samples = samplesOf(past, width).sort((a, b) => a.t - b.t || Number(a.gap) - Number(b.gap));
    const last = samples[samples.length - 1]?.t ?? Number.NEGATIVE_INFINITY;
    const newer = this.#samples.filter((sample) => (sample.gap ? sample.t >= to : sample.t > last + resolution));
    this.#samples = [...samples, ...newer];
    this.width = width;
    this.#known = to;
  }

  /** Takes the commands of the past; those that arrived stay. */
  fillTicks(past: PastSeries): void {
    const ticks = samplesOf(past, 0).flatMap(({ gap, t, text }) => (gap || text === "" ? [] : [{ t, text }]));
    const last = ticks[ticks.length - 1]?.t ?? 0;
    this.#ticks = [...ticks, ...this.#ticks.filter(({ t }) => t > last)];
  }

  command(t: number, text: string): void {
    const last = this.#ticks[this.#ticks.length - 1];
    if (text !== "" && (!last || t > last.t)) this.#ticks.push({ t, text });
  }

  /** A value arrived. Values older than the newest one are known already. */
  add(t: number, text: string): void {
    const last = this.#samples[this.#samples.length - 1];
    if (text === "" || (last && (last.gap ? t < last.t : t <= last.t + resolution))) return;
    const sample = sampleAt(t, text);
    if (last && this.#folds(last, sample)) fold(last, sample);
    else this.#samples.push(sample);
    if (this.#samples.length > most) this.#thin();
  }

  /** Draws two neighbours of the older half as one; of states, the oldest go. */
  #thin(): void {
    const older = this.#samples.splice(0, most / 2);
    if (this.kind !== "number") return;
    const kept: Sample[] = [];
    for (let index = 0; index < older.length; index += 2) {
      const [one, next] = older.slice(index, index + 2);
      if (one) kept.push(one);
      if (one && next && !one.gap && !next.gap) fold(one, next);
      else if (next) kept.push(next);
    }
    this.#samples.unshift(...kept);
  }

  /** From now on the value is not known. */
  lose(t: number): void {
    const last = this.#samples[this.#samples.length - 1];
    if (!last || last.gap) return;
    this.#samples.push(gapAt(Math.max(t, last.t)));
  }

  /** The last value is known to hold since `since`: if that was before the gap, there was none. */
  resume(since: number): void {
    const last = this.#samples[this.#samples.length - 1];
    if (last?.gap && since <= last.t) this.#samples.pop();
  }

  #folds(last: Sample, next: Sample): boolean {
    if (this.kind !== "number" || last.gap || this.width <= 0 || last.t < this.#known) return false;
    return Math.floor(last.t / this.width) === Math.floor(next.t / this.width);
  }

  /** The sample in force at `t`; undefined before the first one. */
  at(t: number): Sample | undefined {
    let low = 0;
    let high = this.#samples.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if ((this.#samples[middle]?.t ?? 0) <= t) low = middle + 1;
      else high = middle;
    }
    return this.#samples[low - 1];
  }

  /** The commands within `[from, to]`. */
  ticksIn(from: number, to: number): Tick[] {
    return this.#ticks.filter(({ t }) => t >= from && t <= to);
  }

  /** The curve of `[from, to]`, with one sample before it; the last value holds until `now`. */
  curve(from: number, to: number, now: number): Drawn {
    const drawn: Drawn = { t: [], value: [], low: [], high: [] };
    const put = (t: number, sample: Sample | null) => {
      const last = drawn.t[drawn.t.length - 1];
      if (last !== undefined && t <= last) t = last + 1e-4; // times of a plot grow
      drawn.t.push(t);
      drawn.value.push(sample ? sample.value : null);
      drawn.low.push(sample ? sample.low : null);
      drawn.high.push(sample ? sample.high : null);
    };
    const putSample = (sample: Sample) => {
      if (before && !before.gap && sample.t - before.until > slow) put(sample.t, flat(before));
      if (sample.until > sample.t) put(sample.t, { ...sample, value: sample.first });
      put(sample.until, sample);
      if (sample.high > sample.low) put(sample.until, flat(sample)); // the band ends with the bucket
    };
    let before: Sample | undefined;
    for (const sample of this.#shown(from, to)) {
      if (!sample.gap) {
        if (!Number.isNaN(sample.value)) putSample(sample);
      } else {
        if (before && !before.gap) put(sample.t, flat(before));
        put(sample.t, null);
      }
      before = sample;
    }
    const end = Math.min(to, now);
    if (before && !before.gap && end > before.t && before === this.#samples[this.#samples.length - 1] && !Number.isNaN(before.value))
      put(end, flat(before));
    return drawn;
  }

  /** The words of `[from, to]`, joined where they are equal. */
  spans(from: number, to: number, now: number): Span[] {
    const spans: Span[] = [];
    const end = Math.min(to, now);
    for (const { t, gap, text } of this.#shown(from, to)) {
      const start = Math.max(t, from);
      if (spans[spans.length - 1]?.from === start) spans.pop(); // it lasted no time
      const last = spans[spans.length - 1];
      if (last) last.to = start;
      const word = gap ? "" : text;
      if (last?.word === word) last.to = end;
      else spans.push({ from: start, to: end, word });
    }
    return spans.filter((span) => span.to > span.from);
  }

  /** Times, values and words within `[from, to]`, for a file; what held at its beginning is there, too. */
  within(from: number, to: number): Sample[] {
    const before = this.at(from);
    const samples = this.#samples.filter(({ t }) => t >= from && t <= to);
    return before && !before.gap && before.t < from ? [{ ...before, t: from }, ...samples] : samples;
  }

  #shown(from: number, to: number): Sample[] {
    const first = this.at(from);
    const start = first ? this.#samples.lastIndexOf(first) : 0;
    let end = this.#samples.length;
    while (end > start && (this.#samples[end - 1]?.t ?? 0) > to) end--;
    // One beyond, so that the line goes on to the edge.
    return this.#samples.slice(start, this.kind === "number" ? end + 1 : end);
  }
}

function flat(sample: Sample): Sample {
  return { ...sample, low: sample.value, high: sample.value };
}

function fold(into: Sample, next: Sample): void {
  const area = into.mean * (into.until - into.t) + into.value * (next.t - into.until) + next.mean * (next.until - next.t);
  if (next.until > into.t) into.mean = area / (next.until - into.t);
  into.count += next.count;
  into.value = next.value;
  into.until = next.until;
  into.low = Math.min(into.low, next.low);
  into.high = Math.max(into.high, next.high);
}

function sampleBefore([t, value]: [number, number | string], wordOf: (value: number) => string): Sample {
  return typeof value === "string" ? sampleAt(t, value) : sampleAt(t, wordOf(value), value);
}

/** A bucket in which a state had several words shows them all; after it, the last one holds. */
function samplesOf(past: PastSeries, width: number): Sample[] {
  const samples: Sample[] = [];
  const { t = [], first = [], min = [], max = [], mean = [], n = [], words } = past;
  const values = past.v ?? past.last ?? [];
  const wordOf = (value: number) => words?.[value] ?? String(value);
  if (past.before) samples.push(sampleBefore(past.before, wordOf));
  t.forEach((time, index) => {
    const value = values[index];
    if (value === null || value === undefined) return;
    const low = min[index] ?? value;
    const high = max[index] ?? value;
    const mixed = words !== undefined && low !== high;
    const text = mixed ? `${wordOf(low)} … ${wordOf(high)}` : wordOf(value);
    const count = n[index] ?? 1;
    const until = count > 1 ? time + width : time;
    samples.push({ ...sampleAt(time, text, value), until, first: first[index] ?? value, low, high, mean: mean[index] ?? value, count });
    if (mixed) samples.push(sampleAt(time + width, wordOf(value), value));
  });
  for (const [time, text] of past.texts ?? []) samples.push(sampleAt(time, text));
  for (const [from] of past.gaps ?? []) samples.push(gapAt(from));
  return samples;
}
