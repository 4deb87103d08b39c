import { Age } from "../parts/age";
import type { Device } from "../core/catalog";
import { typeWords } from "../core/format";
import { pinnedDevices } from "../core/settings";
import { compareNatural } from "../core/text";
import { Icon } from "../parts/icons";
import { phone } from "../parts/screen";
import { State } from "../parts/state";
import type { Column } from "../parts/table";
import { Value } from "../parts/value";
import * as text from "../words/devices";

/** The quality of what stands for the device in the list. */
export function qualityOf(device: Device): string {
  return device.first?.quality || "";
}

export function groupOf(device: Device, group: string): string {
  if (group === "network") return `${device.network} · ${device.owner}`;
  if (group === "place") return device.area || text.noPlace;
  return device.mainType ? typeWords(device.mainType) : "–";
}

const stateOrder = ["unreachable", "unknown", "reachable"];

function firstNumber(device: Device): number {
  const value = Number.parseFloat(device.first?.value?.value ?? "");
  return Number.isNaN(value) ? Number.NEGATIVE_INFINITY : value;
}

interface Choice {
  chosen: ReadonlySet<string>;
  toggle(device: Device): void;
}

function Choose({ device, chosen, toggle }: Choice & { device: Device }) {
  return (
    <input
      type="checkbox"
      tabIndex={-1}
      aria-label={`${text.select} ${device.name}`}
      checked={chosen.has(device.path)}
      onChange={() => toggle(device)}
    />
  );
}

/** On a narrow screen with what chooses it. */
function Name({ device, ...choice }: Choice & { device: Device }) {
  const pinned = pinnedDevices.value.includes(device.path);
  return (
    <span class="device-name">
      {phone.value && <Choose device={device} {...choice} />}
      <a href={`#/devices/${device.path.split("/").map(encodeURIComponent).join("/")}`} tabIndex={-1}>
        {device.name}
      </a>
      {pinned && (
        <span class="pinned" title={text.pinned}>
          <Icon name="pin" size={14} />
        </span>
      )}
    </span>
  );
}

function FirstValue({ device }: { device: Device }) {
  const point = device.first;
  return (
    <span class="first-value">
      <Value point={point} />
      {point && <span class="muted type">{typeWords(point.type)}</span>}
    </span>
  );
}

/** Columns that show points. */
export const ofPoints = ["value", "quality", "heard"];

/** `sortable`: the points of all devices are known, not only those of the rows that are shown. */
export function deviceColumns(chosen: ReadonlySet<string>, toggle: (device: Device) => void, sortable: boolean): Column<Device>[] {
  const columns = allColumns(chosen, toggle);
  return sortable ? columns : columns.map((column) => (ofPoints.includes(column.id) ? { ...column, compare: undefined } : column));
}

function allColumns(chosen: ReadonlySet<string>, toggle: (device: Device) => void): Column<Device>[] {
  return [
    {
      id: "chosen",
      title: text.select,
      spoken: true,
      width: "34px",
      cell: (device) => <Choose device={device} chosen={chosen} toggle={toggle} />,
    },
    {
      id: "state",
      title: text.state,
      width: "118px",
      live: true,
      phone: "end",
      compare: (a, b) => stateOrder.indexOf(a.state) - stateOrder.indexOf(b.state),
      cell: (device) => <State word={device.state} title={device.reason} />,
    },
    {
      id: "name",
      title: text.name,
      width: "minmax(150px,1.6fr)",
      phone: "main",
      compare: (a, b) => compareNatural(a.name, b.name),
      cell: (device) => <Name device={device} chosen={chosen} toggle={toggle} />,
    },
    {
      id: "network",
      title: text.network,
      width: "minmax(90px,0.8fr)",
      phone: "sub",
      compare: (a, b) => compareNatural(a.network, b.network) || a.owner - b.owner,
      cell: (device) => device.network,
    },
    {
      id: "model",
      title: text.model,
      width: "minmax(100px,1.2fr)",
      compare: (a, b) => compareNatural(a.model, b.model),
      cell: (device) => <span title={device.model}>{device.model}</span>,
    },
    {
      id: "place",
      title: text.place,
      width: "minmax(80px,0.8fr)",
      compare: (a, b) => compareNatural(a.area, b.area),
      cell: (device) => device.area,
    },
    {
      id: "value",
      title: text.value,
      width: "minmax(150px,1.2fr)",
      live: true,
      phone: "side",
      compare: (a, b) => firstNumber(a) - firstNumber(b),
      cell: (device) => <FirstValue device={device} />,
    },
    {
      id: "quality",
      title: text.quality,
      width: "124px",
      live: true,
      compare: (a, b) => compareNatural(qualityOf(a), qualityOf(b)),
      cell: (device) => <Quality device={device} />,
    },
    {
      id: "heard",
      title: text.heard,
      width: "72px",
      live: true,
      numeric: true,
      compare: (a, b) => b.heard - a.heard,
      cell: (device) => <Age time={device.heard} />,
    },
  ];
}

function Quality({ device }: { device: Device }) {
  const quality = qualityOf(device);
  const reason = device.first?.status?.json.reason;
  return quality ? <State word={quality} title={typeof reason === "string" ? reason : ""} /> : <span class="muted">…</span>;
}
