import { type Point, text } from "../core/catalog";
import { colourTypes, hexOf, readColour, reciprocal } from "../core/colour";
import { formatValue, unitSign } from "../core/format";
import * as words from "../words/frame";
import { colourAt, Swatch } from "./swatch";

const longest = 80;

/** A value or command of a point as people read it: colours and white light in one form, numbers in the locale. */
export function shownValue(point: Point, value: string): string {
  const { type } = point;
  if (type === "colourTemperatureMired" && Number(value) > 0) return `${reciprocal(Number(value))} K`;
  if (colourTypes.has(type)) {
    const colour = readColour(type, value, objectIn(value));
    return colour ? hexOf(colour) : value;
  }
  return formatValue(value, text(point.description?.json.data_type));
}

function objectIn(value: string): Record<string, unknown> {
  try {
    const tree: unknown = JSON.parse(value);
    return typeof tree === "object" && tree !== null ? (tree as Record<string, unknown>) : {};
  } catch {
    return {};
  }
}

/** The reported value of a point with its unit; a title where it is cut. */
export function Value({ point, unit = true }: { point: Point | undefined; unit?: boolean }) {
  const value = point?.value?.value;
  if (!point || value === undefined) return <span class="muted">…</span>;
  if (value === null) return <span class="muted">{words.bytes(point.value?.size ?? 0)}</span>;
  if (value === "") return <span class="muted">–</span>;
  const sign = unit ? unitSign(point.unit) : "";
  const cut = value.length > longest;
  return (
    <span class={`value quality-${point.quality || "unknown"}`} title={cut ? value.slice(0, 1000) : undefined}>
      {colourTypes.has(point.type) && <Swatch colour={colourAt(point)} />}
      {cut ? `${value.slice(0, longest)}…` : shownValue(point, value)}
      {sign && <span class="unit">{` ${sign}`}</span>}
    </span>
  );
}
