// Texts of the view of networks.
import { many } from "../core/text";
import { tableShown } from "./frame";

export const title = "Networks";
export const none = "No island has a network.";
export const noneText = "Networks are in the configuration of the island. One of each kind:";
export const example =
  "networks:\n  wsn-1: {type: wsn, source: serial@/dev/ttyUSB0:telosb}\n  knx-hall: {type: knx, host: 192.168.1.20}\n  zigbee: {type: zigbee, broker: 127.0.0.1:1883}";
export const filtered = "No network matches.";
export const noSuch = (path: string) => `There is no network ${path}.`;
export const line = "Line";
export const network = "Network";
export const island = "Island";
export const since = "Since";
export const devices = "Reachable";
export const reachable = (reachable: number, all: number) => tableShown(reachable, all) || "–";
export const reachableDevices = (reachable: number, all: number) => `${reachable.toLocaleString()} of ${many(all, "device")} reachable`;
export const lostCount = (count: number) => `${count.toLocaleString()} lost`;
export const arriving = "Arriving";
export const lost = "Lost";
export const reason = "Reason";
export const attempts = "Attempts";
export const nextIn = (seconds: number) => `next attempt in ${seconds} s`;
export const nextNow = "trying now";
export const reopen = "Open now";
export const reopened = (network: string, state: string, reason: string) => `Opening ${network}: ${state}${reason && `, ${reason}`}`;
export const perSecond = (rate: string) => `${rate}/s`;
export const itsDevices = (count: number) => many(count, "device");
export const kinds = { loss: "Lost or refused", oddity: "Unusual", flow: "Traffic", fact: "State" };
export const nothing = "none";
export const yes = "yes";
export const no = "no";
export const zeros = (count: number) => many(count, "counter is 0", "counters are 0");
