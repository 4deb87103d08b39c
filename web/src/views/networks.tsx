import { useMemo, useRef } from "preact/hooks";
import { baseFeeds, catalog, chosenIsland, loadingOf, mayBe, noIslands, ownerPattern, useFeeds } from "../app";
import { type Network, number, text as textOf } from "../core/catalog";
import { arrivalsOf, CounterRates, lossesOf } from "../core/counters";
import { formatCount, formatRate } from "../core/format";
import { useOrder } from "../core/hooks";
import { second } from "../core/redraw";
import { go, hrefTo, rememberList, type Route, setQuery } from "../core/router";
import { compareNatural, matches } from "../core/text";
import { FilterField } from "../parts/fields";
import { Age } from "../parts/age";
import { NoIsland } from "../parts/no_island";
import { prose } from "../parts/prose";
import { coarse, moreLines, phone } from "../parts/screen";
import { Empty, Loaded, State, NoneMatch } from "../parts/state";
import { type Column, compareBy, Outdated, SortSelect, Table } from "../parts/table";
import * as text from "../words/networks";
import * as setup from "../words/setup";
import * as words from "../words/frame";
import { AddNetwork } from "./add_network";
import { KnxImport } from "./knx_import";
import { NetworkPanel, NextAttempt } from "./network_panel";
import type { View } from "./views";

interface Members {
  all: number;
  reachable: number;
}

/** Devices of each network, by its path. */
function membersOf(): Map<string, Members> {
  const members = new Map<string, Members>();
  for (const device of catalog.devices.values()) {
    const path = `${device.owner}/${device.network}`;
    const known = members.get(path) ?? { all: 0, reachable: 0 };
    known.all++;
    if (device.state === "reachable") known.reachable++;
    members.set(path, known);
  }
  return members;
}

function columnsOf(rates: CounterRates, members: Map<string, Members>): Column<Network>[] {
  const flow = (network: Network) => rates.of(arrivalsOf(network.counters));
  return [
    {
      id: "line",
      title: text.line,
      width: "112px",
      live: true,
      phone: "end",
      compare: (a, b) => compareNatural(a.line, b.line),
      cell: (network) => <State word={network.line} />,
    },
    {
      id: "name",
      title: text.network,
      width: "minmax(130px,1fr)",
      phone: "main",
      compare: (a, b) => compareNatural(a.id, b.id),
      cell: (network) => <strong class="name">{network.id}</strong>,
    },
    { id: "island", title: text.island, width: "72px", wide: true, compare: (a, b) => a.owner - b.owner, cell: (network) => network.owner },
    {
      id: "since",
      title: text.since,
      width: "72px",
      numeric: true,
      live: true,
      compare: (a, b) => number(b.status?.json.since) - number(a.status?.json.since),
      cell: (network) => <Age time={number(network.status?.json.since)} />,
    },
    {
      id: "devices",
      title: text.devices,
      width: "110px",
      numeric: true,
      phone: "sub",
      compare: (a, b) => a.devices - b.devices,
      cell: (network) => {
        const { all, reachable } = members.get(network.path) ?? { all: 0, reachable: 0 };
        return phone.value ? (
          <PhoneFacts network={network} devices={text.reachableDevices(reachable, all)} />
        ) : (
          text.reachable(reachable, all)
        );
      },
    },
    {
      id: "arriving",
      title: text.arriving,
      width: "84px",
      numeric: true,
      live: true,
      phone: "side",
      compare: (a, b) => (flow(b) || 0) - (flow(a) || 0),
      cell: (network) => (arrivalsOf(network.counters) ? <Rate rate={flow(network)} /> : <span class="muted">–</span>),
    },
    {
      id: "lost",
      title: text.lost,
      width: "92px",
      numeric: true,
      live: true,
      compare: (a, b) => lossesOf(b.counters) - lossesOf(a.counters),
      cell: (network) => <Lost network={network} />,
    },
    {
      id: "reason",
      title: text.reason,
      width: "minmax(200px,2.4fr)",
      cell: (network) => (
        <span class="muted reason uncut">
          <NextAttempt network={network} />
          {prose(textOf(network.status?.json.reason))}
        </span>
      ),
    },
  ];
}

/** Room for the whole reason. */
function heightOf({ status }: Network): number {
  const letters = textOf(status?.json.reason).length + (number(status?.json.next_attempt) > 0 ? 26 : 0);
  return phone.value ? 60 + moreLines(letters, innerWidth - 150) : (coarse.value ? 44 : 30) + moreLines(letters, 200);
}

function PhoneFacts({ network, devices }: { network: Network; devices: string }) {
  const lost = lossesOf(network.counters);
  const reason = textOf(network.status?.json.reason);
  return (
    <span class="uncut">
      {prose(reason || devices)}
      {lost > 0 && <span class="loss">{` · ${text.lostCount(lost)}`}</span>}
    </span>
  );
}

function Rate({ rate }: { rate: number }) {
  return Number.isNaN(rate) ? (
    <span class="muted">…</span>
  ) : (
    <span class={rate < 0.05 ? "muted" : ""}>{text.perSecond(formatRate(rate))}</span>
  );
}

function Lost({ network }: { network: Network }) {
  const lost = lossesOf(network.counters);
  return <span class={lost > 0 ? "loss" : "muted"}>{formatCount(lost)}</span>;
}

const besides = new Set(["island", "since", "arriving", "lost"]);

/** One row a network; the chosen one with all its counters. Drawn once a second. */
function Networks({ route }: { route: Route }) {
  rememberList("networks", route.query);
  const tick = second.value;
  const feeds = useFeeds([{ pattern: `${ownerPattern()}:*.*.property.*.value`, min: 1000 }]);
  const rates = useMemo(() => new CounterRates(), []);
  const sampled = useRef(-1);
  if (sampled.current !== tick) {
    sampled.current = tick;
    for (const network of catalog.networks.values()) rates.sample(network.counters.values(), Date.now() / 1000);
  }
  const [path] = route.parts;
  const chosen = path ? catalog.networks.get(path) : undefined;
  const members = useMemo(membersOf, [tick, catalog.structure]);
  const columns = columnsOf(rates, members);
  const { q = "", sort = "name" } = route.query;
  const island = chosenIsland();
  const sorted = columns.find((column) => column.id === sort.replace(/^-/, ""));
  const order = useOrder(() => catalog.networks.values(), catalog.structure, {
    name: JSON.stringify([q, sort, island]),
    keep: (network) => (!island || network.owner === island) && (q === "" || matches(q, `${network.id} ${network.line} ${network.owner}`)),
    compare: compareBy(columns, sort, (a, b) => compareNatural(a.id, b.id) || a.owner - b.owner),
    live: sorted?.live ?? false,
    complete: loadingOf([...baseFeeds, ...feeds]) === "ready",
  });
  const rows = useMemo(() => order.rows.map((row) => ({ row })), [order.rows]);
  if (noIslands() && catalog.networks.size === 0) return <NoIsland />;
  if (chosen && phone.value) return <NetworkPanel network={chosen} rates={rates} />;
  // Beside the panel there is room for what says how the networks are.
  const beside = path ? columns.filter(({ id }) => !besides.has(id)) : columns;
  return (
    <section class="view networks">
      <div class="toolbar">
        <h1>{text.title}</h1>
        <FilterField value={q} />
        {phone.value && <SortSelect columns={columns} sorting={{ by: sort, set: (by) => setQuery({ sort: by }) }} />}
        {mayBe("admin") && <SetupLinks />}
        <span class="count">{words.tableShown(order.rows.length, catalog.networks.size)}</span>
        <Outdated order={order} />
      </div>
      <Loaded state={loadingOf([...baseFeeds, ...feeds])} empty={rows.length === 0 && <NoNetworks filtered={catalog.networks.size > 0} />}>
        <div class="split">
          <Table
            label={text.title}
            columns={beside}
            rows={rows}
            rowsVersion={`${order.version} ${order.rows.map(heightOf).join()}`}
            heightOf={heightOf}
            nameOf={(network) => network.path}
            place={`networks ${q} ${sort}`}
            sorting={{ by: sort, set: (by) => setQuery({ sort: by === "name" ? "" : by }) }}
            marked={(network) => network === chosen}
            onOpen={(network) => go("networks", [network.path], { q, sort: route.query.sort ?? "" })}
          />
          {chosen && <NetworkPanel network={chosen} rates={rates} />}
          {path && !chosen && <NoSuchNetwork path={path} />}
        </div>
      </Loaded>
    </section>
  );
}

function SetupLinks() {
  return (
    <>
      <a class="button" href={hrefTo("networks", ["add"])}>
        {setup.add}
      </a>
      <a class="button" href={hrefTo("networks", ["import"])}>
        {setup.importKnx}
      </a>
    </>
  );
}

function NoSuchNetwork({ path }: { path: string }) {
  return (
    <aside class="panel" aria-label={path}>
      <Empty title={text.noSuch(path)}>
        <button type="button" onClick={() => go("networks")}>
          {words.close}
        </button>
      </Empty>
    </aside>
  );
}

function NoNetworks({ filtered }: { filtered: boolean }) {
  if (!filtered) {
    return (
      <Empty title={text.none}>
        <p>{text.noneText}</p>
        <pre class="content">{text.example}</pre>
        {mayBe("admin") && (
          <p class="actions">
            <SetupLinks />
          </p>
        )}
      </Empty>
    );
  }
  return <NoneMatch title={text.filtered} clear={{ q: "", island: "" }} />;
}

export const networksView: View = {
  id: "networks",
  title: text.title,
  key: "n",
  icon: "networks",
  show: (route) => {
    const [what] = route.parts;
    if (what === "add") return <AddNetwork />;
    return what === "import" ? <KnxImport route={route} /> : <Networks route={route} />;
  },
};
