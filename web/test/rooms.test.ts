import assert from "node:assert/strict";
import { test } from "node:test";
import { Catalog, type Device } from "../src/core/catalog";
import { tellFact } from "../src/core/facts";
import { arrangedIn, givenName, moved, pinOf, toggled } from "../src/core/overview";
import { roomsOf, tilesOfDevice } from "../src/core/rooms";
import { Store } from "../src/core/store";
import * as words from "../src/words/overview";

function setUp() {
  const store = new Store(() => {});
  const catalog = new Catalog(store);
  const put = (key: string, value: string | Record<string, unknown>) => {
    const tuple = store.get(`7:proxy.${key}`) ?? store.hold(`7:proxy.${key}`);
    assert.ok(tuple);
    store.set(tuple, typeof value === "string" ? value : JSON.stringify(value), 1, 1);
  };
  put("island", { id: 7, name: "home" });
  /** A device with its points: `sensor.temperature-1` to its value. */
  const device = (id: string, area: string, points: Record<string, string>, about: Record<string, unknown> = {}): Device => {
    put(`net.${id}.description`, { name: id, area });
    put(`net.${id}.status`, { status: "reachable" });
    for (const [point, value] of Object.entries(points)) {
      put(`net.${id}.${point}.value`, value);
      const access = point.startsWith("actuator") ? "read-write" : "read";
      const type = point.replace(/^.*\.|-.*$/g, "");
      put(`net.${id}.${point}.description`, { type, data_type: "real", access, ...about });
      put(`net.${id}.${point}.status`, { quality: "good" });
    }
    const found = catalog.device(7, "net", id);
    assert.ok(found);
    return found;
  };
  return { store, catalog, put, device };
}

/** All of one room. */
function roomOf(...devices: Device[]) {
  const [room] = roomsOf(devices, []);
  assert.ok(room);
  return room;
}

test("rooms come in the order that people gave, then by name, then networks of devices without one", () => {
  const { catalog, device } = setUp();
  for (const [id, area] of [
    ["a", "Attic"],
    ["b", "Kitchen"],
    ["c", "Hall"],
    ["d", ""],
    ["e", "Kitchen"],
  ] as const)
    device(id, area, {});
  const rooms = roomsOf(catalog.devices.values(), ["Kitchen", "Gone"]);
  assert.deepEqual(
    rooms.map(({ name, placed }) => [name, placed]),
    [
      ["Kitchen", true],
      ["Attic", true],
      ["Hall", true],
      ["net", false],
    ],
  );
  assert.deepEqual(
    rooms[0]?.devices.map(({ id }) => id),
    ["b", "e"],
  );
});

test("of several measurements a room tells the span, of several doors how many are open", () => {
  const { device } = setUp();
  const tell = (...devices: Device[]) => {
    const [fact] = roomOf(...devices).facts;
    assert.ok(fact);
    return tellFact(fact, words.some);
  };
  const doors = { data_type: "boolean", words: ["closed", "open"] };
  const [one, two] = [device("one", "", { "sensor.temperature-1": "20.449" }), device("two", "", { "sensor.temperature-1": "19" })];
  assert.equal(tell(one).value, "20.4");
  assert.equal(tell(one, two).value, "19 – 20.4");
  const open = device("x", "", { "sensor.contact-1": "open" }, doors);
  const closed = device("y", "", { "sensor.contact-1": "closed" }, doors);
  assert.equal(tell(open).value, "open");
  assert.equal(tell(open, closed).value, "1 of 2 open");
  assert.equal(tell(closed, device("z", "", { "sensor.contact-1": "closed" }, doors)).value, "all closed");
  assert.equal(tell(device("m", "", { "sensor.motion-1": "on" }, { data_type: "boolean" })).value, "yes");
});

test("a value that is not good counts only where there is no good one, and says so", () => {
  const { put, device } = setUp();
  const [old, good] = [device("old", "", { "sensor.temperature-1": "5" }), device("new", "", { "sensor.temperature-1": "21" })];
  put("net.old.sensor.temperature-1.status", { quality: "stale" });
  const tell = (...devices: Device[]) => tellFact(roomOf(...devices).facts[0] ?? { type: "", points: [] }, words.some);
  assert.deepEqual(tell(old, good), { value: "21", unit: "", quality: "good" });
  assert.deepEqual(tell(old), { value: "5", unit: "", quality: "stale" });
});

test("what belongs together is operated together, lamps before blinds before heating", () => {
  const { device } = setUp();
  const plain = device("a", "", { "actuator.temperatureSetpoint-1": "20", "actuator.blindMove-1": "", "actuator.blindPosition-1": "0" });
  const lamps = device("b", "", { "actuator.lamp-1": "on", "actuator.dimmer-1": "5", "actuator.lamp-2": "off", "actuator.effect-1": "" });
  const lines = roomOf(plain, lamps).tiles.map(({ kind, device: { id }, instance, points }) => [kind, id, instance, [...points.keys()]]);
  assert.deepEqual(lines, [
    ["light", "b", "1", ["dimmer", "lamp"]],
    ["light", "b", "2", ["lamp"]],
    ["blind", "a", "1", ["blindMove", "blindPosition"]],
    ["thermostat", "a", "1", ["temperatureSetpoint"]],
  ]);
  assert.equal(tilesOfDevice(device("c", "", { "actuator.lamp-ceiling": "on" }))[0]?.instance, "", "the only one needs no number");
  assert.deepEqual(tilesOfDevice(device("d", "", { "sensor.lamp-1": "on" })), [], "what cannot be set is not operated");
});

test("a network of very many devices without rooms is no room to look at", () => {
  const { device } = setUp();
  const many = Array.from({ length: 201 }, (_, id) => device(`d${id}`, "", { "sensor.temperature-1": "20" }));
  assert.deepEqual(roomOf(...many).facts, []);
  assert.equal(roomOf(...many.slice(1)).facts.length, 1);
});

test("what people arranged is read as it is, odd parts of it as missing", () => {
  const { store, put, device } = setUp();
  const point = device("a", "", { "sensor.light-1": "1" }).points.get("sensor.light-1");
  assert.ok(point);
  put("overview", { rooms: ["Hall", 7], pins: "none", names: { "net.a.sensor.light-1": "Window", "net.a.sensor.x": 7 } });
  const tuple = store.get("7:proxy.overview");
  assert.deepEqual(arrangedIn(tuple), { rooms: ["Hall"], pins: [] });
  assert.equal(pinOf(point), "net.a.sensor.light-1");
  assert.equal(givenName(tuple, point), "Window");
  assert.equal(givenName(undefined, point), "");
});

test("a member of a list is moved within it, and is in it or not", () => {
  assert.deepEqual(moved(["a", "b", "c"], "c", -1), ["a", "c", "b"]);
  assert.deepEqual(moved(["a", "b", "c"], "a", 1), ["b", "a", "c"]);
  assert.deepEqual(moved(["a", "b"], "a", -1), ["a", "b"]);
  assert.deepEqual(moved(["a", "b"], "x", 1), ["a", "b"]);
  assert.deepEqual(toggled(["a"], "b"), ["a", "b"]);
  assert.deepEqual(toggled(["a", "b"], "a"), ["b"]);
});
