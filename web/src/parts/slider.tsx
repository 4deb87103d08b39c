import type { Point } from "../core/catalog";
import type { Control } from "../core/commands";
import { reciprocal } from "../core/colour";
import { Drafts } from "../core/drafts";
import { redraw } from "../core/redraw";
import * as text from "../words/command";
import { sendCommand } from "./sent";

/** Where sliders were left, until the command has ended. */
const slid = new Drafts();

interface SliderProps {
  point: Point;
  label: string;
  minimum: number;
  maximum: number;
  step: number;
  /** Where it stands while nobody moves it; empty = not known. */
  value: string;
  /** The command for a place. */
  commandOf?(place: string): string;
  /** How the place is said. */
  say?(place: string): string;
  class?: string;
}

/** Acts when it is let go; stays there until the command has ended, then shows what the device reports. */
export function Slider({ point, label, value, commandOf = (place) => place, say, class: look = "", ...range }: SliderProps) {
  const { path } = point;
  const moved = slid.of(path);
  const place = moved ?? value;
  const known = place !== "";
  return (
    <>
      <input
        type="range"
        aria-label={label}
        class={`${look}${known ? "" : " unknown"}`.trim() || undefined}
        aria-valuetext={known ? say?.(place) : text.unknown}
        min={range.minimum}
        max={range.maximum}
        step={range.step}
        value={known ? place : range.minimum}
        onInput={(event) => {
          slid.type(path, event.currentTarget.value);
          redraw();
        }}
        onChange={(event) => {
          const left = event.currentTarget.value;
          slid.type(path, left);
          sendCommand(point, commandOf(left), () => slid.done(path, left));
        }}
      />
      {say && known && (
        <output class="muted" aria-hidden="true">
          {say(place)}
        </output>
      )}
    </>
  );
}

interface WhiteProps {
  control: Control & { kind: "white" };
  point: Point;
  label: string;
}

/** From warm to cold white, in kelvin whatever the device counts in. */
export function WhiteSlider({ control: { minimum, maximum, mired }, point, label }: WhiteProps) {
  const reported = Number(point.value?.value ?? "") || 0;
  const kelvin = mired && reported > 0 ? reciprocal(reported) : reported;
  const bound = (value: number) => Math.max(minimum, Math.min(maximum, value));
  return (
    <Slider
      class="white"
      point={point}
      label={label}
      minimum={minimum}
      maximum={maximum}
      step={50}
      value={reported > 0 ? String(bound(kelvin)) : ""}
      commandOf={(place) => (mired ? String(reciprocal(Number(place))) : place)}
      say={text.kelvin}
    />
  );
}
