import { mayBe } from "../app";
import type { Point } from "../core/catalog";
import { type Control, controlOf, toneOf, waitsUntil } from "../core/commands";
import { formatTime } from "../core/format";
import * as text from "../words/command";
import { Age } from "./age";
import { ColourControl } from "./colour";
import { DraftControl } from "./draft";
import { prose } from "./prose";
import { outcomeAt, sendCommand } from "./sent";
import { WhiteSlider } from "./slider";
import { State } from "./state";
import { shownValue } from "./value";

/** State of the last command, with age, reason and commander. Beside the reported value, never in its place. */
export function OutcomeMark({ point }: { point: Point }) {
  const outcome = outcomeAt(point);
  if (!outcome) return null;
  const { state, value, reason, since, commander } = outcome;
  const until = waitsUntil(outcome);
  const facts = [until > 0 && text.until(formatTime(until)), reason, commander && text.by(commander)].filter(Boolean);
  return (
    <span class="outcome">
      <span>
        <State word={state} tone={toneOf(state)} />{" "}
        <span class="muted">
          {text.commanded(shownValue(point, value))} · <Age time={since} />
        </span>
      </span>
      {facts.length > 0 && <span class="muted">{prose(facts.join(" · "))}</span>}
    </span>
  );
}

export function isWritable(point: Point): boolean {
  return String(point.description?.json.access ?? "").includes("write");
}

/** The control that the description of a point asks for; nothing where nothing can be set. */
export function CommandControl({ point }: { point: Point }) {
  if (!isWritable(point) || !mayBe("command")) return null;
  const control = controlOf(point.description?.json ?? {});
  const label = `${point.device.name} ${point.id}`;
  return (
    <span class={`control control-${control.kind}`}>
      <ControlOf control={control} point={point} label={label} />
    </span>
  );
}

export interface ControlProps<C extends Control = Control> {
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
    case "colour":
      return <ColourControl point={point} label={label} />;
    case "white":
      return <WhiteSlider control={control} point={point} label={label} />;
    default:
      return <DraftControl control={control} point={point} label={label} />;
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
