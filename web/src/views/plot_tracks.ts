import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { active, catalog, components, islands, islandsKnown, line, server, store, useFeeds, wokenSensors } from "../app";
import { boundsOf, type TimeRange } from "../core/plot_time";
import { type Plotted, PlottedPoints } from "../core/plotted";
import { frameNumber, second } from "../core/redraw";
import { askJson, RestError } from "../core/rest";
import { serverNow } from "../core/server_time";
import type { Tuple } from "../core/store";
import type { PastSeries } from "../core/track";

export type { Plotted };

export type Past = "none" | "loading" | "ready" | { code: string; text: string };

/** At most so many points a pixel column of a large screen. */
const buckets = 1000;
/** A key that is held zooms many times; the server answers five questions a second. */
const settling = 150;
const busyPause = 1000;
/** Milliseconds between two drawings: a plot of thousands of points takes some of them. */
const redrawPause = 200;

interface Tracks {
  plotted: Plotted[];
  /** Those that do not exist, neither now nor in the past that is shown. */
  unknown: Plotted[];
  past: Past;
  retry(): void;
}

/** The points with their past, kept up to date: history and subscription joined. */
export function useTracks(paths: string[], range: TimeRange): Tracks {
  const name = paths.join();
  const feeds = useFeeds(paths.map((path) => ({ pattern: `${path}.*`, min: 250 })));
  const sensors = paths.filter((path) => path.includes(".sensor."));
  useFeeds(active.value ? sensors.map((path) => ({ pattern: `${path}.value`, active: true, min: 250 })) : []);
  useEffect(() => {
    wokenSensors.value = active.value ? sensors.length : 0;
  }, [active.value, sensors.length]);
  // Of an owner that is gone there is no snapshot: its points have a past only.
  const owners = [...islands.value, ...components.value].map(({ id }) => id);
  const ready = islandsKnown.value && feeds.every((feed) => feed.complete(owners));
  if (!ready) void frameNumber.value; // drawn again in each frame until all is there
  const points = useMemo(() => new PlottedPoints(catalog, store, serverNow), []);
  const plotted = useMemo(() => points.of(paths), [name, ready]);
  points.describe();
  useLive(points, plotted, ready);
  const { past, retry } = usePast(points, plotted, range, ready);
  const answered = ready && server.value !== null && past === (server.value.history ? "ready" : "none");
  return { plotted, unknown: answered ? plotted.filter((one) => points.isUnknown(one)) : [], past, retry };
}

/** Tuples of the points as they change; ends of knowledge once a second. */
function useLive(points: PlottedPoints, plotted: Plotted[], ready: boolean): void {
  const [, setVersion] = useState(0);
  useEffect(() => {
    let timer = 0;
    const draw = () => {
      timer = 0;
      setVersion((version) => version + 1);
    };
    const byTuple = new Map<string, { one: Plotted; leaf: string }>();
    for (const one of plotted) for (const leaf of ["value", "status", "command"]) byTuple.set(`${one.path}.${leaf}`, { one, leaf });
    const take = (tuple: Tuple, delivered: boolean) => {
      const target = byTuple.get(tuple.id);
      if (!target) return;
      points.take(target.one, target.leaf, tuple, delivered);
      timer ||= window.setTimeout(draw, redrawPause);
    };
    const stop = store.listen({ added: (tuple) => take(tuple, false), changed: (tuple) => take(tuple, true) });
    const hidden = () => document.hidden && points.lose();
    document.addEventListener("visibilitychange", hidden);
    return () => {
      clearTimeout(timer);
      document.removeEventListener("visibilitychange", hidden);
      stop();
    };
  }, [plotted]);
  const tick = second.value;
  useEffect(() => {
    if (line.value === "lost") points.lose();
    else if (ready) points.endUnknown();
  }, [tick, plotted, ready]);
}

/** Asks the history when points or range change, and when live values were missed. */
function usePast(points: PlottedPoints, plotted: Plotted[], range: TimeRange, ready: boolean): { past: Past; retry(): void } {
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
      const { from, to } = boundsOf(range, serverNow());
      askJson<Answer>(historyPath(plotted, from, to), { signal: cancel.signal }).then(({ bucket, series }) => {
        if (mine !== asked.current) return;
        fill(plotted, series, Math.min(to, serverNow()), bucket);
        points.endUnknown();
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
        describe(one, past);
        one.track.fill(past, to, bucket);
      }
      if (past.key === `${one.path}.command`) one.track.fillTicks(past);
    }
  }
}

/** What the history knows of a point that does not describe itself, such as one that is gone. */
function describe(one: Plotted, past: PastSeries): void {
  if (one.words.length === 0) one.words = past.words ?? [];
  if (one.point?.description) return;
  one.track.kind = past.kind === "number" ? "number" : "state";
  one.unit = past.unit === "1" ? "" : (past.unit ?? "");
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
