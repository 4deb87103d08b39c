import { list, number, text } from "./catalog";
import { colourTypes, reciprocal } from "./colour";
import type { Answer } from "./frames";

/** What control a point gets, from its description alone. */
export type Control =
  | { kind: "switch"; off: string; on: string }
  | { kind: "buttons"; words: string[] }
  | { kind: "choice"; words: string[] }
  | { kind: "slider"; minimum: number; maximum: number; step: number }
  | { kind: "number"; minimum?: number; maximum?: number; step: number | "any" }
  | { kind: "colour" }
  | { kind: "white"; minimum: number; maximum: number; mired: boolean } // kelvin
  | { kind: "text"; json: boolean };

/** Wider ranges say what is possible, not what one would choose by a slider. */
const widestSlider = 1000;

/** What lamps can do at most, in kelvin: types allow more. */
const [warmest, coldest] = [1500, 10_000];

export function controlOf(description: Record<string, unknown>): Control {
  const type = text(description.type);
  if (colourTypes.has(type)) return { kind: "colour" };
  if (type === "colourTemperature" || type === "colourTemperatureMired") return whiteControl(description, type !== "colourTemperature");
  const words = list(description.words);
  const event = text(description.report) === "event";
  switch (text(description.data_type)) {
    case "boolean": {
      const [off = "off", on = "on"] = words;
      return event ? { kind: "buttons", words: [off, on] } : { kind: "switch", off, on };
    }
    case "enumeration":
      if (words.length === 0) return { kind: "text", json: false };
      return words.length <= 4 ? { kind: "buttons", words } : { kind: "choice", words };
    case "integer":
      return numberControl(description, 1);
    case "real":
      return numberControl(description, "any");
    case "json":
      return { kind: "text", json: true };
    default:
      return { kind: "text", json: false };
  }
}

function whiteControl({ minimum, maximum }: Record<string, unknown>, mired: boolean): Control {
  const kelvin = (bound: unknown) => (mired && number(bound) > 0 ? reciprocal(number(bound)) : number(bound));
  const [low, high] = mired ? [kelvin(maximum), kelvin(minimum)] : [kelvin(minimum), kelvin(maximum)];
  return { kind: "white", minimum: Math.max(low, warmest), maximum: Math.min(high || coldest, coldest), mired };
}

function numberControl(description: Record<string, unknown>, step: 1 | "any"): Control {
  const { minimum, maximum } = description;
  if (typeof minimum !== "number" || typeof maximum !== "number" || maximum - minimum > widestSlider || maximum <= minimum) {
    return { kind: "number", minimum: optional(minimum), maximum: optional(maximum), step };
  }
  return { kind: "slider", minimum, maximum, step: step === 1 ? 1 : niceStep(maximum - minimum) };
}

function optional(value: unknown): number | undefined {
  return typeof value === "number" ? value : undefined;
}

/** About 200 steps over the range: 1 for 0..100 %, 0.1 for 15..30 °C. */
function niceStep(range: number): number {
  return 10 ** Math.round(Math.log10(range / 200));
}

/** Where a command is on its way (docs/life-of-a-command.md). */
export interface Outcome {
  state: string;
  value: string;
  reason: string;
  since: number; // seconds
  until: number;
  final: boolean;
  commander: string;
}

const finalStates = new Set(["confirmed", "assumed", "applied", "refused", "failed", "timed-out", "expired", "superseded"]);
const goodStates = new Set(["confirmed", "assumed", "applied"]);

export function isFinal(state: string): boolean {
  return finalStates.has(state);
}

export type Tone = "good" | "waiting" | "bad" | "neutral";

export function toneOf(state: string): Tone {
  if (goodStates.has(state)) return "good";
  if (state === "superseded") return "neutral";
  return isFinal(state) ? "bad" : "waiting";
}

/** The outcome so far after one more answer to the `set`. */
export function advance(before: Outcome, answer: Answer, now: number): Outcome {
  if (answer.ok === false) {
    const lost = ["unreachable", "expired"].includes(answer.error?.code ?? "");
    const state = isFinal(answer.verdict ?? "") ? answer.verdict! : lost ? "unknown" : "refused";
    return { ...before, state, reason: answer.error?.text ?? "", since: now, until: 0, final: true };
  }
  const state = answer.state ?? (answer.verdict === "applied" ? "queued" : (answer.verdict ?? before.state));
  const final = answer.final ?? (isFinal(state) && state !== "queued");
  return { ...before, state, reason: answer.reason ?? "", since: now, until: answer.until ?? 0, final };
}

/** Until when a command waits for its line or device; 0 if it does not wait. */
export function waitsUntil({ state, until }: Outcome): number {
  return state === "queued" ? until : 0;
}

export function begin(value: string, now: number): Outcome {
  return { state: "sending", value, reason: "", since: now, until: 0, final: false, commander: "" };
}

/** The command of a point's `.status`: also those of others. Null if there was none. */
export function outcomeOf(status: Record<string, unknown>): Outcome | null {
  const command = status.command;
  if (typeof command !== "object" || command === null) return null;
  const member = command as Record<string, unknown>;
  const state = text(member.state);
  if (state === "") return null;
  return {
    state,
    value: text(member.value),
    reason: text(member.reason),
    since: number(member.since),
    until: number(member.until),
    final: isFinal(state),
    commander: text(member.commander),
  };
}
