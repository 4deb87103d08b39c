import { useMemo } from "preact/hooks";
import { baseFeeds, catalog, loadingOf, useFeeds } from "../app";
import type { Device, Point } from "../core/catalog";
import { typeWords, unitSign } from "../core/format";
import { useFrame } from "../core/redraw";
import { go, hrefToList } from "../core/router";
import { compareNatural } from "../core/text";
import { Empty, Loaded, State } from "../parts/state";
import { type Column, Table } from "../parts/table";
import { Value } from "../parts/value";
import * as text from "../words/devices";
import * as words from "../words/frame";

/** Each device is one subscription of the connection. */
const most = 100;

/** The chosen devices against the types of their points. */
export function Compare({ paths }: { paths: string[] }) {
  useFrame();
  const devices = paths
    .slice(0, most)
    .map((path) => catalog.devices.get(path))
    .filter((device) => device !== undefined);
  const feeds = useFeeds(devices.map((device) => ({ pattern: `${device.owner}:${device.prefix}.${device.network}.${device.id}.*.*.*` })));
  const columns = useMemo(() => columnsOf(devices), [catalog.points, catalog.structure]);
  const rows = useMemo(() => devices.map((row) => ({ row })), [devices.map((device) => device.path).join(), catalog.structure]);
  return (
    <section class="view">
      <div class="toolbar">
        <h1>{text.compared}</h1>
        <a href={hrefToList("devices")}>{text.all}</a>
        <span class="count">
          {devices.length < paths.length ? words.tableShown(devices.length, paths.length) : text.count(devices.length)}
        </span>
      </div>
      <Loaded state={loadingOf([...baseFeeds, ...feeds])} empty={devices.length === 0 && <Empty title={text.noneCompared} />}>
        <Table
          label={text.compared}
          columns={columns}
          rows={rows}
          rowsVersion={rows}
          nameOf={(device) => device.path}
          sideways
          onOpen={(device) => go("devices", device.path.split("/"))}
        />
      </Loaded>
    </section>
  );
}

function pointsOf(device: Device, type: string): Point[] {
  return device.ordered.filter((point) => point.type === type);
}

function columnsOf(devices: Device[]): Column<Device>[] {
  const types = new Map<string, string>();
  for (const device of devices) {
    for (const point of device.points.values()) types.set(point.type, unitSign(point.unit) || (types.get(point.type) ?? ""));
  }
  const columns: Column<Device>[] = [
    { id: "name", title: text.name, width: "minmax(110px,1fr)", cell: (device) => device.name },
    { id: "state", title: text.state, width: "110px", cell: (device) => <State word={device.state} /> },
  ];
  for (const [type, unit] of [...types].sort(([a], [b]) => compareNatural(a, b))) {
    columns.push({
      id: type,
      title: `${typeWords(type)}${unit ? ` (${unit})` : ""}`,
      width: `${Math.max(90, 8 * type.length + 8 * unit.length + 16)}px`,
      numeric: true,
      cell: (device) =>
        pointsOf(device, type).map((point, index) => (
          <span key={point.id}>
            {index > 0 && " · "}
            <Value point={point} unit={false} />
          </span>
        )),
    });
  }
  return columns;
}
