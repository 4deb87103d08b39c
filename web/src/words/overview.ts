// Texts of the overview.
import { many } from "../core/text";
import { ignoredToo, none } from "./inbox";

export const title = "Overview";
export const island = "Island";
export const host = "Host";
export const program = "Program";
export const up = "Up for";
export const devices = "Devices reachable";
export { reachable, perSecond } from "./networks";
export const alerts = "Needs attention";
export const noAlerts = "All lines are up, every device answers, no battery is low, and the last commands ended well.";
export const moreAlerts = (count: number) => `and ${count} more: rubicon alerts`;
export const problem = "problem";
export const warning = "warning";
export const inbox = "Inbox";
export const noneWaiting = (ignored: number) => none + ignoredToo(ignored);
export const waiting = (waiting: number, ignored: number) =>
  `${many(waiting, "device waits", "devices wait")} for a decision.${ignoredToo(ignored)}`;
export const decide = "Decide";
export const floods = "Set most often";
export const quiet = "Nothing is being set.";
export const measuring = "Counting …";
export const tuples = "Tuples";
