import { number, text } from "./catalog";

/** What a network lets others watch: telegrams of KNX, packets of motes, messages of Zigbee2MQTT. */
export type TrafficKind = "knx" | "wsn" | "zigbee";

/** Request, reply and message types of each (docs/knx.md, docs/motes.md, docs/zigbee.md). */
export const types = {
  knx: { request: "knx.request", reply: "knx.reply", message: "knx.telegram" },
  wsn: { request: "wsn.request", reply: "wsn.reply", message: "wsn.packet" },
  zigbee: { request: "zigbee.request", reply: "zigbee.reply", message: "zigbee.message" },
} as const;

export interface Passing {
  id: number;
  time: number;
  out: boolean; // sent by the island
  kind: string; // write, read, response; join, readings, ...
  from: string;
  to: string;
  name: string;
  value: string;
  hex: string;
  raw: string; // the message as it came
}

/** As many as a busy bus sends in some minutes. */
export const kept = 5000;
/** Nothing moves while the user reads, until there are so many. */
export const keptWhileReading = 15_000;

export function readPassing(kind: TrafficKind, raw: string, id: number): Passing | null {
  let json: unknown;
  try {
    json = JSON.parse(raw);
  } catch {
    return null;
  }
  if (typeof json !== "object" || json === null) return null;
  const member = json as Record<string, unknown>;
  const common = { id, time: number(member.time), hex: text(member.hex), raw };
  if (kind === "knx") {
    const value = [text(member.value), text(member.unit)].filter(Boolean).join(" ");
    return {
      ...common,
      out: member.own === true,
      kind: text(member.service),
      from: text(member.source),
      to: text(member.address),
      name: text(member.name),
      value,
    };
  }
  if (kind === "zigbee") return { ...common, ...messageOf(member) };
  const mote = typeof member.mote === "number" ? String(member.mote) : text(member.mote);
  const out = text(member.direction) === "out";
  return { ...common, out, kind: text(member.kind), from: out ? "" : mote, to: out ? mote : "", name: "", value: text(member.text) };
}

/** The topic of a device is its name, with `set`, `get` or `availability` behind it; those of the bridge begin with `bridge/`. */
function messageOf(member: Record<string, unknown>): Omit<Passing, "id" | "time" | "hex" | "raw"> {
  const topic = text(member.topic);
  const [, name = topic, verb = ""] = /^(.*)\/(set|get|availability)$/.exec(topic) ?? [];
  const ofBridge = topic.startsWith("bridge/");
  const value = typeof member.text === "string" ? member.text : `${number(member.bytes)} bytes`;
  const out = text(member.direction) === "out";
  return { out, kind: ofBridge ? "bridge" : verb || "state", from: "", to: "", name: ofBridge ? topic.slice(7) : name, value };
}

export function searchedOf({ kind, from, to, name, value, hex }: Passing): string {
  return `${kind} ${from} ${to} ${name} ${value} ${hex}`;
}

export function bytesOf(hex: string): Uint8Array {
  const digits = hex.replace(/[^0-9a-f]/gi, "");
  return Uint8Array.from({ length: digits.length >> 1 }, (_, index) => Number.parseInt(digits.slice(2 * index, 2 * index + 2), 16));
}

/** One JSON object a line, as they came. */
export function jsonLines(passing: Passing[]): string {
  return passing.map(({ raw }) => `${raw}\n`).join("");
}

/** A group address of three or two levels, or a plain number. */
export function isGroup(address: string): boolean {
  const parts = address.split("/").map((part) => (/^\d+$/.test(part) ? Number(part) : Number.NaN));
  const limits = { 1: [65535], 2: [31, 2047], 3: [31, 7, 255] }[parts.length] ?? [];
  return parts.length === limits.length && parts.every((part, index) => part <= (limits[index] ?? -1)) && parts.some((part) => part > 0);
}

/** A frame of the network's own capture. */
export interface CapturedFrame {
  time: number; // nanoseconds since 1970
  out: boolean;
  cemi: string;
}

const linkRaw = 101; // LINKTYPE_RAW
const port = 3671;
const multicast = [224, 0, 23, 12];
const island = [127, 0, 0, 1];
const bus = [127, 0, 0, 2];

/** The frames as routing indications, for Wireshark; as `rubicon knx capture` writes them: IP addresses are made up. */
export function pcapOf(frames: CapturedFrame[]): Uint8Array {
  const chunks: Uint8Array[] = [pcapHead()];
  for (const { time, out, cemi } of frames) {
    const packet = ipPacket(out ? island : bus, bytesOf(cemi));
    const head = new DataView(new ArrayBuffer(16));
    head.setUint32(0, Math.floor(time / 1e9), true);
    head.setUint32(4, Math.floor((time % 1e9) / 1000), true);
    head.setUint32(8, packet.length, true);
    head.setUint32(12, packet.length, true);
    chunks.push(new Uint8Array(head.buffer), packet);
  }
  return joined(chunks);
}

function pcapHead(): Uint8Array {
  const head = new DataView(new ArrayBuffer(24));
  head.setUint32(0, 0xa1b2c3d4, true);
  head.setUint16(4, 2, true);
  head.setUint16(6, 4, true);
  head.setUint32(16, 65535, true);
  head.setUint32(20, linkRaw, true);
  return new Uint8Array(head.buffer);
}

/** IPv4 and UDP without UDP checksum around a KNXnet/IP ROUTING_INDICATION. */
function ipPacket(source: number[], cemi: Uint8Array): Uint8Array {
  const knx = 6 + cemi.length;
  const total = 20 + 8 + knx;
  const view = new DataView(new ArrayBuffer(total));
  view.setUint8(0, 0x45);
  view.setUint16(2, total);
  view.setUint8(8, 16);
  view.setUint8(9, 17);
  [...source, ...multicast].forEach((byte, index) => view.setUint8(12 + index, byte));
  view.setUint16(10, checksum(view));
  view.setUint16(20, port);
  view.setUint16(22, port);
  view.setUint16(24, 8 + knx);
  view.setUint16(28, 0x0610);
  view.setUint16(30, 0x0530);
  view.setUint16(32, knx);
  const packet = new Uint8Array(view.buffer);
  packet.set(cemi, 34);
  return packet;
}

function checksum(head: DataView): number {
  let sum = 0;
  for (let at = 0; at < 20; at += 2) sum += head.getUint16(at);
  while (sum > 0xffff) sum = (sum & 0xffff) + (sum >>> 16);
  return ~sum & 0xffff;
}

function joined(chunks: Uint8Array[]): Uint8Array {
  const all = new Uint8Array(chunks.reduce((sum, { length }) => sum + length, 0));
  let at = 0;
  for (const chunk of chunks) {
    all.set(chunk, at);
    at += chunk.length;
  }
  return all;
}
