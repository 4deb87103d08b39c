import assert from "node:assert/strict";
import { test } from "node:test";
import { OneAtATime } from "../src/core/one_at_a_time";

const turn = () => new Promise((done) => setTimeout(done, 0));

test("each piece of work ends, and what was asked for meanwhile is done once", async () => {
  const started: (() => void)[] = [];
  const work = new OneAtATime(() => new Promise((done) => started.push(done)));
  for (let asked = 0; asked < 5; asked++) work.ask();
  assert.equal(started.length, 1);
  started[0]?.();
  await turn();
  assert.equal(started.length, 2);
  started[1]?.();
  await turn();
  assert.equal(started.length, 2);
  work.ask();
  work.ask();
  work.end();
  started[2]?.();
  await turn();
  assert.equal(started.length, 3);
});
