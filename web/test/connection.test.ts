import assert from "node:assert/strict";
import { test } from "node:test";
import { Connection, type LineState } from "../src/core/connection";
import type { Answer, Frame } from "../src/core/frames";
import { TestClock, TestServer } from "./support";

function setUp() {
  const clock = new TestClock();
  const server = new TestServer();
  const states: LineState[] = [];
  const frames: Frame[] = [];
  const connection = new Connection(server.open, clock, { state: (state) => states.push(state), frame: (frame) => frames.push(frame) });
  connection.start();
  return { clock, server, states, frames, connection };
}

test("each request gets the answer with its id", () => {
  const { server, connection } = setUp();
  server.last.events.opened();
  const answers: string[] = [];
  connection.request({ do: "islands" }, (answer) => answers.push(`islands ${answer.ok}`));
  connection.request({ do: "get", key: "1:a" }, (answer) => answers.push(`get ${answer.error?.code}`));
  assert.deepEqual(server.last.sent, [
    { id: 1, do: "islands" },
    { id: 2, do: "get", key: "1:a" },
  ]);
  server.say({ id: 2, ok: false, error: { code: "not-found", text: "" } });
  server.say({ id: 1, ok: true });
  server.say({ id: 1, ok: true });
  assert.deepEqual(answers, ["get not-found", "islands true"]);
});

test("a followed command gets its states until the final one", () => {
  const { server, connection } = setUp();
  server.last.events.opened();
  const states: (string | undefined)[] = [];
  connection.request({ do: "set" }, (answer: Answer) => states.push(answer.state ?? answer.verdict), true);
  server.say({ id: 1, ok: true, verdict: "applied" });
  server.say({ id: 1, state: "sent" });
  server.say({ id: 1, state: "confirmed", final: true });
  server.say({ id: 1, state: "superseded", final: true });
  assert.deepEqual(states, ["applied", "sent", "confirmed"]);
});

test("requests of a lost line are answered as unreachable", () => {
  const { server, connection, states } = setUp();
  server.last.events.opened();
  const codes: (string | undefined)[] = [];
  connection.request({ do: "set" }, (answer) => codes.push(answer.error?.code));
  server.last.events.closed();
  connection.request({ do: "set" }, (answer) => codes.push(answer.error?.code));
  assert.deepEqual(codes, ["unreachable", "unreachable"]);
  assert.deepEqual(states, ["live", "lost"]);
});

test("a closed line is opened again after 250, 500 and then each 750 ms", () => {
  const { clock, server } = setUp();
  for (const wait of [250, 500, 750, 750]) {
    const before = server.opened.length;
    server.last.events.closed();
    clock.advance(wait - 1);
    assert.equal(server.opened.length, before);
    clock.advance(1);
    assert.equal(server.opened.length, before + 1);
  }
});

test("a line that opened starts with the shortest wait again", () => {
  const { clock, server } = setUp();
  server.last.events.closed();
  clock.advance(250);
  server.last.events.closed();
  clock.advance(500);
  server.last.events.opened();
  server.last.events.closed();
  clock.advance(250);
  assert.equal(server.opened.length, 4);
});

test("twelve seconds of silence are a lost line, any frame is a sign of life", () => {
  const { clock, server, states } = setUp();
  server.last.events.opened();
  clock.advance(11_999);
  server.say({ alive: 1 });
  clock.advance(11_999);
  assert.deepEqual(states, ["live"]);
  clock.advance(1);
  assert.deepEqual(states, ["live", "lost"]);
  assert.equal(server.last.closed, true);
});

test("a line that is opened anew is lost and live again", () => {
  const { clock, server, states, connection } = setUp();
  server.last.events.opened();
  connection.restart();
  server.last.events.opened();
  clock.advance(250);
  assert.deepEqual(states, ["live", "lost", "live"]);
  assert.equal(server.opened.length, 2);
  assert.equal(server.opened[0]?.closed, true);
});

test("what an old line still says is ignored", () => {
  const { clock, server, frames } = setUp();
  const old = server.last.events;
  old.opened();
  old.closed();
  clock.advance(250);
  server.last.events.opened();
  old.received('{"alive":1}');
  old.closed();
  assert.deepEqual(frames, []);
  assert.equal(server.opened.length, 2);
});

test("a frame that is no JSON object is ignored", () => {
  const { server, frames } = setUp();
  server.last.events.opened();
  for (const text of ["", "[]", "null", "{", '"a"', "7"]) server.last.events.received(text);
  assert.deepEqual(frames, []);
});
