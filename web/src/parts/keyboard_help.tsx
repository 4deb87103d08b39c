import { signal } from "@preact/signals";
import { shortcutsInForce } from "../core/keyboard";
import { singleKeys } from "../core/settings";
import { words } from "../words";
import { Dialog } from "./dialog";

const open = signal(false);

export function showHelp(): void {
  open.value = true;
}

const signs: Record<string, string> = { " ": "Space", ArrowDown: "↓", ArrowUp: "↑", ArrowLeft: "←", ArrowRight: "→", Escape: "Esc", PageDown: "Page ↓", PageUp: "Page ↑" };

/** The list of the keys that are in force where the user is. */
export function KeyboardHelp() {
  if (!open.value) return null;
  return (
    <Dialog title={words.keyboard.title} onClose={() => (open.value = false)}>
      <dl class="shortcuts">
        {shortcutsInForce().map(({ keys, what }) => (
          <div key={keys}>
            <dt>
              {(keys === " " ? [" "] : keys.split(" ")).map((key) => (
                <kbd key={key}>{signs[key] ?? key}</kbd>
              ))}
            </dt>
            <dd>{what}</dd>
          </div>
        ))}
      </dl>
      <label class="check">
        <input type="checkbox" checked={singleKeys.value} onChange={(event) => (singleKeys.value = event.currentTarget.checked)} />
        {words.keyboard.single}
      </label>
    </Dialog>
  );
}
