import { typeWords } from "./format";
import { readKey, type KeyMeaning, type Leaf, type PointKind } from "./keys";
import type { Store, Tuple } from "./store";
import { compareNatural } from "./text";

/** A sensor, actuator or property of a device. */
export class Point {
  value?: Tuple;
  status?: Tuple;
  description?: Tuple;
  command?: Tuple;

  constructor(
    readonly device: Device,
    readonly kind: PointKind,
    readonly id: string,
  ) {}

  /** OWNER:KEY without the last part. */
  get path(): string {
    const { owner, prefix, network, id } = this.device;
    return `${owner}:${prefix}.${network}.${id}.${this.kind}.${this.id}`;
  }

  get type(): string {
    return text(this.description?.json.type) || this.id.replace(/-[^-]*$/, "");
  }

  get unit(): string {
    const unit = text(this.description?.json.unit);
    return unit === "1" ? "" : unit;
  }

  get quality(): string {
    return text(this.status?.json.quality);
  }

  get empty(): boolean {
    return !this.value && !this.status && !this.description && !this.command;
  }
}

export class Device {
  status?: Tuple;
  description?: Tuple;
  readonly points = new Map<string, Point>();
  /** How many its description lists; null: it has not come. */
  described: number | null = null;
  #sorted: Point[] | null = null;
  #main: Point | undefined;

  constructor(
    readonly owner: number,
    readonly prefix: string,
    readonly network: string,
    readonly id: string,
  ) {}

  /** Names the device within the page: 6541/wsn-1/7. */
  get path(): string {
    return `${this.owner}/${this.network}/${this.id}`;
  }

  get name(): string {
    return text(this.description?.json.name) || this.id;
  }

  get area(): string {
    return text(this.description?.json.area);
  }

  /** Model, else type, else what it can do. */
  get model(): string {
    const about = this.description?.json;
    return text(about?.model) || text(about?.type) || this.capabilities.slice(0, 3).map(typeWords).join(", ");
  }

  /** The type of what stands for it in a list, as far as its description says. */
  get mainType(): string | undefined {
    const [first] = [...this.capabilities].sort((a, b) => rankOfType(a) - rankOfType(b));
    return first ?? this.first?.type;
  }

  /** The types of its points, as its description says. */
  get capabilities(): string[] {
    return list(this.description?.json.capabilities);
  }

  /** Whether a point has this type, as the description or the point says. */
  offers(type: string): boolean {
    return this.capabilities.includes(type) || this.ordered.some((point) => point.type === type);
  }

  get state(): string {
    return text(this.status?.json.status) || "unknown";
  }

  get since(): number {
    return number(this.status?.json.since);
  }

  get reason(): string {
    return text(this.status?.json.reason);
  }

  /** Sensors, actuators, properties, each in natural order. */
  get ordered(): Point[] {
    this.#sorted ??= [...this.points.values()].sort(
      (a, b) => kindOrder.indexOf(a.kind) - kindOrder.indexOf(b.kind) || compareNatural(a.id, b.id),
    );
    return this.#sorted;
  }

  /** What stands for the device in a list: what people look for first; battery and the like only if there is no other. */
  get first(): Point | undefined {
    this.#main ??= [...this.ordered].sort((a, b) => rankOf(a) - rankOf(b))[0];
    return this.#main;
  }

  /** The latest time at which one of its points was heard. */
  get heard(): number {
    let latest = 0;
    for (const point of this.points.values()) {
      latest = Math.max(latest, number(point.status?.json.heard) || (point.value?.value ? point.value.time : 0));
    }
    return latest;
  }

  /** The points changed. */
  touch(): void {
    this.#sorted = null;
    this.#main = undefined;
  }
}

/** Types that people look for first, in this order. */
const sought = [
  "lamp",
  "relay",
  "switch",
  "lock",
  "blindPosition",
  "contact",
  "motion",
  "occupancy",
  "presence",
  "temperature",
  "power",
  "light",
  "humidity",
];
/** Types of points that devices have beside what they are for. */
const aside = new Set(["battery", "batteryLow", "deviceTemperature", "linkQuality", "voltage", "rssi", "lastSeen", "uptime"]);

function rankOf(point: Point): number {
  return point.kind === "property" ? 1000 : rankOfType(point.type);
}

function rankOfType(type: string): number {
  if (aside.has(type)) return 900;
  const place = sought.indexOf(type);
  return place < 0 ? 800 : place;
}

const kindOrder: PointKind[] = ["sensor", "actuator", "property"];

export class Network {
  status?: Tuple;
  readonly counters = new Map<string, Tuple>();
  devices = 0;

  constructor(
    readonly owner: number,
    readonly prefix: string,
    readonly id: string,
  ) {}

  get path(): string {
    return `${this.owner}/${this.id}`;
  }

  get line(): string {
    return text(this.status?.json.line) || "unknown";
  }

  get empty(): boolean {
    return !this.status && this.counters.size === 0 && this.devices === 0;
  }
}

/** The one with this path, else the first whose line is up, else the first. */
export function networkToShow(networks: Network[], path: string | undefined): Network | undefined {
  return networks.find((one) => one.path === path) ?? networks.find(({ line }) => line === "up") ?? networks[0];
}

const islandKey = ".island";

/** An island publishes its own id and name at PREFIX.island. */
function namesIsland(tuple: Tuple): boolean {
  if (!tuple.key.endsWith(islandKey) || tuple.key.indexOf(".") !== tuple.key.length - islandKey.length) return false;
  return tuple.json.id === tuple.owner && typeof tuple.json.name === "string";
}

/** Of an island, as far as it is described. */
export interface Described {
  devices: number;
  points: number;
}

/** Devices and networks of all islands, put together from the tuples of the store as they come and go. */
export class Catalog {
  readonly devices = new Map<string, Device>();
  readonly networks = new Map<string, Network>();
  /** Waiting devices of the inbox, by OWNER:KEY. */
  readonly waiting = new Map<string, Tuple>();
  /** What each inbox says of itself, by OWNER:KEY. */
  readonly inboxes = new Map<string, Tuple>();
  /** What of each island needs a person, by OWNER:KEY. */
  readonly alerts = new Map<string, Tuple>();
  /** What people arranged on the overview of each island, by owner. */
  readonly overviews = new Map<number, Tuple>();
  /** What each history says of itself, by OWNER:KEY; any component may publish such a tuple. */
  readonly histories = new Map<string, Tuple>();
  /** Grows when devices or networks come, go, or describe themselves anew. */
  structure = 0;
  /** Grows when points come, go, or describe themselves anew. */
  points = 0;
  /** Grows when waiting devices come or go. */
  arrivals = 0;
  /** By owner. */
  readonly described = new Map<number, Described>();

  /** The prefixes of the islands, by owner. Other components, and other keys of an island, are none of its devices. */
  readonly #prefixes = new Map<number, string>();

  constructor(private readonly store: Store) {
    store.listen({
      added: (tuple) => this.#put(tuple, tuple),
      changed: (tuple) => this.#changed(tuple),
      removed: (tuple) => this.#removed(tuple),
    });
  }

  device(owner: number, network: string, id: string): Device | undefined {
    return this.devices.get(`${owner}/${network}/${id}`);
  }

  #changed(tuple: Tuple): void {
    if (namesIsland(tuple)) this.#learnPrefix(tuple.owner, tuple.key.slice(0, -islandKey.length));
    if (!tuple.key.endsWith(".description") || !this.#isOfIsland(tuple)) return;
    const key = readKey(tuple.key);
    if (key.what === "device") {
      this.structure++;
      this.#describe(this.device(tuple.owner, key.network, key.device));
    } else this.points++;
  }

  #describe(device: Device | undefined): void {
    if (!device) return;
    const sum = this.described.get(device.owner) ?? { devices: 0, points: 0 };
    const now = device.description ? pointsIn(device.description.json) : null;
    sum.points += (now ?? 0) - (device.described ?? 0);
    sum.devices += Number(now !== null) - Number(device.described !== null);
    device.described = now;
    this.described.set(device.owner, sum);
  }

  #removed(tuple: Tuple): void {
    this.#put(tuple, undefined);
    const prefix = this.#prefixes.get(tuple.owner);
    if (prefix === undefined || tuple.key !== prefix + islandKey) return;
    this.#putAllOf(tuple.owner, (other) => this.#put(other, undefined));
    this.#prefixes.delete(tuple.owner);
  }

  #isOfIsland(tuple: Tuple): boolean {
    const prefix = this.#prefixes.get(tuple.owner);
    return prefix !== undefined && tuple.key.startsWith(`${prefix}.`);
  }

  /** Takes what came before it. */
  #learnPrefix(owner: number, prefix: string): void {
    if (this.#prefixes.has(owner)) return;
    this.#prefixes.set(owner, prefix);
    this.#putAllOf(owner, (tuple) => this.#put(tuple, tuple));
  }

  #putAllOf(owner: number, put: (tuple: Tuple) => void): void {
    for (const tuple of this.store.tuples.values()) if (tuple.owner === owner) put(tuple);
  }

  #put(tuple: Tuple, now: Tuple | undefined): void {
    if (tuple.key.endsWith(".history.status")) setOrDelete(this.histories, tuple.id, now);
    if (!this.#isOfIsland(tuple)) return;
    const key = readKey(tuple.key);
    switch (key.what) {
      case "point":
        this.#putPoint(tuple.owner, key, now);
        break;
      case "device":
        this.#putDevice(tuple.owner, key, now);
        break;
      case "network":
        if (key.leaf === "status") this.#putNetwork(tuple.owner, key, (network) => (network.status = now));
        break;
      case "counter":
        if (key.leaf === "value") this.#putNetwork(tuple.owner, key, (network) => setOrDelete(network.counters, key.name, now));
        break;
      case "waiting":
        setOrDelete(this.waiting, tuple.id, now);
        this.arrivals++;
        break;
      case "inbox":
        setOrDelete(this.inboxes, tuple.id, now);
        break;
      case "alerts":
        setOrDelete(this.alerts, tuple.id, now);
        break;
      case "overview":
        if (now) this.overviews.set(tuple.owner, now);
        else this.overviews.delete(tuple.owner);
        break;
      case "other":
        break;
    }
  }

  #putPoint(owner: number, key: KeyMeaning & { what: "point" }, now: Tuple | undefined): void {
    this.#withDevice(owner, key, (device) => {
      const name = `${key.kind}.${key.point}`;
      const known = device.points.get(name);
      const point = known ?? new Point(device, key.kind, key.point);
      setLeaf(point, key.leaf, now);
      if (point.empty) device.points.delete(name);
      else if (!known) device.points.set(name, point);
      if (!point.empty && known) return;
      device.touch();
      this.points++;
    });
  }

  #putDevice(owner: number, key: KeyMeaning & { what: "device" }, now: Tuple | undefined): void {
    this.#withDevice(owner, key, (device) => {
      if (key.leaf === "status") device.status = now;
      else device.description = now;
      if (key.leaf !== "status") this.#describe(device);
    });
  }

  #withDevice(owner: number, key: { prefix: string; network: string; device: string }, change: (device: Device) => void): void {
    const path = `${owner}/${key.network}/${key.device}`;
    const known = this.devices.get(path);
    const device = known ?? new Device(owner, key.prefix, key.network, key.device);
    change(device);
    const empty = !device.status && !device.description && device.points.size === 0;
    if (empty === !known) return;
    this.structure++;
    setOrDelete(this.devices, path, empty ? undefined : device);
    this.#putNetwork(owner, key, (network) => (network.devices += empty ? -1 : 1));
  }

  #putNetwork(owner: number, key: { prefix: string; network: string }, change: (network: Network) => void): void {
    const path = `${owner}/${key.network}`;
    const known = this.networks.get(path);
    const network = known ?? new Network(owner, key.prefix, key.network);
    change(network);
    if (network.empty === !known) return;
    this.structure++;
    setOrDelete(this.networks, path, network.empty ? undefined : network);
  }
}

function pointsIn(description: Record<string, unknown>): number {
  return list(description.sensors).length + list(description.actuators).length + list(description.properties).length;
}

function setLeaf(point: Point, leaf: Leaf, now: Tuple | undefined): void {
  point[leaf] = now;
}

function setOrDelete<V>(map: Map<string, V>, key: string, value: V | undefined): void {
  if (value === undefined) map.delete(key);
  else map.set(key, value);
}

/** Members of JSON that came from outside: anything but the expected type counts as missing. */
export function text(value: unknown): string {
  return typeof value === "string" ? value : "";
}

export function number(value: unknown): number {
  return typeof value === "number" && Number.isFinite(value) ? value : 0;
}

export function list(value: unknown): string[] {
  return Array.isArray(value) ? value.filter((item): item is string => typeof item === "string") : [];
}
