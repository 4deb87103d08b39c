// Texts of the list of devices.
import { many } from "../core/text";

export const compared = "Compared devices";
export const all = "All devices";
export const title = "Devices";
export const label = "Devices";
export const none = "No device has joined.";
export const noneCompared = "None of these devices is there.";
export const noneText = (islands: number) =>
  `${many(islands, "island is", "islands are")} here. A device is listed as soon as it announces itself.`;
export const filtered = "No device matches.";
export const group = "Group";
export const groups = { none: "none", network: "by network", place: "by room", type: "by type" };
export const anyNetwork = "Any network";
export const anyType = "Any type";
export const anyQuality = "Any quality";
export const network = "Network";
export const type = "Type";
export const quality = "Quality";
export const state = "State";
export const name = "Name";
export const model = "Model";
export const place = "Room";
export const value = "Value";
export const heard = "Heard";
export const noPlace = "no room";
export const pinned = "Pinned";
export const select = "select";
export const compare = (count: number) => `Compare ${count}`;
export const unselect = "Clear selection";
export const tooMany =
  "There are too many points to know all of them: the list has no order and no filter by value, quality and time. Choose an island, if one has fewer.";
export const count = (count: number) => many(count, "device");
