import type { ComponentChildren } from "preact";
import { useEffect, useMemo, useState } from "preact/hooks";
import {
  baseFeeds,
  catalog,
  chosenIsland,
  islands,
  line,
  type Loading,
  loadingOf,
  noIslands,
  ownerPattern,
  server,
  store,
  useFeeds,
} from "../app";
import { formatCount, formatRate } from "../core/format";
import type { Component } from "../core/frames";
import { Rates } from "../core/rates";
import { second } from "../core/redraw";
import { hrefTo } from "../core/router";
import { Age } from "../parts/age";
import { NoIsland } from "../parts/no_island";
import { NotWritten } from "../parts/not_written";
import { Loaded, State } from "../parts/state";
import * as text from "../words/overview";
import * as words from "../words/frame";
import { type Alert, alertsIn, placeOf, reachableOf, waitingIn } from "./overview_facts";
import type { View } from "./views";

const shownAlerts = 12;
const floods = 5;
/** Seconds until rates mean something. */
const settled = 4;

/** What there is, and what needs attention. Drawn once a second: it counts, it does not show values. */
function Overview() {
  void second.value;
  const owner = ownerPattern();
  const values = useFeeds([{ pattern: `${owner}:*.*.*.*.*.value`, min: 1000 }]);
  const state = loadingOf(baseFeeds);
  if (noIslands()) return <NoIsland />;
  return (
    <section class="overview">
      <h1>{text.title}</h1>
      <Loaded state={state} empty={state === "loading" && catalog.devices.size === 0}>
        <Islands />
        <NotWritten owners={[...islands.value, server.value]} />
        <div class="cards">
          <Alerts state={state} />
          <Inbox state={state} />
          <Floods state={loadingOf(values)} />
        </div>
      </Loaded>
    </section>
  );
}

function Islands() {
  const island = chosenIsland();
  const rows = islands.value.filter(({ id }) => !island || id === island);
  return (
    <div class="wide-table">
      <table>
        <thead>
          <tr>
            <th scope="col">{text.island}</th>
            <th scope="col" class="desk">
              {text.host}
            </th>
            <th scope="col" class="desk">
              {text.program}
            </th>
            <th scope="col">{text.up}</th>
            <th scope="col">{text.devices}</th>
          </tr>
        </thead>
        <tbody>
          {rows.map((row) => (
            <Island key={row.id} island={row} />
          ))}
        </tbody>
      </table>
    </div>
  );
}

function Island({ island }: { island: Component }) {
  const { reachable, all } = reachableOf(catalog, island.id);
  return (
    <tr>
      <th scope="row">
        <a href={hrefTo("devices", [], { island: String(island.id) })}>{island.name || island.id}</a> <span class="muted">{island.id}</span>
      </th>
      <td class="desk">{island.host}</td>
      <td class="desk">{[island.program, island.version].filter(Boolean).join(" ")}</td>
      <td>
        <Age time={island.since} />
      </td>
      <td>
        <meter min={0} max={Math.max(all, 1)} value={reachable} aria-label={text.reachable(reachable, all)} />
        {text.reachable(reachable, all)}
      </td>
    </tr>
  );
}

interface CardProps {
  title: string;
  count: number;
  none: string;
  /** Of what it counts: there is none only when all of it has arrived. */
  state: Loading;
  more?: { href: string; label: string };
  bad?: boolean;
  children: ComponentChildren;
}

/** A section that says in its head how much there is, also when that is nothing. */
function Card({ title, count, none, state, more, bad, children }: CardProps) {
  const nothing = state === "ready" ? none : state === "loading" ? `${words.loading} …` : `${state.code}: ${state.text}`;
  return (
    <section class="card" aria-label={title}>
      <header>
        <h2>{title}</h2>
        {count > 0 && <span class={`badge${bad ? " bad" : ""}`}>{formatCount(count)}</span>}
        {more && count > 0 && <a href={more.href}>{more.label}</a>}
      </header>
      {count === 0 ? <p class="muted">{nothing}</p> : <ul class="facts-list">{children}</ul>}
    </section>
  );
}

type OfState = Pick<CardProps, "state">;

function Alerts({ state }: OfState) {
  const { alerts, more } = alertsIn(catalog, chosenIsland());
  const count = alerts.length + more;
  return (
    <Card title={text.alerts} count={count} none={text.noAlerts} state={state} bad={alerts.some(({ problem }) => problem)}>
      {alerts.slice(0, shownAlerts).map((alert) => (
        <AlertRow key={alert.owner + alert.about + alert.what} alert={alert} />
      ))}
      {count > shownAlerts && <li class="muted">{text.moreAlerts(count - shownAlerts)}</li>}
    </Card>
  );
}

function AlertRow({ alert }: { alert: Alert }) {
  const place = placeOf(catalog, alert);
  return (
    <li class="alert">
      {place ? <a href={hrefTo(place.view, place.path)}>{alert.what}</a> : <span>{alert.what}</span>}
      <State word={alert.problem ? text.problem : text.warning} tone={alert.problem ? "bad" : "waiting"} />
      <Age time={alert.since} />
      <p class="muted">{alert.fix}</p>
    </li>
  );
}

function Inbox({ state }: OfState) {
  const { waiting, ignored } = waitingIn(catalog, chosenIsland());
  return (
    <Card
      title={text.inbox}
      count={waiting}
      none={text.noneWaiting(ignored)}
      state={state}
      more={{ href: hrefTo("inbox"), label: text.decide }}
    >
      <li>{text.waiting(waiting, ignored)}</li>
    </Card>
  );
}

function Floods({ state }: OfState) {
  const rates = useMemo(() => new Rates(store, performance.now()), []);
  useEffect(() => () => rates.end(), [rates]);
  const [samples, setSamples] = useState(0);
  useEffect(() => {
    rates.sample(performance.now());
    if (state === "ready" && samples < settled) setSamples(samples + 1);
  }, [second.value]);
  useEffect(() => {
    if (line.value === "lost") rates.interrupt();
  }, [line.value]);
  const island = chosenIsland();
  const top = rates
    .top(island ? 200 : floods)
    .filter(({ tuple }) => !island || tuple.owner === island)
    .slice(0, floods);
  return (
    <Card
      title={text.floods}
      count={top.length}
      none={samples < settled ? text.measuring : text.quiet}
      state={state}
      more={{ href: hrefTo("tuples", [], { order: "rate" }), label: text.tuples }}
    >
      {top.map(({ tuple, rate }) => (
        <li key={tuple.id}>
          <a class="key" href={hrefTo("tuples", [tuple.id])} title={tuple.id}>
            {tuple.key}
          </a>
          <span class="muted">{(tuple.value ?? "").slice(0, 40)}</span>
          <span class="rate">{text.perSecond(formatRate(rate))}</span>
        </li>
      ))}
    </Card>
  );
}

export const overviewView: View = { id: "overview", title: text.title, key: "o", icon: "overview", show: () => <Overview /> };
