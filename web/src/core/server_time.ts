/** The clock of the server, as far as its answers show it: times of tuples are by that one, and the browser's may be wrong. */
export class ServerTime {
  /** Seconds that the server is ahead of the browser. */
  offset = 0;

  /** `local` is the browser's clock in seconds. */
  constructor(private readonly local: () => number) {}

  now(): number {
    return this.local() + this.offset;
  }

  /** The server's clock was between these times at a moment after `since`, by the browser's clock, and before now. */
  heard(earliest: number, latest: number, since: number): void {
    this.offset = Math.min(Math.max(this.offset, earliest - this.local()), latest - since);
  }
}

const longestWay = 2;

export const serverTime = new ServerTime(() => Date.now() / 1000);

/** Seconds since 1970 by the server's clock. */
export function serverNow(): number {
  return serverTime.now();
}

/** A frame with a time of the server has arrived. */
export function heardFrame(time: number): void {
  const now = Date.now() / 1000;
  serverTime.heard(time, time + longestWay, now);
}

/** An answer to a request of `since` has arrived; its `Date` has whole seconds. */
export function heardAnswer(date: string | null, since: number): void {
  const time = Date.parse(date ?? "") / 1000;
  if (!Number.isNaN(time)) serverTime.heard(time, time + 1, since);
}
