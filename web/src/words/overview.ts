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
export const lines = "Lines not up";
export const allUp = (count: number) => (count === 1 ? "The line of 1 network is up." : `All lines of ${count} networks are up.`);
export const networks = "Networks";
export const gone = "Devices gone";
export const noneGone = "No device is unreachable.";
export const all = "All";
export const commands = "Commands that failed";
export const noneFailing = "The last command of every actuator and property ended well.";
export const inbox = "Inbox";
export const noneWaiting = (ignored: number) => none + ignoredToo(ignored);
export const waiting = (waiting: number, ignored: number) =>
  `${many(waiting, "device waits", "devices wait")} for a decision.${ignoredToo(ignored)}`;
export const decide = "Decide";
export const floods = "Set most often";
export const quiet = "Nothing is being set.";
export const measuring = "Counting …";
export const tuples = "Tuples";
