const natural = new Intl.Collator(undefined, { numeric: true, sensitivity: "base" });

/** A word of 16 hexadecimal digits: `00124b0010000000`, with or without `0x`. */
const address = /(?<![0-9a-z])(?:0x)?[0-9a-f]{16}(?![0-9a-z])/gi;

/** The collator takes digits together as a number. Apart, those of an address are texts; after the nines, they follow all numbers. */
const apart = (id: string) => (id.length < 16 ? id : id.replace(address, (digits) => `${"9".repeat(40)} ${[...digits].join(" ")}`));

/** 2 before 10, a before B, IEEE addresses by their digits: the order of the API (src/base/compare_text.h). */
export function compareNatural(a: string, b: string): number {
  return natural.compare(apart(a), apart(b));
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
