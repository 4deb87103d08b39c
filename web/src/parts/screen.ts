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

/** Pixels of a line of small letters, and of such a letter on average. */
const [line, letter] = [16, 6];

/** The size of letters for which the heights of rows are given. */
export const normalSize = 13;

const letters = signal(sizeOfLetters());
addEventListener("resize", () => (letters.value = sizeOfLetters()));

function sizeOfLetters(): number {
  return Number.parseFloat(getComputedStyle(document.documentElement).fontSize) || normalSize;
}

/** As many pixels as these are with letters of the size that the user has. */
export function scaled(pixels: number): number {
  return Math.round((pixels * letters.value) / normalSize);
}

/** Pixels that lines after the first take of a text of so many letters, in a column at least so wide: what is not to be cut. */
export function moreLines(letters: number, width: number): number {
  return Math.max(0, Math.ceil((letters * letter) / width) - 1) * line;
}

/** Pixels of a row of a table. */
export function rowHeight(twoLines = phone.value): number {
  return scaled(twoLines ? 60 : coarse.value ? 44 : 30);
}
