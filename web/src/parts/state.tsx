import type { ComponentChildren } from "preact";
import { feed, type Loading } from "../app";
import type { Tone } from "../core/commands";
import { setQuery } from "../core/router";
import * as words from "../words/frame";
import { prose } from "./prose";

const tones: Record<string, Tone> = {
  reachable: "good",
  unreachable: "bad",
  good: "good",
  assumed: "waiting",
  stored: "waiting",
  stale: "waiting",
  bad: "bad",
  "device-offline": "bad",
  "network-down": "bad",
  up: "good",
  connecting: "waiting",
  ended: "neutral",
  refused: "bad",
  down: "bad",
};

export function toneOfWord(word: string): Tone {
  return tones[word] ?? "neutral";
}

/** A state as dot and word: colour never stands alone. */
export function State({ word, tone = toneOfWord(word), title }: { word: string; tone?: Tone; title?: string }) {
  return (
    <span class={`state tone-${tone}`} title={title}>
      <span class="dot" aria-hidden="true" />
      {word}
    </span>
  );
}

/** What stands where rows would be: why there are none, and what to do. With `whole`, in the place of the whole view. */
export function Empty({ title, whole, children }: { title: string; whole?: boolean; children?: ComponentChildren }) {
  return (
    <div class="empty">
      {whole ? <h1 class="empty-title">{title}</h1> : <p class="empty-title">{title}</p>}
      {children}
    </div>
  );
}

/** Loading, failed, empty, or the content: four different states. */
export function Loaded({ state, empty, children }: { state: Loading; empty?: ComponentChildren; children: ComponentChildren }) {
  if (typeof state === "object") {
    return (
      <Empty title={words.failedTitle}>
        <p>
          {state.code}: {prose(state.text)}
        </p>
        <p>
          <button type="button" onClick={() => feed.retry()}>
            {words.failedRetry}
          </button>
        </p>
      </Empty>
    );
  }
  if (empty && state === "loading") return <Skeleton />;
  return <>{empty || children}</>;
}

/** Rows that are still on their way. */
export function Skeleton({ rows = 8 }: { rows?: number }) {
  return (
    <div class="skeleton" role="status" aria-label={words.loading}>
      {Array.from({ length: rows }, (_, index) => (
        <div key={index} style={`width:${60 + ((index * 37) % 35)}%`} />
      ))}
    </div>
  );
}

/** Filtered to nothing, with the way back. */
export function NoneMatch({ title, clear = { q: "" } }: { title: string; clear?: Record<string, string> }) {
  return (
    <Empty title={title}>
      <button type="button" onClick={() => setQuery(clear)}>
        {words.tableClear}
      </button>
    </Empty>
  );
}
