// What several points of a room say together, in words.
import { type Point, text } from "./catalog";
import { formatValue, unitSign } from "./format";
import { activeWord, type Fact } from "./rooms";

export interface Told {
  value: string;
  unit: string;
  /** The best quality among those that say it; empty = none says anything. */
  quality: string;
}

const current = new Set(["good", "assumed"]);

/** Digits behind the point that people read at a glance; the page of the device has them all. */
const digits: Record<string, number> = { temperature: 1, humidity: 0, co2: 0, light: 0, power: 0 };
/** For types without words of their own, `on` says no more than that it is so. */
const plainWords: Record<string, string> = { on: "yes", off: "no" };

function shown(point: Point): string {
  const value = point.value?.value ?? "";
  const most = digits[point.type];
  const long = most !== undefined && (value.split(".")[1]?.length ?? 0) > most;
  const number = long && Number.isFinite(Number(value)) ? Number(value).toFixed(most) : value;
  return plainWords[number] ?? formatValue(number, text(point.description?.json.data_type) || "real");
}

function isNumber(point: Point): boolean {
  const type = text(point.description?.json.data_type);
  return type === "real" || type === "integer" || (type === "" && !Number.isNaN(Number(point.value?.value || "-")));
}

/** One value, the span of several, or how many of several words say that there is something: `2 of 3 open`. */
export function tellFact({ points }: Fact, of: (count: number, all: number, word: string) => string): Told {
  const known = points.filter((point) => point.value?.value);
  const good = known.filter((point) => current.has(point.quality || "good"));
  const told = good.length > 0 ? good : known;
  const [first] = told;
  if (!first) return { value: "", unit: "", quality: "" };
  const quality = first.quality || "good";
  const unit = unitSign(first.unit);
  if (told.length === 1) return { value: shown(first), unit, quality };
  if (isNumber(first)) {
    const sorted = [...told].sort((a, b) => Number(a.value?.value) - Number(b.value?.value));
    const [low, high] = [shown(sorted[0] as Point), shown(sorted[sorted.length - 1] as Point)];
    return { value: low === high ? low : `${low} – ${high}`, unit, quality };
  }
  const active = told.filter((point) => point.value?.value === activeWord(point));
  return { value: of(active.length, told.length, shown(active[0] ?? first)), unit: "", quality };
}
