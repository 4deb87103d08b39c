import { text } from "./catalog";
import { Tuple } from "./store";

/** The tuple of a list of ignored devices: PREFIX.inbox.ignored. */
export const ignoredLeaf = ".ignored";

/** What an inbox lists as ignored, in the form of what waits there; named by address, which is how a decision names them. */
export class IgnoredDevices {
  #known = new Map<string, Tuple>();

  /** `inbox`: OWNER:PREFIX.inbox; rows that were there before remain the same objects. */
  read(lists: { inbox: string; value: string }[]): Tuple[] {
    const before = this.#known;
    this.#known = new Map();
    for (const { inbox, value } of lists) {
      const all = new Tuple("", 0, "");
      all.value = value;
      for (const device of objects(all.json.devices)) this.#take(inbox, device, before);
    }
    return [...this.#known.values()];
  }

  #take(inbox: string, device: Record<string, unknown>, before: ReadonlyMap<string, Tuple>): void {
    const id = `${inbox}.${text(device.network)}.${text(device.address)}`;
    const colon = id.indexOf(":");
    const tuple = before.get(id) ?? new Tuple(id, Number(id.slice(0, colon)), id.slice(colon + 1));
    tuple.value = JSON.stringify(device);
    this.#known.set(id, tuple);
  }
}

function objects(value: unknown): Record<string, unknown>[] {
  return Array.isArray(value) ? value.filter((one) => typeof one === "object" && one !== null) : [];
}
