import type { Track } from "./track";

/** Programs for tables take what begins like that for a formula; words come from devices. */
const formula = /^[=+\-@\t\r]/;

function word(text: string): string {
  return formula.test(text) && Number.isNaN(Number(text)) ? `'${text}` : text;
}

function cell(text: string): string {
  return /[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

export function csvLine(cells: string[]): string {
  return `${cells.map(cell).join(",")}\n`;
}

/** Of points with times in which several values are drawn as one. */
const columns = ["last", "first", "minimum", "maximum", "mean"];

/**
 * Values of several points, a line for each time at which one of them has one (RFC 4180). A gap is the word `gap`. The last
 * value of a bucket stands at its beginning, as all of it.
 */
export function csvOf(points: { name: string; track: Track }[], from: number, to: number): string {
  const lines = new Map<number, string[]>();
  const head = ["time"];
  for (const { name, track } of points) {
    const samples = track.within(from, to);
    const banded = samples.some(({ low, high }) => high > low);
    const at = head.length;
    head.push(...(banded ? columns.map((column) => `${name} ${column}`) : [name]));
    for (const { t: time, gap, text, value, first, low, high, mean } of samples) {
      // A gap may begin at the time of the value before it.
      const t = gap && lines.get(time)?.[at] ? time + 0.001 : time;
      const line = lines.get(t) ?? [];
      lines.set(t, line);
      line[at] = gap ? "gap" : track.kind === "state" ? word(text) : numberText(value);
      if (!banded || gap) continue;
      [first, low, high, mean].forEach((one, place) => (line[at + 1 + place] = numberText(one)));
    }
  }
  const times = [...lines.keys()].sort((a, b) => a - b);
  const rows = times.map((time) => {
    const line = lines.get(time) ?? [];
    return csvLine([new Date(Math.round(time * 1000)).toISOString(), ...head.slice(1).map((_, index) => line[index + 1] ?? "")]);
  });
  return csvLine(head) + rows.join("");
}

/** Without the digits that only binary fractions make. */
function numberText(value: number): string {
  return String(Number(value.toPrecision(12)));
}
