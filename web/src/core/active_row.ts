/** The row that keys act on. Rows before it may come and go: its name says which one it is. */
export interface ActiveRow {
  index: number;
  /** Undefined until the user chose a row. */
  name?: string;
}

/** Where the active row is now; if it went, the row in its place. */
export function activeNow(before: ActiveRow, count: number, nameAt?: (index: number) => string): ActiveRow {
  const { name } = before;
  const index = Math.min(before.index, Math.max(count - 1, 0));
  if (count === 0 || !nameAt || name === undefined) return { index, name };
  if (nameAt(index) === name) return { index, name };
  for (let other = 0; other < count; other++) if (nameAt(other) === name) return { index: other, name };
  return { index, name: nameAt(index) };
}
