import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { active, catalog, line, server, store, useFeeds, wokenSensors } from "../app";
import { list, number, type Point, text } from "../core/catalog";
import { boundsOf, type TimeRange } from "../core/plot_time";
import { frameNumber, second } from "../core/redraw";
import { askJson, RestError } from "../core/rest";
import type { Tuple } from "../core/store";
import { type PastSeries, Track } from "../core/track";

/** One of the points of the plot, by `OWNER:KEY` without `.value`. */
export interface Plotted {
  path: string;
  point?: Point;
  track: Track;
  /** Words in the order of their type; colours follow it. */
  words: string[];
}

export type Past = "none" | "loading" | "ready" | { code: string; text: string };

/** At most so many points a pixel column of a large screen. */
const buckets = 1000;
/** A key that is held zooms many times; the server answers five questions a second. */
const settling = 120;
const busyPause = 1000;
/** Milliseconds between two drawings: a plot of thousands of points takes some of them. */
const redrawPause = 200;
const goodQualities = new Set(["", "good", "assumed"]);

function pointAt(path: string): Point | undefined {
  const [owner = "", key = ""] = path.split(":", 2);
  const [, network = "", device = "", kind = "", id = ""] = key.split(".");
  return catalog.device(Number(owner), network, device)?.points.get(`${kind}.${id}`);
}

function kindOf(point: Point | undefined, value: string): "number" | "state" {
  const type = text(point?.description?.json.data_type);
  if (type === "real" || type === "integer") return "number";
  if (type !== "") return "state";
  return value === "" || Number.isNaN(Number(value)) ? "state" : "number";
}

function now(): number {
  return Date.now() / 1000;
}

/** The points with their past, kept up to date: history and subscription joined. */
export function useTracks(paths: string[], range: TimeRange): { plotted: Plotted[]; past: Past; retry(): void } {
  const name = paths.join();
  const feeds = useFeeds(paths.map((path) => ({ pattern: `${path}.*`, min: 250 })));
  const sensors = paths.filter((path) => path.includes(".sensor."));
  useFeeds(active.value ? sensors.map((path) => ({ pattern: `${path}.value`, active: true, min: 250 })) : []);
  useEffect(() => {
    wokenSensors.value = active.value ? sensors.length : 0;
  }, [active.value, sensors.length]);
  const ready = feeds.every(({ state }) => state === "ready" || state === "failed");
  if (!ready) void frameNumber.value; // drawn again in each frame until all is there
  const plotted = useMemo(() => paths.map(begin), [name, ready]);
  useLive(plotted);
  const { past, retry } = usePast(plotted, range, ready);
  return { plotted, past, retry };
}

function begin(path: string): Plotted {
  const point = pointAt(path);
  const value = store.get(`${path}.value`);
  return { path, point, track: new Track(kindOf(point, value?.value ?? "")), words: list(point?.description?.json.words) };
}

/** Tuples of the points as they change; ends of knowledge once a second. */
function useLive(plotted: Plotted[]): void {
  const [, setVersion] = useState(0);
  useEffect(() => {
    let timer = 0;
    const draw = () => {
      timer = 0;
      setVersion((version) => version + 1);
    };
    const byTuple = new Map<string, { one: Plotted; leaf: string }>();
    for (const one of plotted) for (const leaf of ["value", "status", "command"]) byTuple.set(`${one.path}.${leaf}`, { one, leaf });
    const changed = (tuple: Tuple) => {
      const target = byTuple.get(tuple.id);
      if (!target) return;
      take(target.one, target.leaf, tuple);
      timer ||= window.setTimeout(draw, redrawPause);
    };
    const stop = store.listen({ added: changed, changed });
    return () => {
      clearTimeout(timer);
      stop();
    };
  }, [plotted]);
  const tick = second.value;
  useEffect(() => {
    for (const { path, track } of plotted) {
      const value = store.get(`${path}.value`);
      if (line.value === "lost" || (value && !value.present)) track.lose(now());
    }
  }, [tick, plotted]);
}

function take({ path, track }: Plotted, leaf: string, tuple: Tuple): void {
  const value = leaf === "value" ? tuple : store.get(`${path}.value`);
  const status = store.get(`${path}.status`)?.json ?? {};
  const good = goodQualities.has(text(status.quality));
  if (leaf === "command") {
    if (tuple.sequence > 0) track.command(tuple.time, tuple.value ?? "");
  } else if (!good) {
    if (value?.value) track.add(value.time, value.value); // what it was before
    track.lose(number(status.since) || now());
  } else if (value?.value) {
    const afterGap = track.at(now())?.gap ?? false;
    track.add(afterGap && leaf === "status" ? Math.max(number(status.since), value.time) : value.time, value.value);
  }
}

/** Asks the history when points or range change, and when live values were missed. */
function usePast(plotted: Plotted[], range: TimeRange, ready: boolean): { past: Past; retry(): void } {
  const known = server.value?.history ?? false;
  const [past, setPast] = useState<Past>("none");
  const [turn, setTurn] = useState(0);
  const missed = useMissed();
  const asked = useRef(0);
  useEffect(() => {
    if (!known || !ready || plotted.length === 0) {
      setPast("none");
      return undefined;
    }
    const cancel = new AbortController();
    const mine = ++asked.current;
    setPast("loading");
    const failed = (error: unknown) => {
      if (mine !== asked.current || cancel.signal.aborted) return;
      if (error instanceof RestError && error.code === "busy") timer = window.setTimeout(ask, busyPause);
      else setPast(error instanceof RestError ? { code: error.code, text: error.message } : { code: "failed", text: String(error) });
    };
    const ask = () => {
      const { from, to } = boundsOf(range, now());
      askJson<Answer>(historyPath(plotted, from, to), { signal: cancel.signal }).then(({ bucket, series }) => {
        if (mine !== asked.current) return;
        fill(plotted, series, Math.min(to, now()), bucket);
        setPast("ready");
      }, failed);
    };
    let timer = window.setTimeout(ask, settling);
    return () => {
      clearTimeout(timer);
      cancel.abort();
    };
  }, [plotted, ready, known, JSON.stringify(range), turn, missed]);
  return { past, retry: () => setTurn(turn + 1) };
}

interface Answer {
  bucket: number;
  series: PastSeries[];
}

function historyPath(plotted: Plotted[], from: number, to: number): string {
  const keys = plotted.flatMap(({ path, point }) => [`${path}.value`, ...(point && point.kind !== "sensor" ? [`${path}.command`] : [])]);
  const query = keys.map((key) => `key=${encodeURIComponent(key)}`);
  return `/history?${query.join("&")}&from=${from}&to=${to}&buckets=${buckets}`;
}

function fill(plotted: Plotted[], series: PastSeries[], to: number, bucket: number): void {
  for (const one of plotted) {
    for (const past of series) {
      if (past.key === `${one.path}.value`) {
        one.track.fill(past, to, bucket);
        if (one.words.length === 0) one.words = past.words ?? [];
      }
      if (past.key === `${one.path}.command`) one.track.fillTicks(past);
    }
  }
}

/** Grows when values were missed: the line was lost, or the page was hidden. */
function useMissed(): number {
  const [missed, setMissed] = useState(0);
  const before = useRef(line.value);
  useEffect(() => {
    if (line.value === "live" && before.current === "lost") setMissed((count) => count + 1);
    before.current = line.value;
  }, [line.value]);
  useEffect(() => {
    const shown = () => !document.hidden && setMissed((count) => count + 1);
    document.addEventListener("visibilitychange", shown);
    return () => document.removeEventListener("visibilitychange", shown);
  }, []);
  return missed;
}
