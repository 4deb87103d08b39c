// Texts of the log.
import { many } from "../core/text";

export const title = "Log";
export const time = "Time";
export const level = "Level";
export const island = "Island";
export const subject = "Subject";
export const text = "Text";
export const anyLevel = "any";
export const atLeast = (level: string) => (level === "error" ? "error" : `${level} and above`);
export const pause = "Pause";
export const pauseKey = "pause, or go on";
export const resume = (count: number) => (count > 0 ? `Go on (${count} new)` : "Go on");
export const copy = (count: number) => `Copy ${many(count, "line")}`;
export const toEnd = "To the end";
export const missed = (count: number) => `${many(count, "line")} before it missed. `;
export const whole = "The whole line";
export const none = "No line yet.";
export const noneText = (kept: number) =>
  `The last hundred lines of each island are shown, and up to ${kept.toLocaleString()} as they are written.`;
export const notRead = (island: number, why: string) => `The log of ${island} cannot be read. ${why}`;
export const filtered = "No line matches.";
