import { effect } from "@preact/signals";
import { useCallback, useRef } from "preact/hooks";
import { connection, line, listenTo, useMessages } from "../app";
import type { Network } from "../core/catalog";
import { browserClock } from "../core/clock";
import type { Message } from "../core/frames";
import { redraw } from "../core/redraw";
import { type TrafficKind, types } from "../core/traffic";
import { replyOf, Watch } from "../core/watch";
import { notify } from "../parts/notices";
import * as text from "../words/traffic";
import { isZigbee } from "./zigbee_tool";

export function kindOf(network: Network): TrafficKind | null {
  if (network.counters.has("telegrams-received")) return "knx";
  if (network.counters.has("packets-read")) return "wsn";
  return isZigbee(network) ? "zigbee" : null;
}

/** Sends a request to the tools of a network. */
export function requestOf(network: Network, kind: TrafficKind, request: Record<string, unknown>, failed: (why: string) => void): void {
  connection.request(
    { do: "send", to: network.owner, network: network.id, type: types[kind].request, value: JSON.stringify(request) },
    (answer) => {
      if (answer.error) failed(answer.error.text);
    },
  );
}

/** By the path of the network. They outlive the view: one may watch, go to a device, command it and come back. */
const watches = new Map<string, Watch>();

function renewAll(): void {
  for (const watch of watches.values()) watch.renew();
}

effect(() => {
  if (line.value === "live") renewAll();
  if (line.value === "lost") for (const watch of watches.values()) watch.interrupt();
});
document.addEventListener("visibilitychange", () => !document.hidden && renewAll());

export function watchOf(network: Network, kind: TrafficKind): Watch {
  const known = watches.get(network.path);
  if (known) return known;
  const watch = new Watch(network.owner, network.id, kind, browserClock, {
    listen: listenTo,
    send: (request, failed) => requestOf(network, kind, request, failed),
    live: () => line.value === "live",
    hidden: () => document.hidden,
    changed: redraw,
    refused: (why) => notify(text.refused(why), "bad"),
    ended: () => notify(text.ended, "bad"),
  });
  watches.set(network.path, watch);
  return watch;
}

/** Replies of the tools of a network; `id` says to which request. */
export function useReplies(network: Network, kind: TrafficKind, call: (reply: Record<string, unknown>) => void): void {
  const latest = useRef(call);
  latest.current = call;
  const took = useCallback(
    (message: Message) => {
      if (message.from !== network.owner || (message.network && message.network !== network.id)) return;
      const reply = replyOf(message);
      if (reply) latest.current(reply);
    },
    [network],
  );
  useMessages(types[kind].reply, took);
}
