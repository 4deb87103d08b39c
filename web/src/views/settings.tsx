import { useEffect, useState } from "preact/hooks";
import { chosenIsland, islands, loadingOf, mayBe, noIslands, ownerPattern, store, useFeeds } from "../app";
import { list, number, text as textOf } from "../core/catalog";
import { findLines } from "../core/find_lines";
import { useFrame } from "../core/redraw";
import { type Route, setQuery } from "../core/router";
import type { Tuple } from "../core/store";
import { compareNatural } from "../core/text";
import { FilterField, Choice } from "../parts/fields";
import { Age } from "../parts/age";
import { setTuple } from "../parts/sent";
import { CopyButton } from "../parts/copy";
import { Dialog } from "../parts/dialog";
import { MayNot } from "../parts/may_not";
import { NoIsland } from "../parts/no_island";
import { notify } from "../parts/notices";
import { prose } from "../parts/prose";
import { Empty, Loaded, Skeleton, State } from "../parts/state";
import { useWhole } from "../parts/whole";
import * as text from "../words/settings";
import * as setup from "../words/setup";
import * as words from "../words/frame";
import { ChangeDialog } from "./change_dialog";
import { faultsOf, placeOf } from "./faults";
import type { View } from "./views";

function Settings({ route }: { route: Route }) {
  useFrame();
  const feeds = useFeeds([{ pattern: `${ownerPattern()}:*.settings.*`, min: 100 }]);
  const values = [...(feeds[0]?.held.tuples ?? [])]
    .filter(({ key }) => key.endsWith(".settings.value"))
    .sort((a, b) => a.owner - b.owner || compareNatural(a.key, b.key));
  const wanted = Number(route.query.of) || chosenIsland();
  const value = values.find(({ owner }) => owner === wanted) ?? values[0];
  if (noIslands()) return <NoIsland />;
  return (
    <section class="view settings">
      <Loaded state={loadingOf(feeds)} empty={!value && <Empty title={text.none} />}>
        {value && <IslandSettings key={value.id} value={value} all={values} search={route.query.q ?? ""} />}
      </Loaded>
    </section>
  );
}

function nameOf(owner: number | string): string {
  const name = islands.value.find(({ id }) => id === Number(owner))?.name;
  return name ? `${name} · ${owner}` : String(owner);
}

/** Milliseconds within which an island has read its file. */
const patience = 30_000;

type Asked = { what: "try" | "reload"; preview: boolean; after: number } | null;

/** Sends `try` and `reload`, and follows the status until it has their outcome. */
function useSettingsCommands(status: Tuple | undefined, command: string) {
  const [asked, setAsked] = useState<Asked>(null);
  const [preview, setPreview] = useState(false);
  const send = (what: "try" | "reload", withPreview = false) => {
    setPreview(false);
    setAsked({ what, preview: withPreview, after: number(status?.json.at) });
    setTuple(command, what, {}, (answer) => {
      if (!answer.error) return;
      setAsked(null);
      notify(text.failed(answer.error.text), "bad");
    });
  };
  const state = textOf(status?.json.state);
  useEffect(() => {
    if (!asked || textOf(status?.json.what) !== asked.what || number(status?.json.at) <= asked.after) return;
    setAsked(null);
    const count = list(status?.json.changes).length;
    if (state === "refused") notify(text.refused(faultsOf(status?.json ?? {}).length), "bad");
    else if (asked.what === "reload") notify(text.reloaded(count), "good");
    else if (count === 0) notify(text.equal, "good");
    else if (asked.preview) setPreview(true);
  }, [status?.sequence, asked]);
  useEffect(() => {
    if (!asked) return undefined;
    const timer = setTimeout(() => {
      setAsked(null);
      notify(text.noOutcome, "bad");
    }, patience);
    return () => clearTimeout(timer);
  }, [asked]);
  return { busy: asked !== null, preview, endPreview: () => setPreview(false), send };
}

/** Always the same one: a dialog asks once for each change. */
const undo = { do: "undo" } as const;

function IslandSettings({ value, all, search }: { value: Tuple; all: Tuple[]; search: string }) {
  const status = store.get(value.id.replace(/value$/, "status"));
  const { busy, preview, endPreview, send } = useSettingsCommands(status, value.id.replace(/value$/, "command"));
  const { text: whole, error } = useWhole(value);
  const lines = findLines(whole ?? "", search);
  const admin = mayBe("admin");
  const [undoing, setUndoing] = useState(false);
  const file = status?.json.file as Record<string, unknown> | undefined;
  return (
    <>
      <MayNot needs="admin" />
      <div class="toolbar">
        <h1>{text.title}</h1>
        {all.length > 1 && (
          <Choice
            label={words.islandsLabel}
            value={String(value.owner)}
            values={all.map(({ owner }) => String(owner))}
            name={nameOf}
            onChange={(of) => setQuery({ of })}
          />
        )}
        <FilterField value={search} />
        {admin && (
          <>
            <button type="button" disabled={busy} title={text.checkTitle} onClick={() => send("try")}>
              {text.check}
            </button>
            <button type="button" disabled={busy} title={text.reloadTitle} onClick={() => send("try", true)}>
              {text.reload}
            </button>
            {file?.previous === true && (
              <button type="button" disabled={busy} title={setup.previousTitle} onClick={() => setUndoing(true)}>
                {setup.previous}
              </button>
            )}
          </>
        )}
        {whole && <CopyButton text={whole} />}
        {busy && <span class="muted">{text.busy}</span>}
      </div>
      {status && <Outcome status={status} />}
      {error && <div class="strip bad">{error}</div>}
      {whole === null && !error ? (
        <Skeleton rows={12} />
      ) : lines.length === 0 || whole === "" ? (
        <Empty title={whole ? text.filtered : text.empty}>
          {whole && (
            <button type="button" onClick={() => setQuery({ q: "" })}>
              {words.tableClear}
            </button>
          )}
        </Empty>
      ) : (
        <div class="configuration" tabIndex={0} role="region" aria-label={text.inForce(nameOf(value.owner))}>
          <pre class="numbers" aria-hidden="true">
            {lines.map((line) => `${line.number}\n`).join("")}
          </pre>
          <pre>{lines.map((line) => `${line.text}\n`).join("")}</pre>
        </div>
      )}
      {undoing && (
        <ChangeDialog
          owner={value.owner}
          base={value.key.replace(/\.value$/, "")}
          change={undo}
          onClose={() => setUndoing(false)}
          onDone={() => setUndoing(false)}
        />
      )}
      {preview && status && (
        <Dialog title={text.preview(list(status.json.changes).length)} onClose={endPreview}>
          <Changes status={status} />
          <div class="actions">
            <button type="button" class="primary" onClick={() => send("reload")}>
              {text.reloadNow}
            </button>
            <button type="button" onClick={endPreview}>
              {text.cancel}
            </button>
          </div>
        </Dialog>
      )}
    </>
  );
}

function Changes({ status }: { status: Tuple }) {
  return (
    <ul class="changes">
      {list(status.json.changes).map((line) => (
        <li key={line}>{line}</li>
      ))}
    </ul>
  );
}

/** What the last check or reload found: what differs from the file, or every error with its place. */
function Outcome({ status }: { status: Tuple }) {
  const { json } = status;
  const state = textOf(json.state);
  const asked = textOf(json.what);
  const what = asked === "try" || json.tried === true ? "try" : "reload";
  const changes = list(json.changes);
  const faults = faultsOf(json);
  if (state === "idle" || state === "") return <div class="strip">{text.idle}</div>;
  return (
    <section class="outcome-block" aria-label={text.outcome}>
      <p>
        <State word={state} tone={state === "ok" ? "good" : "bad"} />{" "}
        {state === "ok" ? text.ok[what](changes.length) : text.bad[what](faults.length)} <Age time={number(json.at)} />
      </p>
      {state === "ok" && changes.length > 0 && <Changes status={status} />}
      {faults.length > 0 && (
        <table class="faults">
          <thead>
            <tr>
              <th scope="col">{text.place}</th>
              <th scope="col">{text.error}</th>
            </tr>
          </thead>
          <tbody>
            {faults.map((fault, index) => (
              <tr key={index}>
                <td>
                  <code>{placeOf(fault) || "–"}</code>
                </td>
                <td>{prose(fault.text)}</td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
      {faults.length > 0 && (
        <CopyButton text={faults.map((fault) => `${placeOf(fault)} ${fault.text}`.trim()).join("\n")} label={text.copyErrors} />
      )}
    </section>
  );
}

export const settingsView: View = {
  id: "settings",
  title: text.title,
  key: "s",
  icon: "settings",
  show: (route) => <Settings route={route} />,
};
