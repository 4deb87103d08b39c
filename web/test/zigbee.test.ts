import assert from "node:assert/strict";
import { test } from "node:test";
import { mapOf, Pairing } from "../src/core/zigbee";

test("a device that joins is told as far as it got, a failed one with the reason", () => {
  const pairing = new Pairing("1", 100);
  pairing.take({ event: "joined", address: "a1", name: "0xa1" });
  pairing.take({ event: "interviewing", address: "a1", name: "0xa1" });
  pairing.take({ event: "interviewed", address: "a1", name: "0xa1", vendor: "Innr", model: "SP 120" });
  pairing.take({ event: "announced", address: "a1" });
  pairing.take({ event: "joined", address: "b2" });
  pairing.take({ event: "failed", address: "b2", why: "too far away" });
  assert.deepEqual(
    [...pairing.joins.values()],
    [
      { address: "a1", name: "0xa1", model: "Innr SP 120", state: "interviewed", why: "" },
      { address: "b2", name: "b2", model: "", state: "failed", why: "too far away" },
    ],
  );
  assert.equal(pairing.until, 100);
  pairing.take({ event: "closed", why: "the bridge is gone" });
  assert.deepEqual([pairing.until, pairing.why], [0, "the bridge is gone"]);
});

test("the map is a tree of the fewest hops, of those the best links", () => {
  const nodes = [
    { address: "c", name: "Coordinator", role: "Coordinator" },
    { address: "r", name: "plug", role: "Router" },
    { address: "e", name: "door", role: "EndDevice" },
    { address: "x", name: "lost", role: "EndDevice", failed: ["lqi"] },
  ];
  const links = [
    { source: "r", target: "c", quality: 200 },
    { source: "c", target: "r", quality: 90 },
    { source: "e", target: "r", quality: 120 },
    { source: "e", target: "nobody", quality: 255 },
  ];
  const map = mapOf(nodes, links);
  const at = (address: string) => map.nodes.find((node) => node.address === address) ?? { x: NaN, y: NaN };
  assert.deepEqual(
    ["c", "r", "e", "x"].map((address) => [at(address).x, at(address).y]),
    [
      [0, 15],
      [150, 0],
      [300, 0],
      [150, 30], // nobody reaches it: behind the coordinator all the same
    ],
  );
  assert.deepEqual(
    map.links.map(({ from, to, quality, way }) => [from.address, to.address, quality, way]),
    [
      ["r", "c", 200, true],
      ["e", "r", 120, true],
    ],
  );
  assert.deepEqual([map.width, map.height], [450, 60]);
});

test("a map of nothing is empty", () => {
  assert.deepEqual(mapOf([], []).nodes, []);
});
