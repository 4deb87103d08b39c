import assert from "node:assert/strict";
import { test } from "node:test";
import { csvOf } from "../src/core/csv";
import { boundsOf, moved, rangeQuery, readRange, timeLabels, zoomed } from "../src/core/plot_time";
import { slow, Track } from "../src/core/track";

const numbers = () => new Track("number");

test("history and live values are one curve, none twice", () => {
  const track = numbers();
  track.add(95, "5"); // arrived before the history answered
  track.add(101, "7");
  track.fill({ key: "1:a", before: [10, 1], t: [20, 95], v: [2, 5] }, 100, 1);
  track.add(95, "5");
  track.add(102, "8");
  assert.deepEqual(track.curve(0, 200, 110), {
    t: [10, 20, 95, 95.0001, 101, 102, 110],
    value: [1, 2, 2, 5, 7, 8, 8],
    low: [1, 2, 2, 5, 7, 8, 8],
    high: [1, 2, 2, 5, 7, 8, 8],
  });
});

test("a value is there once, though the history keeps milliseconds only", () => {
  const track = numbers();
  track.add(95.0674, "5");
  track.fill({ key: "1:a", t: [20, 95.067], v: [2, 5] }, 100, 0);
  track.add(95.0674, "5");
  assert.deepEqual(
    track.within(0, 100).map(({ t }) => t),
    [20, 95.067],
  );
});

test("a text from before the time asked for is in force", () => {
  const track = new Track("state");
  track.fill({ key: "1:a", kind: "text", before: [10, "sits"], texts: [[20, "stands"]] }, 100, 1);
  assert.equal(track.at(15)?.text, "sits");
  assert.equal(track.at(25)?.text, "stands");
});

test("a curve ends where the value was not known, and begins again after it", () => {
  const track = numbers();
  track.fill({ key: "1:a", t: [10, 50], v: [1, 3], gaps: [[20, 45]] }, 60, 1);
  assert.deepEqual(track.curve(0, 60, 60).value, [1, 1, null, 3, 3]);
  assert.deepEqual(track.curve(0, 60, 60).t.slice(1, 3), [20, 20.0001]);
  track.lose(70);
  track.lose(71);
  assert.deepEqual(track.curve(48, 100, 100).value.slice(-3), [3, 3, null]);
  assert.ok(track.at(75)?.gap);
  assert.equal(track.at(5), undefined);
});

test("a long series of live values keeps its beginning", () => {
  const track = numbers();
  for (let second = 0; second < 20_000; second++) track.add(second, String(second % 100));
  const curve = track.curve(0, 20_000, 20_000);
  assert.equal(curve.t[0], 0);
  assert.ok(curve.t.length <= 3 * 6001); // three points a bucket: first, last, end of its band
  assert.equal(Math.min(...curve.low.map(Number)), 0);
  assert.equal(Math.max(...curve.high.map(Number)), 99);
});

test("a file begins with what held at its beginning, and words are no formulas", () => {
  const track = numbers();
  track.add(10, "1");
  track.add(30, "2");
  const states = new Track("state");
  states.add(20, "=1+1");
  states.add(25, "-5");
  const [head, ...lines] = csvOf(
    [
      { name: "a", track },
      { name: "b", track: states },
    ],
    15,
    40,
  ).split("\n");
  assert.equal(head, "time,a,b");
  assert.deepEqual(
    lines.filter(Boolean).map((line) => line.replace(/^1970-01-01T00:00:/, "")),
    ["15.000Z,1,", "20.000Z,,'=1+1", "25.000Z,,-5", "30.000Z,2,"],
  );
  track.lose(30);
  assert.match(csvOf([{ name: "a", track }], 25, 40), /30.000Z,2\n.*30.001Z,gap\n$/);
});

test("a lost line leaves no gap where the history knows better", () => {
  const track = numbers();
  track.add(10, "1");
  track.lose(20);
  track.fill({ key: "1:a", t: [10, 25], v: [1, 2] }, 40, 1);
  assert.deepEqual(track.curve(0, 40, 40).value, [1, 2, 2]);
});

test("values within a bucket are drawn as one with a band", () => {
  const track = numbers();
  track.fill({ key: "1:a", t: [0], first: [1.5], min: [1], max: [3], mean: [2], last: [2.5], n: [4] }, 10, 10);
  for (const [t, value] of [
    [11, "4"],
    [13, "8"],
    [19, "6"],
    [21, "5"],
  ] as const)
    track.add(t, value);
  assert.deepEqual(track.curve(0, 21, 21), {
    t: [0, 10, 10.0001, 11, 19, 19.0001, 21],
    value: [1.5, 2.5, 2.5, 4, 6, 6, 5],
    low: [1, 1, 2.5, 4, 4, 6, 5],
    high: [3, 3, 2.5, 8, 8, 6, 5],
  });
  const live = track.at(20);
  assert.equal(live?.mean, (4 * 2 + 8 * 6) / 8, "weighted by the time in force");
  const [head, line] = csvOf([{ name: "a", track }], 0, 5).split("\n");
  assert.equal(head, "time,a last,a first,a minimum,a maximum,a mean");
  assert.equal(line, "1970-01-01T00:00:00.000Z,2.5,1.5,1,3,2");
});

/** A lamp that holds the light of a room at 320 or 40 lx for minutes. */
test("a value that was held is a step, and no value is drawn that never was", () => {
  const lux = [320, 40, 320, 40, 320];
  const live = numbers();
  lux.forEach((value, index) => live.add(index * 210, String(value)));
  const fine = numbers();
  fine.fill({ key: "1:a", t: lux.map((_, index) => index * 210), v: lux }, 1000, 1);
  const coarse = numbers(); // each bucket of ten minutes has several values
  coarse.fill(
    { key: "1:a", t: [0, 600], first: [320, 40], min: [40, 40], max: [320, 320], mean: [222, 200], last: [320, 320], n: [3, 2] },
    1200,
    600,
  );
  for (const track of [live, fine, coarse]) {
    const { t, value } = track.curve(0, 1200, 1200);
    assert.ok(
      value.every((one) => one === 320 || one === 40),
      `drawn: ${value}`,
    );
    if (track === coarse) continue;
    for (let index = 1; index < t.length; index++) {
      const slope = value[index] !== value[index - 1];
      assert.ok(!slope || (t[index] ?? 0) - (t[index - 1] ?? 0) < 0.01, `at ${t[index]} a slope from ${t[index - 1]}`);
    }
  }
});

test("between two measurements that follow soon is a line", () => {
  const track = numbers();
  track.add(0, "20");
  track.add(slow, "21");
  track.add(2 * slow + 1, "22");
  assert.deepEqual(track.curve(0, 200, 130).value, [20, 21, 21, 22, 22]);
});

test("states are spans of words; equal ones are joined, gaps stay", () => {
  const track = new Track("state");
  track.fill({ key: "1:a", kind: "words", words: ["off", "on"], before: [5, 0], t: [20, 30], last: [1, 1], gaps: [[40, 50]] }, 60, 1);
  track.add(70, "on");
  assert.deepEqual(track.spans(10, 100, 80), [
    { from: 10, to: 20, word: "off" },
    { from: 20, to: 40, word: "on" },
    { from: 40, to: 70, word: "" },
    { from: 70, to: 80, word: "on" },
  ]);
  assert.equal(track.at(35)?.text, "on");
});

test("a bucket with several words shows them, and the last one holds after it", () => {
  const track = new Track("state");
  track.fill({ key: "1:a", kind: "words", words: ["off", "on"], t: [0, 10, 50], min: [0, 0, 0], max: [1, 1, 0], last: [1, 1, 0] }, 60, 10);
  assert.deepEqual(
    track.spans(0, 60, 60).map(({ from, to, word }) => [from, to, word]),
    [
      [0, 20, "off … on"],
      [20, 50, "on"],
      [50, 60, "off"],
    ],
  );
});

test("commands of the past and new ones", () => {
  const track = numbers();
  track.command(90, "on");
  track.fillTicks({ key: "1:a", kind: "words", words: ["off", "on"], t: [50, 90], v: [0, 1] });
  track.command(95, "off");
  track.command(95, "off");
  assert.deepEqual(track.ticksIn(60, 100), [
    { t: 90, text: "on" },
    { t: 95, text: "off" },
  ]);
});

test("a file has a line for each time, bands where there are some", () => {
  const one = numbers();
  one.fill(
    {
      key: "1:a",
      t: [0, 10],
      first: [0.1, 1],
      min: [0.1, 1],
      max: [0.3, 1],
      mean: [0.2, 1],
      last: [0.1 + 0.2, 1],
      n: [2, 1],
      gaps: [[20, 30]],
    },
    30,
    10,
  );
  const two = new Track("state");
  two.add(10, 'say "hi", twice');
  assert.equal(
    csvOf(
      [
        { name: "one", track: one },
        { name: "two", track: two },
      ],
      0,
      100,
    ),
    "time,one last,one first,one minimum,one maximum,one mean,two\n1970-01-01T00:00:00.000Z,0.3,0.1,0.1,0.3,0.2,\n" +
      '1970-01-01T00:00:10.000Z,1,1,1,1,1,"say ""hi"", twice"\n1970-01-01T00:00:20.000Z,gap,,,,,\n',
  );
});

test("the range of an address, zooming and moving", () => {
  assert.deepEqual(readRange({}), { span: 3600, from: 0, to: 0 });
  assert.deepEqual(readRange({ span: "900" }), { span: 900, from: 0, to: 0 });
  assert.deepEqual(readRange({ from: "10", to: "5", span: "x" }), { span: 3600, from: 0, to: 0 });
  assert.deepEqual(readRange(rangeQuery({ span: 0, from: 10, to: 20 })), { span: 0, from: 10, to: 20 });
  assert.deepEqual(boundsOf(readRange({ span: "900" }), 1000), { from: 100, to: 1000 });
  assert.deepEqual(zoomed({ from: 0, to: 100 }, 25, 0.5), { span: 0, from: 12.5, to: 62.5 });
  assert.deepEqual(moved({ from: 0, to: 100 }, -0.25), { span: 0, from: -25, to: 75 });
});

test("the axis says the day where it changes, and the year once", () => {
  const at = (text: string) => Date.parse(text) / 1000;
  const splits = [at("2026-11-21T23:00Z"), at("2026-11-22T00:00Z"), at("2026-11-22T01:00Z")];
  assert.deepEqual(timeLabels(splits, 3600, "UTC"), ["23:00\n2026-11-21", "00:00\n11-22", "01:00"]);
  assert.deepEqual(timeLabels([at("2026-11-22T01:00:05Z")], 5, "UTC"), ["01:00:05"]);
  const days = ["2026-12-30T00:00Z", "2026-12-31T00:00Z", "2027-01-01T00:00Z", "2027-01-02T00:00Z"].map(at);
  assert.deepEqual(timeLabels(days, 86_400, "UTC"), ["12-30\n2026", "12-31", "01-01\n2027", "01-02"]);
});

test("a gap that begins with the value before it has a time of its own in a file", () => {
  for (let millisecond = 0; millisecond < 100; millisecond++) {
    const track = numbers();
    const time = (1_795_378_036_000 + millisecond) / 1000;
    track.add(time, "5");
    track.lose(time);
    const [, value = "", gap = ""] = csvOf([{ name: "one", track }], 0, time + 1).split("\n");
    assert.equal(Date.parse(gap.split(",")[0] ?? "") - Date.parse(value.split(",")[0] ?? ""), 1, `${time}`);
  }
});
