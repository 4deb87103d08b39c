import assert from "node:assert/strict";
import { test } from "node:test";
import type { Message } from "../src/core/frames";
import { kept } from "../src/core/traffic";
import { Watch } from "../src/core/watch";
import { TestClock } from "./support";

function setUp() {
  const clock = new TestClock();
  const calls = new Map<string, (message: Message) => void>();
  const at = { live: true, hidden: false, requests: 0, said: "" };
  const watch = new Watch(7, "knx", "knx", clock, {
    listen(type, call) {
      calls.set(type, call);
      return () => calls.delete(type);
    },
    send: () => at.requests++,
    live: () => at.live,
    hidden: () => at.hidden,
    changed: () => {},
    refused: (why) => (at.said = why),
    ended: () => (at.said = "ended"),
  });
  const say = (type: string, value: string, network = "knx") => calls.get(type)?.({ from: 7, network, type, value });
  return { clock, watch, at, say, calls };
}

test("a watch goes on without a view: it renews itself and takes what passes", () => {
  const { clock, watch, at, say } = setUp();
  watch.start();
  watch.start();
  clock.advance(120_000);
  assert.equal(at.requests, 5);
  for (let count = 0; count < 3; count++) say("knx.telegram", '{"address":"1/0/1"}');
  say("knx.telegram", '{"address":"1/0/2"}', "knx-hall");
  say("knx.telegram", "no JSON");
  clock.advance(200);
  assert.deepEqual(
    watch.passing.map(({ to }) => to),
    ["1/0/1", "1/0/1", "1/0/1"],
  );
});

test("a watch ends when the page is hidden for longer than the lease, not when the line is lost", () => {
  const { clock, watch, at, calls } = setUp();
  watch.start();
  at.live = false;
  clock.advance(300_000);
  assert.ok(watch.running);
  assert.equal(at.requests, 1);
  at.live = true;
  watch.renew();
  assert.equal(at.requests, 2);
  at.hidden = true;
  clock.advance(80_000);
  assert.deepEqual([watch.running, at.said, calls.size], [false, "ended", 0]);
});

test("a watch says what it missed while the machine slept or the line was lost", () => {
  const { clock, watch, at } = setUp();
  watch.start();
  clock.advance(50_000);
  assert.equal(watch.missed, null);
  clock.sleep(300_000);
  clock.advance(0);
  assert.deepEqual(watch.missed, { from: 110, to: 350 });
  at.live = false;
  watch.interrupt();
  clock.advance(10_000);
  at.live = true;
  watch.renew();
  assert.deepEqual(watch.missed, { from: 350, to: 360 });
  watch.stop();
  watch.start();
  assert.equal(watch.missed, null);
});

test("a watch that the network refuses ends with the reason", () => {
  const { watch, at, say } = setUp();
  watch.start();
  say("knx.reply", '{"id":"page","ok":true,"line":false}');
  say("knx.reply", '{"id":"other","ok":false,"why":"busy"}');
  assert.ok(watch.running);
  say("knx.reply", '{"id":"page","ok":false,"why":"busy"}');
  assert.deepEqual([watch.running, at.said], [false, "busy"]);
});

test("rows stay longer while the user reads", () => {
  const { clock, watch, say } = setUp();
  watch.start();
  const pass = (count: number) => {
    for (let one = 0; one < count; one++) say("knx.telegram", '{"address":"1/0/1"}');
    clock.advance(200);
  };
  pass(10);
  watch.reading = true;
  const first = watch.passing[0];
  pass(kept);
  assert.equal(watch.passing[0], first);
  watch.reading = false;
  pass(1);
  assert.equal(watch.passing.length, kept);
});
