import assert from "node:assert/strict";
import { test } from "node:test";
import { numberIn, pairsOf, sinceTime } from "../src/core/hour";

const asIs = (word: string) => numberIn([], word);

test("a series gives its values in order of time, and gaps", () => {
  assert.deepEqual(pairsOf({ key: "7:a", t: [10, 30], v: [1, 2], gaps: [[20, 25]] }, asIs), [
    [10, 1],
    [20, Number.NaN],
    [30, 2],
  ]);
  assert.deepEqual(pairsOf({ key: "7:a", t: [10], mean: [1.5], last: [2], before: [5, null] }, asIs), [
    [5, Number.NaN],
    [10, 1.5],
  ]);
  assert.deepEqual(pairsOf({ key: "7:a" }, asIs), []);
});

test("words of the history count as those of the point", () => {
  const series = { key: "7:a", t: [10, 20], last: [0, 1], words: ["open", "closed"] };
  assert.deepEqual(
    pairsOf(series, (word) => numberIn(["closed", "open"], word)),
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
