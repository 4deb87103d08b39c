import assert from "node:assert/strict";
import { test } from "node:test";
import { activeNow } from "../src/core/active_row";
import { highest, layoutOf, margin, shownRows } from "../src/core/layout";
import { FrozenOrder, type OrderSpec } from "../src/core/order";
import { Paced } from "../src/core/paced";
import { formatRoute, parseRoute } from "../src/core/router";
import { matches } from "../src/core/text";
import { TestClock } from "./support";

test("only the rows of the window and a margin are drawn", () => {
  const layout = layoutOf(10_000, 30);
  assert.deepEqual(shownRows(layout, 0, 600), { first: 0, end: 21 + margin, shift: 0 });
  const middle = shownRows(layout, 150_000, 600);
  assert.deepEqual(middle, { first: 5000 - margin, end: 5021 + margin, shift: 0 });
  assert.equal(shownRows(layout, 300_000 - 600, 600).end, 10_000);
  assert.deepEqual(shownRows(layoutOf(0, 30), 0, 600), { first: 0, end: 0, shift: 0 });
});

test("a list higher than browsers can draw is scrolled by scale, to its very end", () => {
  const layout = layoutOf(2_000_000, 30);
  assert.equal(layout.drawnTotal, highest);
  assert.equal(shownRows(layout, 0, 600).first, 0);
  const end = shownRows(layout, highest - 600, 600);
  assert.equal(end.end, 2_000_000);
  assert.equal(end.shift + layout.offset(2_000_000), highest);
});

test("rows of different heights are found at their pixel", () => {
  const layout = layoutOf(4, (index) => [10, 30, 20, 40][index] ?? 0);
  assert.equal(layout.total, 100);
  assert.deepEqual(
    [0, 9, 10, 39, 40, 59, 60, 99, 200].map((pixel) => layout.indexAt(pixel)),
    [0, 0, 1, 1, 2, 2, 3, 3, 3],
  );
  assert.equal(layout.height(3), 40);
});

interface Row {
  name: string;
  value: number;
}

function byValue(live: boolean): OrderSpec<Row> {
  return { name: "value", keep: (row) => row.value >= 0, compare: (a, b) => a.value - b.value, live, complete: true };
}

test("rows never move by themselves when the order is by a live column", () => {
  const [a, b, c] = [
    { name: "a", value: 1 },
    { name: "b", value: 2 },
    { name: "c", value: 0 },
  ];
  const order = new FrozenOrder<Row>();
  const spec = byValue(true);
  order.update([a, b], 1, spec);
  a.value = 9;
  order.update([a, b], 1, spec);
  assert.deepEqual(order.rows, [a, b]);
  order.update([a, b, c], 2, spec);
  assert.deepEqual([order.rows, order.outdated], [[a, b, c], 2]);
  order.refresh([a, b, c], spec);
  assert.deepEqual(order.rows, [c, b, a]);
  assert.equal(order.outdated, 0);
  order.update([a, c], 3, spec);
  assert.deepEqual(order.rows, [c, a]);
});

test("a row that no longer fits a live filter stays until asked again", () => {
  const row = { name: "a", value: 1 };
  const order = new FrozenOrder<Row>();
  order.update([row], 1, byValue(true));
  row.value = -1;
  order.update([row], 1, byValue(true));
  assert.deepEqual(order.rows, [row]);
  order.count([row], byValue(true));
  assert.equal(order.outdated, 1);
});

test("while a list is loading, rows come in their place; then new ones come at the end until asked", () => {
  const [a, b, c, d] = [4, 3, 2, 1].map((value) => ({ name: String(value), value })) as [Row, Row, Row, Row];
  const complete = byValue(false);
  const loading = { ...complete, complete: false };
  const order = new FrozenOrder<Row>();
  order.update([a], 1, loading);
  order.update([a, b], 2, loading);
  assert.deepEqual(order.rows, [b, a]);
  order.update([a, b, c], 3, complete);
  assert.deepEqual(order.rows, [c, b, a]);
  order.update([a, b, c, d], 4, complete);
  assert.deepEqual([order.rows, order.outdated], [[c, b, a, d], 1]);
  order.update([a, b, d], 5, loading); // the line was lost
  assert.deepEqual(order.rows, [b, a, d]);
  order.refresh([a, b, d], complete);
  assert.deepEqual([order.rows, order.outdated], [[d, b, a], 0]);
});

test("the end of loading puts the rows in order, though none came or went", () => {
  const [a, b] = [2, 1].map((value) => ({ name: String(value), value })) as [Row, Row];
  const order = new FrozenOrder<Row>();
  order.update([a, b], 1, { ...byValue(false), complete: false });
  a.value = 0;
  order.update([a, b], 1, byValue(false));
  assert.deepEqual(order.rows, [a, b]);
});

test("the active row stays the same one while others come, go and move", () => {
  const at = (names: string) => (index: number) => names[index] ?? "";
  assert.deepEqual(activeNow({ index: 0 }, 3, at("xab")), { index: 0, name: undefined });
  assert.deepEqual(activeNow({ index: 1, name: "b" }, 3, at("xab")), { index: 2, name: "b" });
  assert.deepEqual(activeNow({ index: 1, name: "b" }, 0, at("")), { index: 0, name: "b" });
  assert.deepEqual(activeNow({ index: 1, name: "b" }, 2, at("ac")), { index: 1, name: "c" });
  assert.deepEqual(activeNow({ index: 2, name: "c" }, 2, at("ab")), { index: 1, name: "b" });
  assert.deepEqual(activeNow({ index: 5, name: "c" }, 2), { index: 1, name: "c" });
});

test("another filter or order is taken at once", () => {
  const [a, b] = [
    { name: "a", value: 1 },
    { name: "b", value: 2 },
  ];
  const order = new FrozenOrder<Row>();
  order.update([a, b], 1, byValue(true));
  order.update([a, b], 1, { ...byValue(true), name: "down", compare: (x, y) => y.value - x.value });
  assert.deepEqual(order.rows, [b, a]);
});

test("addresses keep parts and query, whatever they contain", () => {
  const address = formatRoute("tuples", ["7:a.b/c?d#e"], { q: "hall & door", empty: "" });
  assert.deepEqual(parseRoute(address), { view: "tuples", parts: ["7:a.b/c?d#e"], query: { q: "hall & door" } });
  assert.deepEqual(parseRoute(""), { view: "overview", parts: [], query: {} });
  assert.deepEqual(parseRoute("#/devices/%E0%A4%A"), { view: "devices", parts: ["%E0%A4%A"], query: {} });
});

test("a search finds all its words in any order and case", () => {
  assert.ok(matches("LAMP hall", "Hall lamp 1/0/1"));
  assert.ok(!matches("lamp kitchen", "Hall lamp"));
  assert.ok(matches("", "anything"));
});

test("an address that changes often is written now and then, the last one always", () => {
  const clock = new TestClock();
  const written: string[] = [];
  const address = new Paced(clock, 150, (text) => written.push(text));
  for (let step = 0; step < 30; step++) {
    address.put(String(step));
    clock.advance(33);
  }
  clock.advance(150);
  assert.equal(written[0], "0");
  assert.equal(written[written.length - 1], "29");
  assert.ok(written.length <= 8, `${written.length} writes in a second`);
  clock.advance(1000);
  address.put("a");
  address.put("b");
  address.flush();
  address.flush();
  address.put("c");
  address.drop();
  clock.advance(1000);
  assert.deepEqual(written.slice(-2), ["a", "b"]);
});
