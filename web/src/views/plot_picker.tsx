import { useMemo, useState } from "preact/hooks";
import { catalog, chosenIsland, hasRoom, loadingOf, ownerPattern, useFeeds } from "../app";
import type { Point } from "../core/catalog";
import { typeWords, unitSign } from "../core/format";
import { second } from "../core/redraw";
import { compareNatural, matches } from "../core/text";
import { Dialog } from "../parts/dialog";
import { Empty, Loaded } from "../parts/state";
import { Value } from "../parts/value";
import * as text from "../words/plots";
import * as words from "../words/frame";

export const mostPoints = 8;
/** Rows of the list; more words find the others. */
const shown = 100;

interface Props {
  chosen: string[];
  onChange(paths: string[]): void;
  onClose(): void;
}

function searchedOf(point: Point): string {
  const { device } = point;
  return `${device.name} ${device.id} ${device.network} ${device.area} ${point.id} ${typeWords(point.type)} ${point.unit}`;
}

function find(search: string, chosen: string[]): { points: Point[]; more: number } {
  const island = chosenIsland();
  const points: Point[] = [];
  for (const device of catalog.devices.values()) {
    if (island && device.owner !== island) continue;
    for (const point of device.points.values()) if (search === "" || matches(search, searchedOf(point))) points.push(point);
  }
  const rank = (point: Point) => (chosen.includes(point.path) ? 0 : point.kind === "property" ? 2 : 1);
  points.sort((a, b) => rank(a) - rank(b) || compareNatural(a.device.name, b.device.name) || compareNatural(a.path, b.path));
  return { points: points.slice(0, shown), more: Math.max(0, points.length - shown) };
}

/** Chooses the points of the plot. The list stays in its order while boxes are ticked. */
export function PlotPicker({ chosen, onChange, onClose }: Props) {
  const [search, setSearch] = useState("");
  const [first] = useState(chosen);
  const owner = ownerPattern();
  const room = hasRoom(2);
  const leaves = room ? ["description", "value"] : [];
  const feeds = useFeeds(leaves.map((leaf) => ({ pattern: `${owner}:*.*.*.*.*.${leaf}`, min: 1000 })));
  const state = loadingOf(feeds);
  const slow = second.value >> 1;
  const { points, more } = useMemo(() => find(search, first), [search, catalog.structure, state === "ready", slow]);
  const toggle = (path: string) => onChange(chosen.includes(path) ? chosen.filter((other) => other !== path) : [...chosen, path]);
  return (
    <Dialog title={text.choose(chosen.length, mostPoints)} onClose={onClose}>
      <input
        type="search"
        autofocus
        aria-label={words.tableFilter}
        placeholder={text.searchHint}
        value={search}
        onInput={(event) => setSearch(event.currentTarget.value)}
      />
      {!room && <p class="strip">{text.tooMany}</p>}
      <Loaded state={state} empty={points.length === 0 && <Empty title={search ? text.noneFound : text.noPoints} />}>
        <ul class="picker">
          {points.map((point) => {
            const ticked = chosen.includes(point.path);
            return (
              <li key={point.path}>
                <label>
                  <input
                    type="checkbox"
                    checked={ticked}
                    disabled={!ticked && chosen.length >= mostPoints}
                    onChange={() => toggle(point.path)}
                  />
                  <span>{`${point.device.name} · ${point.id}`}</span>
                  <span class="muted">{[point.device.network, point.device.area, unitSign(point.unit)].filter(Boolean).join(" · ")}</span>
                  <Value point={point} />
                </label>
              </li>
            );
          })}
        </ul>
        {more > 0 && <p class="muted">{text.more(more)}</p>}
      </Loaded>
    </Dialog>
  );
}
