import type { Network } from "./catalog";

/** A network that plays a recording (src/networks/log/README.md). */
export interface Replay {
  network: Network;
  state: string; // playing, paused, ended
  speed: string; // a factor, or `max`
  position: number;
  begin: number; // NaN while it is not known
  end: number;
  /** Positions are times since 1970, not since the beginning. */
  absolute: boolean;
}

/** No recording is that long. */
const longestOffset = 1e8;

export function replayOf(network: Network): Replay | null {
  const state = network.counters.get("replay-state")?.value;
  if (!state) return null;
  const position = numberIn(network, "replay-position");
  const begin = numberIn(network, "replay-begin");
  const absolute = (Number.isNaN(position) ? begin : position) > longestOffset;
  return {
    network,
    state,
    speed: network.counters.get("replay-speed")?.value ?? "1",
    position,
    begin: absolute ? begin : begin || 0,
    end: numberIn(network, "replay-end"),
    absolute,
  };
}

function numberIn(network: Network, name: string): number {
  const value = network.counters.get(name)?.value;
  return value ? Number(value) : Number.NaN;
}

/** `OWNER:KEY` of what sets it. */
export function commandOf(network: Network, name: "state" | "speed" | "position"): string {
  return `${network.owner}:${network.prefix}.${network.id}.property.replay-${name}.command`;
}

/** `1:02:03.4`: how far into the recording. */
export function formatOffset(seconds: number): string {
  const whole = Math.floor(seconds);
  const two = (part: number) => String(part).padStart(2, "0");
  return `${Math.floor(whole / 3600)}:${two(Math.floor(whole / 60) % 60)}:${two(whole % 60)}`;
}

/** What the user may write for a position; empty if the network would refuse it. */
export function readSeek(text: string): string {
  const trimmed = text.trim();
  const known = /^[+-]?\d+(\.\d+)?(s|min|m|h|d)?$/.test(trimmed) || !Number.isNaN(Date.parse(trimmed));
  return known ? trimmed : "";
}
