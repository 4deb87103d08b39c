/** What decides which rows a list shows, and in which order. */
export interface OrderSpec<T> {
  /** Changes when the user asks for another filter or order. */
  name: string;
  keep(row: T): boolean;
  compare(a: T, b: T): number;
  /** Filter or order depend on values that change by themselves: the list then stays as it is until asked again. */
  live: boolean;
}

/** The rows of a list. They never move by themselves. */
export class FrozenOrder<T> {
  rows: T[] = [];
  /** Grows with each change of `rows`. */
  version = 0;
  private name: string | null = null;
  private structure = -1;
  private members = new Set<T>();

  /** `structure` changes when `all` has other members, or their constant columns changed. */
  update(all: Iterable<T>, structure: number, spec: OrderSpec<T>): void {
    if (this.name === spec.name && this.structure === structure) return;
    if (this.name === spec.name && spec.live) this.patch(all, spec);
    else this.take(sorted(all, spec));
    this.name = spec.name;
    this.structure = structure;
  }

  /** Takes filter and order anew. */
  refresh(all: Iterable<T>, spec: OrderSpec<T>): void {
    this.take(sorted(all, spec));
  }

  /** How many rows would move, come or go by a refresh. */
  outdated(all: Iterable<T>, spec: OrderSpec<T>): number {
    if (!spec.live) return 0;
    const fresh = sorted(all, spec);
    let different = Math.abs(fresh.length - this.rows.length);
    for (let index = 0; index < Math.min(fresh.length, this.rows.length); index++) {
      if (fresh[index] !== this.rows[index]) different++;
    }
    return different;
  }

  /** Rows that went go, new ones come at the end, all others stay. */
  private patch(all: Iterable<T>, spec: OrderSpec<T>): void {
    const present = new Set(all);
    const rows = this.rows.filter((row) => present.has(row));
    const added = [...present].filter((row) => !this.members.has(row) && spec.keep(row)).sort(spec.compare);
    if (rows.length === this.rows.length && added.length === 0) return;
    this.take([...rows, ...added]);
  }

  private take(rows: T[]): void {
    this.rows = rows;
    this.members = new Set(rows);
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
