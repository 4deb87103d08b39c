import { useState } from "preact/hooks";
import { connection } from "../app";
import type { Answer } from "../core/frames";
import { announce } from "../parts/notices";
import type { Tuple } from "../core/store";
import * as text from "../words/tuples";

interface Draft {
  value: string;
  media: string;
  user: string;
  expire: string;
  only: boolean;
}

/** Seconds since 1970 of a field of date and time; undefined if it is empty. */
export function secondsOf(field: string): number | undefined {
  const time = Date.parse(field);
  return Number.isNaN(time) ? undefined : time / 1000;
}

/** The members of the request. A value that is set keeps its media type if none is given. */
export function requestOf(tuple: Tuple, draft: Draft, verb: "set" | "append", sequence: number): Record<string, unknown> {
  const request: Record<string, unknown> = { do: verb, key: tuple.id, value: draft.value };
  const media = draft.media || (verb === "set" ? tuple.media : "");
  if (media) request.media = media;
  if (draft.only) request.sequence = sequence;
  if (verb === "append") return request; // keeps its times
  const user = secondsOf(draft.user);
  const expire = secondsOf(draft.expire);
  if (user !== undefined) request.user = user;
  if (expire !== undefined) request.expire = expire;
  return request;
}

/** Sets or appends to a tuple of any owner. The owner decides, and its answer is shown. */
export function TupleForm({ tuple }: { tuple: Tuple }) {
  const [draft, setDraft] = useState<Draft>({ value: "", media: "", user: "", expire: "", only: false });
  const [seen, setSeen] = useState(tuple.sequence);
  const [outcome, setOutcome] = useState("");
  const change = (changes: Partial<Draft>) => setDraft({ ...draft, ...changes });
  const answered = (answer: Answer) => {
    const result =
      answer.ok === false
        ? text.failed(answer.error?.code ?? "", answer.error?.text ?? "")
        : text.outcome(answer.state ?? answer.verdict ?? "");
    setOutcome(result);
    announce(result);
  };
  const send = (verb: "set" | "append") =>
    connection.request(requestOf(tuple, draft, verb, seen), answered, tuple.key.endsWith(".command") && verb === "set");
  return (
    <form
      class="tuple-form"
      onSubmit={(event) => {
        event.preventDefault();
        send("set");
      }}
    >
      <h3>{text.set}</h3>
      <textarea
        aria-label={text.newValue}
        placeholder={text.newValue}
        rows={3}
        spellcheck={false}
        value={draft.value}
        onInput={(event) => change({ value: event.currentTarget.value })}
      />
      <div class="form-grid">
        <label class="field">
          <span>{text.media}</span>
          <input
            type="text"
            placeholder={tuple.media || text.mediaHint}
            value={draft.media}
            onInput={(event) => change({ media: event.currentTarget.value })}
          />
        </label>
        <label class="field">
          <span>{text.userTime}</span>
          <input type="datetime-local" step="1" value={draft.user} onInput={(event) => change({ user: event.currentTarget.value })} />
        </label>
        <label class="field">
          <span>{text.expireTime}</span>
          <input type="datetime-local" step="1" value={draft.expire} onInput={(event) => change({ expire: event.currentTarget.value })} />
        </label>
        <label class="check">
          <input
            type="checkbox"
            checked={draft.only}
            onChange={(event) => {
              setSeen(tuple.sequence);
              change({ only: event.currentTarget.checked });
            }}
          />
          {text.only(draft.only ? seen : tuple.sequence)}
        </label>
      </div>
      <div class="actions">
        <button type="submit" class="primary">
          {text.setButton}
        </button>
        <button type="button" onClick={() => send("append")}>
          {text.append}
        </button>
        <span class="muted">{outcome}</span>
      </div>
    </form>
  );
}
