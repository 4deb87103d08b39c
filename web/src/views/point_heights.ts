import { mayBe, nameOfPoint } from "../app";
import { type Point, text } from "../core/catalog";
import type { Outcome } from "../core/commands";
import { isWritable } from "../parts/command";
import { coarse, moreLines, phone } from "../parts/screen";
import { outcomeAt } from "../parts/sent";

/** Pixels of the columns of name, quality and outcome, at least. */
const [nameWidth, qualityWidth, outcomeWidth] = [150, 140, 210];

/** Room for the control of a point, and for the whole reason of its quality and of its last command: reasons are never cut. */
export function heightOfPoint(point: Point): number {
  const control = isWritable(point) && mayBe("command");
  const quantity = (text(point.description?.json.quantity) || point.type).length;
  const outcome = outcomeAt(point);
  const reason = text(point.status?.json.reason).length;
  if (!phone.value) {
    const name = 42 + moreLines(nameOfPoint(point).length * 1.15, nameWidth) + moreLines(quantity, nameWidth);
    const quality = reason > 0 ? 40 + moreLines(reason, qualityWidth) : 0;
    const facts = outcome ? outcomeFacts(outcome) : 0;
    const command = outcome
      ? 30 + moreLines(outcome.value.length + 24, outcomeWidth) + (facts > 0 ? 16 + moreLines(facts, outcomeWidth) : 0)
      : 0;
    return Math.max(control && coarse.value ? 54 : 42, name, quality, command);
  }
  const width = innerWidth - 32;
  const reasons = reason > 0 ? 16 + moreLines(reason, width * 0.7) : 0;
  const head = 66 + reasons + moreLines(quantity, width * 0.6);
  const facts = outcome ? outcomeFacts(outcome) : 0;
  return head + (control ? 52 : 0) + (outcome ? 24 + (facts > 0 ? 16 + moreLines(facts, width) : 0) : 0);
}

/** Letters of the second line of an outcome. */
function outcomeFacts({ reason, commander }: Outcome): number {
  return reason.length + (commander ? commander.length + 6 : 0);
}
