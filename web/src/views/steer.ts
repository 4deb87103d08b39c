import { notify } from "../parts/notices";
import { setTuple } from "../parts/sent";
import * as text from "../words/recordings";

/** Sets a command of the island itself; its status shows the outcome, a refusal is shown at once. */
export function steer(key: string, value: string): void {
  setTuple(key, value, {}, (answer) => {
    if (answer.error) notify(text.refused(value, answer.error.text), "bad");
  });
}
