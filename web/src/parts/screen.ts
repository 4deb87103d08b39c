import { signal } from "@preact/signals";

function media(query: string) {
  const list = matchMedia(query);
  const value = signal(list.matches);
  list.addEventListener("change", () => (value.value = list.matches));
  return value;
}

/** One column, bottom bar, rows of two lines. */
export const phone = media("(max-width: 639px)");
/** Room for every column. */
export const wide = media("(min-width: 1100px)");
/** Fingers instead of a mouse. */
export const coarse = media("(pointer: coarse)");

/** Pixels of a row of a table. */
export function rowHeight(): number {
  return phone.value ? 60 : coarse.value ? 44 : 30;
}
