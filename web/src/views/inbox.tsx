import { useEffect, useMemo, useState } from "preact/hooks";
import { catalog, chosenIsland, connection, loadingOf, mayBe, noIslands, ownerPattern, useFeeds } from "../app";
import { number } from "../core/catalog";
import { browserClock } from "../core/clock";
import { type Decision, Decisions, type Step, type Verb } from "../core/decisions";
import type { Answer } from "../core/frames";
import { useOrder } from "../core/hooks";
import { answerOf, type Decided, type InboxList, listsOf, sizeOf } from "../core/inbox_list";
import { redraw, second, useFrame } from "../core/redraw";
import { askJson, type RestError } from "../core/rest";
import { hrefTo, hrefToList, rememberList, type Route, setQuery } from "../core/router";
import type { Tuple } from "../core/store";
import { compareNatural, matches } from "../core/text";
import { FilterField } from "../parts/fields";
import { MayNot } from "../parts/may_not";
import { NoIsland } from "../parts/no_island";
import { notify } from "../parts/notices";
import { moreLines, phone } from "../parts/screen";
import { Empty, Loaded, NoneMatch } from "../parts/state";
import { compareBy, Outdated, SortSelect, Table } from "../parts/table";
import * as text from "../words/inbox";
import * as devicesText from "../words/devices";
import * as words from "../words/frame";
import { inboxColumns, isIgnored, nameOf, searchedOf, whyOf } from "./inbox_columns";
import { useIgnored } from "./inbox_ignored";
import { inboxesOf, PatternForm } from "./inbox_pattern";
import type { View } from "./views";

type Answered = (step: Step, answer: Answer) => void;

/** Requests that outlive the page may carry so many bytes together. */
const mostKept = 65_536;
let kept = 0;

/** Names count as commands: of many lists at once the server refuses some at first. */
const busyPause = 1000;

async function sendList(list: InboxList, call: Answered): Promise<void> {
  const { body, steps } = list;
  const size = sizeOf([list]);
  const keepalive = kept + size <= mostKept;
  if (keepalive) kept += size;
  try {
    const init = { method: "POST", body: JSON.stringify(body), keepalive };
    const { decisions } = await askJson<{ decisions: Decided[] }>("/inbox", init);
    steps.forEach((step, index) => call(step, answerOf(decisions[index])));
  } catch (error) {
    const { code, message } = error as RestError;
    if (code === "busy") {
      browserClock.after(busyPause, () => void sendList(list, call));
      return;
    }
    for (const step of steps) call(step, { id: 0, ok: false, error: { code, text: message } });
  } finally {
    if (keepalive) kept -= size;
  }
}

/** Decisions outlive the view: who goes on to another one has decided all the same. */
export const decisions = new Decisions(browserClock, {
  send(steps, call, leaving) {
    const [only] = steps;
    if (only && steps.length === 1 && !leaving) connection.request({ do: "set", ...only }, (answer) => call(only, answer));
    else for (const list of listsOf(steps)) void sendList(list, call);
  },
  changed: redraw,
  ended(decision, failures) {
    const [first] = failures;
    if (first) notify(text.failed(failures.length, decision.steps.length, first.answer.error?.text ?? ""), "bad");
    else notify(text.done(decision.verb, decision.devices.size), "good");
  },
});

function undo(decision: Decision): void {
  if (!decisions.undo(decision)) notify(text.tooLate, "waiting");
}

/** Decides about devices one by one. An ignored one has no tuple of its own: its inbox takes its address. */
function decide(verb: Verb, tuples: Tuple[]): void {
  if (tuples.length === 0) return;
  decisions.decide(
    verb,
    tuples.map(({ id }) => id),
    tuples.map((tuple) => {
      const name = nameOf(tuple);
      return isIgnored(tuple) ? { key: tuple.id.slice(0, -name.length - 1), value: `${verb} ${name}` } : { key: tuple.id, value: verb };
    }),
  );
}

function countIn(what: "count" | "ignored"): number {
  const island = chosenIsland();
  let sum = 0;
  for (const tuple of catalog.inboxes.values()) if (!island || tuple.owner === island) sum += number(tuple.json[what]);
  return sum;
}

function Inbox({ route }: { route: Route }) {
  useFrame();
  const owner = ownerPattern();
  const feeds = useFeeds([
    { pattern: `${owner}:*.inbox.*.*`, min: 250 },
    { pattern: `${owner}:*.inbox`, min: 250 },
  ]);
  const { q = "", sort = "name" } = route.query;
  const island = chosenIsland();
  const ignoring = route.parts[0] === "ignored";
  const ignored = useIgnored(inboxesOf(island), ignoring);
  const all = ignoring ? ignored.devices : [...catalog.waiting.values()];
  const version = ignoring ? ignored.version : catalog.arrivals;
  const [chosen, setChosen] = useState<ReadonlySet<string>>(new Set());
  const toggle = (tuple: Tuple) => {
    const next = new Set(chosen);
    if (!next.delete(tuple.id)) next.add(tuple.id);
    setChosen(next);
  };
  const mayDecide = mayBe("admin");
  const columns = useMemo(
    () => inboxColumns({ chosen, toggle, decide, undo, decisions, mayDecide, ignoring }),
    [chosen, mayDecide, ignoring],
  );
  const state = ignoring ? ignored.state : loadingOf(feeds);
  const order = useOrder(() => all, version, {
    name: JSON.stringify([q, sort, island, ignoring]),
    keep: (tuple) => (!island || tuple.owner === island) && (q === "" || matches(q, searchedOf(tuple))),
    compare: compareBy(columns, sort, (a, b) => compareNatural(nameOf(a), nameOf(b))),
    live: columns.some((column) => column.live && column.id === sort.replace(/^-/, "")),
    complete: state === "ready",
  });
  const rows = order.rows;
  const tableRows = useMemo(() => rows.map((row) => ({ row })), [rows]);
  const heightOf = useMemo(() => {
    const [height, width] = phone.value ? [mayDecide ? 156 : 92, innerWidth - 32] : [44, 160];
    return (tuple: Tuple) => height + moreLines(whyOf(tuple).length, width);
  }, [mayDecide, phone.value]);
  useEffect(() => setChosen(new Set(all.map(({ id }) => id).filter((id) => chosen.has(id)))), [all.length]);
  const picked = rows.filter(({ id }) => chosen.has(id));
  const decidePicked = (verb: Verb) => {
    decide(verb, picked);
    setChosen(new Set());
  };
  if (!ignoring) rememberList("inbox", route.query);
  if (noIslands() && catalog.waiting.size === 0) return <NoIsland />;
  return (
    <section class="view inbox">
      <div class="toolbar">
        <h1>{ignoring ? text.ignoredTitle : text.title}</h1>
        <FilterField value={q} />
        {phone.value && <SortSelect columns={columns} sorting={{ by: sort, set: (by) => setQuery({ sort: by }) }} />}
        {mayDecide && rows.length > 0 && (
          <button type="button" onClick={() => setChosen(new Set(picked.length === rows.length ? [] : rows.map(({ id }) => id)))}>
            {picked.length === rows.length ? text.selectNone : text.selectAll(rows.length)}
          </button>
        )}
        {picked.length > 0 && (
          <>
            <button type="button" class="primary" onClick={() => decidePicked("approve")}>
              {text.approveMany(picked.length)}
            </button>
            {!ignoring && (
              <button type="button" onClick={() => decidePicked("ignore")}>
                {text.ignoreMany(picked.length)}
              </button>
            )}
          </>
        )}
        <OtherList ignoring={ignoring} />
        <span class="count">{words.tableShown(rows.length, all.length)}</span>
        <Outdated order={order} />
      </div>
      <MayNot needs="admin" />
      <Pending />
      {mayDecide && !ignoring && <PatternForm waiting={catalog.waiting.values()} ignored={countIn("ignored")} decisions={decisions} />}
      <Loaded state={state} empty={rows.length === 0 && <Nothing all={all.length} filtered={q !== ""} ignoring={ignoring} />}>
        <Table
          label={ignoring ? text.ignoredTitle : text.title}
          columns={columns}
          rows={tableRows}
          rowsVersion={rows}
          heightOf={heightOf}
          nameOf={({ id }) => id}
          place={`inbox ${ignoring} ${q} ${sort}`}
          sorting={{ by: sort, set: (by) => setQuery({ sort: by === "name" ? "" : by }) }}
          marked={({ id }) => chosen.has(id)}
          keys={
            mayDecide
              ? {
                  x: { what: devicesText.select, run: toggle },
                  " ": { what: devicesText.select, run: toggle },
                  y: { what: text.approve, run: (tuple) => decide("approve", [tuple]) },
                  ...(ignoring ? {} : { e: { what: text.ignore, run: (tuple: Tuple) => decide("ignore", [tuple]) } }),
                  u: { what: text.undo, run: undoLast },
                }
              : undefined
          }
        />
      </Loaded>
    </section>
  );
}

function undoLast(): void {
  const last = decisions.pending.filter(({ until }) => until > 0).pop();
  if (last) undo(last);
}

/** What was decided and can still be taken back. */
function Pending() {
  void second.value;
  const pending = decisions.pending;
  if (pending.length === 0) return null;
  return (
    <ul class="pending">
      {pending.map((decision) => {
        const seconds = Math.max(0, Math.ceil((decision.until - browserClock.now()) / 1000));
        return (
          <li key={[...decision.devices].join() + decision.steps[0]?.value} class="pending-decision">
            <span>{decision.until > 0 ? text.pending(decision.verb, decision.devices.size, seconds) : text.sending}</span>
            {decision.until > 0 && (
              <button type="button" class="small" onClick={() => undo(decision)}>
                {text.undo}
              </button>
            )}
          </li>
        );
      })}
    </ul>
  );
}

/** From what waits to what is ignored, and back. */
function OtherList({ ignoring }: { ignoring: boolean }) {
  const ignored = countIn("ignored");
  if (ignoring) return <a href={hrefToList("inbox")}>{text.waiting(countIn("count"))}</a>;
  return ignored > 0 ? <a href={hrefTo("inbox", ["ignored"])}>{text.ignored(ignored)}</a> : null;
}

function Nothing({ all, filtered, ignoring }: { all: number; filtered: boolean; ignoring: boolean }) {
  if (all > 0 && filtered) return <NoneMatch title={devicesText.filtered} />;
  if (ignoring) {
    return (
      <Empty title={text.noneIgnored}>
        <OtherList ignoring />
      </Empty>
    );
  }
  return (
    <Empty title={text.none}>
      <OtherList ignoring={false} />
      <p>{text.noneText}</p>
      {inboxesOf(chosenIsland()).length === 0 && <p>{text.noInbox}</p>}
    </Empty>
  );
}

addEventListener("pagehide", () => decisions.flush());
// The browser asks whether to leave: not all that was decided would arrive.
addEventListener("beforeunload", (event) => {
  if (sizeOf(decisions.pending.flatMap(({ steps }) => listsOf(steps))) > mostKept) event.preventDefault();
});

export const inboxView: View = {
  id: "inbox",
  title: text.title,
  key: "i",
  icon: "inbox",
  mark: () => countIn("count"),
  show: (route) => <Inbox route={route} />,
};
