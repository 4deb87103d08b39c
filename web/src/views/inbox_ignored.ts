import { useEffect, useRef, useState } from "preact/hooks";
import { type Loading, loadingOf, ownerPattern, store, useFeeds } from "../app";
import { IgnoredDevices, ignoredLeaf } from "../core/ignored";
import { RestError, tupleBytes } from "../core/rest";
import type { Tuple } from "../core/store";

/** The text of a tuple; subscriptions leave long ones out. */
async function textOf({ owner, key, value }: Tuple): Promise<string> {
  return value ?? new TextDecoder().decode(await tupleBytes(owner, key));
}

/** The ignored devices of these inboxes, while `shown`. `version` grows when they change. */
export function useIgnored(inboxes: Tuple[], shown: boolean): { devices: Tuple[]; version: number; state: Loading } {
  const feeds = useFeeds(shown ? [{ pattern: `${ownerPattern()}:*.inbox${ignoredLeaf}`, min: 1000 }] : []);
  const devices = useRef(new IgnoredDevices());
  const [read, setRead] = useState<{ devices: Tuple[]; version: number; state: Loading }>({ devices: [], version: 0, state: "loading" });
  const found = inboxes.flatMap(({ id }) => store.get(id + ignoredLeaf) ?? []);
  const arrived = loadingOf(feeds);
  const version = JSON.stringify(found.map(({ id, sequence }) => [id, sequence]));
  useEffect(() => {
    let ended = false;
    const show = (all: Tuple[], state: Loading) => !ended && setRead((known) => ({ devices: all, version: known.version + 1, state }));
    void Promise.all(found.map(async (tuple) => ({ inbox: tuple.id.slice(0, -ignoredLeaf.length), value: await textOf(tuple) }))).then(
      (lists) => show(devices.current.read(lists), "ready"),
      ({ code, message }: RestError) => show([], { code, text: message }),
    );
    return () => void (ended = true);
  }, [version]);
  return { ...read, state: arrived === "ready" ? read.state : arrived };
}
