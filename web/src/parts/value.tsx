import { type Point, text } from "../core/catalog";
import { formatValue, unitSign } from "../core/format";
import * as words from "../words/frame";

const longest = 80;

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
      {cut ? `${value.slice(0, longest)}…` : formatValue(value, text(point.description?.json.data_type))}
      {sign && <span class="unit">{` ${sign}`}</span>}
    </span>
  );
}
