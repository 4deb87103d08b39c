import { useEffect, useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";
import { baseFeeds, catalog, chosenIsland, islands, loadingOf, mayBe, noIslands, ownerPattern, useFeeds } from "../app";
import { type Network, networkToShow } from "../core/catalog";
import { formatFullTime, formatTime, hexDump, prettyJson } from "../core/format";
import { addShortcuts } from "../core/keyboard";
import { useFrame } from "../core/redraw";
import { type Route, setQuery } from "../core/router";
import { compareNatural, matches } from "../core/text";
import { bytesOf, jsonLines, kept, type Passing, searchedOf, type TrafficKind } from "../core/traffic";
import type { Watch } from "../core/watch";
import { FilterField, Choice } from "../parts/fields";
import { CopyButton } from "../parts/copy";
import { download, fileStamp } from "../parts/download";
import { useFollowing } from "../parts/following";
import { NoIsland } from "../parts/no_island";
import { phone } from "../parts/screen";
import { Empty, Loaded, State, NoneMatch } from "../parts/state";
import { Table } from "../parts/table";
import * as text from "../words/traffic";
import * as logText from "../words/log";
import * as words from "../words/frame";
import { Floods } from "./floods";
import { trafficColumns } from "./traffic_columns";
import { kindOf, watchOf } from "./traffic_monitor";
import { CaptureButton, WriteDialog } from "./traffic_tools";
import type { View } from "./views";

function Traffic({ route }: { route: Route }) {
  useFrame();
  const feeds = useFeeds([{ pattern: `${ownerPattern()}:*.*.property.*.value`, min: 1000 }]);
  const opened = useRef<string | undefined>(undefined);
  const island = chosenIsland();
  const networks = [...catalog.networks.values()]
    .filter((network) => (!island || network.owner === island) && kindOf(network) !== null)
    .sort((a, b) => compareNatural(a.path, b.path));
  const state = loadingOf([...baseFeeds, ...feeds]);
  const path = route.query.network ?? opened.current;
  // Which line is up is known when all networks are. The view stays with one that is up or used; of others, the first
  // that comes up is shown.
  const network = state === "loading" && !networks.some((one) => one.path === path) ? undefined : networkToShow(networks, path);
  if (network?.line === "up") opened.current = network.path;
  const kind = network && kindOf(network);
  if (noIslands()) return <NoIsland />;
  return (
    <section class="view traffic">
      <Loaded state={network ? "ready" : state} empty={!network && <Empty title={text.none} whole />}>
        {network && kind && (
          <Monitor
            key={network.path}
            network={network}
            kind={kind}
            networks={networks}
            search={route.query.q ?? ""}
            onUse={() => (opened.current = network.path)}
          />
        )}
      </Loaded>
      <Floods />
    </section>
  );
}

interface MonitorProps {
  network: Network;
  kind: TrafficKind;
  networks: Network[];
  search: string;
  onUse: () => void;
}

function Monitor({ network, kind, networks, search, onUse }: MonitorProps) {
  const monitor = watchOf(network, kind);
  const [paused, setPaused] = useState<Passing[] | null>(null);
  const [following, setFollowing] = useState(true);
  const [chosen, setChosen] = useState<Passing | null>(null);
  const [writing, setWriting] = useState(false);
  const all = paused ?? monitor.passing;
  const shown = useMemo(() => (search === "" ? all : all.filter((one) => matches(search, searchedOf(one)))), [all, search]);
  const rows = useMemo(() => shown.map((row) => ({ row })), [shown]);
  const columns = useMemo(() => trafficColumns(kind), [kind, phone.value]);
  const box = useFollowing(shown.length > 0, shown, following && !paused, setFollowing);
  monitor.reading = paused !== null || !following;
  useEffect(() => () => void (monitor.reading = false), [monitor]);
  const maySend = mayBe("command");
  const lineUp = network.line === "up" || network.line === "unknown";
  const toggle = () => {
    onUse();
    if (monitor.running) monitor.stop();
    else monitor.start();
  };
  const write = () => {
    onUse();
    setWriting(true);
  };
  const togglePause = () => setPaused(paused ? null : monitor.passing);
  useKeys(maySend ? toggle : undefined, togglePause);
  return (
    <>
      <div class="toolbar">
        <h1>{text.title}</h1>
        <Choice
          label={text.network}
          value={network.path}
          values={networks.map(({ path }) => path)}
          name={(path) => nameIn(networks, path)}
          onChange={(path) => setQuery({ network: path })}
          spoken
        />
        {maySend && (
          <button type="button" class={monitor.running ? "" : "primary"} onClick={toggle}>
            {monitor.running ? text.stop : text.start}
          </button>
        )}
        <button type="button" aria-pressed={paused !== null} disabled={all.length === 0} onClick={togglePause}>
          {paused ? text.resume(lastOf(monitor.passing) - lastOf(paused)) : text.pause}
        </button>
        <FilterField value={search} />
        <button
          type="button"
          disabled={shown.length === 0}
          onClick={() => download(`${fileStamp()}-${network.id}.jsonl`, jsonLines(shown), "application/x-ndjson")}
        >
          {text.save}
        </button>
        {kind === "knx" && maySend && <CaptureButton network={network} />}
        {kind === "knx" && maySend && (
          <button type="button" onClick={write}>
            {text.write}
          </button>
        )}
        {!following && !paused && (
          <button type="button" class="small accent" onClick={() => setFollowing(true)}>
            {logText.toEnd}
          </button>
        )}
        <span class="count">{words.tableShown(shown.length, all.length)}</span>
      </div>
      {monitor.running && (
        <div class="strip">
          {monitor.missed && <span>{text.missed(formatTime(monitor.missed.from), formatTime(monitor.missed.to))}</span>}
          {lineUp ? <State word={text.watching(network.id)} tone="good" /> : <State word={text.lineDown} tone="waiting" />}
        </div>
      )}
      {rows.length === 0 ? (
        <Nothing monitor={monitor} filtered={all.length} maySend={maySend} />
      ) : (
        <div class="log-lines" ref={box}>
          <Table
            label={text.title}
            columns={columns}
            rows={rows}
            rowsVersion={shown}
            nameOf={({ id }) => String(id)}
            marked={({ id }) => id === chosen?.id}
            onOpen={(one) => {
              setFollowing(false);
              setChosen(one.id === chosen?.id ? null : one);
            }}
          />
        </div>
      )}
      {chosen && <Whole one={chosen} onClose={() => setChosen(null)} />}
      {writing && <WriteDialog network={network} seen={monitor.passing} onClose={() => setWriting(false)} />}
    </>
  );
}

function nameIn(networks: Network[], path: string): string {
  const network = networks.find((one) => one.path === path);
  return islands.value.length > 1 ? `${network?.id} · ${network?.owner}` : (network?.id ?? "");
}

/** Its number; 0 if there is none. */
function lastOf(passing: Passing[]): number {
  return passing[passing.length - 1]?.id ?? 0;
}

function useKeys(toggle: (() => void) | undefined, pause: () => void): void {
  const latest = useRef({ toggle, pause });
  latest.current = { toggle, pause };
  useLayoutEffect(
    () =>
      addShortcuts([
        { keys: "w", what: text.toggleKey, run: () => latest.current.toggle?.() },
        { keys: "f", what: logText.pauseKey, run: () => latest.current.pause() },
      ]),
    [],
  );
}

function Nothing({ monitor, filtered, maySend }: { monitor: Watch; filtered: number; maySend: boolean }) {
  if (filtered > 0) {
    return <NoneMatch title={text.filtered} />;
  }
  if (monitor.running) return <Empty title={text.waiting} />;
  return (
    <Empty title={text.stopped}>
      <p>{maySend ? text.startText(kept) : text.mayNot}</p>
    </Empty>
  );
}

/** One telegram or packet whole: its bytes, and everything that was decoded. */
function Whole({ one, onClose }: { one: Passing; onClose(): void }) {
  return (
    <aside class="whole-line" tabIndex={0} aria-label={text.whole}>
      <p>
        <span class="muted">{formatFullTime(one.time)}</span> <strong>{[one.kind, one.to || one.from].filter(Boolean).join(" ")}</strong>{" "}
        {one.name}
      </p>
      {one.hex && <pre class="content">{hexDump(bytesOf(one.hex))}</pre>}
      <pre class="content">{prettyJson(one.raw) ?? one.raw}</pre>
      <div class="actions">
        <CopyButton text={one.raw} />
        <button type="button" class="small" onClick={onClose}>
          {words.close}
        </button>
      </div>
    </aside>
  );
}

export const trafficView: View = {
  id: "traffic",
  title: text.title,
  key: "m",
  icon: "traffic",
  show: (route) => <Traffic route={route} />,
};
