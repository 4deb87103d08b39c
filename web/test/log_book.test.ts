import assert from "node:assert/strict";
import { test } from "node:test";
import { atLeast, kept, LogBook, lineText } from "../src/core/log_book";

const line = (number: number, time = number) => ({ number, time, level: "info", subject: "knx", text: `line ${number}` });
const lines = (from: number, to: number) => Array.from({ length: to - from + 1 }, (_, index) => line(from + index));

test("each line is taken once, and missing ones are counted", () => {
  const book = new LogBook();
  book.take(1, lines(5, 7));
  book.take(1, lines(5, 8));
  book.take(1, lines(5, 8));
  book.take(1, lines(12, 13));
  assert.deepEqual(
    book.lines.map(({ number, missed }) => [number, missed]),
    [
      [5, 0],
      [6, 0],
      [7, 0],
      [8, 0],
      [12, 3],
      [13, 0],
    ],
  );
  assert.equal(book.version, 3);
});

test("lines are counted beyond those that are kept", () => {
  const book = new LogBook();
  for (let first = 1; first <= 3 * kept; first += 100) book.take(1, lines(first, first + 99));
  assert.equal(book.lines.length, kept);
  assert.equal(book.taken, 3 * kept);
});

test("an island that is started again counts from 1", () => {
  const book = new LogBook();
  book.take(1, lines(50, 52));
  book.take(1, [line(1, 60), line(2, 61)]);
  assert.deepEqual(book.lines.map(({ number, missed }) => [number, missed]).slice(-2), [
    [1, 0],
    [2, 0],
  ]);
  assert.equal(new Set(book.lines.map(({ id }) => id)).size, 5);
});

test("the lines of several islands are in the order of time", () => {
  const book = new LogBook();
  book.take(1, [line(1, 10), line(2, 30)]);
  book.take(2, [line(1, 20)]);
  assert.deepEqual(
    book.lines.map(({ owner, time }) => [owner, time]),
    [
      [1, 10],
      [2, 20],
      [1, 30],
    ],
  );
});

test("the oldest lines go, later while somebody reads", () => {
  const book = new LogBook();
  for (let at = 1; at < 2300; at += 100) book.take(1, lines(at, at + 99), true);
  assert.equal(book.lines.length, 2300);
  book.take(1, [line(2301)]);
  assert.equal(book.lines.length, kept);
  assert.equal(book.lines[0]?.number, 302);
});

test("what is no line of a log is left out", () => {
  const book = new LogBook();
  book.take(1, "nothing");
  book.take(1, [null, 3]);
  assert.equal(book.lines.length, 0);
  book.take(1, [{ number: 1, time: 1, level: 7 }]);
  assert.equal(book.lines[0]?.level, "");
});

test("levels and the text of a line", () => {
  assert.ok(atLeast("error", "warning"));
  assert.ok(!atLeast("info", "warning"));
  assert.ok(atLeast("notice", "warning"));
  const book = new LogBook();
  book.take(1, [line(1, 0)]);
  assert.equal(book.lines.map(lineText).join(), "1970-01-01T00:00:00.000Z info    knx: line 1");
});
