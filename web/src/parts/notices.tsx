import { signal } from "@preact/signals";
import type { Tone } from "../core/commands";
import * as words from "../words/frame";
import { prose } from "./prose";

interface Notice {
  id: number;
  text: string;
  tone: Tone;
  action?: { label: string; run(): void };
}

export const spoken = signal("");
export const notices = signal<Notice[]>([]);
let lastId = 0;
const shownFor = 6000;

/** Says a text to screen readers: the connection, outcomes of commands. Never values. They speak what changes: the same text twice differs by a space. */
export function announce(text: string): void {
  spoken.value = spoken.value === text ? `${text}\u00a0` : text;
}

/** Shows a line, and says it. It goes away by itself unless it is bad or asks for something. An equal line is shown once. */
export function notify(text: string, tone: Tone = "neutral", action?: Notice["action"]): void {
  const notice = { id: ++lastId, text, tone, action };
  notices.value = [...notices.value.filter((other) => other.text !== text), notice].slice(-4);
  announce(text);
  if (tone !== "bad" && !action) setTimeout(() => dismiss(notice), shownFor);
}

function dismiss(notice: Notice): void {
  notices.value = notices.value.filter((other) => other !== notice);
}

export function Notices() {
  return (
    <>
      <div class="spoken" role="status" aria-live="polite">
        {spoken.value}
      </div>
      <div class="notices">
        {notices.value.map((notice) => (
          <div key={notice.id} class={`notice tone-${notice.tone}`}>
            <span>{prose(notice.text)}</span>
            {notice.action && (
              <button
                type="button"
                onClick={() => {
                  notice.action?.run();
                  dismiss(notice);
                }}
              >
                {notice.action.label}
              </button>
            )}
            <button type="button" class="plain" aria-label={words.close} title={words.close} onClick={() => dismiss(notice)}>
              ×
            </button>
          </div>
        ))}
      </div>
    </>
  );
}
