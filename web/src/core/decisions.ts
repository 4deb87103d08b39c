import type { Clock } from "./clock";
import type { Answer } from "./frames";

export type Verb = "approve" | "ignore";

/** Time to take a decision back before it is sent: the island itself cannot forget one. */
export const graceTime = 10_000;

/** One set: `approve` to the tuple of a device, or `approve PATTERN` to an inbox. */
export interface Step {
  key: string; // OWNER:KEY
  value: string;
}

export interface Decision {
  verb: Verb;
  /** The tuples of the devices that it decides about. */
  devices: ReadonlySet<string>;
  steps: Step[];
  until: number; // milliseconds of the clock; 0 = being sent
}

export interface DecisionCalls {
  /** Sends all steps, and gets the answer to each. `leaving`: what is under way must outlive the page. */
  send(steps: Step[], call: (step: Step, answer: Answer) => void, leaving: boolean): void;
  /** Something changed that is shown. */
  changed(): void;
  /** All steps were answered. */
  ended(decision: Decision, failures: { step: Step; answer: Answer }[]): void;
}

/** Decisions of the user about waiting devices, held for a while so that they can be taken back, then sent. */
export class Decisions {
  readonly #open = new Map<Decision, () => void>();

  constructor(
    private readonly clock: Clock,
    private readonly calls: DecisionCalls,
  ) {}

  decide(verb: Verb, devices: Iterable<string>, steps: Step[]): Decision {
    const decision = { verb, devices: new Set(devices), steps, until: this.clock.now() + graceTime };
    this.#open.set(
      decision,
      this.clock.after(graceTime, () => this.#send(decision)),
    );
    this.calls.changed();
    return decision;
  }

  /** False if it is too late. */
  undo(decision: Decision): boolean {
    if (decision.until === 0) return false;
    this.#open.get(decision)?.();
    const known = this.#open.delete(decision);
    this.calls.changed();
    return known;
  }

  /** The page is being left: all that was decided is sent now. */
  flush(): void {
    for (const [decision, stop] of this.#open) {
      if (decision.until === 0) continue;
      stop();
      this.#send(decision, true);
    }
  }

  /** What was decided about a device and is not done yet. */
  of(device: string): Decision | undefined {
    for (const decision of this.#open.keys()) {
      if (decision.devices.has(device)) return decision;
    }
    return undefined;
  }

  get pending(): Decision[] {
    return [...this.#open.keys()];
  }

  #send(decision: Decision, leaving = false): void {
    decision.until = 0;
    const failures: { step: Step; answer: Answer }[] = [];
    let left = decision.steps.length;
    const answered = (step: Step, answer: Answer) => {
      if (answer.ok !== true) failures.push({ step, answer });
      if (--left > 0) return;
      this.#open.delete(decision);
      this.calls.ended(decision, failures);
      this.calls.changed();
    };
    this.calls.send(decision.steps, answered, leaving);
    this.calls.changed();
  }
}

/** A pattern of the inbox: `*` is any text, `?` one character, all else itself. Takes time by the product of both lengths at most. */
export function matchesPattern(pattern: string, name: string): boolean {
  let at = 0; // in the pattern
  let star = -1; // the last `*` passed
  let tried = 0; // where the text after that `*` was tried last
  for (let index = 0; index < name.length;) {
    const sign = pattern[at];
    if (sign === "*") {
      star = at++;
      tried = index;
    } else if (sign === "?" || sign === name[index]) {
      at++;
      index++;
    } else if (star >= 0) {
      at = star + 1;
      index = ++tried;
    } else {
      return false;
    }
  }
  while (pattern[at] === "*") at++;
  return at === pattern.length;
}
