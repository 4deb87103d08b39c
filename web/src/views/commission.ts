// Names, rooms and what becomes of devices: sets of ordinary tuples (docs/tuple-keys.md, docs/inbox.md).
import type { Device } from "../core/catalog";
import type { Answer } from "../core/frames";
import { notify } from "../parts/notices";
import { setTuple } from "../parts/sent";
import * as text from "../words/commission";

/** Gives a device the members that change; `""` takes one away. */
export function describe(device: Device, change: { name?: string; area?: string }, call: (answer: Answer) => void): void {
  const { owner, prefix, network, id } = device;
  setTuple(`${owner}:${prefix}.${network}.${id}.description`, JSON.stringify(change), {}, call);
}

/** Gives a room to each of the devices; says at the end what came of it. */
export function giveRoom(devices: Device[], area: string): void {
  let left = devices.length;
  const failures: string[] = [];
  for (const device of devices) {
    describe(device, { area }, ({ error }) => {
      if (error) failures.push(error.text);
      if (--left > 0) return;
      const [why] = failures;
      if (why === undefined) notify(text.given(devices.length, area), "good");
      else notify(text.notGiven(failures.length, devices.length, why), "bad");
    });
  }
}

/** The inbox of its island lets the device go. */
export function dismiss(device: Device, verb: "ignore" | "forget", call: (answer: Answer) => void): void {
  const { owner, prefix, network, id } = device;
  setTuple(`${owner}:${prefix}.inbox`, `${verb} ${network}.${id}`, {}, call);
}
