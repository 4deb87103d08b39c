import type { ComponentChildren } from "preact";
import { catalog, chosenIsland, mayBe } from "../app";
import type { Device } from "../core/catalog";
import { typeWords } from "../core/format";
import { usePaced } from "../core/hooks";
import { hrefTo, setQuery } from "../core/router";
import { compareNatural } from "../core/text";
import { FilterField, Choice } from "../parts/fields";
import { phone } from "../parts/screen";
import { type Column, Outdated, SortSelect } from "../parts/table";
import * as text from "../words/devices";
import * as commissionText from "../words/commission";
import * as words from "../words/frame";

export const qualities = ["good", "assumed", "stored", "stale", "unknown", "bad", "device-offline", "network-down"];

export interface Filters {
  search: string;
  network: string;
  type: string;
  quality: string;
  group: string;
  sort: string;
}

export function readFilters(query: Record<string, string>): Filters {
  const { q = "", network = "", type = "", quality = "", group = "", sort = "name" } = query;
  return { search: q, network, type, quality, group, sort: sort || "name" };
}

interface Props {
  filters: Filters;
  columns: Column<Device>[];
  shown: number;
  order: { outdated: number; refresh(): void };
  chosen: ReadonlySet<string>;
  onClear(): void;
  onRoom(): void;
}

/** Filter, groups, order, and what is done with the chosen devices. */
export function DeviceFilters({ filters, columns, shown, order, chosen, onClear, onRoom }: Props) {
  const choices = usePaced(`${catalog.structure} ${catalog.points} ${chosenIsland()}`, () => choicesOf(chosenIsland()));
  const set = (name: string) => (value: string) => setQuery({ [name]: value });
  return (
    <div class="toolbar">
      <h1>{text.title}</h1>
      <FilterField value={filters.search} />
      <Fold>
        <Choice
          label={text.network}
          none={text.anyNetwork}
          value={filters.network}
          values={choices.networks}
          onChange={set("network")}
          spoken
        />
        <Choice
          label={text.type}
          none={text.anyType}
          value={filters.type}
          values={choices.types}
          name={typeWords}
          onChange={set("type")}
          spoken
        />
        {columns.some(({ id, compare }) => id === "quality" && compare) && (
          <Choice label={text.quality} none={text.anyQuality} value={filters.quality} values={qualities} onChange={set("quality")} spoken />
        )}
        <Choice
          label={text.group}
          none={text.groups.none}
          value={filters.group}
          values={["network", "place", "type"]}
          name={groupName}
          onChange={set("group")}
        />
        {phone.value && <SortSelect columns={columns} sorting={{ by: filters.sort, set: set("sort") }} />}
      </Fold>
      <span class="count">{words.tableShown(shown, catalog.devices.size)}</span>
      <Outdated order={order} />
      {chosen.size > 0 && (
        <span class="chosen">
          <a class="button primary" href={hrefTo("devices", ["compare"], { d: [...chosen].join(",") })}>
            {text.compare(chosen.size)}
          </a>
          {mayBe("admin") && (
            <button type="button" onClick={onRoom}>
              {commissionText.giveRoom(chosen.size)}
            </button>
          )}
          <button type="button" onClick={onClear}>
            {text.unselect}
          </button>
        </span>
      )}
    </div>
  );
}

/** Choices beside the search: folded on a narrow screen. */
function Fold({ children }: { children: ComponentChildren }) {
  if (!phone.value) return <>{children}</>;
  return (
    <details class="fold">
      <summary>{words.tableMore}</summary>
      <div>{children}</div>
    </details>
  );
}

function groupName(group: string): string {
  return text.groups[group as keyof typeof text.groups] ?? group;
}

function choicesOf(island: number): { networks: string[]; types: string[] } {
  const networks = new Set<string>();
  const types = new Set<string>();
  for (const device of catalog.devices.values()) {
    if (island && device.owner !== island) continue;
    networks.add(device.network);
    for (const type of device.capabilities) types.add(type);
    for (const point of device.points.values()) types.add(point.type);
  }
  return { networks: [...networks].sort(compareNatural), types: [...types].sort(compareNatural) };
}
