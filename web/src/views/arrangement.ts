import { catalog, chosenIsland, islands, mayBe, server } from "../app";
import { arrangedIn, type Arranged } from "../core/overview";
import { setTuple } from "../parts/sent";
import { notify } from "../parts/notices";
import * as text from "../words/overview";

/** The overviews of the islands that are shown: the one that serves the page first, whose order counts for rooms of several. */
function overviews(): [number, Arranged][] {
  const island = chosenIsland();
  const own = server.value?.id ?? 0;
  return [...catalog.overviews]
    .filter(([owner, tuple]) => (!island || owner === island) && tuple.present)
    .sort(([a], [b]) => Number(b === own) - Number(a === own) || a - b)
    .map(([owner, tuple]) => [owner, arrangedIn(tuple)]);
}

export function orderOfRooms(): string[] {
  return [...new Set(overviews().flatMap(([, { rooms }]) => rooms))];
}

/** Points on the overview, by path, in their order. */
export function pinnedPoints(): string[] {
  return overviews().flatMap(([owner, { pins }]) => pins.map((pin) => `${owner}:${prefixOf(owner)}.${pin}`));
}

function prefixOf(owner: number): string {
  return catalog.overviews.get(owner)?.key.split(".", 1)[0] ?? "";
}

/** Some island keeps what is arranged, and the caller may change it. */
export function mayArrange(): boolean {
  return mayBe("command") && overviews().length > 0 && islands.value.length > 0;
}

/** Changes some members of the overview of an island. */
export function arrange(owner: number, change: Partial<Arranged> & { names?: Record<string, string> }): void {
  const tuple = catalog.overviews.get(owner);
  if (!tuple) return;
  setTuple(tuple.id, JSON.stringify(change), {}, ({ error }) => {
    if (error) notify(text.notArranged(error.text), "bad");
  });
}

/** Each island keeps the order of all rooms that are shown. */
export function arrangeRooms(rooms: string[]): void {
  for (const [owner] of overviews()) arrange(owner, { rooms });
}
