import { useCallback, useEffect, useRef, useState } from "preact/hooks";
import { connection, line, useMessages } from "../app";
import type { Network } from "../core/catalog";
import type { Message } from "../core/frames";
import { kept, type Passing, readPassing, type TrafficKind, types } from "../core/traffic";
import { notify } from "../parts/notices";
import { words } from "../words";

const text = words.traffic;
/** The network stops by itself when nobody renews within this time. */
const lease = 60;
const renewal = 25_000;
/** The same for every page of this server: the network then sends each telegram once. */
const name = "page";

export function kindOf(network: Network): TrafficKind | null {
  if (network.counters.has("telegrams-received")) return "knx";
  return network.counters.has("packets-read") ? "wsn" : null;
}

function isFrom(message: Message, network: Network): boolean {
  return message.from === network.owner && (!message.network || message.network === network.id);
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

export interface Monitor {
  running: boolean;
  /** The network has its line. */
  up: boolean;
  passing: Passing[];
  start(): void;
  stop(): void;
  clear(): void;
}

/** Watches a network while it is asked to; renews before the lease ends, but not while the page is hidden. */
export function useMonitor(network: Network, kind: TrafficKind): Monitor {
  const [running, setRunning] = useState(false);
  const [up, setUp] = useState(true);
  const [passing, setPassing] = useState<Passing[]>([]);
  const incoming = useRef<Passing[]>([]);
  const lastId = useRef(0);
  const runningNow = useRef(false);
  runningNow.current = running;
  const took = useCallback(
    (message: Message) => {
      if (!runningNow.current || !isFrom(message, network)) return;
      const one = readPassing(kind, message.value ?? "", ++lastId.current);
      if (one) incoming.current.push(one);
    },
    [network, kind],
  );
  useMessages(types[kind].message, took);
  const stop = useCallback((why: string) => {
    setRunning(false);
    notify(why, "waiting");
  }, []);
  useReplies(network, kind, (reply) => {
    if (reply.id !== name) return;
    if (reply.ok === true) setUp(reply.line !== false);
    else stop(text.refused(String(reply.why ?? "")));
  });
  useBatches(incoming, setPassing);
  useRenewal(
    running && line.value === "live",
    () => requestOf(network, kind, { id: name, do: "monitor", seconds: lease }, (why) => stop(text.refused(why))),
    () => stop(text.ended),
  );
  return { running, up, passing, start: () => setRunning(true), stop: () => setRunning(false), clear: () => setPassing([]) };
}

/** Takes what came over some frames together: a busy bus would draw for each telegram. */
function useBatches(incoming: { current: Passing[] }, setPassing: (change: (before: Passing[]) => Passing[]) => void): void {
  useEffect(() => {
    const timer = setInterval(() => {
      const fresh = incoming.current;
      if (fresh.length === 0) return;
      incoming.current = [];
      setPassing((before) => [...before, ...fresh].slice(-kept));
    }, 200);
    return () => clearInterval(timer);
  }, []);
}

function useRenewal(running: boolean, renew: () => void, ended: () => void): void {
  const latest = useRef({ renew, ended });
  latest.current = { renew, ended };
  useEffect(() => {
    if (!running) return undefined;
    let renewed = Date.now();
    latest.current.renew();
    const timer = setInterval(() => {
      if (!document.hidden) {
        renewed = Date.now();
        latest.current.renew();
      } else if (Date.now() - renewed > lease * 1000) {
        latest.current.ended();
      }
    }, renewal);
    return () => clearInterval(timer);
  }, [running]);
}

/** Replies of the tools of a network; `id` says to which request. */
export function useReplies(network: Network, kind: TrafficKind, call: (reply: Record<string, unknown>) => void): void {
  const latest = useRef(call);
  latest.current = call;
  const took = useCallback(
    (message: Message) => {
      if (!isFrom(message, network)) return;
      try {
        latest.current(JSON.parse(message.value ?? "") as Record<string, unknown>);
      } catch {
        return; // no reply of a tool
      }
    },
    [network],
  );
  useMessages(types[kind].reply, took);
}
