import assert from "node:assert/strict";
import { test } from "node:test";
import { advance, begin, controlOf, outcomeOf, toneOf, waitsUntil } from "../src/core/commands";
import { Drafts } from "../src/core/drafts";
import { Patience } from "../src/core/patience";
import type { Answer } from "../src/core/frames";

test("the control comes from the description alone", () => {
  assert.deepEqual(controlOf({ data_type: "boolean" }), { kind: "switch", off: "off", on: "on" });
  assert.deepEqual(controlOf({ data_type: "boolean", words: ["closed", "open"] }), { kind: "switch", off: "closed", on: "open" });
  assert.deepEqual(controlOf({ data_type: "boolean", words: ["up", "down"], report: "event" }), { kind: "buttons", words: ["up", "down"] });
  assert.deepEqual(controlOf({ data_type: "enumeration", words: ["a", "b"] }), { kind: "buttons", words: ["a", "b"] });
  assert.deepEqual(controlOf({ data_type: "enumeration", words: ["a", "b", "c", "d", "e"] }).kind, "choice");
  assert.deepEqual(controlOf({ data_type: "enumeration" }), { kind: "text", json: false });
  assert.deepEqual(controlOf({ data_type: "real", minimum: 0, maximum: 100 }), { kind: "slider", minimum: 0, maximum: 100, step: 1 });
  assert.deepEqual(controlOf({ data_type: "real", minimum: 15, maximum: 30 }), { kind: "slider", minimum: 15, maximum: 30, step: 0.1 });
  assert.deepEqual(controlOf({ data_type: "integer", minimum: 0, maximum: 10 }), { kind: "slider", minimum: 0, maximum: 10, step: 1 });
  assert.deepEqual(controlOf({ data_type: "integer", minimum: 10, maximum: 86400000 }), {
    kind: "number",
    minimum: 10,
    maximum: 86400000,
    step: 1,
  });
  assert.deepEqual(controlOf({ data_type: "real" }), { kind: "number", minimum: undefined, maximum: undefined, step: "any" });
  assert.deepEqual(controlOf({ data_type: "json" }), { kind: "text", json: true });
  for (const type of ["colourRgb", "colourXy", "colourHueSaturation"]) assert.equal(controlOf({ data_type: "json", type }).kind, "colour");
});

test("white light is chosen in kelvin, within what lamps can do", () => {
  const white = (description: Record<string, unknown>) => controlOf({ data_type: "real", ...description });
  assert.deepEqual(white({ type: "colourTemperatureMired", minimum: 153, maximum: 500 }), {
    kind: "white",
    minimum: 2000,
    maximum: 6536,
    mired: true,
  });
  assert.deepEqual(white({ type: "colourTemperature", minimum: 1000, maximum: 20000 }), {
    kind: "white",
    minimum: 1500,
    maximum: 10000,
    mired: false,
  });
  assert.deepEqual(white({ type: "colourTemperature" }), { kind: "white", minimum: 1500, maximum: 10000, mired: false });
});

test("odd descriptions give a field for text", () => {
  for (const description of [{}, { data_type: 7 }, { data_type: "enumeration", words: "a" }, { data_type: "text", words: [1] }]) {
    assert.equal(controlOf(description as Record<string, unknown>).kind, "text");
  }
  assert.equal(controlOf({ data_type: "real", minimum: 5, maximum: 5 }).kind, "number");
  assert.equal(controlOf({ data_type: "boolean", words: [1, 2] }).kind, "switch");
});

function states(...answers: Partial<Answer>[]): string[] {
  let outcome = begin("on", 0);
  return answers.map((answer, index) => {
    outcome = advance(outcome, { id: 1, ...answer }, index + 1);
    return `${outcome.state}${outcome.final ? "!" : ""} ${outcome.reason}`.trim();
  });
}

test("a command goes through its states to the final one", () => {
  assert.deepEqual(
    states({ ok: true, verdict: "applied" }, { state: "sent", reason: "waits for a report" }, { state: "confirmed", final: true }),
    ["queued", "sent waits for a report", "confirmed!"],
  );
  assert.deepEqual(states({ ok: true, verdict: "applied" }, { state: "timed-out", reason: "no report", final: true }), [
    "queued",
    "timed-out! no report",
  ]);
});

test("a refusal carries its reason; a lost line leaves the outcome unknown", () => {
  assert.deepEqual(states({ ok: false, error: { code: "refused", text: "not a number" } }), ["refused! not a number"]);
  assert.deepEqual(states({ ok: true, verdict: "applied" }, { ok: false, error: { code: "unreachable", text: "lost" } }), [
    "queued",
    "unknown! lost",
  ]);
});

test("what was not executed is told apart from what nobody knows", () => {
  const error = { code: "expired", text: "no answer" };
  assert.deepEqual(states({ ok: false, verdict: "expired", error }), ["expired! no answer"]);
  assert.deepEqual(states({ ok: false, verdict: "timed-out", error }), ["timed-out! no answer"]);
  assert.deepEqual(states({ ok: false, error }), ["unknown! no answer"]);
});

test("the status of a point tells whose command it was", () => {
  const command = { state: "assumed", value: "30", since: 5, reason: "", commander: "rubicon set (pid 7)" };
  const outcome = outcomeOf({ quality: "assumed", command });
  assert.deepEqual([outcome?.state, outcome?.value, outcome?.final, outcome?.commander], ["assumed", "30", true, "rubicon set (pid 7)"]);
  for (const status of [{}, { command: null }, { command: "on" }, { command: {} }, { command: { state: 7 } }])
    assert.equal(outcomeOf(status as Record<string, unknown>), null);
});

test("each state has a tone", () => {
  assert.deepEqual(
    ["sending", "queued", "sent", "confirmed", "assumed", "refused", "failed", "timed-out", "expired", "superseded"].map(toneOf),
    ["waiting", "waiting", "waiting", "good", "good", "bad", "bad", "bad", "bad", "neutral"],
  );
});

test("only a queued command waits until a time", () => {
  const waiting = { ...begin("on", 1), state: "queued", until: 90 };
  assert.equal(waitsUntil(waiting), 90);
  assert.equal(waitsUntil({ ...waiting, state: "sent" }), 0);
});

test("how long commands wait is chosen for one device, until its page is left", () => {
  const patience = new Patience();
  patience.choose("7/wsn/1", 86_400);
  assert.deepEqual([patience.of("7/wsn/1"), patience.of("7/wsn/2")], [86_400, 5]);
  patience.forget("7/wsn/2");
  assert.equal(patience.of("7/wsn/1"), 86_400);
  patience.forget("7/wsn/1");
  assert.equal(patience.of("7/wsn/1"), 5);
});

test("what was typed stays until it is in force; what was typed since stays", () => {
  const drafts = new Drafts();
  drafts.type("7:p.n.d.actuator.a", "40");
  assert.equal(drafts.of("7:p.n.d.actuator.a"), "40");
  drafts.type("7:p.n.d.actuator.a", "50");
  drafts.done("7:p.n.d.actuator.a", "40");
  assert.equal(drafts.of("7:p.n.d.actuator.a"), "50");
  drafts.done("7:p.n.d.actuator.a", "50");
  assert.equal(drafts.of("7:p.n.d.actuator.a"), null);
});
