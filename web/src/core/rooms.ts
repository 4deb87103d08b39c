// The rooms of a building, and what is worth showing of each.
import { type Device, list, type Point, text } from "./catalog";
import { compareNatural } from "./text";

/** Devices of one area, or those of a network to which nobody gave a room. */
export interface Room {
  /** In addresses: the name of the area, or `network OWNER/NETWORK`. */
  id: string;
  name: string;
  placed: boolean;
  devices: Device[];
  /** What it tells and what is operated in it, of as many devices as one overlooks. */
  facts: Fact[];
  tiles: Tile[];
}

/** With more devices, a network without rooms is a list, no room. */
export const mostDevices = 200;

const unplaced = "network ";

/** All rooms: those of `order` first, then by name; then the networks whose devices have none. */
export function roomsOf(devices: Iterable<Device>, order: string[]): Room[] {
  const rooms = new Map<string, Room>();
  for (const device of devices) {
    const area = device.area;
    const id = area || `${unplaced}${device.owner}/${device.network}`;
    const room = rooms.get(id) ?? { id, name: area || device.network, placed: area !== "", devices: [], facts: [], tiles: [] };
    room.devices.push(device);
    rooms.set(id, room);
  }
  const place = ({ id }: Room) => (order.includes(id) ? order.indexOf(id) : order.length);
  const sorted = [...rooms.values()].sort(
    (a, b) => Number(b.placed) - Number(a.placed) || place(a) - place(b) || compareNatural(a.name, b.name) || compareNatural(a.id, b.id),
  );
  for (const room of sorted) {
    room.devices.sort((a, b) => compareNatural(a.name, b.name));
    if (room.devices.length > mostDevices) continue;
    room.tiles = tilesOf(room.devices);
    room.facts = factsOf(room.devices, room.tiles.length > 0);
  }
  return sorted;
}

/** One thing that a room tells, from all points that measure it. */
export interface Fact {
  type: string;
  points: Point[];
}

/** What people want to know of a room, in this order. Types of one line are one fact. */
const told = [
  ["temperature"],
  ["humidity"],
  ["co2"],
  ["light"],
  ["motion", "occupancy", "presence"],
  ["contact"],
  ["smoke", "gas", "carbonMonoxideAlarm", "waterLeak"],
  ["power"],
];

/** Of a room that measures nothing of that, the first point of some devices. */
const mostOthers = 4;

function factsOf(devices: Device[], operated: boolean): Fact[] {
  const facts = told.map((types): Fact => ({ type: types[0] ?? "", points: [] }));
  for (const device of devices) {
    for (const point of device.ordered) {
      const at = point.kind === "sensor" ? told.findIndex((types) => types.includes(point.type)) : -1;
      if (at >= 0) facts[at]?.points.push(point);
    }
  }
  const found = facts.filter(({ points }) => points.length > 0);
  if (found.length > 0 || operated) return found;
  const first = devices.map((device) => device.first).filter((point) => point?.kind === "sensor");
  return first.slice(0, mostOthers).map((point) => ({ type: point?.type ?? "", points: point ? [point] : [] }));
}

export type TileKind = "light" | "blind" | "thermostat" | "other";

/** What is operated together: a lamp with its level and colour, a blind, a thermostat. */
export interface Tile {
  kind: TileKind;
  device: Device;
  /** What tells several of a device apart; empty for the only one. */
  instance: string;
  /** By type. */
  points: Map<string, Point>;
}

const families: Record<string, TileKind> = {
  lamp: "light",
  dimmer: "light",
  colourTemperature: "light",
  colourTemperatureMired: "light",
  colourXy: "light",
  colourHueSaturation: "light",
  colourRgb: "light",
  blindPosition: "blind",
  blindTilt: "blind",
  blindMove: "blind",
  temperatureSetpoint: "thermostat",
};
/** Operated on its own; what is not here is on the page of the device. */
const plain = new Set(
  (
    "switch relay lock doorOpener garageDoor window valve valveSwitch heating cooling boiler pump fan fanSpeed fanStage damper " +
    "ventilation hvacMode scene namedScene siren charger vacuum volume playback"
  ).split(" "),
);
const order: TileKind[] = ["light", "blind", "thermostat", "other"];

function writable(point: Point): boolean {
  return point.kind === "actuator" && text(point.description?.json.access).includes("write");
}

/** What is after the first `-`: `ceiling` of `lamp-ceiling`. */
function instanceOf(point: Point): string {
  return point.id.slice(point.id.indexOf("-") + 1);
}

export function tilesOfDevice(device: Device): Tile[] {
  const tiles = new Map<string, Tile>();
  for (const point of device.ordered) {
    if (!writable(point)) continue;
    const kind = families[point.type] ?? (plain.has(point.type) ? "other" : undefined);
    if (!kind) continue;
    const instance = instanceOf(point);
    const name = kind === "other" ? point.id : `${kind} ${instance}`;
    const tile = tiles.get(name) ?? { kind, device, instance, points: new Map() };
    tile.points.set(point.type, point);
    tiles.set(name, tile);
  }
  const all = [...tiles.values()].sort((a, b) => order.indexOf(a.kind) - order.indexOf(b.kind));
  if (all.length === 1 && all[0]) all[0].instance = "";
  return all;
}

function tilesOf(devices: Device[]): Tile[] {
  return devices.flatMap(tilesOfDevice).sort((a, b) => order.indexOf(a.kind) - order.indexOf(b.kind));
}

/** The one that measures what a thermostat regulates. */
export function measuredBy(device: Device): Point | undefined {
  return device.ordered.find((point) => point.kind === "sensor" && point.type === "temperature");
}

/** The word of a boolean that says that there is something: `open`, `occupied`, `on`. */
export function activeWord(point: Point): string {
  return list(point.description?.json.words)[1] ?? "on";
}

/** The rooms that devices have. */
export function roomNames(devices: Iterable<Device>): string[] {
  const areas = new Set<string>();
  for (const { area } of devices) if (area) areas.add(area);
  return [...areas].sort(compareNatural);
}
