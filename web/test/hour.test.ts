import assert from "node:assert/strict";
import { test } from "node:test";
import { addLive, numberIn, pairsOf, sinceTime } from "../src/core/hour";

const asIs = (word: string) => numberIn([], word);

test("a series gives its values in order of time, and gaps", () => {
  assert.deepEqual(pairsOf({ key: "7:a", t: [10, 30], v: [1, 2], gaps: [[20, 25]] }, 60, asIs), [
    [10, 1],
    [20, Number.NaN],
    [30, 2],
  ]);
  assert.deepEqual(pairsOf({ key: "7:a", t: [10], first: [1], last: [2], before: [5, null] }, 60, asIs), [
    [5, Number.NaN],
    [10, 1],
    [59.94, 2],
  ]);
  const single = pairsOf({ key: "7:a", t: [32, 60], first: [1, 2], last: [1, 3] }, 60, asIs);
  assert.deepEqual(single, [
    [32, 1],
    [59.94, 1],
    [60, 2],
    [119.94, 3],
  ]);
  assert.deepEqual(pairsOf({ key: "7:a" }, 60, asIs), []);
});

test("live values are added, and a gap where nothing is known, though the value stays", () => {
  const pairs: [number, number][] = [[10, 1]];
  addLive(pairs, 101, 100, 2, 30);
  addLive(pairs, 112, 111, 3, 30); // the same pixel
  addLive(pairs, 120, 111, Number.NaN, 30); // the device is gone
  addLive(pairs, 121, 111, Number.NaN, 30);
  assert.deepEqual(pairs, [
    [10, 1],
    [100, 3],
    [120, Number.NaN],
  ]);
  addLive(pairs, 130, 111, 3, 30); // it is back with the same value
  assert.deepEqual(pairs[3], [130, 3]);
  const none: [number, number][] = [];
  addLive(none, 5, 0, Number.NaN, 30);
  assert.deepEqual(none, []);
});

test("words of the history count as those of the point", () => {
  const series = { key: "7:a", t: [10, 20], v: [0, 1], words: ["open", "closed"] };
  assert.deepEqual(
    pairsOf(series, 10, (word) => numberIn(["closed", "open"], word)),
    [
      [10, 1],
      [20, 0],
    ],
  );
  assert.deepEqual(
    ["on", "off", "21.5"].map((word) => numberIn([], word)),
    [1, 0, 21.5],
  );
});

test("what was before the hour holds at its beginning", () => {
  const pairs: [number, number][] = [
    [1, 5],
    [4, 6],
    [9, 7],
  ];
  assert.deepEqual(sinceTime(pairs, 5), [
    [5, 6],
    [9, 7],
  ]);
  assert.deepEqual(sinceTime(pairs, 10), [[10, 7]]);
  assert.deepEqual(sinceTime(pairs, 0), pairs);
  assert.deepEqual(sinceTime([], 0), []);
});
