// Colours of lights: hue and saturation at full brightness, in the forms that points have (docs/types.md).

export interface Colour {
  hue: number; // 0 to 360
  saturation: number; // 0 to 1
}

type Triple = [number, number, number];

/** Linear sRGB of CIE XYZ with the white of D65, and back (IEC 61966-2-1). */
const toLinear: Triple[] = [
  [3.2406, -1.5372, -0.4986],
  [-0.9689, 1.8758, 0.0415],
  [0.0557, -0.204, 1.057],
];
const fromLinear: Triple[] = [
  [0.4124, 0.3576, 0.1805],
  [0.2126, 0.7152, 0.0722],
  [0.0193, 0.1192, 0.9505],
];

function times(matrix: Triple[], [a, b, c]: Triple): Triple {
  return matrix.map(([x, y, z]) => x * a + y * b + z * c) as Triple;
}

const curved = (part: number) => (part <= 0.0031308 ? 12.92 * part : 1.055 * part ** (1 / 2.4) - 0.055);
const straight = (part: number) => (part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4);

/** Red, green and blue, 0 to 1, of which one is 1. */
function rgbOf({ hue, saturation }: Colour): Triple {
  const part = (place: number) => {
    const at = (place + hue / 60) % 6;
    return 1 - saturation * Math.max(0, Math.min(at, 4 - at, 1));
  };
  return [part(5), part(3), part(1)];
}

function colourOf(parts: Triple): Colour {
  const most = Math.max(...parts);
  const span = most - Math.min(...parts);
  if (most <= 0 || span === 0) return { hue: 0, saturation: 0 };
  const [red, green, blue] = parts;
  const sixth = most === red ? (green - blue) / span : most === green ? 2 + (blue - red) / span : 4 + (red - green) / span;
  return { hue: (sixth * 60 + 360) % 360, saturation: span / most };
}

export const colourTypes = new Set(["colourRgb", "colourXy", "colourHueSaturation"]);

/** The colour in the value of a point of that type; null if it has none. */
export function readColour(type: string, value: string, json: Record<string, unknown>): Colour | null {
  const { x, y, hue, saturation } = json;
  if (type === "colourXy") {
    if (typeof x !== "number" || typeof y !== "number" || y <= 0) return null;
    const linear = times(toLinear, [x / y, 1, (1 - x - y) / y]).map((part) => Math.max(0, part));
    const most = Math.max(...linear);
    return most > 0 ? colourOf(linear.map((part) => curved(part / most)) as Triple) : null;
  }
  if (type === "colourHueSaturation") {
    return typeof hue === "number" && typeof saturation === "number" ? { hue, saturation: saturation / 100 } : null;
  }
  const parts = /^#([0-9a-f]{2})([0-9a-f]{2})([0-9a-f]{2})$/i
    .exec(value)
    ?.slice(1)
    .map((hex) => Number.parseInt(hex, 16) / 255);
  return parts ? colourOf(parts as Triple) : null;
}

export function hexOf(colour: Colour): string {
  const parts = rgbOf(colour).map((part) =>
    Math.round(part * 255)
      .toString(16)
      .padStart(2, "0"),
  );
  return `#${parts.join("")}`;
}

/** The command that asks a point of that type for the colour. */
export function writeColour(type: string, colour: Colour): string {
  if (type === "colourHueSaturation") {
    return JSON.stringify({ hue: Math.round(colour.hue), saturation: Math.round(colour.saturation * 100) });
  }
  if (type !== "colourXy") return hexOf(colour);
  const [x, y, z] = times(fromLinear, rgbOf(colour).map(straight) as Triple);
  const short = (part: number) => Math.round((part / (x + y + z)) * 10_000) / 10_000;
  return JSON.stringify({ x: short(x), y: short(y) });
}

/** Kelvin of mired and mired of kelvin. */
export function reciprocal(value: number): number {
  return Math.round(1e6 / value);
}
