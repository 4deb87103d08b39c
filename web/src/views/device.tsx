import { useEffect, useMemo, useState } from "preact/hooks";
import { active, baseFeeds, catalog, loadingOf, mayBe, measuredWants, useFeeds, wokenSensors } from "../app";
import type { Device, Point } from "../core/catalog";
import { prettyJson } from "../core/format";
import { redraw, useFrame } from "../core/redraw";
import { hrefTo, hrefToList } from "../core/router";
import { pinnedDevices, togglePin } from "../core/settings";
import { Age } from "../parts/age";
import { patience } from "../parts/sent";
import { CopyButton } from "../parts/copy";
import { MayNot } from "../parts/may_not";
import { prose } from "../parts/prose";
import { Empty, Loaded, Skeleton, State } from "../parts/state";
import { Table, type TableRow } from "../parts/table";
import * as text from "../words/device";
import * as commissionText from "../words/commission";
import * as commandText from "../words/command";
import * as plotsText from "../words/plots";
import * as words from "../words/frame";
import { DeviceDialog } from "./device_dialog";
import { mostPoints } from "./plot_picker";
import { pointColumns } from "./point_columns";
import { heightOfPoint } from "./point_heights";
import { PointDialog } from "./point_dialog";
import { useHourOf } from "./sparkline";

/** One device: its points with values and controls, and what it says about itself. */
export function DevicePage({ parts }: { parts: string[] }) {
  useFrame();
  const [owner = "", network = "", id = ""] = parts;
  const device = catalog.device(Number(owner), network, id);
  const prefix = device?.prefix ?? "*";
  const base = `${owner}:${prefix}.${network}.${id}`;
  const feeds = useFeeds([
    { pattern: `${base}.*.*.*` },
    ...(active.value ? [{ pattern: `${base}.sensor.*.value`, active: true, min: 50 }] : []),
    ...measuredWants(),
  ]);
  const state = loadingOf([...baseFeeds, ...feeds]);
  const name = device?.name;
  useEffect(() => {
    const before = document.title;
    if (name) document.title = `${name} – ${words.product}`;
    return () => {
      document.title = before;
    };
  }, [name]);
  if (!device) {
    if (state === "loading") return <Skeleton />;
    return (
      <Empty title={text.missing(`${network}.${id}`)} whole>
        <a href={hrefToList("devices")}>{text.all}</a>
      </Empty>
    );
  }
  return (
    <section class={`view device${device.state === "unreachable" ? " offline" : ""}`}>
      <Header device={device} />
      <MayNot needs="command" />
      <Loaded state={state} empty={device.points.size === 0 && <Empty title={text.noPoints} />}>
        <Points device={device} />
      </Loaded>
    </section>
  );
}

function Header({ device }: { device: Device }) {
  const [editing, setEditing] = useState(false);
  const pinned = pinnedDevices.value.includes(device.path);
  const plotted = device.ordered.flatMap((point) => (point.kind === "property" ? [] : [point.path])).slice(0, mostPoints);
  const facts = [
    device.model,
    device.area,
    text.address(String(device.description?.json.address ?? device.id)),
    text.of(device.network, device.owner),
  ].filter(Boolean);
  return (
    <header class="thing">
      <div class="thing-title">
        <h1>{device.name}</h1>
        <State word={device.state} />
        <span class="muted">
          {device.since > 0 && (
            <>
              {text.since} <Age time={device.since} />
            </>
          )}
          {device.reason && prose(` · ${device.reason}`)}
        </span>
        <div class="thing-actions">
          {mayBe("command") && <TimeToLive device={device} />}
          {mayBe("admin") && (
            <button type="button" onClick={() => setEditing(true)}>
              {commissionText.edit}
            </button>
          )}
          <button type="button" aria-pressed={pinned} onClick={() => togglePin(pinnedDevices, device.path)}>
            {pinned ? text.unpin : text.pin}
          </button>
          {plotted.length > 0 && (
            <a class="button" href={hrefTo("plots", [], { k: plotted.join() })}>
              {plotsText.title}
            </a>
          )}
          <a class="button" href={hrefTo("tuples", [`${device.owner}:${device.prefix}.${device.network}.${device.id}`])}>
            {text.tuples}
          </a>
        </div>
      </div>
      <div class="muted facts">{facts.join(" · ")}</div>
      {editing && <DeviceDialog device={device} onClose={() => setEditing(false)} />}
      <details class="about">
        <summary>{text.about}</summary>
        <Raw device={device} />
      </details>
    </header>
  );
}

const spans = [5, 60, 3600, 86400];

/** The choice holds for this device until its page is left. */
function TimeToLive({ device: { path } }: { device: Device }) {
  useEffect(() => () => patience.forget(path), [path]);
  const choose = (seconds: number) => {
    patience.choose(path, seconds);
    redraw();
  };
  return (
    <label class="field ttl" title={text.ttlTitle}>
      <span>{commandText.waits}</span>
      <select value={String(patience.of(path))} onChange={(event) => choose(Number(event.currentTarget.value))}>
        {spans.map((seconds) => (
          <option key={seconds} value={String(seconds)}>
            {text.span(seconds)}
          </option>
        ))}
      </select>
    </label>
  );
}

function Raw({ device }: { device: Device }) {
  return (
    <div class="raw">
      {(["description", "status"] as const).map((leaf) => {
        const tuple = device[leaf];
        if (!tuple) return null;
        return (
          <div key={leaf}>
            <p>
              <code>{tuple.id}</code> <CopyButton text={tuple.id} />
            </p>
            <pre tabIndex={0} role="region" aria-label={leaf}>
              {prettyJson(tuple.value ?? "") ?? tuple.value}
            </pre>
          </div>
        );
      })}
    </div>
  );
}

function rowsOf(device: Device): TableRow<Point>[] {
  const rows: TableRow<Point>[] = [];
  for (const kind of ["sensor", "actuator", "property"] as const) {
    const points = device.ordered.filter((point) => point.kind === kind);
    if (points.length > 0) rows.push({ group: text.kinds[kind], count: points.length }, ...points.map((row) => ({ row })));
  }
  return rows;
}

function Points({ device }: { device: Device }) {
  const ordered = device.ordered;
  const [opened, setOpened] = useState<Point | null>(null);
  const rows = useMemo(() => rowsOf(device), [device, ordered]);
  const described = ordered.filter((point) => point.description).length;
  const hour = useHourOf(device, ordered);
  const columns = useMemo(() => pointColumns(hour), [hour]);
  useEffect(() => {
    wokenSensors.value = active.value ? ordered.filter((point) => point.kind === "sensor").length : 0;
  }, [active.value, ordered]);
  return (
    <>
      <Table
        label={text.points(device.name)}
        columns={columns}
        rows={rows}
        rowsVersion={`${ordered.length} ${described} ${ordered.map(heightOfPoint).join()}`}
        heightOf={heightOfPoint}
        nameOf={(point) => `${point.kind}.${point.id}`}
        place={`device ${device.path}`}
        onOpen={(point) => setOpened(point)}
      />
      {opened && <PointDialog point={opened} onClose={() => setOpened(null)} />}
    </>
  );
}
