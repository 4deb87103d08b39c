// Numbers and times for people. What is copied stays as it is in the tuple.

/** UCUM codes as people write them; others are shown as they are. */
const unitSigns: Record<string, string> = {
  Cel: "°C",
  "[degF]": "°F",
  "[ppm]": "ppm",
  "[ppb]": "ppb",
  deg: "°",
  Ohm: "Ω",
  "kW.h": "kWh",
  "W.h": "Wh",
  "ug/m3": "µg/m³",
  "mg/m3": "mg/m³",
  "m/s2": "m/s²",
  "W/m2": "W/m²",
  "V.A": "VA",
  m3: "m³",
  "m3/h": "m³/h",
  m2: "m²",
  us: "µs",
  "{count}": "",
  "1": "",
};

export function unitSign(unit: string): string {
  return unitSigns[unit] ?? unit;
}

/** Making a formatter costs more than using it a hundred times. */
function cached<O extends object, F>(make: (locale: string | undefined, options: O) => F): (locale: string | undefined, options: O) => F {
  const made = new Map<string, F>();
  return (locale, options) => {
    const name = JSON.stringify([locale, options]);
    let format = made.get(name);
    if (!format) made.set(name, (format = make(locale, options)));
    return format;
  };
}

const numberFormat = cached((locale, options: Intl.NumberFormatOptions) => new Intl.NumberFormat(locale, options));
const dateFormat = cached((locale, options: Intl.DateTimeFormatOptions) => new Intl.DateTimeFormat(locale, options));

/** A leading zero is part of a name or a code. */
const plainNumber = /^-?(0|[1-9]\d*)(\.\d+)?([eE][-+]?\d+)?$/;

/** A value as it is shown: numbers of points that say they are numbers in the locale, all else as it is. */
export function formatValue(value: string, dataType: string, locale?: string): string {
  return dataType === "real" || dataType === "integer" ? formatNumber(value, locale) : value;
}

/** A number in the locale with the digits that were sent; what is none as it is. */
export function formatNumber(value: string, locale?: string): string {
  if (!plainNumber.test(value)) return value;
  const magnitude = Math.abs(Number(value));
  if (value.length > 15 || magnitude >= 1e12 || /[eE]/.test(value)) return value;
  const digits = value.split(".")[1]?.length ?? 0;
  const options = { minimumFractionDigits: digits, maximumFractionDigits: digits, useGrouping: magnitude >= 10000 };
  return numberFormat(locale, options).format(Number(value));
}

export function formatCount(count: number, locale?: string): string {
  return numberFormat(locale, { maximumFractionDigits: 0 }).format(count);
}

/** Sets per second: `0`, `0.2`, `14`. */
export function formatRate(rate: number, locale?: string): string {
  if (rate < 0.05) return "0";
  return numberFormat(locale, { maximumFractionDigits: rate < 10 ? 1 : 0 }).format(rate);
}

export function formatBytes(bytes: number): string {
  const units = ["B", "KiB", "MiB", "GiB", "TiB"];
  let unit = 0;
  while (bytes >= 1024 && unit < units.length - 1) {
    bytes /= 1024;
    unit++;
  }
  return `${unit === 0 || bytes >= 100 ? Math.round(bytes) : bytes.toFixed(1)} ${units[unit]}`;
}

/** How long ago, in one unit: `now`, `12 s`, `3 min`, `5 h`, `2 d`. */
export function formatAge(seconds: number): string {
  if (seconds < 1.5) return "now";
  if (seconds < 90) return `${Math.round(seconds)} s`;
  if (seconds < 5400) return `${Math.round(seconds / 60)} min`;
  if (seconds < 129600) return `${Math.round(seconds / 3600)} h`;
  return `${Math.round(seconds / 86400)} d`;
}

const timeParts: Intl.DateTimeFormatOptions = { hour: "2-digit", minute: "2-digit", second: "2-digit", hourCycle: "h23" };

/** 12:04:31, with the day if that is not today. */
export function formatTime(seconds: number, now = Date.now(), locale?: string, zone?: string): string {
  if (seconds <= 0) return "";
  const date = new Date(seconds * 1000);
  const options = { ...timeParts, timeZone: zone };
  const time = dateFormat(locale, options).format(date);
  const day = dateFormat("en-CA", { timeZone: zone });
  return day.format(date) === day.format(new Date(now)) ? time : `${day.format(date)} ${time}`;
}

/** 2026-11-22 12:04:31.047 CET: for tooltips and details. */
export function formatFullTime(seconds: number, zone?: string): string {
  if (seconds <= 0) return "";
  const date = new Date(seconds * 1000);
  const day = dateFormat("en-CA", { timeZone: zone }).format(date);
  const time = dateFormat("en-GB", { ...timeParts, fractionalSecondDigits: 3, timeZone: zone }).format(date);
  return `${day} ${time} ${zoneName(date, zone)}`;
}

/** The short name of the browser's time zone at that time. */
export function zoneName(date = new Date(), zone?: string): string {
  const parts = dateFormat("en-GB", { timeZoneName: "short", timeZone: zone }).formatToParts(date);
  return parts.find((part) => part.type === "timeZoneName")?.value ?? "";
}

/** Words in place of type names: colourTemperature becomes `colour temperature`. */
export function typeWords(type: string): string {
  return type
    .replace(/([a-z0-9])([A-Z])/g, "$1 $2")
    .replaceAll("_", " ")
    .toLowerCase();
}

/** JSON over several lines; null if the text is none. */
export function prettyJson(text: string): string | null {
  try {
    const value: unknown = JSON.parse(text);
    return typeof value === "object" && value !== null ? JSON.stringify(value, null, 2) : null;
  } catch {
    return null;
  }
}

/** Bytes as 16 a line: offset, hex, printable characters. */
export function hexDump(bytes: Uint8Array, limit = 4096): string {
  const lines: string[] = [];
  for (let at = 0; at < Math.min(bytes.length, limit); at += 16) {
    const row = [...bytes.subarray(at, at + 16)];
    const hex = row.map((byte) => byte.toString(16).padStart(2, "0")).join(" ");
    const print = row.map((byte) => (byte >= 32 && byte < 127 ? String.fromCharCode(byte) : "·")).join("");
    lines.push(`${at.toString(16).padStart(6, "0")}  ${hex.padEnd(47)}  ${print}`);
  }
  if (bytes.length > limit) lines.push(`… ${bytes.length - limit} more bytes`);
  return lines.join("\n");
}
