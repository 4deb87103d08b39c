// The keys of the proxy (docs/tuple-keys.md). The first part is the prefix of the island.

export type PointKind = "sensor" | "actuator" | "property";
export type Leaf = "value" | "status" | "description" | "command";

export type KeyMeaning =
  | { what: "point"; prefix: string; network: string; device: string; kind: PointKind; point: string; leaf: Leaf }
  | { what: "device"; prefix: string; network: string; device: string; leaf: "status" | "description" }
  | { what: "network"; prefix: string; network: string; leaf: "status" | "devices" }
  | { what: "counter"; prefix: string; network: string; name: string; leaf: Leaf }
  | { what: "waiting"; prefix: string; network: string; device: string }
  | { what: "inbox" | "alerts" | "overview"; prefix: string }
  | { what: "other" };

const kinds = new Set(["sensor", "actuator", "property"]);
const leaves = new Set(["value", "status", "description", "command"]);
/** Second parts that are no networks. */
const reserved = new Set(["history", "inbox", "property", "recorder", "settings"]);
const other: KeyMeaning = { what: "other" };

/** What a key of an island stands for. */
export function readKey(key: string): KeyMeaning {
  const parts = key.split(".");
  const [prefix = "", network = "", device = "", third = "", point = "", leaf = ""] = parts;
  if (parts.length === 4 && network === "inbox") return { what: "waiting", prefix, network: device, device: third };
  if (parts.length === 2 && (network === "inbox" || network === "alerts" || network === "overview")) return { what: network, prefix };
  if (reserved.has(network)) return other;
  switch (parts.length) {
    case 3:
      return device === "status" || device === "devices" ? { what: "network", prefix, network, leaf: device } : other;
    case 4:
      if (third !== "status" && third !== "description") return other;
      return { what: "device", prefix, network, device, leaf: third };
    case 5:
      if (device !== "property" || !leaves.has(point)) return other;
      return { what: "counter", prefix, network, name: third, leaf: point as Leaf };
    case 6:
      if (!kinds.has(third) || !leaves.has(leaf)) return other;
      return { what: "point", prefix, network, device, kind: third as PointKind, point, leaf: leaf as Leaf };
    default:
      return other;
  }
}
