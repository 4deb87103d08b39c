// What people arranged on the overview of an island: its tuple PREFIX.overview (docs/tuple-keys.md).
import { list, type Point, text } from "./catalog";
import type { Tuple } from "./store";

export interface Arranged {
  /** Rooms in the order in which they are shown. */
  rooms: string[];
  /** Points whose curve is on the overview, as `network.device.sensor.point`. */
  pins: string[];
}

export function arrangedIn(tuple: Tuple | undefined): Arranged {
  return { rooms: list(tuple?.json.rooms), pins: list(tuple?.json.pins) };
}

/** The name of a point in the tuple: its key without the prefix of the island. */
export function pinOf({ device, kind, id }: Point): string {
  return `${device.network}.${device.id}.${kind}.${id}`;
}

/** What people call a point; empty if they gave it no name. */
export function givenName(tuple: Tuple | undefined, point: Point): string {
  const names = tuple?.json.names;
  return typeof names === "object" && names !== null ? text((names as Record<string, unknown>)[pinOf(point)]) : "";
}

/** The list with one of its members moved by `step` places; the same list where there is no such place. */
export function moved(names: string[], name: string, step: number): string[] {
  const from = names.indexOf(name);
  const to = from + step;
  if (from < 0 || to < 0 || to >= names.length) return names;
  const next = names.filter((other) => other !== name);
  next.splice(to, 0, name);
  return next;
}

/** The list with the name, or without it if it has it. */
export function toggled(names: string[], name: string): string[] {
  return names.includes(name) ? names.filter((other) => other !== name) : [...names, name];
}
