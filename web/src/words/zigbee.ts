// Texts of pairing and of the map of ZigBee.
import { many } from "../core/text";

export const title = "ZigBee";
export const pair = "Pair devices";
export const pairText =
  "Put the new device into its pairing mode: its manual says how, often by holding a button for five seconds. Keep it near and awake.";
export const stop = "Stop pairing";
export const open = (seconds: number) => `Devices may join for ${seconds} s`;
export const opening = "Joining is being permitted …";
export const ended = (count: number) => `Pairing has ended: ${count === 0 ? "no device joined" : `${many(count, "device")} came`}.`;
export const nobody = "No device has joined yet.";
export const failed = (why: string) => `ZigBee: ${why}`;
export const noReply = "the network does not reply";
export const states: Record<string, string> = {
  joined: "joined",
  interviewing: "being asked what it is",
  interviewed: "ready",
  failed: "failed",
  left: "left",
  announced: "here again",
};
export const map = "Map";
export const mapOf = (network: string) => `Who reaches whom in ${network}`;
export const mapReading = "Every router is being asked. This takes up to two minutes.";
export const mapLabel = (nodes: number, links: number) => `${many(nodes, "device")}, ${many(links, "link")}; the table below lists them`;
export const mapLegend = "Blue lines: the way to the coordinator, with the link quality; 255 is best. Grey lines: other neighbours.";
export const from = "From";
export const to = "To";
export const quality = "Link quality";
export const silent = (names: string) => `Did not answer: ${names}.`;
export const remove = "Remove from ZigBee …";
export const removeWhat = "The device leaves the ZigBee network and has to be paired again to come back.";
export const removeNow = (name: string) => `Remove ${name}`;
export const removed = (name: string) => `${name} left the ZigBee network`;
