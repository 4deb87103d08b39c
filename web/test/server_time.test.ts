import assert from "node:assert/strict";
import { test } from "node:test";
import { ServerTime } from "../src/core/server_time";

test("times are those of the server, as exactly as its answers show them", () => {
  let local = 1000;
  const time = new ServerTime(() => local);
  time.heard(1000, 1001, 999.9); // a clock that agrees is left alone
  assert.equal(time.now(), 1000);
  time.heard(1600, 1601, 999.9); // the browser is ten minutes behind
  assert.equal(time.now(), 1600);
  local += 10;
  time.heard(1610.4, 1612.4, 1010);
  assert.equal(time.now(), 1610.4);
  local += 600; // the browser's clock is set right
  time.heard(1611, 1612, 1609.9);
  assert.ok(Math.abs(time.now() - 1611) <= 1.1, String(time.now()));
});
