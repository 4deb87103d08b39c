import { useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";
import { islands, server } from "../app";
import { csvOf } from "../core/csv";
import { formatTime, zoneName } from "../core/format";
import { addShortcuts } from "../core/keyboard";
import { boundsOf, moved, rangeQuery, readRange, type TimeRange, zoomed } from "../core/plot_time";
import { second } from "../core/redraw";
import { type Route, setQuery } from "../core/router";
import { serverNow } from "../core/server_time";
import { CopyButton } from "../parts/copy";
import { download, fileStamp } from "../parts/download";
import { NotWritten } from "../parts/not_written";
import { Empty } from "../parts/state";
import * as text from "../words/plots";
import { PlotCanvas } from "./plot_canvas";
import { PlotLanes } from "./plot_lanes";
import { nameOf, PlotLegend, readingOf } from "./plot_legend";
import { mostPoints, PlotPicker } from "./plot_picker";
import { PlotToolbar } from "./plot_toolbar";
import { type Past, type Plotted, useTracks } from "./plot_tracks";
import type { View } from "./views";

function Plots({ route }: { route: Route }) {
  const paths = (route.query.k ?? "").split(",").filter(Boolean).slice(0, mostPoints);
  const [picking, setPicking] = useState(false);
  const choose = (chosen: string[]) => setQuery({ k: chosen.join(",") });
  return (
    <section class="view plots">
      {paths.length > 0 ? (
        <Plot route={route} paths={paths} choose={choose} onPick={() => setPicking(true)} />
      ) : (
        <NoPoints onPick={() => setPicking(true)} />
      )}
      {picking && <PlotPicker chosen={paths} onChange={choose} onClose={() => setPicking(false)} />}
    </section>
  );
}

function NoPoints({ onPick }: { onPick(): void }) {
  return (
    <>
      <div class="toolbar">
        <h1>{text.title}</h1>
      </div>
      <Empty title={text.none}>
        <p>{text.noneText(mostPoints)}</p>
        <p>
          <button type="button" class="primary" onClick={onPick}>
            {text.pick}
          </button>
        </p>
        <NoHistory />
      </Empty>
    </>
  );
}

/** Nothing where the server keeps a history. */
function NoHistory() {
  if (server.value?.history !== false) return null;
  return (
    <p class="strip">
      {text.noHistory} <code>{text.historyLine}</code> <CopyButton text={text.historyLine} />
    </p>
  );
}

/** The range of the address, and the way back through the zooms. */
function useRange(route: Route) {
  const range = readRange(route.query);
  const stack = useRef<TimeRange[]>([]);
  const set = (next: TimeRange) => {
    stack.current = [...stack.current, range].slice(-50);
    setQuery(rangeQuery(next));
  };
  const back = () => {
    const before = stack.current.pop();
    if (before) setQuery(rangeQuery(before));
  };
  return { range, set, back };
}

interface PlotProps {
  route: Route;
  paths: string[];
  choose(paths: string[]): void;
  onPick(): void;
}

function Plot({ route, paths, choose, onPick }: PlotProps) {
  void second.value; // the live edge moves
  const { range, set, back } = useRange(route);
  const { plotted, unknown, past, retry } = useTracks(paths, range);
  const [at, setAt] = useState(0);
  const [box, setBox] = useState({ left: 0, width: 0 });
  const present = serverNow();
  const bounds = boundsOf(range, present);
  // The live edge moves by whole pixels: a second, or more where a pixel is more.
  const step = range.span ? Math.max(1, range.span / 1000) : 1;
  const steady = range.span ? boundsOf(range, Math.ceil(present / step) * step) : bounds;
  const crossed = at >= steady.from && at <= steady.to && at > 0;
  const save = () =>
    download(
      `${fileStamp()}.csv`,
      csvOf(
        plotted.map((one) => ({ name: one.path, track: one.track })),
        steady.from,
        steady.to,
      ),
      "text/csv",
    );
  // What is said at the crosshair changes with the crosshair only: a screen reader reads each change aloud.
  const said = useMemo(() => spoken(plotted, at), [at, paths.join()]);
  const keys = usePlotKeys({ bounds: steady, at, setAt, set, back, plotted });
  return (
    <>
      <PlotToolbar range={range} bounds={steady} at={crossed ? at : 0} onRange={set} onBack={back} onPick={onPick} onSave={save} />
      <PastState past={past} retry={retry} />
      {/* The page of an island has the name of the island. */}
      <NotWritten owners={[server.value, ...islands.value.filter(({ name }) => name === server.value?.name)]} />
      {unknown.length === plotted.length ? (
        <Empty title={text.unknown(unknown.map(nameOf).join(", "))}>
          <p>{text.unknownText}</p>
        </Empty>
      ) : (
        <div
          class="plot"
          tabIndex={0}
          role="slider"
          aria-label={text.label(plotted.map(nameOf).join(", "), formatTime(steady.from), formatTime(steady.to))}
          aria-roledescription={text.role}
          aria-valuemin={0}
          aria-valuemax={Math.round(steady.to)}
          aria-valuenow={crossed ? Math.round(at) : 0}
          aria-valuetext={crossed ? said : text.noCrosshair}
          onKeyDown={keys}
        >
          <PlotCanvas
            plotted={plotted}
            bounds={steady}
            now={present}
            at={crossed ? at : 0}
            onAt={setAt}
            onZoom={(from, to) => set({ span: 0, from, to })}
            onBack={back}
            onBox={(left, width) => setBox((known) => (known.left === left && known.width === width ? known : { left, width }))}
          />
          <PlotLanes plotted={plotted} bounds={steady} now={present} left={box.left} width={box.width} at={crossed ? at : 0} onAt={setAt} />
        </div>
      )}
      <PlotLegend
        plotted={plotted}
        unknown={unknown}
        at={crossed ? at : Math.min(present, steady.to)}
        bounds={steady}
        crossed={crossed}
        onRemove={(path) => choose(paths.filter((other) => other !== path))}
      />
      <p class="zone muted">{text.zone(Intl.DateTimeFormat().resolvedOptions().timeZone, zoneName())}</p>
    </>
  );
}

/** What a screen reader says at the crosshair. */
function spoken(plotted: Plotted[], at: number): string {
  return [formatTime(at), ...plotted.map((one) => `${nameOf(one)} ${readingOf(one, one.track.at(at))}`)].join(", ");
}

function PastState({ past, retry }: { past: Past; retry(): void }) {
  if (typeof past === "object") {
    return (
      <div class="strip bad" role="alert">
        {text.failed(past.code, past.text)}
        <button type="button" class="small" onClick={retry}>
          {text.retry}
        </button>
      </div>
    );
  }
  if (past === "loading") return <div class="strip loading">{text.loading}</div>;
  return past === "none" ? <NoHistory /> : null;
}

interface KeyUse {
  bounds: { from: number; to: number };
  at: number;
  setAt(at: number): void;
  set(range: TimeRange): void;
  back(): void;
  plotted: Plotted[];
}

/** Keys of the plot while it has the focus, and those for everywhere in the view. */
function usePlotKeys(use: KeyUse): (event: KeyboardEvent) => void {
  const latest = useRef(use);
  latest.current = use;
  const centre = () => {
    const { bounds, at } = latest.current;
    return at > 0 ? at : (bounds.from + bounds.to) / 2;
  };
  const zoom = (factor: number) => latest.current.set(zoomed(latest.current.bounds, centre(), factor));
  const cross = (share: number) => {
    const { bounds, at, setAt } = latest.current;
    const from = at > 0 ? at : share > 0 ? bounds.from : bounds.to;
    setAt(Math.min(bounds.to, Math.max(bounds.from, from + share * (bounds.to - bounds.from))));
  };
  const pan = (share: number) => latest.current.set(moved(latest.current.bounds, share));
  useLayoutEffect(
    () =>
      addShortcuts([
        { keys: "+", what: text.zoomIn, run: () => zoom(0.5) },
        { keys: "-", what: text.zoomOut, run: () => zoom(2) },
        { keys: "0", what: text.back, run: () => latest.current.back() },
        { keys: "ArrowLeft", what: text.crossLeft, run: () => cross(-0.01) },
        { keys: "ArrowRight", what: text.crossRight, run: () => cross(0.01) },
        { keys: "PageUp", what: text.earlier, run: () => pan(-0.5) },
        { keys: "PageDown", what: text.later, run: () => pan(0.5) },
      ]),
    [],
  );
  return (event) => {
    const steps: Record<string, () => void> = {
      ArrowLeft: () => cross(event.shiftKey ? -0.1 : -0.01),
      ArrowRight: () => cross(event.shiftKey ? 0.1 : 0.01),
      Home: () => latest.current.setAt(latest.current.bounds.from),
      End: () => latest.current.setAt(latest.current.bounds.to),
      Escape: () => latest.current.setAt(0),
    };
    const run = steps[event.key];
    if (!run || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    run();
  };
}

export const plotsView: View = {
  id: "plots",
  title: text.title,
  key: "p",
  icon: "plots",
  wakes: ({ query }) => (query.k ?? "") !== "",
  show: (route) => <Plots route={route} />,
};
