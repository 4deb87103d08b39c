import assert from "node:assert/strict";
import { test } from "node:test";
import { type Decision, Decisions, graceTime, matchesPattern, type Step } from "../src/core/decisions";
import type { Answer } from "../src/core/frames";
import { answerOf, listsOf, longestList, sizeOf } from "../src/core/inbox_list";
import { TestClock } from "./support";

function inbox() {
  const clock = new TestClock();
  const sent: { steps: Step[]; answer: (step: Step, answer: Answer) => void; leaving: boolean }[] = [];
  const ended: { decision: Decision; failures: number }[] = [];
  const decisions = new Decisions(clock, {
    send: (steps, answer, leaving) => sent.push({ steps, answer, leaving }),
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
  const only = { key: "1:b", value: "approve" };
  assert.deepEqual(
    sent.map(({ steps }) => steps),
    [[only]],
  );
  assert.ok(!decisions.undo(second));
  assert.equal(decisions.of("1:b"), second);
  sent[0]?.answer(only, { id: 1, ok: true });
  assert.equal(decisions.of("1:b"), undefined);
  assert.equal(ended[0]?.failures, 0);
});

test("many are sent together, and failures are collected", () => {
  const { clock, sent, ended, approve } = inbox();
  approve(...Array.from({ length: 45 }, (_, index) => `1:${index}`));
  clock.advance(graceTime);
  assert.equal(sent.length, 1);
  const { steps, answer, leaving } = sent[0]!;
  assert.equal(steps.length, 45);
  assert.ok(!leaving);
  steps.forEach((step, index) =>
    answer(step, index < 2 ? { id: 1, ok: false, error: { code: "refused", text: "" } } : { id: 1, ok: true }),
  );
  assert.deepEqual(
    ended.map(({ failures }) => failures),
    [2],
  );
});

test("leaving the page sends all that was decided, once", () => {
  const { sent, decisions, approve, clock } = inbox();
  approve("1:a");
  approve(...Array.from({ length: 200 }, (_, index) => `1:${index}`));
  decisions.flush();
  decisions.flush();
  clock.advance(graceTime);
  assert.deepEqual(
    sent.map(({ steps, leaving }) => [steps.length, leaving]),
    [
      [1, true],
      [200, true],
    ],
  );
});

test("lists have the names of one island and word, in the order of the steps", () => {
  const lists = listsOf([
    { key: "1:proxy.inbox.wsn-1.7", value: "approve" },
    { key: "2:home.inbox.knx.1_4_6", value: "approve" },
    { key: "1:proxy.inbox", value: "approve wsn-*.8" },
    { key: "1:proxy.inbox.wsn-1.9", value: "ignore" },
  ]);
  assert.deepEqual(
    lists.map(({ body }) => body),
    [
      { island: 1, approve: ["wsn-1.7", "wsn-*.8"] },
      { island: 2, approve: ["knx.1_4_6"] },
      { island: 1, ignore: ["wsn-1.9"] },
    ],
  );
  assert.equal(lists[0]?.steps[1]?.value, "approve wsn-*.8");
});

test("lists are no longer than the server takes", () => {
  const steps = Array.from({ length: longestList + 1 }, (_, index) => ({ key: `1:proxy.inbox.wsn-1.${index}`, value: "approve" }));
  assert.deepEqual(
    listsOf(steps).map((list) => list.steps.length),
    [longestList, 1],
  );
});

test("the size of lists is that of their bytes as they are sent", () => {
  const lists = listsOf([
    { key: "1:proxy.inbox.wsn-1.7", value: "approve" },
    { key: "2:proxy.inbox.wsn-1.Küche", value: "ignore" },
  ]);
  assert.equal(sizeOf(lists), '{"island":1,"approve":["wsn-1.7"]}'.length + '{"island":2,"ignore":["wsn-1.Kueche"]}'.length);
  assert.equal(sizeOf([]), 0);
});

test("what the server did with a name is the answer to its step", () => {
  assert.equal(answerOf({ state: "applied" }).ok, true);
  const refused = answerOf({ state: "refused", error: { code: "not-found", text: "no device" } });
  assert.deepEqual([refused.ok, refused.error?.text], [false, "no device"]);
  assert.equal(answerOf(undefined).ok, false);
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
