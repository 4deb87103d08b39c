import { type Catalog, list, number, type Point, text } from "./catalog";
import type { Store, Tuple } from "./store";
import { Track } from "./track";

/** One of the points of the plot, by `OWNER:KEY` without `.value`. */
export interface Plotted {
  path: string;
  point?: Point;
  track: Track;
  /** Words in the order of their type; colours follow it. */
  words: string[];
  unit: string;
  /** When its value was known last; 0 = not since the plot was opened. */
  seen: number;
}

const goodQualities = new Set(["", "good", "assumed"]);

function kindOf(point: Point | undefined, value: string): "number" | "state" {
  const type = text(point?.description?.json.data_type);
  if (type === "real" || type === "integer") return "number";
  if (type !== "") return "state";
  return value === "" || Number.isNaN(Number(value)) ? "state" : "number";
}

/** The points of a plot. Each keeps its track as long as it is plotted, whatever becomes of subscriptions and other points. */
export class PlottedPoints {
  #kept = new Map<string, Plotted>();

  constructor(
    private readonly catalog: Catalog,
    private readonly store: Store,
    private readonly now: () => number,
  ) {}

  of(paths: string[]): Plotted[] {
    const plotted = paths.map((path) => this.#kept.get(path) ?? { path, track: new Track("state"), words: [], unit: "", seen: 0 });
    this.#kept = new Map(plotted.map((one) => [one.path, one]));
    this.describe();
    return plotted;
  }

  /** Takes what descriptions say by now: they may come after values. */
  describe(): void {
    for (const one of this.#kept.values()) this.#describeOne(one);
  }

  #describeOne(one: Plotted): void {
    const { path, track } = one;
    const point = this.#pointAt(path);
    const known = point?.description !== undefined;
    const value = this.store.get(`${path}.value`)?.value ?? "";
    if (known || (track.empty && value !== "")) track.kind = kindOf(point, value);
    one.point = point ?? one.point;
    if (known) one.unit = point.unit;
    const words = list(point?.description?.json.words);
    if (words.length > 0) one.words = words;
  }

  #pointAt(path: string): Point | undefined {
    const [owner = "", key = ""] = path.split(":", 2);
    const [, network = "", device = "", kind = "", id = ""] = key.split(".");
    return this.catalog.device(Number(owner), network, device)?.points.get(`${kind}.${id}`);
  }

  /** Takes the value, status or command of a point. `delivered`: by the server just now. */
  take({ path, track }: Plotted, leaf: string, tuple: Tuple, delivered: boolean): void {
    const value = leaf === "value" ? tuple : this.store.get(`${path}.value`);
    const status = this.store.get(`${path}.status`)?.json ?? {};
    const since = number(status.since);
    if (leaf === "command") {
      if (tuple.sequence > 0) track.command(tuple.time, tuple.value ?? "");
    } else if (!goodQualities.has(text(status.quality))) {
      if (value?.value) track.add(value.time, value.value); // what it was before
      track.lose(since || this.now());
    } else if (value?.value) {
      if (delivered && leaf === "value") track.resume(Math.max(since, value.time));
      const afterGap = track.at(this.now())?.gap ?? false;
      track.add(afterGap && leaf === "status" ? Math.max(since, value.time) : value.time, value.value);
    }
  }

  /** Neither an island nor what was read of the history knows it. */
  isUnknown({ path, point, track }: Plotted): boolean {
    return !point && track.empty && !this.store.get(`${path}.value`);
  }

  /** What is not known at present ends where it was known last. */
  endUnknown(): void {
    for (const one of this.#kept.values()) {
      if (this.#isKnown(one.path)) one.seen = this.now();
      else one.track.lose(one.seen);
    }
  }

  #isKnown(path: string): boolean {
    const value = this.store.get(`${path}.value`);
    const quality = text(this.store.get(`${path}.status`)?.json.quality);
    return value?.present === true && value.value !== "" && goodQualities.has(quality);
  }

  /** From now on, the page hears nothing of them. */
  lose(): void {
    for (const { track } of this.#kept.values()) track.lose(this.now());
  }
}
