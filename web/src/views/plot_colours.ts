import { useEffect, useState } from "preact/hooks";
import { theme } from "../core/settings";

export interface Bounds {
  from: number;
  to: number;
}

const light = ["#1558b0", "#b3541e", "#1a7f37", "#8236c9", "#00767d", "#b5176e", "#7a5b00", "#5b6470"];
const dark = ["#6fb0ff", "#ffa066", "#4cc26e", "#be95ff", "#3dcfd0", "#ff7eb6", "#e0b93a", "#b4bec9"];
const darkQuery = matchMedia("(prefers-color-scheme: dark)");

export function isDark(): boolean {
  return theme.value === "dark" || (theme.value === "system" && darkQuery.matches);
}

/** A canvas takes no variables of the style sheet: colours of points, by their place. */
export function colourOf(place: number): string {
  const colours = isDark() ? dark : light;
  return colours[place % colours.length] ?? "#888888";
}

/** Colour never alone: from the fifth point on lines are dashed, and the legend numbers all of them. */
export function dashOf(place: number): number[] | undefined {
  return place < 4
    ? undefined
    : [
        [6, 3],
        [2, 3],
        [8, 3, 2, 3],
        [12, 4],
      ][place % 4];
}

/** The colours of the theme that a canvas needs. */
export function inkOf(): { text: string; muted: string; edge: string; surface: string } {
  return isDark()
    ? { text: "#e3e8ee", muted: "#9ba7b4", edge: "#2a333e", surface: "#2a333e" }
    : { text: "#1b2129", muted: "#59636f", edge: "#e1e5ea", surface: "#e1e5ea" };
}

/** Changes with the theme. */
export function useInk(): string {
  const [, setTurn] = useState(0);
  useEffect(() => {
    const changed = () => setTurn((turn) => turn + 1);
    darkQuery.addEventListener("change", changed);
    return () => darkQuery.removeEventListener("change", changed);
  }, []);
  return isDark() ? "dark" : "light";
}
