import { signal } from "@preact/signals";
import type { Tone } from "../core/commands";

interface Notice {
  id: number;
  text: string;
  tone: Tone;
  action?: { label: string; run(): void };
}

const spoken = signal("");
const notices = signal<Notice[]>([]);
let lastId = 0;

/** Says a text to screen readers: the connection, outcomes of commands. Never values. */
export function announce(text: string): void {
  spoken.value = text;
}

/** Shows a line that goes away by itself, and says it. An equal line is shown once. */
export function notify(text: string, tone: Tone = "neutral", action?: Notice["action"], milliseconds = 6000): void {
  const notice = { id: ++lastId, text, tone, action };
  notices.value = [...notices.value.filter((other) => other.text !== text), notice].slice(-4);
  announce(text);
  setTimeout(() => dismiss(notice), milliseconds);
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
            <span>{notice.text}</span>
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
          </div>
        ))}
      </div>
    </>
  );
}
