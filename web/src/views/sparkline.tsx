import { useEffect, useState } from "preact/hooks";
import { line, server } from "../app";
import { type Device, list, type Point } from "../core/catalog";
import { addLive, numberIn, pairsOf, type Series, sinceTime } from "../core/hour";
import { askJson } from "../core/rest";
import { serverNow } from "../core/server_time";
import { slow } from "../core/track";

const seconds = 3600;
const width = 120;
const height = 24;
const most = 240;
/** Minutes of an hour, of which the first and the last are not whole. */
const buckets = 61;

/** The most series that the history takes in one question. */
const mostAsked = 32;

/** What is known of the last hour, by OWNER:KEY of values: [time, value] with NaN for gaps; live values are added. */
export type Hour = Map<string, [number, number][]>;

/** Asks the history once for all points of a device or of a list; without history, the hour starts now. */
export function useHourOf(whose: Device | string, points: Point[]): Hour {
  const [hour, setHour] = useState<Hour>(() => new Map());
  const known = server.value?.history ?? false;
  const keys = points.filter((point) => point.kind !== "property").map((point) => `${point.path}.value`);
  const name = keys.slice(0, mostAsked).join();
  useEffect(() => {
    setHour(new Map());
    if (!known || name === "") return undefined;
    const pointOf = (key: string) => points.find((point) => `${point.path}.value` === key);
    const cancel = new AbortController();
    const to = serverNow();
    const query = keys.slice(0, mostAsked).map((key) => `key=${encodeURIComponent(key)}`);
    const path = `/history?${query.join("&")}&from=${to - seconds}&to=${to}&buckets=${buckets}`;
    askJson<{ bucket: number; series: Series[] }>(path, { signal: cancel.signal }).then(
      (answer) =>
        setHour(
          new Map(
            answer.series.map((series) => [
              series.key,
              pairsOf(series, answer.bucket, (word) => numberIn(wordsOf(pointOf(series.key)), word)),
            ]),
          ),
        ),
      () => undefined, // the curve starts now
    );
    return () => cancel.abort();
  }, [whose, name, known]);
  return hour;
}

function wordsOf(point: Point | undefined): string[] {
  return list(point?.description?.json.words);
}

function withLive(point: Point, hour: Hour): [number, number][] {
  const key = `${point.path}.value`;
  let pairs = hour.get(key);
  if (!pairs) hour.set(key, (pairs = []));
  const good = line.value !== "lost" && point.value?.present && ["", "good", "assumed"].includes(point.quality);
  const value = good ? numberIn(wordsOf(point), point.value?.value ?? "") : Number.NaN;
  addLive(pairs, serverNow(), point.value?.time ?? 0, value, seconds / width);
  if (pairs.length > most) pairs.splice(0, pairs.length - most);
  return pairs;
}

/** The curve of the last hour; gaps stay gaps. The number beside it says the same in words. */
export function Sparkline({ point, hour }: { point: Point; hour: Hour }) {
  if (point.kind === "property") return null;
  const now = serverNow();
  const pairs = sinceTime(withLive(point, hour), now - seconds);
  const values = pairs.map(([, value]) => value).filter((value) => !Number.isNaN(value));
  if (values.length === 0) return null;
  const low = Math.min(...values);
  const span = Math.max(...values) - low;
  const x = (time: number) => (((time - now + seconds) / seconds) * width).toFixed(1);
  const y = (value: number) => (span === 0 ? height / 2 : height - 2 - ((value - low) / span) * (height - 4)).toFixed(1);
  const steps = point.description?.json.data_type !== "real";
  let path = "";
  let before = Number.NaN;
  let since = 0;
  for (const [time, value] of pairs) {
    const held = steps || time - since > slow;
    if (!Number.isNaN(value))
      path += Number.isNaN(before) ? `M${x(time)} ${y(value)}` : `${held ? `H${x(time)}` : ""}L${x(time)} ${y(value)}`;
    before = value;
    since = time;
  }
  if (!Number.isNaN(before)) path += `H${width}`;
  return (
    <svg class="spark" viewBox={`0 0 ${width} ${height}`} width={width} height={height} preserveAspectRatio="none" aria-hidden="true">
      <path d={path} />
    </svg>
  );
}
