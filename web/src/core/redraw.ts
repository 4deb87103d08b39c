import { signal } from "@preact/signals";
import { Component } from "preact";

// The library of signals skips a component whose properties are the same objects as before. Tuples, devices and points
// are changed in place: here, what is drawn draws all that is in it.
Component.prototype.shouldComponentUpdate = undefined;

/** Grows by one in each animation frame in which something changed; views read it and draw from the store. */
export const frameNumber = signal(0);

let asked = false;

/** Asks for a redraw in the next animation frame. */
export function redraw(): void {
  if (asked) return;
  asked = true;
  requestAnimationFrame(() => {
    asked = false;
    frameNumber.value++;
  });
}

/** A component that calls it is drawn again in each frame in which something changed. */
export function useFrame(): number {
  return frameNumber.value;
}

/** Grows once a second, for ages. */
export const second = signal(0);
setInterval(() => {
  if (!document.hidden) second.value++;
}, 1000);
