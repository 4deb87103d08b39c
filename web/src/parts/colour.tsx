import { useRef, useState } from "preact/hooks";
import type { Point } from "../core/catalog";
import { type Colour, hexOf, writeColour } from "../core/colour";
import { type Control, toneOf } from "../core/commands";
import { useFrame } from "../core/redraw";
import * as text from "../words/command";
import { Dialog } from "./dialog";
import { prose } from "./prose";
import { outcomeAt, sendCommand } from "./sent";
import { WhiteSlider } from "./slider";
import { State } from "./state";
import { colourAt, Swatch } from "./swatch";

/** A lamp's white light beside its colour. */
export interface White {
  point: Point;
  control: Control & { kind: "white" };
}

/** A button with the colour of the lamp, which opens the wheel. */
export function ColourControl({ point, label, white }: { point: Point; label: string; white?: White }) {
  const [open, setOpen] = useState(false);
  return (
    <>
      <button type="button" class="colour" aria-label={text.colourOf(label)} onClick={() => setOpen(true)}>
        <Swatch colour={colourAt(point)} />
        <span>{text.colour}</span>
      </button>
      {open && (
        <Dialog title={text.colourOf(label)} onClose={() => setOpen(false)}>
          <ColourChoice point={point} />
          {white && (
            <label class="colour-part">
              <span>{text.white}</span>
              <WhiteSlider {...white} label={text.whiteOf(label)} />
            </label>
          )}
          <Ended points={white ? [point, white.point] : [point]} />
        </Dialog>
      )}
    </>
  );
}

/** What became of the last command of these. */
function Ended({ points }: { points: Point[] }) {
  const outcomes = points.map(outcomeAt).filter((outcome) => outcome !== null);
  const [outcome] = outcomes.sort((a, b) => b.since - a.since);
  if (!outcome) return null;
  return (
    <p class="muted">
      <State word={outcome.state} tone={toneOf(outcome.state)} /> {prose(outcome.reason)}
    </p>
  );
}

function ColourChoice({ point }: { point: Point }) {
  useFrame();
  const [chosen, setChosen] = useState<Colour | null>(null);
  const colour = chosen ?? colourAt(point) ?? { hue: 0, saturation: 0 };
  const send = (next: Colour) => {
    setChosen(next);
    sendCommand(point, writeColour(point.type, next), () => setChosen((now) => (now === next ? null : now)));
  };
  return (
    <div class="colour-choice">
      <Wheel colour={colour} onMove={setChosen} onChoose={send} />
      <div class="colour-fields">
        <Part
          name={text.hue}
          sign="°"
          most={360}
          value={colour.hue}
          onMove={(hue) => setChosen({ ...colour, hue })}
          onChoose={(hue) => send({ ...colour, hue })}
        />
        <Part
          name={text.saturation}
          sign=" %"
          most={100}
          value={colour.saturation * 100}
          onMove={(saturation) => setChosen({ ...colour, saturation: saturation / 100 })}
          onChoose={(saturation) => send({ ...colour, saturation: saturation / 100 })}
        />
        <p>
          <Swatch colour={colour} /> {hexOf(colour)}
        </p>
      </div>
    </div>
  );
}

interface PartProps {
  name: string;
  sign: string;
  most: number;
  value: number;
  onMove(value: number): void;
  onChoose(value: number): void;
}

/** What the wheel chooses, by keys. */
function Part({ name, sign, most, value, onMove, onChoose }: PartProps) {
  const said = `${Math.round(value)}${sign}`;
  return (
    <label class="colour-part">
      <span>{name}</span>
      <input
        type="range"
        max={most}
        value={Math.round(value)}
        aria-valuetext={said}
        onInput={(event) => onMove(Number(event.currentTarget.value))}
        onChange={(event) => onChoose(Number(event.currentTarget.value))}
      />
      <output aria-hidden="true">{said}</output>
    </label>
  );
}

interface WheelProps {
  colour: Colour;
  onMove(colour: Colour): void;
  onChoose(colour: Colour): void;
}

/** Hue around, saturation outwards; chosen where the pointer is let go. Keys have the sliders beside it. */
function Wheel({ colour, onMove, onChoose }: WheelProps) {
  const wheel = useRef<HTMLDivElement>(null);
  const at = (event: PointerEvent): Colour => {
    const { left, top, width } = wheel.current?.getBoundingClientRect() ?? { left: 0, top: 0, width: 1 };
    const x = ((event.clientX - left) / width) * 2 - 1;
    const y = ((event.clientY - top) / width) * 2 - 1;
    return { hue: ((Math.atan2(x, -y) * 180) / Math.PI + 360) % 360, saturation: Math.min(1, Math.hypot(x, y)) };
  };
  const angle = (colour.hue * Math.PI) / 180;
  const x = 50 + 50 * colour.saturation * Math.sin(angle);
  const y = 50 - 50 * colour.saturation * Math.cos(angle);
  return (
    <div
      ref={wheel}
      class="wheel"
      aria-hidden="true"
      onPointerDown={(event) => {
        event.currentTarget.setPointerCapture(event.pointerId);
        onMove(at(event));
      }}
      onPointerMove={(event) => event.buttons > 0 && onMove(at(event))}
      onPointerUp={(event) => onChoose(at(event))}
    >
      <span class="wheel-mark" style={`left:${x}%;top:${y}%`} />
    </div>
  );
}
