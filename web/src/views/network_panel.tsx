import { connection, mayBe } from "../app";
import { type Network, number, text as textOf } from "../core/catalog";
import { advance, begin, type Outcome, toneOf } from "../core/commands";
import { type CounterKind, type CounterRates, kindOf } from "../core/counters";
import { formatFullTime, formatNumber, formatRate, prettyJson } from "../core/format";
import { redraw, second } from "../core/redraw";
import { hrefTo, hrefToList } from "../core/router";
import type { Tuple } from "../core/store";
import { compareNatural } from "../core/text";
import { Age } from "../parts/age";
import { Icon } from "../parts/icons";
import { MayNot } from "../parts/may_not";
import { announce } from "../parts/notices";
import { prose } from "../parts/prose";
import { phone } from "../parts/screen";
import { State } from "../parts/state";
import * as text from "../words/networks";
import * as tuplesText from "../words/tuples";
import * as words from "../words/frame";
import { serverNow } from "../core/server_time";
import { ZigbeePanel } from "./zigbee_panel";
import { isZigbee } from "./zigbee_tool";

/** When the island tries again to open the line. */
export function NextAttempt({ network }: { network: Network }) {
  void second.value;
  const at = number(network.status?.json.next_attempt);
  const seconds = Math.ceil(at - serverNow());
  if (at === 0 || network.line === "up") return null;
  return <span class="attempt">{seconds > 0 ? text.nextIn(seconds) : text.nextNow}</span>;
}

/** The last `reopen` that this page sent, by the path of its network. */
const reopened = new Map<string, Outcome>();

function reopen({ path, owner, prefix, id }: Network): void {
  let outcome = begin("reopen", 0);
  const show = () => {
    reopened.set(path, outcome);
    redraw();
  };
  show();
  connection.request(
    { do: "set", key: `${owner}:${prefix}.${id}.property.line.command`, value: "reopen" },
    (answer) => {
      outcome = advance(outcome, answer, 0);
      if (outcome.final) announce(text.reopened(id, outcome.state, outcome.reason));
      show();
    },
    true,
  );
}

/** Tries now to open a line that is down or refused, and shows what came of it until the line is up. */
function Reopening({ network }: { network: Network }) {
  const { path, line } = network;
  const outcome = reopened.get(path);
  if (line === "up") reopened.delete(path);
  if (!mayBe("admin") || line === "up") return null;
  return (
    <p class="actions">
      {/^(down|refused)$/.test(line) && (
        <button type="button" disabled={outcome?.final === false} onClick={() => reopen(network)}>
          {text.reopen}
        </button>
      )}
      {outcome && (
        <span class="outcome">
          <State word={outcome.state} tone={toneOf(outcome.state)} /> {prose(outcome.reason)}
        </span>
      )}
    </p>
  );
}

interface Counter {
  name: string;
  tuple: Tuple;
  kind: CounterKind;
}

const order: CounterKind[] = ["loss", "oddity", "flow", "fact"];

function isZero({ kind, tuple }: Counter): boolean {
  return tuple.value === "" || (kind !== "fact" && Number(tuple.value) === 0);
}

/** The line of a network, and everything that it counts. */
export function NetworkPanel({ network, rates }: { network: Network; rates: CounterRates }) {
  const status = network.status?.json;
  const counters = [...network.counters]
    .map(([name, tuple]) => ({ name, tuple, kind: kindOf(name, tuple.value ?? "") }))
    .filter(({ name }) => name !== "line" && name !== "next-attempt" && name !== "attempts")
    .sort((a, b) => compareNatural(a.name, b.name));
  const zeros = counters.filter(isZero);
  const reason = textOf(status?.reason);
  const Heading = phone.value ? "h1" : "h2"; // on a narrow screen it is the whole view
  return (
    <aside class="panel" tabIndex={0} aria-label={network.id}>
      <header>
        <a class="button plain" href={hrefToList("networks")} aria-label={words.close}>
          <Icon name="back" size={16} />
        </a>
        <Heading>{network.id}</Heading>
        <State word={network.line} />
      </header>
      <dl class="tuple-facts">
        {reason && <Fact name={text.reason}>{prose(reason)}</Fact>}
        <Fact name={text.since}>
          <Age time={number(status?.since)} /> <span class="muted">{formatFullTime(number(status?.since))}</span>
        </Fact>
        <Fact name={text.attempts}>
          {number(status?.attempts)} <NextAttempt network={network} />
        </Fact>
        <Fact name={text.island}>{network.owner}</Fact>
      </dl>
      <Reopening network={network} />
      <MayNot needs="admin" />
      <div class="actions">
        <a class="button" href={hrefTo("devices", [], { network: network.id })}>
          {text.itsDevices(network.devices)}
        </a>
        <a class="button" href={hrefTo("tuples", [`${network.owner}:${network.prefix}.${network.id}`])}>
          {tuplesText.title}
        </a>
      </div>
      {isZigbee(network) && network.line === "up" && <ZigbeePanel network={network} />}
      {order.map((kind) => (
        <Counters
          key={kind}
          title={text.kinds[kind]}
          kind={kind}
          counters={counters.filter((one) => one.kind === kind && !isZero(one))}
          rates={rates}
        />
      ))}
      {zeros.length > 0 && (
        <details>
          <summary>{text.zeros(zeros.length)}</summary>
          <p class="muted">{zeros.map(({ name }) => name).join(", ")}</p>
        </details>
      )}
    </aside>
  );
}

function Fact({ name, children }: { name: string; children: preact.ComponentChildren }) {
  return (
    <>
      <dt>{name}</dt>
      <dd>{children}</dd>
    </>
  );
}

/** What a network says of itself; of an object each member. */
function FactValue({ tuple }: { tuple: Tuple }) {
  const members = Object.entries(tuple.json);
  if (members.length === 0) return <>{prettyJson(tuple.value ?? "") ? text.nothing : tuple.value}</>;
  return (
    <dl class="members">
      {members.map(([name, value]) => (
        <div key={name}>
          <dt>{name.replaceAll("_", " ")}</dt>
          <dd>{memberText(value)}</dd>
        </div>
      ))}
    </dl>
  );
}

function memberText(value: unknown): string {
  if (typeof value === "boolean") return value ? text.yes : text.no;
  return typeof value === "string" ? value : JSON.stringify(value);
}

function Counters({ title, kind, counters, rates }: { title: string; kind: CounterKind; counters: Counter[]; rates: CounterRates }) {
  if (counters.length === 0) return null;
  return (
    <table class={`counters counters-${kind}`}>
      <caption>{title}</caption>
      <tbody>
        {counters.map(({ name, tuple }) => {
          const value = tuple.value ?? "";
          const rate = rates.of(tuple);
          return (
            <tr key={name}>
              <th scope="row">{name}</th>
              <td>{kind === "fact" ? <FactValue tuple={tuple} /> : formatNumber(value)}</td>
              {kind !== "fact" && <td class="rate">{rate >= 0.05 ? text.perSecond(formatRate(rate)) : ""}</td>}
            </tr>
          );
        })}
      </tbody>
    </table>
  );
}
