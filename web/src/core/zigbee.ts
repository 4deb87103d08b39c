// What the tools of a ZigBee network tell (docs/zigbee.md): who joins, and who reaches whom.
import { list, number, text } from "./catalog";

/** A device that joins, as far as it got. */
export interface Joining {
  address: string;
  name: string;
  model: string;
  /** The last event: joined, interviewing, interviewed, failed, announced, left. */
  state: string;
  why: string;
}

/** While joining is permitted: until when, and who came. */
export class Pairing {
  readonly joins = new Map<string, Joining>();
  /** Why it ended before its time; empty if it did not. */
  why = "";

  constructor(
    readonly id: string,
    public until = 0, // seconds; 0: not permitted (any more)
  ) {}

  take(event: Record<string, unknown>): void {
    const state = text(event.event);
    if (state === "closed") {
      this.until = 0;
      this.why = text(event.why);
      return;
    }
    const address = text(event.address);
    if (address === "") return;
    const before = this.joins.get(address);
    const model = [text(event.vendor), text(event.model)].filter(Boolean).join(" ") || before?.model || "";
    const name = text(event.name) || before?.name || address;
    // A device that announces itself again is still what its interview found.
    const kept = state === "announced" && before ? before.state : state;
    this.joins.set(address, { address, name, model, state: kept, why: text(event.why) });
  }
}

export interface Node {
  address: string;
  name: string;
  role: string;
  failed: string[];
  x: number;
  y: number;
}

export interface Link {
  from: Node;
  to: Node;
  quality: number; // 0 to 255
  /** The way of a device to the coordinator. */
  way: boolean;
}

export interface ZigbeeMap {
  nodes: Node[];
  links: Link[];
  width: number; // pixels
  height: number;
}

/** Pixels between two hops, and between two names. */
const [hop, row] = [150, 30];

/** A tree from the coordinator on the left: each device as far to the right as it has hops, below those of the same way. */
export function mapOf(nodes: Record<string, unknown>[], links: Record<string, unknown>[]): ZigbeeMap {
  const known = new Map<string, Node>();
  for (const one of nodes) {
    const address = text(one.address);
    known.set(address, {
      address,
      name: text(one.name) || address,
      role: text(one.role).toLowerCase(),
      failed: list(one.failed),
      x: 0,
      y: 0,
    });
  }
  const drawn = [...strongest(known, links).values()].sort((a, b) => b.quality - a.quality);
  const root = [...known.values()].find(({ role }) => role === "coordinator") ?? [...known.values()][0];
  if (!root) return { nodes: [], links: [], width: 0, height: 0 };
  const children = ways(root, drawn);
  const reached = new Set([root, ...[...children.values()].flat()]);
  const lost = [...known.values()].filter((node) => !reached.has(node));
  children.set(root, [...(children.get(root) ?? []), ...lost]);
  return { nodes: [...known.values()], links: drawn, ...place(root, children) };
}

/** One link for each pair: the better of both directions. */
function strongest(known: Map<string, Node>, links: Record<string, unknown>[]): Map<string, Link> {
  const best = new Map<string, Link>();
  for (const one of links) {
    const from = known.get(text(one.source));
    const to = known.get(text(one.target));
    if (!from || !to || from === to) continue;
    const pair = [from.address, to.address].sort().join();
    const quality = number(one.quality);
    if ((best.get(pair)?.quality ?? -1) < quality) best.set(pair, { from, to, quality, way: false });
  }
  return best;
}

/** The devices behind each one, by the fewest hops, of those the best links; marks these links. */
function ways(root: Node, links: Link[]): Map<Node, Node[]> {
  const children = new Map<Node, Node[]>();
  const reached = new Set([root]);
  for (let front = [root]; front.length > 0;) {
    const next: Node[] = [];
    for (const link of links) {
      const [near, far] = front.includes(link.from) ? [link.from, link.to] : [link.to, link.from];
      if (!front.includes(near) || reached.has(far)) continue;
      reached.add(far);
      link.way = true;
      children.set(near, [...(children.get(near) ?? []), far]);
      next.push(far);
    }
    front = next;
  }
  return children;
}

/** Each device without others behind it has a row; the others are in the middle of theirs. */
function place(root: Node, children: Map<Node, Node[]>): { width: number; height: number } {
  let rows = 0;
  let deepest = 0;
  const lay = (node: Node, depth: number) => {
    deepest = Math.max(deepest, depth);
    const behind = children.get(node) ?? [];
    for (const child of behind) lay(child, depth + 1);
    node.x = depth * hop;
    const [first, last] = [behind[0], behind[behind.length - 1]];
    node.y = first && last ? (first.y + last.y) / 2 : rows++ * row;
  };
  lay(root, 0);
  return { width: (deepest + 1) * hop, height: rows * row };
}
