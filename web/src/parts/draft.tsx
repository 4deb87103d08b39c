import type { Point } from "../core/catalog";
import { type Control, toneOf } from "../core/commands";
import { Drafts } from "../core/drafts";
import { unitSign } from "../core/format";
import { redraw } from "../core/redraw";
import * as text from "../words/command";
import { sendCommand } from "./sent";
import { Slider } from "./slider";

const drafts = new Drafts();

interface DraftProps {
  control: Control;
  point: Point;
  label: string;
}

/** Controls whose value is typed or chosen first and then set. It stays until it is in force or discarded. */
export function DraftControl({ control, point, label }: DraftProps) {
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
    sendCommand(point, given, ({ state }) => toneOf(state) === "good" && drafts.done(path, given));
  };
  const sliding = control.kind === "slider";
  return (
    <form onSubmit={send}>
      {sliding && <Slider {...control} point={point} label={label} value={value} />}
      <Field control={control} value={value} label={label} onInput={type} />
      {unitSign(point.unit) && (sliding || control.kind === "number") && <span class="unit">{unitSign(point.unit)}</span>}
      {(!sliding || changed) && (
        <button type="submit" class={changed ? "primary" : ""}>
          {text.set}
        </button>
      )}
      {changed && (
        <button type="button" class="plain discard" aria-label={text.discard(label)} title={text.discard(label)} onClick={discard}>
          ×
        </button>
      )}
    </form>
  );
}

function fieldOf(form: HTMLFormElement | null): HTMLInputElement | null {
  return form?.querySelector("input:not([type=range]), select, textarea") ?? null;
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
    case "number": {
      const { minimum, maximum, step } = control;
      const range = text.range(minimum, maximum);
      return (
        <input
          type="number"
          inputMode={padOf(minimum, step)}
          aria-label={control.kind === "slider" ? `${label}, ${range}` : label}
          title={range}
          min={minimum}
          max={maximum}
          step="any"
          required
          value={value}
          onInput={input}
        />
      );
    }
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
    default:
      return <input type="text" aria-label={label} value={value} spellcheck={false} onInput={input} />;
  }
}

/** The pad of a phone that has all signs of the number: those for digits lack a minus on some. */
function padOf(minimum: number | undefined, step: number | "any"): "numeric" | "decimal" | undefined {
  if (minimum === undefined || minimum < 0) return undefined;
  return step === 1 ? "numeric" : "decimal";
}
