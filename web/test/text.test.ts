import assert from "node:assert/strict";
import { test } from "node:test";
import listed from "../../tests/cases/order/ids.txt";
import { compareNatural } from "../src/core/text";

const ids = listed.trim().split("\n");

test("numbers count as numbers, in any case", () => {
  assert.deepEqual(["b", "a10", "A2"].sort(compareNatural), ["A2", "a10", "b"]);
});

test("ids have the order that the programs give them", () => {
  assert.ok(ids.length > 20);
  assert.deepEqual([...ids].reverse().sort(compareNatural), ids);
});

test("the order of ids is an order", () => {
  for (const [i, a] of ids.entries()) {
    for (const [j, b] of ids.entries()) assert.equal(Math.sign(compareNatural(a, b)), Math.sign(i - j), `${a} ${b}`);
  }
});

test("an address is one in any case", () => {
  assert.equal(compareNatural("0x00124B001000000A", "0x00124b001000000a"), 0);
  assert.ok(compareNatural("0x00124B001000000A", "0x00124b0010000010") < 0);
});
