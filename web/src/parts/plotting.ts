import { signal } from "@preact/signals";
import type UPlot from "uplot";

type Library = typeof UPlot;

const library = signal<Library | "failed" | null>(null);
let asked = false;

/** The library that draws plots: a file of its own, which comes when the first plot is shown. Null until then; browsers remember that a file could not be loaded. */
export function usePlotting(): Library | "failed" | null {
  if (!asked) {
    asked = true;
    import("uplot").then(
      (module) => (library.value = module.default),
      () => (library.value = "failed"),
    );
  }
  return library.value;
}
