import { effect, signal } from "@preact/signals";

/** A value that the browser remembers; one that cannot be read or written is kept for this visit. */
export function remembered<T>(name: string, initial: T) {
  const value = signal<T>(load(name, initial));
  effect(() => {
    const text = JSON.stringify(value.value);
    try {
      localStorage.setItem(`rubicon.${name}`, text);
    } catch {
      // Storage is full or forbidden.
    }
  });
  return value;
}

function load<T>(name: string, initial: T): T {
  try {
    const text = localStorage.getItem(`rubicon.${name}`);
    const value: unknown = text === null ? initial : JSON.parse(text);
    return typeof value === typeof initial && Array.isArray(value) === Array.isArray(initial) ? (value as T) : initial;
  } catch {
    return initial;
  }
}

export type Theme = "system" | "light" | "dark";

export const theme = remembered<Theme>("theme", "system");
/** Single keys are shortcuts; some people speak or type by other means and turn them off. */
export const singleKeys = remembered("single-keys", true);
/** Devices by path, in the order in which they were pinned. */
export const pinnedDevices = remembered<string[]>("pinned-devices", []);
/** Branches of the tuple tree. */
export const pinnedBranches = remembered<string[]>("pinned-branches", []);

export function togglePin(pins: { value: string[] }, name: string): void {
  pins.value = pins.value.includes(name) ? pins.value.filter((other) => other !== name) : [...pins.value, name];
}

export function applyTheme(): void {
  effect(() => {
    if (theme.value === "system") delete document.documentElement.dataset.theme;
    else document.documentElement.dataset.theme = theme.value;
  });
}
