import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { baseFeeds, catalog, chosenIsland, components, islands, islandsKnown, line, loadingOf, store, useFeeds } from "../app";
import type { Subscription } from "../core/feed";
import { usePaced } from "../core/hooks";
import { Rates } from "../core/rates";
import { second, useFrame } from "../core/redraw";
import { go, rememberList, route, type Route, setQuery } from "../core/router";
import { pinnedBranches, togglePin } from "../core/settings";
import type { Tuple } from "../core/store";
import { compareNatural, matches } from "../core/text";
import { type Branch, pathsAbove, Tree, type TreeOrder, type TreeRow } from "../core/tree";
import { FilterField, Choice } from "../parts/fields";
import { wantsOf } from "../core/tree_wants";
import { NoIsland } from "../parts/no_island";
import { phone } from "../parts/screen";
import { Loaded, NoneMatch } from "../parts/state";
import * as text from "../words/tuples";
import * as words from "../words/frame";
import { fewDevices } from "./devices";
import { FoundTuples, TupleTree } from "./tuple_tree";
import { TuplePanel } from "./tuple_panel";
import type { View } from "./views";

/** The open branches outlive the view. */
const openBranches = new Set<string>();

/** Samples until rates mean something: they are then taken once for the order by rate. */
const settled = 5;

/** Tree and rates live as long as the view. */
function useTree(): { tree: Tree; rates: Rates; samples: number } {
  const samples = useRef(0);
  const both = useMemo(() => ({ tree: new Tree(store), rates: new Rates(store, performance.now()) }), []);
  useEffect(
    () => () => {
      both.tree.end();
      both.rates.end();
    },
    [both],
  );
  useEffect(() => {
    both.rates.sample(performance.now());
    both.tree.takeRates(both.rates);
    samples.current = Math.min(samples.current + 1, settled);
  }, [second.value]);
  useEffect(() => {
    if (line.value === "lost") both.rates.interrupt();
  }, [line.value]);
  return { ...both, samples: samples.current };
}

/** Owners whose tuples are shown: each is one subscription to all of them. */
function ownersShown(tree: Tree): Branch[] {
  const island = chosenIsland();
  for (const component of [...islands.value, ...components.value]) tree.owner(component.id);
  return [...tree.owners.values()]
    .filter((branch) => !island || Number(branch.part) === island)
    .sort((a, b) => compareNatural(a.part, b.part));
}

/** The islands with so many devices that they are not asked for everything. */
function largeIslands(): Set<string> {
  const counts = new Map<number, number>();
  for (const { owner } of catalog.devices.values()) counts.set(owner, (counts.get(owner) ?? 0) + 1);
  return new Set([...counts].flatMap(([owner, count]) => (count > fewDevices ? [String(owner)] : [])));
}

function Tuples({ route }: { route: Route }) {
  useFrame();
  rememberList("tuples", route.query);
  const { tree, rates, samples } = useTree();
  const [version, setVersion] = useState(0);
  const chosen = route.parts[0] ?? "";
  const search = route.query.q ?? "";
  const order: TreeOrder = route.query.order === "rate" ? "rate" : "key";
  const owners = ownersShown(tree);
  // How many devices an island has is known when the lists of all islands have come.
  const known = loadingOf(baseFeeds) === "ready";
  useOpenAround(chosen, owners, known, () => setVersion((count) => count + 1));
  const large = useMemo(largeIslands, [catalog.structure]);
  const wanted = !known ? [] : search ? owners : owners.filter((branch) => openBranches.has(branch.path));
  const feeds = useFeeds(wanted.flatMap((branch) => wantsOf(branch.part, openBranches, large.has(branch.part))));
  const isLoading = (branch: Branch) =>
    openBranches.has(branch.path) && (!known || feeds.some((one) => isOf(one, branch) && !one.complete([Number(branch.part)])));
  const loading = owners.filter(isLoading);
  const rows = usePaced(
    String(tree.structure),
    () => tree.rows(openBranches, order, owners, isLoading),
    [version, order, owners.length, loading.length, chosenIsland()].join(),
  );
  const pins = pinnedBranches.value;
  const toggle = (branch: Branch, open = !openBranches.has(branch.path)) => {
    if (open) openBranches.add(branch.path);
    else openBranches.delete(branch.path);
    setVersion((count) => count + 1);
  };
  const setOrder = (next: string) => {
    tree.rank();
    setQuery({ order: next === "rate" ? next : "" });
    setVersion((count) => count + 1);
  };
  useEffect(() => setOrder(order), [order === "rate" && samples === settled]);
  if (islandsKnown.value && owners.length === 0) return <NoIsland />;
  const panel = chosen !== "" && (tree.find(chosen)?.tuple || !phone.value || !tree.find(chosen));
  return (
    <section class="view tuples">
      <div class="toolbar">
        <h1>{text.title}</h1>
        <FilterField value={search} label={text.filter} />
        <Choice
          label={text.order}
          value={order}
          values={["key", "rate"]}
          name={(own) => text.orders[own as TreeOrder]}
          onChange={setOrder}
        />
        {order === "rate" && (
          <button type="button" onClick={() => setOrder("rate")}>
            {words.tableUpdate}
          </button>
        )}
        <span class="count">{text.count(owners.reduce((sum, branch) => sum + branch.count, 0))}</span>
      </div>
      {pins.length > 0 && <Pins pins={pins} />}
      {search && owners.some(({ part }) => large.has(part)) && <p class="strip">{text.searchedPartly(fewDevices)}</p>}
      <div class="split">
        {!(phone.value && panel) && (
          <Loaded state={search ? loadingOf(feeds) : loadingOf(baseFeeds)}>
            {search ? (
              <Found search={search} rates={rates} chosen={chosen} />
            ) : (
              <Branches rows={rows} chosen={chosen} toggle={toggle} tree={tree} />
            )}
          </Loaded>
        )}
        {panel && <TuplePanel key={chosen} id={chosen} rates={rates} branch={tree.find(chosen)} />}
      </div>
    </section>
  );
}

/** Opens what is around the chosen tuple, and the only owner there is, unless that means very many tuples. */
function useOpenAround(chosen: string, owners: Branch[], known: boolean, opened: () => void): void {
  const only = owners.length === 1 ? owners[0]?.path : undefined;
  const few = known && catalog.devices.size <= fewDevices;
  const first = !few ? undefined : islands.value.length === 1 ? String(islands.value[0]?.id) : only;
  useEffect(() => {
    const paths = [
      ...pathsAbove(chosen),
      ...(chosen ? [chosen] : []),
      ...(openBranches.size === 0 && first ? [first, `${first}:proxy`] : []),
    ];
    for (const path of paths) openBranches.add(path);
    if (paths.length > 0) opened();
  }, [chosen, first]);
}

function Pins({ pins }: { pins: string[] }) {
  return (
    <div class="pins">
      <span class="muted">{text.pinned}</span>
      {pins.map((path) => (
        <button key={path} type="button" class="small" onClick={() => go("tuples", [path])}>
          {path}
        </button>
      ))}
    </div>
  );
}

interface BranchesProps {
  rows: TreeRow[];
  chosen: string;
  toggle(branch: Branch, open?: boolean): void;
  tree: Tree;
}

function Branches({ rows, chosen, toggle, tree }: BranchesProps) {
  const open = (branch: Branch) => {
    if (branch.tuple) go("tuples", [branch.path], queryOfNow());
    else toggle(branch);
  };
  return (
    <TupleTree
      rows={rows}
      chosen={chosen}
      openBranches={openBranches}
      onToggle={toggle}
      onOpen={open}
      onPin={(branch) => togglePin(pinnedBranches, branch.path)}
      tree={tree}
    />
  );
}

/** What the address says about filter and order stays when another tuple is chosen. */
function queryOfNow(): Record<string, string> {
  return route.value.query;
}

function isOf({ want }: Subscription, branch: Branch): boolean {
  return want.pattern.startsWith(`${branch.part}:`);
}

function Found({ search, rates, chosen }: { search: string; rates: Rates; chosen: string }) {
  const island = chosenIsland();
  const found = useMemo(() => {
    const tuples: Tuple[] = [];
    for (const tuple of store.tuples.values()) {
      if (!island || tuple.owner === island) if (matches(search, `${tuple.id} ${(tuple.value ?? "").slice(0, 200)}`)) tuples.push(tuple);
    }
    return tuples.sort((a, b) => compareNatural(a.id, b.id));
  }, [search, island, store.tuples.size]);
  if (found.length > 0)
    return <FoundTuples tuples={found} rates={rates} chosen={chosen} onOpen={(tuple) => go("tuples", [tuple.id], queryOfNow())} />;
  return <NoneMatch title={text.filtered} />;
}

export const tuplesView: View = { id: "tuples", title: text.title, key: "t", icon: "tuples", show: (route) => <Tuples route={route} /> };
