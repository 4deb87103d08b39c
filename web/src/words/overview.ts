// Texts of the overview and of rooms.
import { typeWords } from "../core/format";
import { many } from "../core/text";
import { ignoredToo } from "./inbox";

export const title = "Overview";
export const island = "Island";
export const islands = "Islands";
export const host = "Host";
export const program = "Program";
export const up = "Up for";
export const devices = "Devices reachable";
export { reachable } from "./networks";
export const alerts = "Needs attention";
export const noAlerts = "All lines are up, every device answers, no battery is low, and the last commands ended well.";
export const moreAlerts = (count: number) => `and ${count} more: rubicon alerts`;
export const problem = "problem";
export const warning = "warning";
export const waiting = (waiting: number, ignored: number) =>
  `${many(waiting, "device waits", "devices wait")} for a decision.${ignoredToo(ignored)}`;
export const decide = "Decide";
export const rooms = "Rooms";
export const unplaced = "Devices without a room";
export const giveRooms = "Give them rooms";
export const pinned = "Pinned";
export const arrange = "Arrange";
export const arranged = "Done";
export const earlier = (name: string) => `Move ${name} forward`;
export const later = (name: string) => `Move ${name} back`;
export const pin = (name: string) => `${name} on the overview`;
export const notArranged = (why: string) => `The overview was not changed: ${why}`;
export const noDevices = "No device has joined yet.";
export const noDevicesText = "Devices appear here as soon as they announce themselves. New ones may wait in the inbox.";
export const noRoom = (name: string) => `No device is in ${name}.`;
export const roomDevices = "Devices";
export const devicesOf = (count: number) => many(count, "device");
export const away = (away: number, all: number) => `${away} of ${many(all, "device")} not reachable`;
export const moreControls = (count: number) => `${many(count, "more control")} …`;
export const unknown = "unknown";
export const notMeasured = (what: string[]) => {
  const all = what.join(", ");
  return `${all.charAt(0).toUpperCase()}${all.slice(1)}: not measured, nobody asks`;
};
export const some = (count: number, all: number, word: string) =>
  word === "no" ? word : count === 0 ? `all ${word}` : word === "yes" ? `${count} of ${all}` : `${count} of ${all} ${word}`;
const factNames: Record<string, string> = {
  co2: "CO₂",
  contact: "doors, windows",
  light: "brightness",
  carbonMonoxideAlarm: "carbon monoxide",
};
export const factName = (type: string) => factNames[type] ?? typeWords(type);
export const lamp = "lamp";
export const tileNames = { light: "lamp", blind: "blind", thermostat: "heating", other: "" };
export const levelOf = (name: string) => `Brightness of ${name}`;
export const whiteOf = (name: string) => `White light of ${name}`;
export const positionOf = (name: string) => `Position of ${name}`;
export const closed = (value: string) =>
  Number(value) <= 0 ? "open" : Number(value) >= 100 ? "closed" : `${Math.round(Number(value))} % closed`;
export const blind = { up: "up", stop: "stop", down: "down" };
export const warmer = (name: string) => `${name}: warmer`;
export const colder = (name: string) => `${name}: colder`;
export const tooMany = "There are too many points to show all of them here: each room has its values on its own page.";
