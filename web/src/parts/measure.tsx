import { mayBe, measured } from "../app";
import { number, type Point, text as textOf } from "../core/catalog";
import { Value } from "./value";
import * as words from "../words/frame";

/** A sensor that is there and has not been heard: some measure only while somebody asks. */
export function isAsleep(point: Point): boolean {
  const { kind, quality, device, status } = point;
  if (kind !== "sensor" || device.state !== "reachable") return false;
  return quality === "unknown" && number(status?.json.heard) === 0;
}

export function measure(points: Point[]): void {
  measured.value = new Set([...measured.value, ...points.map(({ path }) => path)]);
}

export function Measure({ points, label }: { points: Point[]; label: string }) {
  if (!mayBe("view") || points.every(({ path }) => measured.value.has(path))) return null;
  return (
    <button type="button" class="small" aria-label={words.measureOf(label)} title={words.activeTitle} onClick={() => measure(points)}>
      {words.measure}
    </button>
  );
}

function isMote({ device }: Point): boolean {
  return textOf(device.description?.json.type) === "mote";
}

/** The value, or what gets one. */
export function MeasuredValue({ point, label }: { point: Point; label: string }) {
  return isAsleep(point) && !point.value?.value ? <Measure points={[point]} label={label} /> : <Value point={point} />;
}

/** Why a sensor has no value. */
export function whyAsleep(point: Point): string {
  return measured.value.has(point.path) ? words.measuring : words.notMeasured(isMote(point));
}
