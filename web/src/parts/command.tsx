import { connection, mayBe } from "../app";
import type { Point } from "../core/catalog";
import { advance, begin, type Control, controlOf, type Outcome, outcomeOf, toneOf, waitsUntil } from "../core/commands";
import { Drafts } from "../core/drafts";
import { formatTime, unitSign } from "../core/format";
import type { Answer } from "../core/frames";
import { Patience } from "../core/patience";
import { redraw } from "../core/redraw";
import * as text from "../words/command";
import { Age } from "./age";
import { announce } from "./notices";
import { State } from "./state";

export const patience = new Patience();
const drafts = new Drafts();

interface Sent extends Outcome {
  /** `since` of the command that the status showed before. */
  before: number;
}

/** The last command that this page sent to a point, by the point's path. */
const sent = new Map<string, Sent>();

function now(): number {
  return Date.now() / 1000;
}

/** Commands a point and follows the outcome. */
export function sendCommand(point: Point, value: string): void {
  const { path } = point;
  const before = outcomeOf(point.status?.json ?? {})?.since ?? 0;
  let own: Sent = { ...begin(value, now()), before };
  const show = (next: Sent) => {
    if (sent.get(path) === own || !sent.has(path)) sent.set(path, next); // else a newer command is shown
    own = next;
    redraw();
  };
  sent.delete(path);
  show(own);
  connection.request(
    { do: "set", key: `${path}.command`, value, ttl: patience.of(point.device.path) },
    (answer) => {
      show({ ...advance(own, answer, now()), before });
      if (toneOf(own.state) === "good") drafts.done(path, value);
      if (own.final) announce(text.spoken(`${point.device.name} ${point.id}`, value, own.state, own.reason));
    },
    true,
  );
}

/** Sets or appends to a tuple that is no command of a point; the answer is the outcome. */
export function setTuple(
  key: string,
  value: string,
  fields: Record<string, unknown> = {},
  call: (answer: Answer) => void = () => {},
): void {
  connection.request({ do: "set", key, value, ...fields }, call);
}

/** The command of a point that counts: ours until it ends, then what the island says. */
export function outcomeAt(point: Point): Outcome | null {
  const own = sent.get(point.path);
  const reported = outcomeOf(point.status?.json ?? {});
  if (own && (!own.final || !reported || reported.since === own.before)) return own;
  return reported;
}

/** State of the last command, with age, reason and commander. Beside the reported value, never in its place. */
export function OutcomeMark({ point }: { point: Point }) {
  const outcome = outcomeAt(point);
  if (!outcome) return null;
  const { state, value, reason, since, commander } = outcome;
  const until = waitsUntil(outcome);
  const facts = [until > 0 && text.until(formatTime(until)), reason, commander && text.by(commander)].filter(Boolean);
  return (
    <span class="outcome" title={[text.commanded(value), ...facts].join(" · ")}>
      <span>
        <State word={state} tone={toneOf(state)} />{" "}
        <span class="muted">
          {text.commanded(value)} · <Age time={since} />
        </span>
      </span>
      <span class="muted">{facts.join(" · ")}</span>
    </span>
  );
}

/** The control that the description of a point asks for; nothing where nothing can be set. */
export function CommandControl({ point }: { point: Point }) {
  const description = point.description?.json ?? {};
  const access = String(description.access ?? "");
  if (!access.includes("write") || !mayBe("command")) return null;
  const control = controlOf(description);
  const label = `${point.device.name} ${point.id}`;
  return (
    <span class={`control control-${control.kind}`}>
      <ControlOf control={control} point={point} label={label} />
    </span>
  );
}

interface ControlProps<C extends Control = Control> {
  control: C;
  point: Point;
  label: string;
}

function ControlOf({ control, point, label }: ControlProps) {
  switch (control.kind) {
    case "switch":
      return <Switch control={control} point={point} label={label} />;
    case "buttons":
      return <Buttons words={control.words} point={point} label={label} pressed />;
    default:
      return <Draft control={control} point={point} label={label} />;
  }
}

/** Shows the reported value; while that is not known, each word is a button. */
function Switch({ control, point, label }: ControlProps<Control & { kind: "switch" }>) {
  const value = point.value?.value;
  if (value !== control.on && value !== control.off) return <Buttons words={[control.off, control.on]} point={point} label={label} />;
  const on = value === control.on;
  return (
    <button
      type="button"
      role="switch"
      class="switch"
      aria-checked={on}
      aria-label={label}
      onClick={() => sendCommand(point, on ? control.off : control.on)}
    >
      <span class="knob" aria-hidden="true" />
      {value}
    </button>
  );
}

function Buttons({ words: choices, point, label, pressed }: { words: string[]; point: Point; label: string; pressed?: boolean }) {
  const state = pressed && point.description?.json.report !== "event";
  return (
    <span class="segments" role="group" aria-label={label}>
      {choices.map((word) => (
        <button
          key={word}
          type="button"
          aria-pressed={state ? point.value?.value === word : undefined}
          onClick={() => sendCommand(point, word)}
        >
          {word}
        </button>
      ))}
    </span>
  );
}

/** Controls whose value is chosen first and then set. What was chosen stays until it is in force or discarded. */
function Draft({ control, point, label }: ControlProps) {
  const { path } = point;
  const draft = drafts.of(path);
  const reported = point.value?.value ?? "";
  const value = draft ?? reported;
  const changed = draft !== null && draft !== reported;
  const type = (given: string) => {
    if (given === reported) drafts.discard(path);
    else drafts.type(path, given);
    redraw();
  };
  const discard = (event: { currentTarget: HTMLButtonElement }) => {
    drafts.discard(path);
    fieldOf(event.currentTarget.form)?.focus(); // the button goes
    redraw();
  };
  const send = (event: Event) => {
    event.preventDefault();
    const given = draft ?? fieldOf(event.currentTarget as HTMLFormElement)?.value ?? reported;
    drafts.type(path, given);
    sendCommand(point, given);
  };
  return (
    <form onSubmit={send}>
      <Field control={control} value={value} label={label} onInput={type} />
      {unitSign(point.unit) && (control.kind === "slider" || control.kind === "number") && <span class="unit">{unitSign(point.unit)}</span>}
      <button type="submit" class={changed ? "primary" : ""}>
        {text.set}
      </button>
      {changed && (
        <button type="button" class="plain discard" aria-label={text.discard(label)} title={text.discard(label)} onClick={discard}>
          ×
        </button>
      )}
    </form>
  );
}

function fieldOf(form: HTMLFormElement | null): HTMLInputElement | null {
  return form?.querySelector("input, select, textarea") ?? null;
}

interface FieldProps {
  control: Control;
  value: string;
  label: string;
  onInput(value: string): void;
}

function Field({ control, value, label, onInput }: FieldProps) {
  const input = (event: { currentTarget: HTMLInputElement | HTMLSelectElement }) => onInput(event.currentTarget.value);
  switch (control.kind) {
    case "slider":
    case "number":
      return <NumberField control={control} value={value} label={label} onInput={onInput} />;
    case "choice":
      return (
        <select aria-label={label} value={value} onChange={input}>
          {!control.words.includes(value) && <option value={value}>{value || "–"}</option>}
          {control.words.map((word) => (
            <option key={word} value={word}>
              {word}
            </option>
          ))}
        </select>
      );
    case "colour":
      return (
        <input type="color" aria-label={label} value={/^#[0-9a-f]{6}$/i.test(value) ? value.toLowerCase() : "#ffffff"} onInput={input} />
      );
    default:
      return <input type="text" aria-label={label} value={value} spellcheck={false} onInput={input} />;
  }
}

function NumberField({ control, value, label, onInput }: FieldProps & { control: Control & { kind: "slider" | "number" } }) {
  const { minimum, maximum, step } = control;
  const range = text.range(minimum, maximum);
  return (
    <>
      {control.kind === "slider" && (
        <input
          type="range"
          aria-label={label}
          class={value === "" ? "unknown" : ""}
          aria-valuetext={value === "" ? text.unknown : undefined}
          min={minimum}
          max={maximum}
          step={step}
          value={value === "" ? minimum : value}
          onInput={(event) => onInput(event.currentTarget.value)}
        />
      )}
      <input
        type="number"
        aria-label={control.kind === "slider" ? `${label}, ${range}` : label}
        title={range}
        min={minimum}
        max={maximum}
        step="any"
        required
        value={value}
        onInput={(event) => onInput(event.currentTarget.value)}
      />
    </>
  );
}
