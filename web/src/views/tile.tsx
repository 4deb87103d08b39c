import { mayBe } from "../app";
import type { Point } from "../core/catalog";
import { type Control, controlOf, toneOf } from "../core/commands";
import { Drafts } from "../core/drafts";
import { formatNumber, typeWords, unitSign } from "../core/format";
import { redraw, useFrame } from "../core/redraw";
import { measuredBy, type Tile } from "../core/rooms";
import { hrefTo } from "../core/router";
import { ColourControl } from "../parts/colour";
import { CommandControl } from "../parts/command";
import { outcomeAt, sendCommand } from "../parts/sent";
import { Slider, WhiteSlider } from "../parts/slider";
import { State } from "../parts/state";
import { Value } from "../parts/value";
import * as text from "../words/overview";
import { Age } from "../parts/age";
import { prose } from "../parts/prose";
import { nameOfPoint } from "../app";

/** What is operated together in a room: its name, its controls, and what became of the last command where that is not all well. */
export function TileRow({ tile, room }: { tile: Tile; room: string }) {
  useFrame();
  const name = nameOfTile(tile, room);
  const offline = tile.device.state === "unreachable";
  const Controls = tileControls[tile.kind];
  return (
    <li class={`tile tile-${tile.kind}${offline ? " offline" : ""}`}>
      <a class="tile-name" href={hrefTo("devices", tile.device.path.split("/"))}>
        {name}
      </a>
      {mayBe("command") ? <Controls tile={tile} name={name} /> : <Shown tile={tile} />}
      {offline && <State word="unreachable" title={tile.device.reason} />}
      <Trouble tile={tile} />
    </li>
  );
}

/** The name of the device; of several tiles of a device, and where the device is called as its room, also what it is. */
function nameOfTile({ device, instance, points, kind }: Tile, room: string): string {
  const [point] = points.values();
  const given = point ? nameOfPoint(point) : "";
  if (point && given !== point.id) return given;
  const what = kind === "light" ? text.lamp : typeWords(kind === "other" ? (point?.type ?? "") : text.tileNames[kind]);
  const numbered = /^\d*$/.test(instance) ? what : `${what} ${instance.replaceAll("_", " ")}`;
  if (device.name === room) return numbered.charAt(0).toUpperCase() + numbered.slice(1);
  return instance === "" ? device.name : `${device.name} · ${numbered}`;
}

/** For whom may not command: what is reported. */
function Shown({ tile }: { tile: Tile }) {
  const [point] = tile.points.values();
  return (
    <span class="tile-controls">
      <Value point={point} />
    </span>
  );
}

/** The latest command that waits or did not end well. */
function Trouble({ tile }: { tile: Tile }) {
  const outcomes = [...tile.points.values()].map(outcomeAt).filter((outcome) => outcome !== null);
  const [last] = outcomes.sort((a, b) => b.since - a.since);
  if (!last || ["good", "neutral"].includes(toneOf(last.state))) return null;
  return (
    <p class="tile-trouble muted">
      <State word={last.state} tone={toneOf(last.state)} /> <Age time={last.since} /> {prose(last.reason)}
    </p>
  );
}

interface TileProps {
  tile: Tile;
  name: string;
}

const colours = ["colourXy", "colourHueSaturation", "colourRgb"];

/** Of a lamp that has its colour in several forms the one that it reports. */
function colourOf({ points }: Tile): Point | undefined {
  const all = colours.map((type) => points.get(type)).filter((point) => point !== undefined);
  return all.find((point) => point.value?.value) ?? all[0];
}

function Light({ tile, name }: TileProps) {
  const lamp = tile.points.get("lamp");
  const level = tile.points.get("dimmer");
  const colour = colourOf(tile);
  const white = tile.points.get("colourTemperatureMired") ?? tile.points.get("colourTemperature");
  const control = white && controlOf(white.description?.json ?? {});
  const whiteLight = white && control?.kind === "white" ? { point: white, control } : undefined;
  return (
    <>
      <span class="tile-controls">
        {colour && <ColourControl point={colour} label={name} white={whiteLight} />}
        {lamp && <CommandControl point={lamp} />}
      </span>
      {level && <Level point={level} label={text.levelOf(name)} />}
      {!colour && whiteLight && (
        <span class="tile-line control">
          <WhiteSlider {...whiteLight} label={text.whiteOf(name)} />
          <Value point={white} />
        </span>
      )}
    </>
  );
}

/** A slider with what is reported beside it. */
function Level({ point, label, say = percent }: { point: Point; label: string; say?(place: string): string }) {
  const control = controlOf(point.description?.json ?? {});
  if (control.kind !== "slider") return <CommandControl point={point} />;
  const { minimum, maximum, step } = control;
  const value = point.value?.value ?? "";
  return (
    <span class="tile-line control">
      <Slider point={point} label={label} minimum={minimum} maximum={maximum} step={step} value={value} />
      <span class="tile-value">{value === "" ? text.unknown : say(value)}</span>
    </span>
  );
}

function percent(value: string): string {
  return `${formatNumber(String(Math.round(Number(value))))} %`;
}

const moves = [
  { word: "up", sign: "▲", position: "0" },
  { word: "stop", sign: "■", position: null },
  { word: "down", sign: "▼", position: "100" },
] as const;

/** Up, stop and down; without a point that moves, by its position, and without stop. */
function Blind({ tile, name }: TileProps) {
  const move = tile.points.get("blindMove");
  const position = tile.points.get("blindPosition");
  return (
    <>
      <span class="tile-controls segments control" role="group" aria-label={name}>
        {moves.map(({ word, sign, position: end }) => {
          const target = move ?? (end === null ? undefined : position);
          if (!target) return null;
          return (
            <button
              key={word}
              type="button"
              aria-label={`${name}: ${text.blind[word]}`}
              title={text.blind[word]}
              onClick={() => sendCommand(target, move ? word : (end ?? ""))}
            >
              {sign}
            </button>
          );
        })}
      </span>
      {position && <Level point={position} label={text.positionOf(name)} say={text.closed} />}
    </>
  );
}

/** What was chosen by steps and is not sent yet: several steps are one command. */
const chosen = new Drafts();
const timers = new Map<string, number>();
const pause = 800;

function choose(point: Point, value: string): void {
  chosen.type(point.path, value);
  redraw();
  clearTimeout(timers.get(point.path));
  const send = () => sendCommand(point, value, () => chosen.done(point.path, value));
  timers.set(point.path, window.setTimeout(send, pause));
}

/** The step of a thermostat, and the range that people choose from where the device names none. */
const [degree, coldest, hottest] = [0.5, 5, 30];

function Thermostat({ tile, name }: TileProps) {
  const target = tile.points.get("temperatureSetpoint");
  if (!target) return null;
  const now = measuredBy(tile.device);
  const control = controlOf(target.description?.json ?? {}) as Control & { minimum?: number; maximum?: number };
  const narrow = control.kind === "slider" && (control.maximum ?? 0) - (control.minimum ?? 0) <= 60;
  const [low, high] = narrow ? [control.minimum ?? coldest, control.maximum ?? hottest] : [coldest, hottest];
  const value = chosen.of(target.path) ?? target.value?.value ?? "";
  const known = value !== "";
  const step = (by: number) => {
    const from = known ? Number(value) : 20;
    choose(target, String(Math.min(high, Math.max(low, Math.round((from + by) / degree) * degree))));
  };
  return (
    <span class="tile-controls control thermostat" role="group" aria-label={name}>
      {now?.value?.value && (
        <span class="tile-now">
          <Value point={now} />
        </span>
      )}
      <button type="button" aria-label={text.colder(name)} onClick={() => step(-degree)}>
        −
      </button>
      <output class={chosen.of(target.path) !== null ? "target chosen" : "target"}>
        {known ? `${formatNumber(Number(value).toFixed(1))} ${unitSign(target.unit)}` : text.unknown}
      </output>
      <button type="button" aria-label={text.warmer(name)} onClick={() => step(degree)}>
        +
      </button>
    </span>
  );
}

function Other({ tile }: TileProps) {
  return (
    <span class="tile-controls">
      {[...tile.points.values()].map((point) => (
        <CommandControl key={point.path} point={point} />
      ))}
    </span>
  );
}

const tileControls = { light: Light, blind: Blind, thermostat: Thermostat, other: Other };
