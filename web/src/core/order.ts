/** What decides which rows a list shows, and in which order. */
export interface OrderSpec<T> {
  /** Changes when the user asks for another filter or order. */
  name: string;
  keep(row: T): boolean;
  compare(a: T, b: T): number;
  /** Filter or order depend on values that change by themselves. */
  live: boolean;
  /** All rows have come: from then on, rows stay where they are until asked again. */
  complete: boolean;
}

/** The rows of a list. Once it is complete, they never move by themselves. */
export class FrozenOrder<T> {
  rows: T[] = [];
  /** Grows with each change of `rows`. */
  version = 0;
  /** How many rows would move, come or go by a refresh, as counted last. */
  outdated = 0;
  #frozen = false;
  #name: string | null = null;
  #structure = -1;
  #members = new Set<T>();

  /** `structure` changes when `all` has other members, or their constant columns changed. Counts what is out of date. */
  update(all: Iterable<T>, structure: number, spec: OrderSpec<T>): void {
    const same = this.#name === spec.name;
    if (same && this.#structure === structure && (this.#frozen || !spec.complete)) return;
    if (same && this.#frozen) {
      const rows = [...all];
      this.#patch(rows, spec);
      this.count(rows, spec);
    } else {
      this.refresh(all, spec);
    }
    this.#frozen = spec.complete || (same && this.#frozen);
    this.#name = spec.name;
    this.#structure = structure;
  }

  /** Takes filter and order anew. */
  refresh(all: Iterable<T>, spec: OrderSpec<T>): void {
    this.#take(sorted(all, spec));
    this.outdated = 0;
  }

  /** Counts what is out of date. */
  count(all: Iterable<T>, spec: OrderSpec<T>): void {
    if (!this.#frozen) return;
    const places = new Map(sorted(all, spec).map((row, index) => [row, index]));
    const kept = this.rows.flatMap((row) => places.get(row) ?? []);
    this.outdated = this.rows.length + places.size - kept.length - longestRise(kept);
  }

  /** Rows that went go, new ones come at the end, all others stay. */
  #patch(all: Iterable<T>, spec: OrderSpec<T>): void {
    const present = new Set(all);
    const rows = this.rows.filter((row) => present.has(row));
    const added = [...present].filter((row) => !this.#members.has(row) && spec.keep(row)).sort(spec.compare);
    if (rows.length === this.rows.length && added.length === 0) return;
    this.#take([...rows, ...added]);
  }

  #take(rows: T[]): void {
    this.rows = rows;
    this.#members = new Set(rows);
    this.version++;
  }
}

function sorted<T>(all: Iterable<T>, spec: OrderSpec<T>): T[] {
  const rows: T[] = [];
  for (const row of all) {
    if (spec.keep(row)) rows.push(row);
  }
  return rows.sort(spec.compare);
}

/** The length of the longest part of the numbers that rises, with others between: rows that need not move. */
function longestRise(numbers: number[]): number {
  const ends: number[] = []; // the least end of a rise of each length
  for (const number of numbers) {
    let low = 0;
    let high = ends.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if ((ends[middle] ?? 0) < number) low = middle + 1;
      else high = middle;
    }
    ends[low] = number;
  }
  return ends.length;
}
