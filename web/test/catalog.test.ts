import assert from "node:assert/strict";
import { test } from "node:test";
import { Catalog, networkToShow } from "../src/core/catalog";
import { readKey } from "../src/core/keys";
import { Store } from "../src/core/store";
import { alertsIn, placeOf } from "../src/views/overview_facts";

function setUp() {
  const store = new Store(() => {});
  const catalog = new Catalog(store);
  const put = (id: string, value: string) => {
    const known = store.get(id);
    const tuple = known ?? store.hold(id);
    assert.ok(tuple);
    store.set(tuple, value, tuple.sequence + 1, 1);
    return tuple;
  };
  const island = (id: number, prefix = "proxy") => put(`${id}:${prefix}.island`, JSON.stringify({ id, name: "home" }));
  island(7);
  return { store, catalog, put, island };
}

test("keys of points, devices, networks, counters and the inbox differ", () => {
  const meanings: Record<string, string> = {
    "proxy.wsn-1.7.sensor.light-1.value": "point",
    "proxy.wsn-1.7.status": "device",
    "proxy.wsn-1.7.description": "device",
    "proxy.wsn-1.status": "network",
    "proxy.wsn-1.property.line.value": "counter",
    "proxy.inbox.wsn-1.7": "waiting",
    "proxy.inbox": "inbox",
    "proxy.alerts": "alerts",
    "proxy.recorder.day.status": "other",
    "proxy.history.status": "other",
    "proxy.property.clock.value": "other",
    "proxy.settings.status": "other",
    "proxy.island": "other",
    GATEWAY: "other",
    "proxy.wsn-1.7.sensor.light-1.value.more": "other",
    "proxy.wsn-1.7.thing.light-1.value": "other",
    "": "other",
  };
  for (const [key, what] of Object.entries(meanings)) assert.equal(readKey(key).what, what, key);
});

test("a device has its points in order: sensors, actuators, properties, by natural order", () => {
  const { catalog, put } = setUp();
  for (const point of ["property.rate", "actuator.lamp-1", "sensor.light-10", "sensor.light-2"]) put(`7:proxy.wsn.3.${point}.value`, "1");
  const device = catalog.device(7, "wsn", "3");
  assert.deepEqual(
    device?.ordered.map(({ id }) => id),
    ["light-2", "light-10", "lamp-1", "rate"],
  );
});

test("how many points an island has is known from the descriptions of its devices", () => {
  const { store, catalog, put } = setUp();
  const about = (sensors: string[]) => JSON.stringify({ sensors, actuators: ["lamp-1"], properties: ["rate"] });
  put("7:proxy.wsn.3.description", about(["light-1", "light-2"]));
  put("7:proxy.wsn.4.description", about([]));
  put("7:proxy.wsn.5.status", "{}");
  assert.deepEqual(catalog.described.get(7), { devices: 2, points: 6 });
  const last = put("7:proxy.wsn.3.description", about(["light-1"]));
  assert.deepEqual(catalog.described.get(7), { devices: 2, points: 5 });
  store.release(last);
  assert.deepEqual(catalog.described.get(7), { devices: 1, points: 2 });
});

test("what a device is for is known from its description", () => {
  const { catalog, put } = setUp();
  put("7:proxy.zigbee.a.description", JSON.stringify({ capabilities: ["battery", "humidity", "temperature"] }));
  put("7:proxy.zigbee.b.sensor.light-1.value", "1");
  assert.equal(catalog.device(7, "zigbee", "a")?.mainType, "temperature");
  assert.equal(catalog.device(7, "zigbee", "b")?.mainType, "light");
  assert.ok(catalog.device(7, "zigbee", "a")?.offers("humidity"));
  assert.ok(!catalog.device(7, "zigbee", "a")?.offers("light"));
});

test("battery and link quality do not stand for a device that measures something", () => {
  const { catalog, put } = setUp();
  for (const point of ["sensor.battery-1", "sensor.linkQuality-1", "actuator.lamp-1"]) put(`7:proxy.zigbee.a.${point}.value`, "1");
  put("7:proxy.zigbee.b.sensor.battery-1.value", "90");
  assert.equal(catalog.device(7, "zigbee", "a")?.first?.id, "lamp-1");
  assert.equal(catalog.device(7, "zigbee", "b")?.first?.id, "battery-1");
});

test("a device goes with its last tuple, its network too", () => {
  const { store, catalog, put } = setUp();
  const tuples = [put("7:proxy.wsn.3.status", '{"status":"reachable"}'), put("7:proxy.wsn.3.sensor.light-1.value", "1")];
  assert.equal(catalog.networks.get("7/wsn")?.devices, 1);
  for (const tuple of tuples) store.release(tuple);
  assert.equal(catalog.devices.size, 0);
  assert.equal(catalog.networks.size, 0);
});

test("odd descriptions leave a device with what is known of it", () => {
  const { catalog, put } = setUp();
  for (const value of ["", "7", "null", "[]", "{", '{"name":7,"area":null,"model":[],"capabilities":[1,"light","blindPosition"]}']) {
    put("7:proxy.wsn.3.description", value);
    const device = catalog.device(7, "wsn", "3");
    assert.equal(device?.name, "3", value);
    assert.equal(device?.area, "", value);
  }
  assert.equal(catalog.device(7, "wsn", "3")?.model, "light, blind position");
  put("7:proxy.wsn.3.status", '{"status":{},"since":"now"}');
  assert.equal(catalog.device(7, "wsn", "3")?.state, "unknown");
  assert.equal(catalog.device(7, "wsn", "3")?.since, 0);
});

test("the structure changes with devices and descriptions, not with values", () => {
  const { catalog, put } = setUp();
  put("7:proxy.wsn.3.sensor.light-1.value", "1");
  const before = catalog.structure;
  put("7:proxy.wsn.3.sensor.light-1.value", "2");
  assert.equal(catalog.structure, before);
  put("7:proxy.wsn.3.description", '{"name":"Hall"}');
  assert.notEqual(catalog.structure, before);
});

test("a device of two islands is two devices", () => {
  const { catalog, put, island } = setUp();
  island(8);
  put("7:proxy.wsn.3.status", "{}");
  put("8:proxy.wsn.3.status", "{}");
  assert.deepEqual([...catalog.devices.keys()], ["7/wsn/3", "8/wsn/3"]);
});

test("only what an island publishes below its prefix is a device, a line or waits", () => {
  const { catalog, put, island } = setUp();
  for (const name of ["9:robot.arm.status", "9:robot.arm.left.status", "9:robot.inbox.arm.left", "7:house.kitchen.oven.status"])
    put(name, "{}");
  for (const [name, value] of [
    ["9:robot.island", '{"id":7,"name":"arm"}'],
    ["9:robot.island", "idle"],
    ["7:house.island", '{"id":7,"name":"me too"}'],
    ["9:robot.arm.island", '{"id":9,"name":"arm"}'],
  ] as const)
    put(name, value);
  assert.deepEqual([catalog.devices.size, catalog.networks.size, catalog.waiting.size], [0, 0, 0]);
  put("8:flat.wsn.3.status", "{}");
  put("8:flat.inbox.wsn.4", "{}");
  assert.equal(catalog.devices.size, 0);
  island(8, "flat");
  assert.deepEqual([[...catalog.devices.keys()], [...catalog.waiting.keys()]], [["8/wsn/3"], ["8:flat.inbox.wsn.4"]]);
});

test("devices go with their island, and come again with another prefix", () => {
  const { store, catalog, put, island } = setUp();
  put("7:proxy.wsn.3.status", "{}");
  put("7:flat.wsn.4.status", "{}");
  const named = store.get("7:proxy.island");
  assert.ok(named);
  store.release(named);
  assert.deepEqual([catalog.devices.size, catalog.networks.size], [0, 0]);
  island(7, "flat");
  assert.deepEqual([...catalog.devices.keys()], ["7/wsn/4"]);
});

test("what histories say of themselves is known, also of other components than islands, until it goes", () => {
  const { store, catalog, put } = setUp();
  const status = (state: string) => JSON.stringify({ state, reason: "no space left" });
  put("7:proxy.history.status", status("recording"));
  const failing = put("70000:web.history.status", status("failing"));
  assert.deepEqual(
    [...catalog.histories.values()].map(({ json }) => json.state),
    ["recording", "failing"],
  );
  assert.equal(catalog.networks.size, 0);
  store.release(failing);
  assert.equal(catalog.histories.size, 1);
});

test("alerts of all islands or one, problems first, each with the view it leads to", () => {
  const { catalog, put, island } = setUp();
  const list = (...alerts: object[]) => JSON.stringify({ alerts, more: 2 });
  put("7:proxy.wsn.3.status", "{}");
  put("7:proxy.wsn.status", "{}");
  put(
    "7:proxy.alerts",
    list(
      { about: "proxy.wsn.3.sensor.battery-1", severity: "warning", what: "low" },
      { about: "proxy", severity: "problem", what: "clock" },
    ),
  );
  island(8);
  put("8:proxy.alerts", list({ about: "proxy.wsn", severity: "problem", since: 9, what: "down", fix: "look" }, 3 as never));
  put("70000:proxy.alerts", list({ what: "of no island" }));
  const { alerts, more } = alertsIn(catalog, 0);
  assert.deepEqual([alerts.map(({ what }) => what), more], [["clock", "down", "low"], 4]);
  assert.deepEqual(alertsIn(catalog, 8).alerts, [{ owner: 8, about: "proxy.wsn", problem: true, since: 9, what: "down", fix: "look" }]);
  const places = alertsIn(catalog, 7).alerts.map((alert) => placeOf(catalog, alert));
  assert.deepEqual(places, [null, { view: "devices", path: ["7", "wsn", "3"] }]);
  assert.deepEqual(placeOf(catalog, { ...alerts[2]!, about: "proxy.wsn" }), { view: "networks", path: ["7/wsn"] });
});

test("of several networks the first whose line is up is shown, unless one is named", () => {
  const { catalog, put } = setUp();
  const lines = { a: "down", b: "up", c: "up" };
  for (const [id, line] of Object.entries(lines)) put(`7:proxy.wsn-${id}.status`, JSON.stringify({ line }));
  const networks = [...catalog.networks.values()];
  assert.equal(networkToShow(networks, undefined)?.id, "wsn-b");
  assert.equal(networkToShow(networks, "7/wsn-a")?.id, "wsn-a");
  assert.equal(networkToShow(networks, "7/gone")?.id, "wsn-b");
  assert.equal(networkToShow(networks.slice(0, 1), undefined)?.id, "wsn-a");
  assert.equal(networkToShow([], undefined), undefined);
});
