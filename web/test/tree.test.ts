import assert from "node:assert/strict";
import { test } from "node:test";
import { Rates } from "../src/core/rates";
import { Store } from "../src/core/store";
import { pathsAbove, Tree } from "../src/core/tree";
import { wantsOf } from "../src/core/tree_wants";

function setUp(...names: string[]) {
  const store = new Store(() => {});
  const tree = new Tree(store);
  for (const name of names) store.hold(name);
  const set = (name: string, sequence: number) => {
    const tuple = store.get(name);
    assert.ok(tuple);
    store.set(tuple, "v", sequence, 1);
  };
  const shown = (...open: string[]) =>
    tree
      .rows(new Set(open), "key", [...tree.owners.values()])
      .map(({ branch, level, place, size }) => `${" ".repeat(level - 1)}${branch.part} ${place}/${size}`);
  return { store, tree, set, shown };
}

test("only what is below open branches is visible, in natural order, with its place among its siblings", () => {
  const { shown } = setUp("7:a.10", "7:a.9", "7:b", "8:c");
  assert.deepEqual(shown(), ["7 1/2", "8 2/2"]);
  assert.deepEqual(shown("7", "7:a"), ["7 1/2", " a 1/2", "  9 1/2", "  10 2/2", " b 2/2", "8 2/2"]);
});

test("branches count the tuples at and below them, and go with the last", () => {
  const { store, tree } = setUp("7:a", "7:a.b", "7:a.c");
  assert.equal(tree.find("7:a")?.count, 3);
  for (const name of ["7:a.b", "7:a"]) {
    const tuple = store.get(name);
    assert.ok(tuple);
    store.release(tuple);
  }
  assert.equal(tree.find("7:a")?.count, 1);
  assert.equal(tree.find("7:a")?.tuple, undefined);
  assert.equal(tree.find("7:a.b"), undefined);
});

test("leaves are small: they have no map, order or path of their own", () => {
  const { store, tree } = setUp("7:a.b", "7:a.c");
  const members = (path: string) => {
    const branch = tree.find(path);
    assert.ok(branch);
    return Object.values(branch).filter((member) => member instanceof Map || Array.isArray(member) || String(member).includes(":"));
  };
  assert.deepEqual(members("7:a.b"), [store.get("7:a.b")].slice(1));
  assert.equal(tree.find("7:a.b")?.path, "7:a.b");
  assert.equal(members("7:a").length, 1);
});

test("a large island is never asked for everything", () => {
  const open = ["7", "7:proxy", "7:proxy.wsn", "7:proxy.wsn.12", "7:proxy.wsn.12.sensor", "7:proxy.wsn.property", "8:proxy.wsn.5"];
  const patterns = (large: boolean) => wantsOf("7", open, large).map(({ pattern }) => pattern);
  assert.deepEqual(patterns(false), ["7:**"]);
  assert.deepEqual(
    patterns(true).filter((pattern) => pattern.includes("proxy")),
    ["7:proxy.wsn.12.**"],
  );
  assert.ok(patterns(true).every((pattern) => pattern !== "7:**"));
  // What belongs to no device, but nothing as long as a point.
  for (const own of ["*", "*.*", "*.*.*", "*.*.*.*", "*.*.*.*.*"]) assert.ok(patterns(true).includes(`7:${own}`), own);
  assert.ok(!patterns(true).includes("7:*.*.*.*.*.*"));
  const many = Array.from({ length: 1000 }, (_, index) => `7:proxy.wsn.${index}`);
  assert.ok(wantsOf("7", many, true).length < 120);
});

test("keys with odd parts have their place too", () => {
  const { tree } = setUp("7:", "7:..", "7:a:b.c", "7:a");
  assert.equal(tree.find("7")?.count, 4);
  assert.equal(tree.find("7:a:b.c")?.tuple?.key, "a:b.c");
  assert.equal(tree.find("7:..")?.tuple?.key, "..");
});

test("the paths around a tuple are its owner and the branches above it", () => {
  assert.deepEqual(pathsAbove("7:a.b.c"), ["7", "7:a", "7:a.b"]);
  assert.deepEqual(pathsAbove("7:a"), ["7"]);
  assert.deepEqual(pathsAbove("7"), []);
});

test("rates come from sequence numbers, also of sets that were merged", () => {
  const { store, tree, set } = setUp("7:a.b", "7:a.c", "7:d");
  set("7:a.b", 1);
  set("7:d", 1);
  const rates = new Rates(store, 0);
  rates.sample(1000);
  for (let second = 1; second <= 30; second++) {
    set("7:a.b", 1 + 20 * second);
    rates.sample(1000 + 1000 * second);
  }
  tree.takeRates(rates);
  const tuple = store.get("7:a.b");
  assert.ok(tuple);
  assert.ok(Math.abs(rates.of(tuple) - 20) < 0.1, String(rates.of(tuple)));
  assert.equal(tree.find("7")?.rate, rates.of(tuple));
  assert.equal(tree.find("7:d")?.rate, 0);
  assert.deepEqual(
    rates.top(5).map((top) => top.tuple.id),
    ["7:a.b"],
  );
  for (let second = 0; second < 40; second++) rates.sample(40_000 + 1000 * second);
  tree.takeRates(rates);
  assert.equal(tree.find("7")?.rate, 0);
});

test("what was set while the line was lost is no rate of the second after it", () => {
  const { store, set } = setUp("7:a");
  const rates = new Rates(store, 0);
  const tuple = store.get("7:a");
  assert.ok(tuple);
  for (let second = 1; second <= 30; second++) {
    set("7:a", second);
    rates.sample(1000 * second);
  }
  rates.interrupt();
  for (let second = 31; second < 90; second++) rates.sample(1000 * second);
  set("7:a", 90);
  rates.sample(90_000);
  set("7:a", 91);
  rates.sample(91_000);
  assert.ok(rates.of(tuple) <= 1, String(rates.of(tuple)));
});

test("the order by rate stays until it is asked for again", () => {
  const { store, tree, set } = setUp("7:a", "7:b");
  const rates = new Rates(store, 0);
  const order = () => tree.rows(new Set(["7"]), "rate", [...tree.owners.values()]).map(({ branch }) => branch.part);
  set("7:b", 1);
  rates.sample(1000);
  set("7:b", 100);
  rates.sample(2000);
  tree.takeRates(rates);
  assert.deepEqual(order(), ["7", "a", "b"]);
  tree.rank();
  assert.deepEqual(order(), ["7", "b", "a"]);
});
