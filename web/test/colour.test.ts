import assert from "node:assert/strict";
import { test } from "node:test";
import { colourTypes, hexOf, readColour, reciprocal, writeColour } from "../src/core/colour";

const object = (value: string) => (value.startsWith("{") ? (JSON.parse(value) as Record<string, unknown>) : {});

test("the colours of the sRGB primaries are where CIE 1931 has them", () => {
  assert.deepEqual(JSON.parse(writeColour("colourXy", { hue: 0, saturation: 1 })), { x: 0.6401, y: 0.33 });
  assert.deepEqual(JSON.parse(writeColour("colourXy", { hue: 240, saturation: 1 })), { x: 0.15, y: 0.06 });
  assert.deepEqual(JSON.parse(writeColour("colourXy", { hue: 0, saturation: 0 })), { x: 0.3127, y: 0.329 });
});

test("what is written is read again as the same colour, in each form", () => {
  for (const type of colourTypes) {
    for (let hue = 0; hue < 360; hue += 30) {
      for (const saturation of [0.3, 0.7, 1]) {
        const value = writeColour(type, { hue, saturation });
        const read = readColour(type, value, object(value));
        assert.ok(read, value);
        assert.ok(Math.abs(((read.hue - hue + 540) % 360) - 180) < 2, `${type} ${value}: hue ${read.hue}, not ${hue}`);
        assert.ok(Math.abs(read.saturation - saturation) < 0.02, `${type} ${value}: ${read.saturation}, not ${saturation}`);
      }
    }
  }
});

test("a value that is no colour has none", () => {
  assert.equal(readColour("colourXy", '{"x":0.3,"y":0}', { x: 0.3, y: 0 }), null);
  assert.equal(readColour("colourXy", "", {}), null);
  assert.equal(readColour("colourHueSaturation", "{}", {}), null);
  assert.equal(readColour("colourRgb", "red", {}), null);
});

test("colours for the style sheet, and white light in kelvin", () => {
  assert.equal(hexOf({ hue: 120, saturation: 1 }), "#00ff00");
  assert.equal(hexOf({ hue: 30, saturation: 0.5 }), "#ffbf80");
  assert.equal(reciprocal(370), 2703);
  assert.equal(reciprocal(2703), 370);
});
