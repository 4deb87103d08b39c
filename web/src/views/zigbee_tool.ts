import { connection, listenTo } from "../app";
import type { Network } from "../core/catalog";
import type { Message } from "../core/frames";
import { redraw } from "../core/redraw";
import { replyOf } from "../core/watch";
import { Pairing } from "../core/zigbee";
import * as text from "../words/zigbee";

type Reply = Record<string, unknown>;

/** The bridge has 10 s for an answer, two minutes for a map. */
const [patience, mapPatience] = [12_000, 130_000];

const waiting = new Map<string, (reply: Reply) => void>();
/** By the path of the network. They outlive the view: pairing takes minutes. */
const pairings = new Map<string, Pairing>();
let asked = 0;
let listening = false;

export function isZigbee(network: Network | undefined): boolean {
  return network?.counters.has("bridge") ?? false;
}

/** The pairing that this page began last on a network. */
export function pairingOf(network: Network): Pairing | undefined {
  return pairings.get(network.path);
}

function listen(): void {
  if (listening) return;
  listening = true;
  listenTo("zigbee.reply", (message) => {
    const reply = replyOf(message);
    waiting.get(String(reply?.id))?.(reply ?? {});
  });
  listenTo("zigbee.event", joined);
}

function joined(message: Message): void {
  const event = replyOf(message);
  if (!event) return;
  for (const pairing of pairings.values()) if (pairing.id === event.id) pairing.take(event);
  redraw();
}

/** Asks the tools of a network; the reply has `ok`, and `why` where it failed. Requests that change something need the role admin. */
export function askZigbee(network: Network, fields: Reply, call: (reply: Reply) => void, type = "zigbee.request"): string {
  listen();
  // Replies reach every page of this server: the names of requests must differ.
  const id = `page-${Math.random().toString(36).slice(2, 8)}-${++asked}`;
  const end = (reply: Reply) => {
    if (!waiting.delete(id)) return;
    clearTimeout(timer);
    call(reply);
    redraw();
  };
  const timer = setTimeout(() => end({ ok: false, why: text.noReply }), fields.do === "map" ? mapPatience : patience);
  waiting.set(id, end);
  connection.request(
    { do: "send", to: network.owner, network: network.id, type, value: JSON.stringify({ id, ...fields }) },
    ({ error }) => {
      if (error) end({ ok: false, why: error.text });
    },
  );
  return id;
}

export function changeZigbee(network: Network, fields: Reply, call: (reply: Reply) => void): string {
  return askZigbee(network, fields, call, "zigbee.admin");
}

/** Lets devices join for some seconds; 0 ends it. */
export function permit(network: Network, seconds: number, failed: (why: string) => void): void {
  const id = changeZigbee(network, { do: "permit", seconds }, (reply) => {
    if (reply.ok !== true) return failed(String(reply.why ?? ""));
    const pairing = pairings.get(network.path);
    if (pairing?.id === id) pairing.until = Number(reply.until) || 0;
  });
  if (seconds > 0) pairings.set(network.path, new Pairing(id));
}

/** The whole map, which comes in parts. */
export function readMap(network: Network, done: (nodes: Reply[], links: Reply[]) => void, failed: (why: string) => void): void {
  const nodes: Reply[] = [];
  const links: Reply[] = [];
  const read = (from: number) =>
    void askZigbee(network, { do: "map", from }, (reply) => {
      if (reply.ok !== true) return failed(String(reply.why ?? ""));
      nodes.push(...((reply.nodes ?? []) as Reply[]));
      links.push(...((reply.links ?? []) as Reply[]));
      const next = Number(reply.next);
      if (reply.more === true && next > from) read(next);
      else done(nodes, links);
    });
  read(0);
}
