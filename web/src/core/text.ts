const natural = new Intl.Collator(undefined, { numeric: true, sensitivity: "base" });

/** 2 before 10, a before B. */
export function compareNatural(a: string, b: string): number {
  return natural.compare(a, b);
}

/** Each word of `search` occurs in `where`, in any case and order. */
export function matches(search: string, where: string): boolean {
  const text = where.toLowerCase();
  return search
    .toLowerCase()
    .split(/\s+/)
    .every((word) => text.includes(word));
}

/** `1 device`, `12 devices`. */
export function many(count: number, one: string, more = `${one}s`): string {
  return `${count.toLocaleString()} ${count === 1 ? one : more}`;
}
