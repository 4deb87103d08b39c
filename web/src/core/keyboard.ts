import { singleKeys } from "./settings";

/** One key or a sequence (`g d`) and what it does. */
export interface Shortcut {
  keys: string;
  what: string;
  run(): void;
}

const scopes: Shortcut[][] = [];
/** Of a sequence: its first key. `at` is when it was pressed, which may be long before a busy page handles it. */
let started = { key: "", at: 0 };
const longestPause = 1500; // ms

/** Adds shortcuts until the result is called; later ones go before earlier ones. In a layout effect: what is shown has its keys. */
export function addShortcuts(shortcuts: Shortcut[]): () => void {
  scopes.push(shortcuts);
  return () => scopes.splice(scopes.indexOf(shortcuts), 1);
}

/** Those that are in force, for the list behind `?`. */
export function shortcutsInForce(): Shortcut[] {
  const seen = new Set<string>();
  return [...scopes].reverse().flatMap((scope) => scope.filter(({ keys }) => !seen.has(keys) && seen.add(keys)));
}

/** Typing in a field is not a shortcut; Escape is one everywhere. */
function typing(target: EventTarget | null): boolean {
  if (!(target instanceof HTMLElement)) return false;
  if (target instanceof HTMLInputElement) return !["checkbox", "radio", "button"].includes(target.type);
  return target instanceof HTMLTextAreaElement || target instanceof HTMLSelectElement || target.isContentEditable;
}

function find(keys: string): Shortcut | undefined {
  for (const scope of [...scopes].reverse()) {
    const found = scope.find((shortcut) => shortcut.keys === keys);
    if (found) return found;
  }
  return undefined;
}

const scrollKeys = new Set(["ArrowDown", "ArrowUp", "PageDown", "PageUp", "Home", "End"]);

/** What is beside a list scrolls by its own keys while the focus is in it. */
function scrolls(event: KeyboardEvent): boolean {
  return scrollKeys.has(event.key) && event.target instanceof HTMLElement && event.target.closest("aside, dialog, [role=region]") !== null;
}

function pressed(event: KeyboardEvent): void {
  if (event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey) return;
  if (typing(event.target) && event.key !== "Escape") return;
  if (scrolls(event)) return;
  if (!singleKeys.value && event.key.length === 1) return;
  const native = event.target instanceof HTMLElement && event.target.closest("button, a, summary, input");
  if (native && (event.key === "Enter" || event.key === " ")) return;
  const follows = started.key !== "" && event.timeStamp - started.at <= longestPause;
  const keys = follows ? `${started.key} ${event.key}` : event.key;
  started = { key: "", at: 0 };
  const shortcut = find(keys) ?? find(event.key);
  if (shortcut) {
    event.preventDefault();
    shortcut.run();
  } else if (scopes.some((scope) => scope.some(({ keys: other }) => other.startsWith(`${event.key} `)))) {
    started = { key: event.key, at: event.timeStamp };
  }
}

export function startKeyboard(): void {
  addEventListener("keydown", pressed);
}
