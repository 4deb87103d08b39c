import { signal } from "@preact/signals";
import { Component } from "preact";

// The library of signals skips a component whose properties are the same objects as before. Tuples, devices and points
// are changed in place: here, what is drawn draws all that is in it.
Component.prototype.shouldComponentUpdate = undefined;

/** Grows by one in each animation frame in which something changed; views read it and draw from the store. */
export const frameNumber = signal(0);

const waiting = new Set<() => void>();

/** Calls it in the next animation frame. What the calls of one frame change is drawn at once. */
export function inFrame(call: () => void): void {
  if (waiting.size === 0) {
    requestAnimationFrame(() => {
      const calls = [...waiting];
      waiting.clear();
      for (const one of calls) one();
    });
  }
  waiting.add(call);
}

function countFrame(): void {
  frameNumber.value++;
}

/** Asks for a redraw in the next animation frame. */
export function redraw(): void {
  inFrame(countFrame);
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
