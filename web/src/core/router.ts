import { signal } from "@preact/signals";
import { browserClock } from "./clock";
import { Paced } from "./paced";

/** An address within the page: `#/devices/6541/wsn-1/7?q=lamp`. */
export interface Route {
  view: string;
  parts: string[];
  query: Record<string, string>;
}

/** Members of the query that stay when the view changes. */
const lasting = ["island"];

export function parseRoute(hash: string): Route {
  const [path = "", query = ""] = hash.replace(/^#?\/?/, "").split("?", 2);
  const [view = "", ...parts] = path.split("/").map(decode);
  return { view: view || "overview", parts: parts.filter((part) => part !== ""), query: Object.fromEntries(new URLSearchParams(query)) };
}

/** Parts are percent-encoded; empty members of the query are left out. */
export function formatRoute(view: string, parts: string[] = [], query: Record<string, string> = {}): string {
  const path = [view, ...parts].map(encodeURIComponent).join("/");
  const members = new URLSearchParams(Object.entries(query).filter(([, value]) => value !== ""));
  const tail = members.toString();
  return `#/${path}${tail ? `?${tail}` : ""}`;
}

function decode(part: string): string {
  try {
    return decodeURIComponent(part);
  } catch {
    return part;
  }
}

export const route = signal<Route>({ view: "overview", parts: [], query: {} });

/** The address of a view, with what lasts of the present query. */
export function hrefTo(view: string, parts: string[] = [], query: Record<string, string> = {}): string {
  const kept = Object.fromEntries(Object.entries(route.value.query).filter(([name]) => lasting.includes(name)));
  return formatRoute(view, parts, { ...kept, ...query });
}

export function go(view: string, parts: string[] = [], query: Record<string, string> = {}): void {
  address.flush();
  location.hash = hrefTo(view, parts, query);
}

const lists = new Map<string, Record<string, string>>();

/** A view calls it while it shows its list: the way back from one thing leads to the list as it was. */
export function rememberList(view: string, query: Record<string, string>): void {
  lists.set(view, Object.fromEntries(Object.entries(query).filter(([name]) => !lasting.includes(name))));
}

/** The address of the list of a view, with filter and order as they were. */
export function hrefToList(view: string): string {
  return hrefTo(view, [], lists.get(view));
}

export function goToList(view: string): void {
  address.flush();
  location.hash = hrefToList(view);
}

/** Browsers refuse an address that changes a hundred times in ten seconds, as a held key would have it. */
const addressPause = 150;
const address = new Paced(browserClock, addressPause, (next) => history.replaceState(null, "", next));

/** Changes members of the query in place: filters and sorting make no steps of the history. */
export function setQuery(changes: Record<string, string>): void {
  const { view, parts, query } = route.value;
  const next = formatRoute(view, parts, { ...query, ...changes });
  address.put(next);
  route.value = parseRoute(next);
}

function read(): void {
  address.drop(); // the user went elsewhere
  route.value = parseRoute(location.hash);
}

export function startRouter(): void {
  addEventListener("hashchange", read);
  read();
}
