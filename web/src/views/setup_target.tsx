import { chosenIsland, islands, store, useFeeds } from "../app";
import { Choice } from "../parts/fields";
import type { Tuple } from "../core/store";
import { setQuery } from "../core/router";
import * as words from "../words/frame";

/** The island whose file is changed: the one that the user chose, else the first. */
export interface Target {
  owner: number;
  /** `proxy.settings`; empty until it is known. */
  base: string;
  networks: Tuple | undefined;
}

export function useTarget(): Target {
  const owner = chosenIsland() || islands.value[0]?.id || 0;
  const [feed] = useFeeds([{ pattern: `${owner}:*.settings.*`, min: 1000 }]);
  const status = [...(feed?.held.tuples ?? [])].find(({ key }) => key.endsWith(".settings.status"));
  const base = status?.key.replace(/\.status$/, "") ?? "";
  return { owner, base, networks: store.get(`${owner}:${base}.networks`) };
}

/** Where there are several. */
export function IslandChoice({ owner }: { owner: number }) {
  if (islands.value.length < 2) return null;
  return (
    <Choice
      label={words.islandsLabel}
      value={String(owner)}
      values={islands.value.map(({ id }) => String(id))}
      name={(id) => islands.value.find((one) => String(one.id) === id)?.name || id}
      onChange={(island) => setQuery({ island })}
    />
  );
}
