import { signal } from "@preact/signals";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { baseFeeds, catalog, chosenIsland, hasRoom, islands, loadingOf, mayBe, noIslands, ownerPattern, useFeeds } from "../app";
import type { Device } from "../core/catalog";
import { useOrder } from "../core/hooks";
import { useFrame } from "../core/redraw";
import { go, rememberList, type Route, setQuery } from "../core/router";
import { pinnedDevices, togglePin } from "../core/settings";
import { compareNatural, matches } from "../core/text";
import { Empty, Loaded, NoneMatch } from "../parts/state";
import { compareBy, Table, type TableRow } from "../parts/table";
import * as text from "../words/devices";
import * as words from "../words/frame";
import { NoIsland } from "../parts/no_island";
import { Compare } from "./compare";
import { DevicePage } from "./device";
import { deviceColumns, groupOf, ofPoints, qualityOf } from "./device_columns";
import { RoomDialog } from "./device_dialog";
import { DeviceFilters, type Filters, readFilters } from "./device_filters";
import { dragged, RoomTargets } from "./room_targets";
import type { View } from "./views";

/** Up to so many devices, states and descriptions of all points come along; beyond, only those of the rows that are shown. */
export const fewDevices = 1000;
/** Each shown row is a subscription then; a connection has 256. */
const mostRows = 100;
/** The values of all points wait for the list of devices as long as it grows: an island may send nothing. */
const listTime = 2000;

/** Those to compare; the choice outlives the view. */
const chosenDevices = signal<ReadonlySet<string>>(new Set());

function keeps(filters: Filters, island: number): (device: Device) => boolean {
  const { search, network, type, quality } = filters;
  return (device) => {
    if (island && device.owner !== island) return false;
    if (network && device.network !== network) return false;
    if (type && !device.offers(type)) return false;
    if (quality && qualityOf(device) !== quality) return false;
    return search === "" || matches(search, `${device.name} ${device.id} ${device.network} ${device.model} ${device.area} ${device.owner}`);
  };
}

function byName(a: Device, b: Device): number {
  return compareNatural(a.name, b.name) || compareNatural(a.path, b.path);
}

/** Pinned devices first, then the groups in their order, each under its head. */
function grouped(devices: Device[], group: string, pins: string[]): TableRow<Device>[] {
  const pinned = pins.map((path) => devices.find((device) => device.path === path)).filter((device) => device !== undefined);
  const groups = new Map<string, Device[]>();
  if (pinned.length > 0) groups.set(text.pinned, pinned);
  const isPinned = new Set(pinned);
  for (const device of devices) {
    if (isPinned.has(device)) continue;
    const name = group ? groupOf(device, group) : text.title;
    const members = groups.get(name);
    if (members) members.push(device);
    else groups.set(name, [device]);
  }
  if (!group && pinned.length === 0) return devices.map((row) => ({ row }));
  const names = [...groups.keys()].sort((a, b) => Number(b === text.pinned) - Number(a === text.pinned) || compareNatural(a, b));
  return names.flatMap((name) => {
    const members = groups.get(name) ?? [];
    return [{ group: name, count: members.length }, ...members.map((row) => ({ row }))];
  });
}

/** The list of devices has come, or takes too long. */
function useListed(): boolean {
  const listed = useRef(false);
  const [late, setLate] = useState(false);
  useEffect(() => {
    const timer = setTimeout(() => setLate(true), listTime);
    return () => clearTimeout(timer);
  }, [catalog.devices.size]);
  listed.current ||= late || loadingOf(baseFeeds) !== "loading";
  return listed.current;
}

/** Drops the filter and the order that need the points of rows that are not shown. */
function withoutValues(filters: Filters): Filters {
  return { ...filters, quality: "", sort: ofPoints.includes(filters.sort.replace(/^-/, "")) ? "name" : filters.sort };
}

/** All points' values; states and descriptions of as many as are needed. True once it is known which points there are. */
function usePoints(filters: Filters, shown: Device[]): boolean {
  const owner = ownerPattern();
  const live = filters.quality !== "" || /heard|quality/.test(filters.sort);
  // How many devices there are is known when the lists of all islands have come.
  const few = loadingOf(baseFeeds) === "ready" && catalog.devices.size <= fewDevices && hasRoom(3);
  const all = few || live;
  const states = all
    ? [
        { pattern: `${owner}:*.*.*.*.*.description`, min: 1000 },
        { pattern: `${owner}:*.*.*.*.*.status`, min: 1000 },
      ]
    : shown
        .slice(0, mostRows)
        .map(({ owner, prefix, network, id }) => ({ pattern: `${owner}:${prefix}.${network}.${id}.*.*.*`, min: 500, brief: true }));
  const listed = useListed();
  const values = useFeeds(listed && hasRoom(1) ? [{ pattern: `${owner}:*.*.*.*.*.value`, min: 100 }] : []);
  useFeeds(states);
  const owners = islands.value.map(({ id }) => id);
  return listed && values.every((feed) => feed.complete(owners));
}

function DeviceList({ route }: { route: Route }) {
  useFrame();
  rememberList("devices", route.query);
  const sortable = hasRoom(3);
  const filters = sortable ? readFilters(route.query) : withoutValues(readFilters(route.query));
  const chosen = chosenDevices.value;
  const island = chosenIsland();
  const [window, setWindow] = useState<Device[]>([]);
  const [placing, setPlacing] = useState<Device[]>([]);
  const known = usePoints(filters, window);
  const toggle = (device: Device) => {
    const next = new Set(chosen);
    if (!next.delete(device.path)) next.add(device.path);
    chosenDevices.value = next;
  };
  const columns = useMemo(() => deviceColumns(chosen, toggle, sortable), [chosen, sortable]);
  const state = loadingOf(baseFeeds);
  const live = filters.quality !== "" || columns.some((column) => column.live && column.id === filters.sort.replace(/^-/, ""));
  const spec = {
    name: JSON.stringify([filters, island]),
    keep: keeps(filters, island),
    compare: compareBy(columns, filters.sort, byName),
    live,
    complete: state === "ready" && (filters.type === "" || known),
  };
  const order = useOrder(() => catalog.devices.values(), catalog.structure, spec);
  const pins = pinnedDevices.value;
  const rows = useMemo(() => grouped(order.rows, filters.group, pins), [order.rows, filters.group, pins]);
  if (noIslands() && catalog.devices.size === 0) return <NoIsland />;
  return (
    <section class="view">
      <DeviceFilters
        filters={filters}
        columns={columns}
        shown={order.rows.length}
        order={order}
        chosen={chosen}
        onClear={() => (chosenDevices.value = new Set())}
        onRoom={() => setPlacing(chosenOf(chosen))}
      />
      {placing.length > 0 && <RoomDialog devices={placing} onClose={() => setPlacing([])} />}
      {!sortable && <p class="strip">{text.tooMany}</p>}
      <RoomTargets onOther={setPlacing} />
      <Loaded state={state} empty={rows.length === 0 && <NoDevices filtered={catalog.devices.size > 0} />}>
        <Table
          label={text.label}
          columns={columns}
          rows={rows}
          rowsVersion={rows}
          nameOf={(device) => device.path}
          place={`devices ${spec.name}`}
          sorting={{ by: filters.sort, set: (sort) => setQuery({ sort: sort === "name" ? "" : sort }) }}
          marked={(device) => chosen.has(device.path)}
          onOpen={(device) => go("devices", device.path.split("/"))}
          onWindow={(devices) => setWindow(devices)}
          onDrag={mayBe("admin") ? (device) => drag(device, chosen) : undefined}
          keys={{
            " ": { what: words.keyboardPin, run: (device) => togglePin(pinnedDevices, device.path) },
            x: { what: text.select, run: toggle },
          }}
        />
      </Loaded>
    </section>
  );
}

function chosenOf(chosen: ReadonlySet<string>): Device[] {
  return [...chosen].map((path) => catalog.devices.get(path)).filter((device) => device !== undefined);
}

/** A chosen row takes the others that are chosen along; null: it was let go. */
function drag(device: Device | null, chosen: ReadonlySet<string>): void {
  dragged.value = device === null ? [] : chosen.has(device.path) ? chosenOf(chosen) : [device];
}

function NoDevices({ filtered }: { filtered: boolean }) {
  if (!filtered) {
    return (
      <Empty title={text.none}>
        <p>{text.noneText(islands.value.length)}</p>
      </Empty>
    );
  }
  return <NoneMatch title={text.filtered} clear={{ q: "", network: "", type: "", quality: "", island: "" }} />;
}

export const devicesView: View = {
  id: "devices",
  title: text.title,
  key: "d",
  icon: "devices",
  wakes: ({ parts }) => parts.length === 3,
  show(route) {
    if (route.parts[0] === "compare") return <Compare paths={(route.query.d ?? "").split(",")} />;
    return route.parts.length === 3 ? <DevicePage key={route.parts.join("/")} parts={route.parts} /> : <DeviceList route={route} />;
  },
};
