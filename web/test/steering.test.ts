import assert from "node:assert/strict";
import { test } from "node:test";
import { Network } from "../src/core/catalog";
import { findLines } from "../src/core/find_lines";
import { commandOf, formatOffset, readSeek, replayOf } from "../src/core/replay";
import { Tuple } from "../src/core/store";

function network(values: Record<string, string>): Network {
  const made = new Network(6541, "proxy", "log-1");
  for (const [name, value] of Object.entries(values)) {
    const tuple = new Tuple(`6541:proxy.log-1.property.${name}.value`, 6541, `proxy.log-1.property.${name}.value`);
    tuple.value = value;
    made.counters.set(name, tuple);
  }
  return made;
}

test("a network that plays a recording, by time or by offset", () => {
  assert.equal(replayOf(network({ readings: "3" })), null);
  const absolute = replayOf(
    network({ "replay-state": "playing", "replay-position": "1795369403.5", "replay-begin": "1795360000", "replay-speed": "max" }),
  );
  assert.ok(absolute?.absolute);
  assert.equal(absolute?.speed, "max");
  assert.ok(Number.isNaN(absolute?.end));
  const offset = replayOf(network({ "replay-state": "paused", "replay-position": "90.250", "replay-end": "3600" }));
  assert.ok(!offset?.absolute);
  assert.deepEqual([offset?.begin, offset?.position, offset?.end], [0, 90.25, 3600]);
  assert.equal(commandOf(network({}), "speed"), "6541:proxy.log-1.property.replay-speed.command");
});

test("positions as people write and read them", () => {
  assert.equal(formatOffset(3723.4), "1:02:03");
  for (const good of ["90s", "1.5h", "+30s", "-30s", "1795369403", "2026-01-31T12:00:00Z"]) assert.equal(readSeek(` ${good} `), good);
  for (const bad of ["", "soon", "30 fortnights"]) assert.equal(readSeek(bad), "");
});

test("lines are found with those that they belong to", () => {
  const yaml = "island:\n  id: 1\nnetworks:\n  knx:\n    type: knx\n    host: here\n\n  wsn:\n    type: wsn\n    host: there\n";
  assert.deepEqual(
    findLines(yaml, "THERE").map(({ number }) => number),
    [3, 8, 10],
  );
  assert.deepEqual(
    findLines(yaml, "knx").map(({ text }) => text.trim()),
    ["networks:", "knx:", "type: knx"],
  );
  assert.equal(findLines(yaml, "").length, 10);
  assert.equal(findLines(yaml, "nothing").length, 0);
});
