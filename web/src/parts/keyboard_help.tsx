import { signal } from "@preact/signals";
import { shortcutsInForce } from "../core/keyboard";
import { singleKeys } from "../core/settings";
import * as words from "../words/frame";
import { Dialog } from "./dialog";

const open = signal(false);

export function showHelp(): void {
  open.value = true;
}

const signs: Record<string, string> = {
  " ": "Space",
  ArrowDown: "↓",
  ArrowUp: "↑",
  ArrowLeft: "←",
  ArrowRight: "→",
  Escape: "Esc",
  PageDown: "Page ↓",
  PageUp: "Page ↑",
};

/** The list of the keys that are in force where the user is. */
export function KeyboardHelp() {
  if (!open.value) return null;
  return (
    <Dialog title={words.keyboardTitle} onClose={() => (open.value = false)}>
      <dl class="shortcuts">
        {byMeaning().map(([what, all]) => (
          <div key={what}>
            <dt>
              {all.flatMap((keys, index) => [
                index > 0 && <span key={`or ${keys}`}>{words.keyboardOr}</span>,
                <Keys key={keys} keys={keys} />,
              ])}
            </dt>
            <dd>{what}</dd>
          </div>
        ))}
      </dl>
      <label class="check">
        <input type="checkbox" checked={singleKeys.value} onChange={(event) => (singleKeys.value = event.currentTarget.checked)} />
        {words.keyboardSingle}
      </label>
    </Dialog>
  );
}

function Keys({ keys }: { keys: string }) {
  const each = keys === " " ? [" "] : keys.split(" ");
  return (
    <>
      {each.map((key) => (
        <kbd key={key}>{signs[key] ?? key}</kbd>
      ))}
    </>
  );
}

/** Keys that do the same stand together. */
function byMeaning(): [string, string[]][] {
  const meanings = new Map<string, string[]>();
  for (const { keys, what } of shortcutsInForce()) meanings.set(what, [...(meanings.get(what) ?? []), keys]);
  return [...meanings];
}
