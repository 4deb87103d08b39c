// Curves from what the history answers.

/** A series of `GET /api/v1/history` (docs/history.md). */
export interface Series {
  key: string;
  t?: number[];
  v?: (number | null)[];
  first?: (number | null)[];
  last?: (number | null)[];
  words?: string[];
  before?: [number, number | string | null];
  gaps?: [number, number][];
}

/** [time, value] in order of time, NaN where a gap begins: the first and the last of each bucket; a single value has its own time. `numberOf` says what a word counts as. */
export function pairsOf(series: Series, width: number, numberOf: (word: string) => number): [number, number][] {
  const { t = [], v, first = [], last = [], words = [], before, gaps = [] } = series;
  const read = (value: number | null | undefined) => {
    if (value === null || value === undefined) return Number.NaN;
    return words.length > 0 ? numberOf(words[value] ?? "") : value;
  };
  const pairs = t.flatMap((time, index): [number, number][] =>
    v
      ? [[time, read(v[index])]]
      : [
          [time, read(first[index])],
          [Math.floor(time / width) * width + width * 0.999, read(last[index])],
        ],
  );
  if (before && typeof before[1] !== "string") pairs.push([before[0], read(before[1])]);
  for (const [from] of gaps) pairs.push([from, Number.NaN]);
  return pairs.sort((a, b) => a[0] - b[0]);
}

/** A number, or the place of a word among those of the point. */
export function numberIn(words: string[], value: string): number {
  const place = words.indexOf(value);
  if (place >= 0) return place;
  if (value === "on" || value === "off") return value === "on" ? 1 : 0;
  return value === "" ? Number.NaN : Number(value);
}

/** Adds what is known now; NaN where that is nothing. Values that follow within `step` seconds, a pixel, replace the last one. */
export function addLive(pairs: [number, number][], now: number, time: number, value: number, step: number): void {
  const last = pairs[pairs.length - 1];
  const known = !Number.isNaN(value);
  if (known !== (last !== undefined && !Number.isNaN(last[1]))) {
    if (known) pairs.push([last && time <= last[0] ? Math.max(now, last[0]) : time, value]);
    else if (last) pairs.push([Math.max(now, last[0]), Number.NaN]);
  } else if (known && last && time > last[0]) {
    if (time > last[0] + step) pairs.push([time, value]);
    else last[1] = value;
  }
}

/** The pairs from `start` on; what was before holds at its beginning. */
export function sinceTime(pairs: [number, number][], start: number): [number, number][] {
  const first = pairs.findIndex(([time]) => time >= start);
  const before = pairs[(first < 0 ? pairs.length : first) - 1];
  const rest = first < 0 ? [] : pairs.slice(first);
  return before ? [[start, before[1]], ...rest] : rest;
}
