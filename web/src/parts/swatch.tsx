import type { Point } from "../core/catalog";
import { type Colour, hexOf, readColour } from "../core/colour";

/** The colour that a point reports; null where it is not known. */
export function colourAt(point: Point): Colour | null {
  return readColour(point.type, point.value?.value ?? "", point.value?.json ?? {});
}

/** A patch of the colour; striped where it is not known. */
export function Swatch({ colour }: { colour: Colour | null }) {
  return <span class={colour ? "patch" : "patch unknown"} style={colour ? `background:${hexOf(colour)}` : undefined} aria-hidden="true" />;
}
