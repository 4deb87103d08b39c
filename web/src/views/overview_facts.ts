import type { Catalog, Device, Network, Point } from "../core/catalog";
import { number } from "../core/catalog";
import { type Outcome, outcomeOf, toneOf } from "../core/commands";
import { compareNatural } from "../core/text";

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

/** Networks whose line is not up; a recording that ended is no trouble. */
export function linesNotUp(catalog: Catalog): Network[] {
  return [...catalog.networks.values()]
    .filter(({ line }) => line !== "unknown" && line !== "up" && line !== "ended")
    .sort((a, b) => a.owner - b.owner || compareNatural(a.id, b.id));
}

/** Unreachable devices, those that went last first. */
export function gone(catalog: Catalog): Device[] {
  return [...catalog.devices.values()].filter((device) => device.state === "unreachable").sort((a, b) => b.since - a.since);
}

/** Points whose last command ended badly, the latest first. */
export function failingCommands(catalog: Catalog): { point: Point; outcome: Outcome }[] {
  const failing: { point: Point; outcome: Outcome }[] = [];
  for (const device of catalog.devices.values()) {
    for (const point of device.points.values()) {
      if (point.kind === "sensor" || !point.status?.value?.includes('"command"')) continue;
      const outcome = outcomeOf(point.status.json);
      if (outcome && toneOf(outcome.state) === "bad") failing.push({ point, outcome });
    }
  }
  return failing.sort((a, b) => b.outcome.since - a.outcome.since);
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
