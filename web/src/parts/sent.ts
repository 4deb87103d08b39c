// Commands that this page sends to points, and what became of them.
import { connection } from "../app";
import type { Point } from "../core/catalog";
import { advance, begin, type Outcome, outcomeOf } from "../core/commands";
import type { Answer } from "../core/frames";
import { Patience } from "../core/patience";
import { redraw } from "../core/redraw";
import * as text from "../words/command";
import { announce } from "./notices";

export const patience = new Patience();

interface Sent extends Outcome {
  /** `since` of the command that the status showed before. */
  before: number;
}

/** The last command that this page sent to a point, by the point's path. */
const sent = new Map<string, Sent>();

function now(): number {
  return Date.now() / 1000;
}

/** Commands a point and follows the outcome; `ended` gets the final one. */
export function sendCommand(point: Point, value: string, ended: (outcome: Outcome) => void = () => {}): void {
  const { path } = point;
  const before = outcomeOf(point.status?.json ?? {})?.since ?? 0;
  let own: Sent = { ...begin(value, now()), before };
  const show = (next: Sent) => {
    if (sent.get(path) === own || !sent.has(path)) sent.set(path, next); // else a newer command is shown
    own = next;
    redraw();
  };
  sent.delete(path);
  show(own);
  connection.request(
    { do: "set", key: `${path}.command`, value, ttl: patience.of(point.device.path) },
    (answer) => {
      show({ ...advance(own, answer, now()), before });
      if (!own.final) return;
      ended(own);
      announce(text.spoken(`${point.device.name} ${point.id}`, value, own.state, own.reason));
    },
    true,
  );
}

/** Sets or appends to a tuple that is no command of a point; the answer is the outcome. */
export function setTuple(
  key: string,
  value: string,
  fields: Record<string, unknown> = {},
  call: (answer: Answer) => void = () => {},
): void {
  connection.request({ do: "set", key, value, ...fields }, call);
}

/** The command of a point that counts: ours until it ends, then what the island says. */
export function outcomeAt(point: Point): Outcome | null {
  const own = sent.get(point.path);
  const reported = outcomeOf(point.status?.json ?? {});
  if (own && (!own.final || !reported || reported.since === own.before)) return own;
  return reported;
}
