import { signal } from "@preact/signals";
import type UPlot from "uplot";

type Library = typeof UPlot;

const library = signal<Library | null>(null);
let asked = false;

/** The library that draws plots: a file of its own, which comes when the first plot is shown. Null until then. */
export function usePlotting(): Library | null {
  if (!asked) {
    asked = true;
    import("uplot").then(
      (module) => (library.value = module.default),
      () => (asked = false), // the line is lost: the next drawing asks again
    );
  }
  return library.value;
}
