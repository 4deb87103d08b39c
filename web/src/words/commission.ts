// Texts of what sets a building up: names, rooms, what is ignored or forgotten.
import { many } from "../core/text";

export const edit = "Name, room …";
export const editDevice = (name: string) => `Name and room of ${name}`;
export const name = "Name";
export const nameHint = "as the device calls itself";
export const room = "Room";
export const roomHint = "Kitchen, Office 12 …";
export const noRoom = "no room";
export const save = "Save";
export const saved = (name: string) => `${name}: saved`;
export const ignore = "Ignore …";
export const forget = "Forget …";
export const ignoreWhat =
  "The island erases its values and takes no notice of it any more. The inbox lists it under ignored, from where it can come back.";
export const forgetWhat =
  "The island erases its name, room and values, as if it had never been there. If it announces itself again, it is a new device.";
export const ignoreNow = (name: string) => `Ignore ${name}`;
export const forgetNow = (name: string) => `Forget ${name}`;
export const cancel = "Cancel";
export const gone = { ignore: (name: string) => `${name} is ignored`, forget: (name: string) => `${name} is forgotten` };
export const giveRoom = (count: number) => `Room of ${count} …`;
export const giveRoomTitle = (count: number) => `Room of ${many(count, "device")}`;
export const give = "Give the room";
export const given = (count: number, room: string) =>
  room ? `${many(count, "device")} in ${room}` : `${many(count, "device")} without a room`;
export const notGiven = (failed: number, all: number, why: string) => `${failed} of ${many(all, "device")} keep their room: ${why}`;
export const dropHere = (count: number) => `Drop ${many(count, "device")} on a room`;
export const newRoom = "Another room …";
export const pointTitle = (name: string) => `Name of ${name}`;
export const pointHint = (id: string) => `${id}, as its network calls it`;
export const pinned = "Show its curve on the overview";
export const noArrangement = "Names of points and curves on the overview need a state file of the island.";
