import assert from "node:assert/strict";
import { test } from "node:test";
import { Catalog } from "../src/core/catalog";
import { PlottedPoints } from "../src/core/plotted";
import { Store } from "../src/core/store";

const path = "7:proxy.wsn.3.sensor.light-1";

function setUp() {
  const store = new Store(() => {});
  let time = 0;
  const points = new PlottedPoints(new Catalog(store), store, () => time);
  const put = (leaf: string, at: number, value: string) => {
    const tuple = store.get(`${path}.${leaf}`) ?? store.hold(`${path}.${leaf}`);
    assert.ok(tuple);
    store.set(tuple, value, 1, at);
    time = Math.max(time, at);
    const [one] = points.of([path]);
    assert.ok(one);
    points.take(one, leaf, tuple, true);
    return one.track;
  };
  const island = store.hold("7:proxy.island");
  assert.ok(island);
  store.set(island, '{"id":7,"name":"home"}', 1, 1);
  return { points, put, wait: (seconds: number) => (time += seconds) };
}

test("a point keeps its curve while others come and go, and learns what it is later", () => {
  const { points, put } = setUp();
  put("value", 10, "310");
  const [before] = points.of([path, "7:proxy.wsn.3.sensor.other-1"]);
  put("description", 11, '{"data_type":"real"}');
  const [after] = points.of([path]);
  assert.equal(after, before);
  assert.equal(after?.track.at(20)?.value, 310);
  put("description", 12, '{"data_type":"enumeration","words":["on","off"]}');
  points.describe();
  assert.deepEqual([after?.track.kind, after?.words], ["state", ["on", "off"]]);
  points.of([]);
  assert.ok(points.of([path])[0]?.track.empty);
});

test("after a time without the server, an unchanged value was in force all the time, a new one is not", () => {
  const { points, put, wait } = setUp();
  const track = put("value", 10, "310");
  wait(10);
  points.lose();
  assert.ok(track.at(25)?.gap);
  put("value", 10, "310");
  assert.equal(track.at(25)?.value, 310);
  wait(10);
  points.lose(); // at 30
  put("value", 40, "290");
  assert.ok(track.at(35)?.gap);
  assert.equal(track.at(40)?.value, 290);
});

test("what is not known ends where it was known last", () => {
  const { points, put, wait } = setUp();
  const track = put("value", 10, "310");
  wait(5);
  points.endUnknown();
  assert.equal(track.at(15)?.value, 310);
  put("status", 15, '{"quality":"stale"}');
  const [gone] = points.of([path, "7:gone.a.b.sensor.c"]).slice(1);
  assert.ok(gone);
  gone.track.fill({ key: gone.path, kind: "number", t: [3], v: [1] }, 14, 1);
  points.endUnknown();
  assert.ok(track.at(16)?.gap);
  assert.equal(gone.track.at(2), undefined);
  assert.ok(gone.track.at(4)?.gap);
});

test("a value is not known to have held while the device was away", () => {
  const { points, put, wait } = setUp();
  put("status", 5, '{"quality":"good","since":5}');
  const track = put("value", 10, "310");
  wait(10);
  points.lose(); // at 20
  put("status", 30, '{"quality":"good","since":28}');
  put("value", 10, "310");
  assert.ok(track.at(25)?.gap);
  assert.equal(track.at(28)?.value, 310);
});

test("a point is unknown while neither an island nor the history has anything of it", () => {
  const { points, put } = setUp();
  const [one] = points.of([path]);
  assert.ok(one && points.isUnknown(one));
  put("value", 10, "310");
  assert.ok(!points.isUnknown(one));
});
