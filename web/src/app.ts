// The one connection, store and catalogue of the page, and what views use of them.
import { effect, signal } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import { Catalog, type Point } from "./core/catalog";
import { browserClock } from "./core/clock";
import { Connection, type LineState, openBrowserWire } from "./core/connection";
import { Feed, type Subscription, type Want } from "./core/feed";
import type { Answer, Component, Frame, Message } from "./core/frames";
import { givenName } from "./core/overview";
import { redraw } from "./core/redraw";
import { ask, askJson, RestError, type ServerInfo } from "./core/rest";
import { route, setQuery } from "./core/router";
import { heardFrame, serverTime } from "./core/server_time";
import { Store } from "./core/store";
import { announce, notify } from "./parts/notices";
import * as words from "./words/frame";

export const line = signal<LineState>("connecting");
/** When the line was lost, in ms of Date.now(); 0 while it is up. */
export const lostSince = signal(0);
/** Until then the server merges updates, because this connection takes fewer than arrive; in ms of Date.now(). */
export const mergedUntil = signal(0);
export const server = signal<ServerInfo | null>(null);
/** The server wants a token: before it says anything, or because a session ended while the page was in use. */
export const loginNeeded = signal<"" | "first" | "again">("");
export const islands = signal<Component[]>([]);
export const components = signal<Component[]>([]);
/** The lists of islands and components have arrived. */
export const islandsKnown = signal(false);

/** The server sees no island at all. */
export function noIslands(): boolean {
  return islandsKnown.value && islands.value.length === 0;
}

export const store = new Store(redraw);
export const catalog = new Catalog(store);

const socketUrl = `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/api/v1/ws`;
export const connection: Connection = new Connection(openBrowserWire(socketUrl), browserClock, { state: lineChanged, frame: framed });
export const feed = new Feed(store, () => connection, browserClock, redraw);

/** What the frame of the page shows everywhere: devices for the search, lines and inbox for the marks of the rail. */
const always: Want[] = [
  { pattern: "*:*.island", min: 1000 }, // the prefix of each island
  { pattern: "*:*.*.*.description", min: 250 },
  { pattern: "*:*.*.*.status", min: 250 },
  { pattern: "*:*.*.status", min: 250 },
  { pattern: "*:*.inbox", min: 250 },
  { pattern: "*:*.alerts", min: 250 },
  { pattern: "*:*.overview", min: 250 },
];
export const baseFeeds: Subscription[] = [];

type MessageCall = (message: Message) => void;
const listeners = new Map<string, Set<MessageCall>>();

function lineChanged(state: LineState): void {
  line.value = state;
  if (state === "live") {
    lostSince.value = 0;
    announce(words.lineLive);
    const learned = learnServer();
    if (server.value?.tokens) void learned.then(greet);
    else greet();
    return;
  }
  if (state === "lost") {
    lostSince.value = Date.now();
    announce(words.lineLost);
    feed.disconnected();
    void learnServer();
  }
}

/** Not while a token is needed: all would be refused. */
function greet(): void {
  if (loginNeeded.value || !connection.live) return;
  connection.request({ do: "islands" }, greeted);
  connection.request({ do: "components" });
  for (const type of listeners.keys()) connection.request({ do: "listen", type });
  feed.connected();
}

function greeted(answer: Answer): void {
  if (answer.error?.code === "refused") needLogin();
}

/** What the page knows of the server stays: the view behind the login is as it was. */
function needLogin(): void {
  loginNeeded.value ||= server.value ? "again" : "first";
}

/** Learns who we are to the server, and whether it wants a token. */
async function learnServer(): Promise<void> {
  try {
    const before = server.value?.release;
    const now = await askJson<ServerInfo>("");
    if (before !== undefined && before !== now.release) notify(words.lineReleased, "waiting", reloading);
    tellClock();
    if (now.tokens && ["none", ""].includes(now.caller.role)) return needLogin();
    server.value = now;
    if (!loginNeeded.value) return;
    loginNeeded.value = "";
    connection.restart();
  } catch (error) {
    if (error instanceof RestError && (error.status === 401 || error.status === 403)) needLogin();
  }
}

/** The page of another release may be other files than those that are still to come. */
const reloading = { label: words.lineReload, run: () => location.reload() };

let clockTold = false;
const clockMatters = 5;

function tellClock(): void {
  const wrong = Math.abs(serverTime.offset) > clockMatters;
  if (wrong && !clockTold) notify(words.lineClock(serverTime.offset), "waiting");
  clockTold = wrong;
}

function framed(frame: Frame): void {
  if (frame.alive !== undefined) heardFrame(frame.alive);
  if (frame.s !== undefined) feed.take(frame);
  if (frame.islands) {
    islands.value = frame.islands;
    islandsKnown.value = true;
    redraw();
  }
  if (frame.components) {
    components.value = frame.components;
    redraw();
  }
  if (frame.message) {
    for (const call of listeners.get(frame.message.type) ?? []) call(frame.message);
  }
  if (frame.slow) merging();
  if (frame.lost) notify(words.lineEventsLost(frame.lost.events), "bad");
}

/** The server says once a minute that it merges updates. */
const mergingLasts = 75_000;

function merging(): void {
  if (mergedUntil.value < Date.now()) announce(words.lineSlow);
  mergedUntil.value = Date.now() + mergingLasts;
}

export function startApp(): void {
  for (const want of always) baseFeeds.push(feed.want(want));
  document.addEventListener("visibilitychange", () => {
    feed.hide(document.hidden);
    if (document.hidden) sleep();
  });
  endActiveWithAddress();
  connection.start();
}

/** Takes a token for the session cookie; throws RestError. */
export async function login(token: string): Promise<void> {
  await askJson("/session", { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify({ token }) });
  await learnServer();
}

/** Ends the session; the page asks for a token again. */
export async function logout(): Promise<void> {
  try {
    await ask("/session", { method: "DELETE" });
  } catch (error) {
    notify(words.loginNotEnded(error instanceof RestError ? error.message : String(error)), "bad");
    return;
  }
  server.value = null;
  loginNeeded.value = "first";
  connection.restart();
}

/** Calls for each message of a type until the result is called. */
export function listenTo(type: string, call: MessageCall): () => void {
  const calls = listeners.get(type) ?? new Set<MessageCall>();
  if (calls.size === 0) connection.request({ do: "listen", type });
  calls.add(call);
  listeners.set(type, calls);
  return () => {
    calls.delete(call);
    if (calls.size > 0) return;
    listeners.delete(type);
    connection.request({ do: "unlisten", type });
  };
}

/** Messages of a type while the view is shown. */
export function useMessages(type: string, call: MessageCall): void {
  useEffect(() => listenTo(type, call), [type, call]);
}

/** Subscribes while the view is shown; the component draws from store or catalogue. */
export function useFeeds(wants: Want[]): Subscription[] {
  const name = JSON.stringify(wants);
  const subscriptions = useMemo(() => wants.map((want) => feed.want(want)), [name]);
  useEffect(() => () => subscriptions.forEach((subscription) => feed.drop(subscription)), [subscriptions]);
  return subscriptions;
}

export type Loading = "loading" | "ready" | { code: string; text: string };

/** Whether all subscriptions have the snapshots of all islands: loading, ready, or what failed. */
export function loadingOf(subscriptions: Iterable<Subscription>): Loading {
  if (!islandsKnown.value) return "loading";
  const owners = islands.value.map((island) => island.id);
  for (const subscription of subscriptions) {
    if (subscription.state === "failed") return subscription.error ?? { code: "failed", text: "" };
    if (!subscription.complete(owners)) return "loading";
  }
  return "ready";
}

/** A connection has 300,000 tuples; some are for what else is looked at. */
const roomForPoints = 250_000;
/** Points of a device that has not described itself yet. */
const usualPoints = 5;

/** Whether so many tuples of each point of the chosen island fit into the connection, beside the two of each device. */
export function hasRoom(leaves: number): boolean {
  const chosen = chosenIsland();
  const said = new Map(islands.value.map(({ id, devices = 0 }) => [id, devices]));
  let tuples = 0;
  for (const owner of new Set([...said.keys(), ...catalog.described.keys()])) {
    const known = catalog.described.get(owner) ?? { devices: 0, points: 0 };
    const devices = Math.max(said.get(owner) ?? 0, known.devices);
    tuples += 2 * devices;
    if (!chosen || chosen === owner) tuples += leaves * (known.points + (devices - known.devices) * usualPoints);
  }
  return tuples <= roomForPoints;
}

/** The island that the user chose; 0 = all. */
export function chosenIsland(): number {
  return Number(route.value.query.island ?? 0) || 0;
}

export function chooseIsland(id: number): void {
  setQuery({ island: id ? String(id) : "" });
}

/** `6541` or `*`: the owner part of a pattern for what the user chose. */
export function ownerPattern(): string {
  return String(chosenIsland() || "*");
}

/** The user lets this address wake sensors. It ends with the address, and when the page is hidden. */
export const active = signal(false);
/** Points that the user lets this address measure, by path. It ends as `active` does. */
export const measured = signal<ReadonlySet<string>>(new Set());
/** How many sensors the present view wakes, as the view counts them. */
export const wokenSensors = signal(0);

function sleep(): void {
  active.value = false;
  if (measured.peek().size > 0) measured.value = new Set();
}

/** The wants of what the user lets be measured. */
export function measuredWants(): Want[] {
  return [...measured.value].map((path) => ({ pattern: `${path}.value`, active: true, min: 1000 }));
}

/** What people call a point: the name that they gave it, else its id. */
export function nameOfPoint(point: Point): string {
  return givenName(catalog.overviews.get(point.device.owner), point) || point.id;
}

function endActiveWithAddress(): void {
  let before = "";
  effect(() => {
    const address = [route.value.view, ...route.value.parts].join("/");
    if (address !== before) sleep();
    before = address;
  });
}

/** Roles include those before them; without tokens everybody is admin. */
const roles = ["none", "view", "command", "admin"];

export function mayBe(role: "view" | "command" | "admin"): boolean {
  const mine = server.value?.caller.role ?? "admin";
  return roles.indexOf(mine) >= roles.indexOf(role);
}
