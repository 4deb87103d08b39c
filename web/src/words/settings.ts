// Texts of settings.
import { many } from "../core/text";

export const title = "Settings";
export const none = "No island shows its configuration.";
export const empty = "The configuration is empty.";
export const filtered = "No line matches.";
export const inForce = (island: string) => `Configuration in force of ${island}`;
export const check = "Check the file";
export const checkTitle = "Reads the file again and shows what a reload would change. Changes nothing.";
export const reload = "Reload …";
export const reloadTitle = "Shows first what would be touched.";
export const reloadNow = "Reload now";
export const cancel = "Cancel";
export const noOutcome = "The island did not say what came of it. Its log may.";
export const busy = "The island reads its file …";
export const preview = (count: number) => `A reload makes ${many(count, "change")}`;
export const equal = "The file equals what is in force.";
export const reloaded = (count: number) => `Reloaded: ${many(count, "change")}.`;
export const refused = (count: number) => `Refused: ${many(count, "error")}. Nothing was changed.`;
export const failed = (reason: string) => `Not done: ${reason}`;
export const idle = "The configuration in force, without secrets. The file was not checked since the start.";
export const outcome = "Last check or reload";
export const ok = {
  try: (count: number) =>
    count === 0 ? "Check: the file equals what is in force." : `Check: the file differs by ${many(count, "change")}.`,
  reload: (count: number) => `Reload: ${many(count, "change")} made.`,
};
export const bad = {
  try: (count: number) => `Check: ${many(count, "error")} in the file.`,
  reload: (count: number) => `Reload refused: ${many(count, "error")}. Nothing was changed.`,
};
export const place = "Place";
export const error = "Error";
export const copyErrors = "Copy errors";
