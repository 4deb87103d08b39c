// Texts of the inbox.
import type { Verb } from "../core/decisions";
import { many } from "../core/text";

export const title = "Inbox";
export const device = "Device";
export const says = "Says it is";
export const why = "Waits because";
export const since = "Since";
export const decision = "Decision";
export const approve = "Approve";
export const ignore = "Ignore";
export const undo = "Undo";
export const approveMany = (count: number) => `Approve ${count.toLocaleString()}`;
export const ignoreMany = (count: number) => `Ignore ${count.toLocaleString()}`;
export const selectAll = (count: number) => `Select all ${count.toLocaleString()}`;
export const selectNone = "Clear selection";
export const has = (kind: "sensors" | "actuators" | "properties", count: number) =>
  many(count, { sensors: "sensor", actuators: "actuator", properties: "property" }[kind], kind);
export const ignored = (count: number) => `${count.toLocaleString()} ${count === 1 ? "is" : "are"} ignored`;
export const ignoredToo = (count: number) => (count > 0 ? ` ${ignored(count)}.` : "");
export const waiting = (count: number) => `${count.toLocaleString()} ${count === 1 ? "waits" : "wait"}`;
export const ignoredTitle = "Ignored devices";
export const ignoredBy = "Ignored by";
export const noneIgnored = "No device is ignored.";
export const none = "No device waits.";
export const noneText = "A device waits here when the configuration says discovery: {new-devices: ask}, or when the island cannot list it.";
export const noInbox = "No island shows its inbox.";
export const pattern = "By pattern";
export const patternHint = "NETWORK.DEVICE; * is any text, ? one character. The exact address of an ignored device approves it again.";
export const matching = (count: number) => `${many(count, "waiting device matches", "waiting devices match")}.`;
export const noMatch = "No waiting device matches.";
export const exactly = "No waiting device has this address; an ignored one may have it.";
export const decided = { approve: "approved", ignore: "ignored" };
const devices = (count: number) => many(Math.max(count, 1), "device");
export const pending = (verb: Verb, count: number, seconds: number) => `${devices(count)} will be ${decided[verb]} in ${seconds} s.`;
export const done = (verb: Verb, count: number) => `${devices(count)} ${decided[verb]}.`;
export const sending = "sending";
export const tooLate = "It is too late: the decision is on its way to the island.";
export const failed = (failures: number, all: number, reason: string) =>
  `${failures} of ${many(all, "decision was", "decisions were")} refused: ${reason}`;
