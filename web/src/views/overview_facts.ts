import { type Catalog, number, text } from "../core/catalog";

export function reachableOf(catalog: Catalog, owner: number): { reachable: number; all: number } {
  let reachable = 0;
  let all = 0;
  for (const device of catalog.devices.values()) {
    if (device.owner !== owner) continue;
    all++;
    if (device.state === "reachable") reachable++;
  }
  return { reachable, all };
}

export interface Alert {
  owner: number;
  /** Key of the network, device or point. */
  about: string;
  problem: boolean;
  since: number; // seconds
  what: string;
  fix: string;
}

/** What needs a person, on all islands or one; problems first. `more` found no room in the lists. */
export function alertsIn(catalog: Catalog, island: number): { alerts: Alert[]; more: number } {
  const alerts: Alert[] = [];
  let more = 0;
  for (const { owner, json } of catalog.alerts.values()) {
    if (island && owner !== island) continue;
    more += number(json.more);
    for (const one of Array.isArray(json.alerts) ? json.alerts : []) if (isObject(one)) alerts.push(alertOf(owner, one));
  }
  return { alerts: alerts.sort((a, b) => Number(b.problem) - Number(a.problem)), more };
}

function isObject(value: unknown): value is Record<string, unknown> {
  return typeof value === "object" && value !== null;
}

function alertOf(owner: number, one: Record<string, unknown>): Alert {
  const problem = one.severity === "problem";
  return { owner, about: text(one.about), problem, since: number(one.since), what: text(one.what), fix: text(one.fix) };
}

/** Where an alert leads: the page of its device, or that of its network; null for the island itself. */
export function placeOf(catalog: Catalog, { owner, about }: Alert): { view: string; path: string[] } | null {
  const [, network = "", device = ""] = about.split(".");
  if (catalog.device(owner, network, device)) return { view: "devices", path: [String(owner), network, device] };
  const path = `${owner}/${network}`;
  return catalog.networks.has(path) ? { view: "networks", path: [path] } : null;
}

/** The inboxes of all islands, or of one. */
export function waitingIn(catalog: Catalog, island: number): { waiting: number; ignored: number } {
  let waiting = 0;
  let ignored = 0;
  for (const tuple of catalog.inboxes.values()) {
    if (island && tuple.owner !== island) continue;
    waiting += number(tuple.json.count);
    ignored += number(tuple.json.ignored);
  }
  return { waiting, ignored };
}
