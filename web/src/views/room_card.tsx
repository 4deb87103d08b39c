import type { ComponentChildren } from "preact";
import { measured, nameOfPoint } from "../app";
import { tellFact } from "../core/facts";
import { useFrame } from "../core/redraw";
import { type Fact, mostDevices, type Room } from "../core/rooms";
import { hrefTo } from "../core/router";
import { isAsleep, Measure } from "../parts/measure";
import * as text from "../words/overview";
import * as words from "../words/frame";
import { TileRow } from "./tile";

/** What a card has room for; the rest is on the page of the room. */
const mostFacts = 6;
const mostTiles = 5;

export function hrefToRoom({ id, name, placed, devices }: Room): string {
  return !placed && devices.length > mostDevices ? hrefTo("devices", [], { network: name }) : hrefTo("overview", [id]);
}

/** A room with its main values and controls. */
export function RoomCard({ room, children }: { room: Room; children?: ComponentChildren }) {
  useFrame();
  const { facts, tiles } = room;
  const away = room.devices.filter(({ state }) => state === "unreachable").length;
  const more = tiles.length - mostTiles;
  return (
    <section class="card room" aria-label={room.name}>
      <header>
        <h3>
          <a href={hrefToRoom(room)}>{room.name}</a>
        </h3>
        <span class="muted">{away > 0 ? text.away(away, room.devices.length) : text.devicesOf(room.devices.length)}</span>
        {children}
      </header>
      {facts.length > 0 && <Facts room={room} facts={facts.slice(0, mostFacts)} />}
      {tiles.length > 0 && (
        <ul class="tiles">
          {tiles.slice(0, mostTiles).map((tile) => (
            <TileRow key={`${tile.device.path} ${tile.kind} ${tile.instance}`} tile={tile} room={room.name} />
          ))}
        </ul>
      )}
      {more > 0 && (
        <a class="room-more" href={hrefToRoom(room)}>
          {text.moreControls(more)}
        </a>
      )}
    </section>
  );
}

/** The values, then in one line what nobody measures. */
export function Facts({ room, facts }: { room: Room; facts: Fact[] }) {
  const asleep = facts.filter(({ points }) => points.every((point) => isAsleep(point) && !point.value?.value));
  const known = facts.filter((fact) => !asleep.includes(fact));
  const points = asleep.flatMap((fact) => fact.points);
  const asked = points.some(({ path }) => measured.value.has(path));
  return (
    <>
      {known.length > 0 && (
        <dl class="room-facts">
          {known.map((fact) => (
            <FactOf key={fact.points[0]?.path} fact={fact} />
          ))}
        </dl>
      )}
      {asleep.length > 0 && (
        <p class="asleep">
          {asked ? words.measuring : text.notMeasured(asleep.map(({ type }) => text.factName(type)))}
          <Measure points={points} label={room.name} />
        </p>
      )}
    </>
  );
}

/** One value with what it is. */
function FactOf({ fact }: { fact: Fact }) {
  const { value, unit, quality } = tellFact(fact, text.some);
  const [point] = fact.points;
  if (!point) return null;
  const given = nameOfPoint(point);
  const what = fact.points.length === 1 && given !== point.id ? given : text.factName(fact.type);
  return (
    <div class="fact">
      <dt>{what}</dt>
      <dd class={`quality-${quality || "unknown"}`}>
        {value ? (
          <>
            {value}
            {unit && <span class="unit"> {unit}</span>}
            {!["good", "assumed"].includes(quality) && <small>{quality}</small>}
          </>
        ) : (
          <small>{text.unknown}</small>
        )}
      </dd>
    </div>
  );
}
