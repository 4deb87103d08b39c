import { catalog, chosenIsland, type Loading } from "../app";
import { formatCount } from "../core/format";
import { hrefTo } from "../core/router";
import { Age } from "../parts/age";
import { prose } from "../parts/prose";
import { State } from "../parts/state";
import * as text from "../words/overview";
import * as inboxText from "../words/inbox";
import * as words from "../words/frame";
import { type Alert, alertsIn, placeOf, waitingIn } from "./overview_facts";

const shownAlerts = 12;

/** What needs a person, each with the way to its remedy. There is nothing only when all lists have arrived. */
export function Attention({ state }: { state: Loading }) {
  const island = chosenIsland();
  const { alerts, more } = alertsIn(catalog, island);
  const { waiting, ignored } = waitingIn(catalog, island);
  const count = alerts.length + more;
  const nothing = state === "ready" ? text.noAlerts : state === "loading" ? `${words.loading} …` : `${state.code}: ${state.text}`;
  const calm = count === 0 && waiting === 0;
  const bad = alerts.some(({ problem }) => problem);
  return (
    <section class={`card attention${calm ? " calm" : ""}`} aria-label={text.alerts}>
      <header>
        <h2>{text.alerts}</h2>
        {count > 0 && <span class={`badge${bad ? " bad" : ""}`}>{formatCount(count)}</span>}
      </header>
      {calm && <p class="muted">{nothing}</p>}
      {!calm && (
        <ul class="facts-list">
          {waiting > 0 && (
            <li class="alert">
              <span>
                <strong>{inboxText.title}</strong> {text.waiting(waiting, ignored)}
              </span>
              <a class="button small" href={hrefTo("inbox")}>
                {text.decide}
              </a>
            </li>
          )}
          {alerts.slice(0, shownAlerts).map((alert) => (
            <AlertRow key={alert.owner + alert.about + alert.what} alert={alert} />
          ))}
          {count > shownAlerts && <li class="muted">{text.moreAlerts(count - shownAlerts)}</li>}
        </ul>
      )}
    </section>
  );
}

function AlertRow({ alert }: { alert: Alert }) {
  const place = placeOf(catalog, alert);
  return (
    <li class="alert">
      {place ? <a href={hrefTo(place.view, place.path)}>{prose(alert.what)}</a> : <span>{prose(alert.what)}</span>}
      <State word={alert.problem ? text.problem : text.warning} tone={alert.problem ? "bad" : "waiting"} />
      <Age time={alert.since} />
      <p class="muted">{prose(alert.fix)}</p>
    </li>
  );
}
