// Which time a plot shows: the last span up to now, or a fixed one. It is in the address.

export interface TimeRange {
  /** Seconds up to now; 0 = fixed. */
  span: number;
  from: number;
  to: number;
}

export const spans = [900, 3600, 86_400, 604_800, 2_592_000];
const standard = 3600;
const shortest = 1;
const longest = 10 * 366 * 86_400;

export function readRange(query: Record<string, string>): TimeRange {
  const from = Number(query.from);
  const to = Number(query.to);
  if (query.from && query.to && to - from >= shortest && to - from <= longest) return { span: 0, from, to };
  const span = Number(query.span);
  return { span: span >= shortest && span <= longest ? span : standard, from: 0, to: 0 };
}

export function rangeQuery(range: TimeRange): Record<string, string> {
  if (range.span) return { span: range.span === standard ? "" : String(range.span), from: "", to: "" };
  return { span: "", from: rounded(range.from), to: rounded(range.to) };
}

function rounded(time: number): string {
  return String(Math.round(time * 1000) / 1000);
}

/** The bounds at this moment. */
export function boundsOf(range: TimeRange, now: number): { from: number; to: number } {
  return range.span ? { from: now - range.span, to: now } : { from: range.from, to: range.to };
}

/** Around `at`, `factor` times as much time; never longer or shorter than makes sense. */
export function zoomed(bounds: { from: number; to: number }, at: number, factor: number): TimeRange {
  const now = bounds.to - bounds.from;
  const length = Math.max(shortest, Math.min(longest, now * factor));
  const share = (at - bounds.from) / now;
  const from = at - share * length;
  return { span: 0, from, to: from + length };
}

export function moved(bounds: { from: number; to: number }, share: number): TimeRange {
  const by = (bounds.to - bounds.from) * share;
  return { span: 0, from: bounds.from + by, to: bounds.to + by };
}

const day = 86_400;

/** What the axis of time says at each split: the day where it changes, the year once, seconds only where they matter. */
export function timeLabels(splits: number[], step: number, zone?: string): string[] {
  const part = (options: Intl.DateTimeFormatOptions) => new Intl.DateTimeFormat("en-CA", { timeZone: zone, hourCycle: "h23", ...options });
  const dayOf = part({ year: "numeric", month: "2-digit", day: "2-digit" });
  const timeOf = part({ hour: "2-digit", minute: "2-digit", ...(step < 60 ? { second: "2-digit" } : {}) });
  let before = "";
  return splits.map((split) => {
    const date = new Date(split * 1000);
    const today = dayOf.format(date);
    const yearStays = today.slice(0, 4) === before.slice(0, 4);
    const changed = before !== "" && today !== before;
    before = today;
    const short = today.slice(5);
    if (step >= day) return yearStays ? short : `${short}\n${today.slice(0, 4)}`;
    const time = timeOf.format(date);
    return changed || (split === splits[0] && step >= 3600) ? `${time}\n${yearStays ? short : today}` : time;
  });
}

/** `2026-11-22T12:04:31`, for fields of date and time, in the browser's zone. */
export function localInput(seconds: number): string {
  const date = new Date(seconds * 1000);
  return new Date(date.getTime() - date.getTimezoneOffset() * 60_000).toISOString().slice(0, 19);
}

export function fromLocalInput(text: string): number {
  return new Date(text).getTime() / 1000;
}
