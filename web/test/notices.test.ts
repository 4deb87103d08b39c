import assert from "node:assert/strict";
import { test } from "node:test";
import { announce, notices, notify, spoken } from "../src/parts/notices";

/** Calls that wait for a time. */
function caught(run: () => void): (() => void)[] {
  const calls: (() => void)[] = [];
  const real = globalThis.setTimeout;
  globalThis.setTimeout = ((call: () => void) => calls.push(call)) as unknown as typeof setTimeout;
  try {
    run();
  } finally {
    globalThis.setTimeout = real;
  }
  return calls;
}

test("what went wrong, and what asks for something, stays until it is closed", () => {
  const calls = caught(() => {
    notify("saved", "good");
    notify("the network refuses", "bad");
    notify("another release", "waiting", { label: "Reload the page", run: () => undefined });
  });
  for (const call of calls) call();
  assert.deepEqual(
    notices.value.map(({ text }) => text),
    ["the network refuses", "another release"],
  );
});

test("the same text twice is another text for screen readers", () => {
  announce("refused");
  const first = spoken.value;
  announce("refused");
  assert.notEqual(spoken.value, first);
  assert.equal(spoken.value.trim(), "refused");
  announce("refused");
  assert.equal(spoken.value, first);
});
