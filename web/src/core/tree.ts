import type { Rates } from "./rates";
import type { Store, Tuple } from "./store";
import { compareNatural } from "./text";

const noChildren: ReadonlyMap<string, Branch> = new Map();

/** An owner, or a part of a key with all that is below it. Most are leaves: what only branches with children have is made with the first. */
export class Branch {
  private made: Map<string, Branch> | null = null;
  tuple?: Tuple;
  /** Tuples here and below. */
  count = 0;
  /** Sets a second, here and below. */
  rate = 0;
  /** The rate by which it was put in order. */
  rank = 0;
  private sorted: Branch[] | null = null;
  private sortedBy = "";

  constructor(
    readonly part: string,
    readonly parent: Branch | null,
  ) {}

  /** OWNER or OWNER:KEY. */
  get path(): string {
    if (!this.parent) return this.part;
    return `${this.parent.path}${this.parent.parent ? "." : ":"}${this.part}`;
  }

  get children(): ReadonlyMap<string, Branch> {
    return this.made ?? noChildren;
  }

  put(child: Branch): void {
    this.made ??= new Map();
    this.made.set(child.part, child);
    this.sorted = null;
  }

  drop(child: Branch): void {
    this.made?.delete(child.part);
    if (this.made?.size === 0) this.made = null;
    this.sorted = null;
  }

  childrenBy(order: TreeOrder, turn: number): Branch[] {
    const by = `${order} ${turn}`;
    if (this.sorted && this.sortedBy === by) return this.sorted;
    this.sortedBy = by;
    const byKey = (a: Branch, b: Branch) => compareNatural(a.part, b.part);
    this.sorted = [...this.children.values()].sort(order === "rate" ? (a, b) => b.rank - a.rank || byKey(a, b) : byKey);
    return this.sorted;
  }
}

export type TreeOrder = "key" | "rate";

export interface TreeRow {
  branch: Branch;
  level: number; // from 1
  size: number; // of its siblings
  place: number; // among them, from 1
  /** Stands for rows that are still on their way. */
  pending?: number;
}

/** Rows that are shown for an owner whose tuples are still on their way. */
const pendingRows = 3;

/** The tuples of the store by owner and the parts of their keys. */
export class Tree {
  readonly owners = new Map<number, Branch>();
  /** Grows when branches come or go. */
  structure = 0;
  private turn = 0;
  private rated: Branch[] = [];
  private readonly stop: () => void;

  constructor(store: Store) {
    this.stop = store.listen({ added: (tuple) => this.add(tuple), removed: (tuple) => this.remove(tuple) });
  }

  end(): void {
    this.stop();
  }

  /** A component without tuples is a branch too. */
  owner(id: number): Branch {
    let branch = this.owners.get(id);
    if (!branch) {
      branch = new Branch(String(id), null);
      this.owners.set(id, branch);
      this.structure++;
    }
    return branch;
  }

  find(path: string): Branch | undefined {
    const [owner = "", key] = split(path);
    let branch = this.owners.get(Number(owner));
    for (const part of key === undefined ? [] : key.split(".")) branch = branch?.children.get(part);
    return branch;
  }

  /** Takes the rates of now for the order by rate. */
  rank(): void {
    const visit = (branch: Branch) => {
      branch.rank = branch.rate;
      for (const child of branch.children.values()) visit(child);
    };
    for (const owner of this.owners.values()) visit(owner);
    this.turn++;
  }

  /** Adds up the rates of all tuples; call it after each sample. */
  takeRates(rates: Rates): void {
    for (const branch of this.rated) branch.rate = 0;
    this.rated = [];
    for (const { tuple, rate } of rates.moving()) {
      for (let branch = this.find(tuple.id) ?? null; branch; branch = branch.parent) {
        if (branch.rate === 0) this.rated.push(branch);
        branch.rate += rate;
      }
    }
  }

  /** What is visible: the owners, and what is below the branches whose paths are open. */
  rows(open: ReadonlySet<string>, order: TreeOrder, owners: Branch[], loading: (owner: Branch) => boolean = () => false): TreeRow[] {
    const rows: TreeRow[] = [];
    const visit = (branches: Branch[], level: number) => {
      branches.forEach((branch, index) => {
        rows.push({ branch, level, size: branches.length, place: index + 1 });
        if (!open.has(branch.path)) return;
        if (branch.children.size > 0) visit(branch.childrenBy(order, this.turn), level + 1);
        if (branch.parent || !loading(branch)) return;
        for (let pending = 1; pending <= pendingRows; pending++)
          rows.push({ branch, level: level + 1, size: pendingRows, place: pending, pending });
      });
    };
    visit(owners, 1);
    return rows;
  }

  private add(tuple: Tuple): void {
    let branch = this.owner(tuple.owner);
    branch.count++;
    for (const part of tuple.key.split(".")) {
      let child = branch.children.get(part);
      if (!child) {
        child = new Branch(part, branch);
        branch.put(child);
        this.structure++;
      }
      child.count++;
      branch = child;
    }
    branch.tuple = tuple;
  }

  private remove(tuple: Tuple): void {
    const leaf = this.find(tuple.id);
    if (!leaf) return;
    leaf.tuple = undefined;
    for (let branch: Branch | null = leaf; branch; branch = branch.parent) {
      branch.count--;
      if (branch.count > 0 || !branch.parent) continue;
      branch.parent.drop(branch);
      this.structure++;
    }
  }
}

/** OWNER:KEY apart; the key may contain colons. */
function split(path: string): [string, string | undefined] {
  const colon = path.indexOf(":");
  return colon < 0 ? [path, undefined] : [path.slice(0, colon), path.slice(colon + 1)];
}

/** The paths of the branches around this one, from its owner on. */
export function pathsAbove(path: string): string[] {
  const [owner, key] = split(path);
  if (key === undefined) return [];
  const parts = key.split(".");
  return [owner, ...parts.slice(1).map((_, index) => `${owner}:${parts.slice(0, index + 1).join(".")}`)];
}
