import { number, text } from "./catalog";

export interface LogLine {
  owner: number;
  number: number; // of its island, from 1
  time: number;
  level: string;
  subject: string;
  text: string;
  /** So many lines before it did not arrive. */
  missed: number;
  /** Unlike numbers, never used twice: an island that is started again counts from 1. */
  id: string;
}

export const levels = ["debug", "info", "warning", "error"];
/** Lines that are kept; more while the user reads and nothing may move. */
export const kept = 2000;
const keptWhileReading = 6000;

interface Seen {
  number: number;
  time: number;
  session: number;
}

/** The lines of the logs of islands, put together from the lists of the last hundred (docs/tuple-keys.md). */
export class LogBook {
  lines: LogLine[] = [];
  /** Grows with each change of `lines`. */
  version = 0;
  /** Lines taken so far, also those that are not kept any more. */
  taken = 0;
  readonly #seen = new Map<number, Seen>();

  /** Takes what a tuple says now: those lines that are new. */
  take(owner: number, list: unknown, reading = false): void {
    const lines = (Array.isArray(list) ? list : []).flatMap((line) => parse(owner, line));
    const newest = lines[lines.length - 1];
    if (!newest) return;
    const seen = this.#seen.get(owner) ?? { number: 0, time: 0, session: 0 };
    const restarted = newest.number < seen.number || (newest.number === seen.number && newest.time > seen.time);
    const before = restarted ? 0 : seen.number;
    const session = seen.session + (restarted ? 1 : 0);
    const fresh = lines.filter((line) => line.number > before);
    if (fresh.length === 0) return;
    this.#seen.set(owner, { number: newest.number, time: newest.time, session });
    let last = before;
    for (const line of fresh) {
      line.id = `${owner}/${session}/${line.number}`;
      line.missed = last > 0 ? line.number - last - 1 : 0;
      last = line.number;
    }
    this.#add(fresh, reading);
  }

  #add(fresh: LogLine[], reading: boolean): void {
    const inOrder = (this.lines[this.lines.length - 1]?.time ?? 0) <= (fresh[0]?.time ?? 0);
    const lines = [...this.lines, ...fresh];
    if (!inOrder) lines.sort((a, b) => a.time - b.time); // stable: lines of one island stay in order
    this.lines = lines.slice(-(reading ? keptWhileReading : kept));
    this.version++;
    this.taken += fresh.length;
  }
}

function parse(owner: number, line: unknown): LogLine[] {
  if (typeof line !== "object" || line === null) return [];
  const member = line as Record<string, unknown>;
  return [
    {
      owner,
      number: number(member.number),
      time: number(member.time),
      level: text(member.level),
      subject: text(member.subject),
      text: text(member.text),
      missed: 0,
      id: "",
    },
  ];
}

/** `least` and those above it; unknown levels always. */
export function atLeast(level: string, least: string): boolean {
  const place = levels.indexOf(level);
  return place < 0 || place >= levels.indexOf(least);
}

/** As `rubicon log` prints it. */
export function lineText(line: LogLine): string {
  return `${new Date(line.time * 1000).toISOString()} ${line.level.padEnd(7)} ${line.subject ? `${line.subject}: ` : ""}${line.text}`;
}
