import assert from "node:assert/strict";
import { test } from "node:test";
import { Connection } from "../src/core/connection";
import { Feed } from "../src/core/feed";
import { Store } from "../src/core/store";
import { TestClock, TestServer } from "./support";

const lamp = "7:proxy.knx.lamp.actuator.switch-1.value";
const door = "7:proxy.knx.door.sensor.contact-1.value";

function setUp() {
  const clock = new TestClock();
  const server = new TestServer();
  const store = new Store(() => {});
  const connection: Connection = new Connection(server.open, clock, {
    state: (state) => (state === "live" ? feed.connected() : feed.disconnected()),
    frame: (frame) => feed.take(frame),
  });
  const feed: Feed = new Feed(
    store,
    () => connection,
    clock,
    () => {},
  );
  connection.start();
  server.last.events.opened();
  const verbs = () => server.last.sent.map((request) => request.do);
  const reconnect = () => {
    server.last.events.closed();
    clock.advance(250);
    server.last.events.opened();
  };
  return { clock, server, store, connection, feed, verbs, reconnect };
}

function answerLast(server: TestServer, subscription: number): void {
  server.say({ id: server.last.sent[server.last.sent.length - 1]?.id, ok: true, subscription });
}

test("equal wants share a subscription, passive unless the want is active", () => {
  const { server, feed } = setUp();
  feed.want({ pattern: "7:**" });
  feed.want({ pattern: "7:**" });
  feed.want({ pattern: "7:**", active: true, min: 100 });
  assert.deepEqual(server.last.sent, [
    { id: 1, do: "subscribe", pattern: "7:**", min: 50, passive: true },
    { id: 2, do: "subscribe", pattern: "7:**", min: 100, active: true },
  ]);
});

test("numbers stand for the keys that introduced them", () => {
  const { server, store, feed } = setUp();
  const subscription = feed.want({ pattern: "7:**" });
  answerLast(server, 4);
  server.say({ s: 4, k: { "0": lamp }, set: [[0, "on", 3, 100.5]] });
  server.say({ s: 4, set: [[0, "off", 4, 101.5]] });
  assert.equal(store.get(lamp)?.value, "off");
  assert.equal(store.get(lamp)?.sequence, 4);
  assert.equal(subscription.complete([7]), false);
  server.say({ s: 4, snapshot: 7 });
  assert.equal(subscription.complete([7]), true);
  assert.equal(subscription.complete([7, 8]), true);
});

test("a subscription to all owners is complete when each known island has sent its snapshot", () => {
  const { server, feed } = setUp();
  const subscription = feed.want({ pattern: "*:**" });
  assert.equal(subscription.complete([]), false);
  answerLast(server, 1);
  assert.equal(subscription.complete([]), true);
  server.say({ s: 1, snapshot: 7 });
  assert.equal(subscription.complete([7, 8]), false);
  server.say({ s: 1, snapshot: 8 });
  assert.equal(subscription.complete([7, 8]), true);
});

test("a number that became free names another key", () => {
  const { server, store, feed } = setUp();
  feed.want({ pattern: "7:**" });
  answerLast(server, 1);
  server.say({ s: 1, k: { "0": lamp }, set: [[0, "on", 1, 1]] });
  server.say({ s: 1, gone: [[0, "deleted"]] });
  assert.equal(store.get(lamp), undefined);
  server.say({ s: 1, k: { "0": door }, set: [[0, "open", 1, 1]] });
  assert.equal(store.get(door)?.value, "open");
  assert.equal(store.tuples.size, 1);
});

test("a tuple lives as long as one subscription holds it", () => {
  const { clock, server, store, feed } = setUp();
  const all = feed.want({ pattern: "7:**" });
  answerLast(server, 1);
  feed.want({ pattern: lamp });
  answerLast(server, 2);
  server.say({ s: 1, k: { "0": lamp }, set: [[0, "on", 1, 1]] });
  server.say({ s: 2, k: { "0": lamp }, set: [[0, "on", 1, 1]] });
  feed.drop(all);
  clock.advance(10_000);
  assert.deepEqual(server.last.sent[2], { id: 3, do: "unsubscribe", subscription: 1 });
  assert.equal(store.get(lamp)?.value, "on");
  server.say({ s: 2, gone: [[0, "expired"]] });
  assert.equal(store.tuples.size, 0);
});

test("a subscription outlives its view a while, demand does not", () => {
  const { clock, feed, server, verbs } = setUp();
  const seen = feed.want({ pattern: "7:a" });
  answerLast(server, 1);
  feed.drop(seen);
  clock.advance(9_000);
  assert.equal(feed.want({ pattern: "7:a" }), seen);
  const woken = feed.want({ pattern: "7:a", active: true });
  answerLast(server, 2);
  feed.drop(woken);
  clock.advance(0);
  assert.deepEqual(verbs(), ["subscribe", "subscribe", "unsubscribe"]);
});

test("after a reconnection the old tuples stay until the snapshot shows what is there", () => {
  const { server, store, feed, reconnect } = setUp();
  feed.want({ pattern: "7:**" });
  answerLast(server, 1);
  server.say({
    s: 1,
    k: { "0": lamp, "1": door },
    set: [
      [0, "on", 9, 1],
      [1, "open", 9, 1],
    ],
  });
  const before = store.get(lamp);
  reconnect();
  assert.equal(store.get(door)?.value, "open");
  answerLast(server, 1);
  server.say({ s: 1, k: { "0": lamp }, set: [[0, "off", 1, 2]] });
  assert.equal(store.get(lamp), before);
  server.say({ s: 1, snapshot: 7 });
  assert.equal(store.get(lamp)?.value, "off");
  assert.equal(store.get(door), undefined);
});

test("tuples of an owner that did not come back go after a while", () => {
  const { clock, server, store, feed, reconnect } = setUp();
  feed.want({ pattern: "*:**" });
  answerLast(server, 1);
  server.say({ s: 1, k: { "0": lamp }, set: [[0, "on", 9, 1]] });
  reconnect();
  answerLast(server, 1);
  clock.advance(5_000);
  assert.equal(store.tuples.size, 0);
});

test("a hidden page has no subscriptions and gets them again when it is shown", () => {
  const { server, store, feed, verbs } = setUp();
  feed.want({ pattern: "7:**" });
  answerLast(server, 1);
  server.say({ s: 1, k: { "0": lamp }, set: [[0, "on", 9, 1]] });
  feed.hide(true);
  server.say({ s: 1, set: [[0, "off", 10, 2]] });
  assert.equal(store.get(lamp)?.value, "on");
  feed.hide(false);
  assert.deepEqual(verbs(), ["subscribe", "unsubscribe", "subscribe"]);
  answerLast(server, 2);
  server.say({ s: 2, k: { "0": lamp }, set: [[0, "off", 10, 2]] });
  assert.equal(store.get(lamp)?.value, "off");
});

test("an answer that comes after the page was hidden ends that subscription", () => {
  const { server, feed } = setUp();
  feed.want({ pattern: "7:**" });
  feed.hide(true);
  server.say({ id: 1, ok: true, subscription: 5 });
  assert.deepEqual(server.last.sent[1], { id: 2, do: "unsubscribe", subscription: 5 });
});

test("a refused subscription says why", () => {
  const { server, feed } = setUp();
  const subscription = feed.want({ pattern: "7:**" });
  server.say({ id: 1, ok: false, error: { code: "refused", text: "no role" } });
  assert.equal(subscription.state, "failed");
  assert.equal(subscription.error?.text, "no role");
});

test("a brief subscription ends with its last user", () => {
  const { clock, feed, server, verbs } = setUp();
  const row = feed.want({ pattern: "7:a.*", brief: true });
  answerLast(server, 1);
  feed.drop(row);
  clock.advance(0);
  assert.deepEqual(verbs(), ["subscribe", "unsubscribe"]);
});

test("what the server was too busy for is asked again, as long as it is wanted", () => {
  const { clock, server, feed } = setUp();
  const busy = (id: unknown) => server.say({ id, ok: false, error: { code: "busy", text: "256 subscriptions" } });
  const wanted = feed.want({ pattern: "7:a.*" });
  const left = feed.want({ pattern: "7:b.*", brief: true });
  for (const { id } of [...server.last.sent]) busy(id);
  assert.equal(wanted.state, "failed");
  feed.drop(left);
  clock.advance(3_000);
  assert.equal(server.last.sent.length, 3);
  answerLast(server, 4);
  assert.equal(wanted.state, "loading");
  assert.equal(wanted.error, null);
  clock.advance(10_000);
  assert.equal(server.last.sent.length, 3);
});

test("the user can ask again for what failed", () => {
  const { server, feed } = setUp();
  const failed = feed.want({ pattern: "7:a.*" });
  feed.want({ pattern: "7:b.*" });
  server.say({ id: 1, ok: false, error: { code: "failed", text: "" } });
  server.say({ id: 2, ok: true, subscription: 2 });
  feed.retry();
  assert.equal(server.last.sent.length, 3);
  answerLast(server, 3);
  assert.equal(failed.state, "loading");
});

test("an owner that is absent is marked", () => {
  const { server, store, feed } = setUp();
  feed.want({ pattern: "7:**", full: true });
  answerLast(server, 1);
  server.say({ s: 1, k: { "0": lamp }, set: [[0, "on", 9, 1, { m: "text/plain", c: 7, w: 1, e: 0, p: true }]] });
  server.say({ s: 1, absent: [7] });
  assert.equal(store.get(lamp)?.present, false);
  server.say({ s: 1, present: [7] });
  assert.equal(store.get(lamp)?.present, true);
  assert.equal(store.get(lamp)?.media, "text/plain");
});

test("a key without an owner, and numbers without a key, harm nothing", () => {
  const { server, store, feed } = setUp();
  feed.want({ pattern: "7:**" });
  answerLast(server, 1);
  server.say({
    s: 1,
    k: { "0": "no owner", "1": ":x", "2": "x:y", "3": lamp },
    set: [
      [0, "a", 1, 1],
      [9, "b", 1, 1],
      [3, "on", 1, 1],
    ],
  });
  server.say({ s: 1, gone: [[8, "deleted"]] });
  server.say({ s: 99, k: { "0": door }, set: [[0, "open", 1, 1]] });
  assert.deepEqual([...store.tuples.keys()], [lamp]);
});
