import assert from "node:assert/strict";
import { test } from "node:test";
import { burst, type Decision, Decisions, graceTime, matchesPattern, type Step } from "../src/core/decisions";
import type { Answer } from "../src/core/frames";
import { TestClock } from "./support";

function inbox() {
  const clock = new TestClock();
  const sent: { step: Step; call: (answer: Answer) => void }[] = [];
  const ended: { decision: Decision; failures: number }[] = [];
  const decisions = new Decisions(clock, {
    send: (step, call) => sent.push({ step, call }),
    changed: () => {},
    ended: (decision, failures) => ended.push({ decision, failures: failures.length }),
  });
  const approve = (...keys: string[]) =>
    decisions.decide(
      "approve",
      keys,
      keys.map((key) => ({ key, value: "approve" })),
    );
  return { clock, sent, ended, decisions, approve };
}

test("a decision can be taken back for ten seconds, and is sent then", () => {
  const { clock, sent, decisions, approve, ended } = inbox();
  const first = approve("1:a");
  const second = approve("1:b");
  clock.advance(graceTime - 1);
  assert.ok(decisions.undo(first));
  assert.equal(decisions.of("1:a"), undefined);
  assert.equal(decisions.of("1:b"), second);
  assert.equal(sent.length, 0);
  clock.advance(1);
  assert.deepEqual(
    sent.map(({ step }) => step),
    [{ key: "1:b", value: "approve" }],
  );
  assert.ok(!decisions.undo(second));
  assert.equal(decisions.of("1:b"), second);
  sent[0]?.call({ id: 1, ok: true });
  assert.equal(decisions.of("1:b"), undefined);
  assert.equal(ended[0]?.failures, 0);
});

test("many are sent no faster than the server takes them, and failures are collected", () => {
  const { clock, sent, ended, approve } = inbox();
  approve(...Array.from({ length: 45 }, (_, index) => `1:${index}`));
  clock.advance(graceTime);
  assert.equal(sent.length, 20);
  clock.advance(600);
  assert.equal(sent.length, 40);
  clock.advance(600);
  assert.equal(sent.length, 45);
  sent.forEach(({ call }, index) => call(index < 2 ? { id: 1, ok: false, error: { code: "refused", text: "" } } : { id: 1, ok: true }));
  assert.deepEqual(
    ended.map(({ failures }) => failures),
    [2],
  );
});

test("leaving the page sends what was decided", () => {
  const { sent, decisions, approve, clock } = inbox();
  approve("1:a");
  decisions.flush();
  assert.equal(sent.length, 1);
  clock.advance(graceTime);
  assert.equal(sent.length, 1);
});

test("leaving the page sends at once what the server takes, and says what is left", () => {
  const { sent, decisions, approve, clock } = inbox();
  const names = (count: number) => Array.from({ length: count }, (_, index) => `1:${index}`);
  approve(...names(45));
  assert.equal(decisions.flush(), 0);
  assert.equal(sent.length, 45);
  clock.advance(1000);
  approve(...names(80));
  assert.equal(decisions.flush(), 80 - burst);
  assert.equal(decisions.flush(), 80 - burst);
  clock.advance(1200); // the user stays
  assert.equal(sent.length, 45 + 80);
});

test("several decisions together are sent no faster than one", () => {
  const { sent, approve, clock } = inbox();
  for (let first = 0; first < 5; first++) approve(...Array.from({ length: 20 }, (_, index) => `1:${first}.${index}`));
  clock.advance(graceTime);
  assert.equal(sent.length, 20);
  clock.advance(4 * 600);
  assert.equal(sent.length, 100);
});

test("patterns of the inbox", () => {
  assert.ok(matchesPattern("wsn-1.*", "wsn-1.7"));
  assert.ok(matchesPattern("*.1_?", "knx.1_7"));
  assert.ok(!matchesPattern("wsn-1.7", "wsn-1.77"));
  assert.ok(!matchesPattern("wsn.1", "wsnx1"));
  assert.ok(matchesPattern("a(b.*", "a(b.c"));
  assert.ok(matchesPattern("*", ""));
  assert.ok(!matchesPattern("?", ""));
  assert.ok(matchesPattern("*ab*b", "aabxab"));
});

test("a pattern of many stars takes no time", () => {
  assert.ok(!matchesPattern("*a".repeat(12) + "b", "a".repeat(60)));
});
