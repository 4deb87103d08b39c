import { useEffect, useState } from "preact/hooks";
import { list, number, text as textOf } from "../core/catalog";
import { ask, askJson, RestError, tuplePath } from "../core/rest";
import { CopyButton } from "../parts/copy";
import { Dialog } from "../parts/dialog";
import { download } from "../parts/download";
import { notify } from "../parts/notices";
import { prose } from "../parts/prose";
import { Skeleton } from "../parts/state";
import * as text from "../words/setup";
import { faultsOf, placeOf } from "./faults";

/** A change of the file of an island: the value of `<prefix>.settings.command`. */
export interface Change {
  do: "add" | "import" | "undo";
  network?: string;
  options?: string;
  groups?: string;
}

type Status = Record<string, unknown>;

/** A set of the API carries at most 1 MiB. */
export const mostGroups = 900_000;

async function statusOf(owner: number, base: string): Promise<Status> {
  const { value } = await askJson<{ value: string }>(tuplePath(owner, `${base}.status`));
  return JSON.parse(value) as Status;
}

const pause = (time: number) => new Promise((done) => setTimeout(done, time));

/** A reload of an island with rights closes all connections, that of the request too. */
const attempts = 20;

/** Sends it, and waits for its outcome: the status that the island then shows. What it refuses is there, with places. */
async function send(owner: number, base: string, change: Change, onlyTry: boolean): Promise<Status> {
  const before = number((await statusOf(owner, base)).at);
  const body = JSON.stringify({ ...change, ...(onlyTry && { try: true }) });
  let failure = new RestError("failed", text.noOutcome, 0);
  try {
    await ask(`${tuplePath(owner, `${base}.command`)}?wait=60s`, { method: "PUT", headers: { "content-type": "text/plain" }, body });
  } catch (error) {
    if (!(error instanceof RestError) || (error.status !== 409 && error.status !== 0)) throw error;
    failure = error;
  }
  for (let left = failure.status === 409 ? 1 : attempts; left > 0; left--) {
    const status = await statusOf(owner, base).catch(() => ({}) as Status);
    if (number(status.at) > before && status.what === change.do) return status;
    if (left > 1) await pause(500);
  }
  throw failure;
}

export async function undoChange(owner: number, base: string): Promise<void> {
  try {
    const status = await send(owner, base, { do: "undo" }, false);
    if (status.state === "ok") return notify(text.done.undo, "good");
    notify(faultsOf(status).map((fault) => fault.text)[0] ?? text.noOutcome, "bad");
  } catch (error) {
    notify(String((error as Error).message), "bad");
  }
}

interface Props {
  owner: number;
  /** `proxy.settings` */
  base: string;
  change: Change;
  onClose(): void;
  onDone(): void;
}

/** What a change would do, as the island says after reading the new file; then the change. */
export function ChangeDialog({ owner, base, change, onClose, onDone }: Props) {
  const [tried, setTried] = useState<Status | null>(null);
  const [error, setError] = useState("");
  const [busy, setBusy] = useState(false);
  useEffect(() => {
    let ended = false;
    send(owner, base, change, true).then(
      (status) => !ended && setTried(status),
      (failure: Error) => !ended && setError(failure.message),
    );
    return () => void (ended = true);
  }, [change]);
  const apply = () => {
    setBusy(true);
    send(owner, base, change, false).then(
      (status) => {
        setBusy(false);
        if (status.state !== "ok") return setTried(status);
        notify(text.done[change.do], "good", { label: text.undo, run: () => void undoChange(owner, base) });
        onDone();
      },
      (failure: Error) => {
        setBusy(false);
        setError(failure.message);
      },
    );
  };
  return (
    <Dialog wide title={text.changeTitle[change.do](change.network ?? "")} onClose={onClose}>
      {!tried && !error && (
        <>
          <p role="status">{text.checking}</p>
          <Skeleton rows={3} />
        </>
      )}
      <p role="alert" class="error">
        {prose(error)}
      </p>
      {tried && <Outcome status={tried} groups={change.groups} />}
      <div class="actions">
        {tried?.state === "ok" && fixedOf(tried) === "" && (
          <button type="button" class="primary" disabled={busy} onClick={apply}>
            {text.apply(fileOf(tried))}
          </button>
        )}
        <button type="button" onClick={onClose}>
          {text.back}
        </button>
        {busy && <span class="muted">{text.applying}</span>}
      </div>
    </Dialog>
  );
}

function memberOf(status: Status, name: string): string {
  return typeof status.file === "object" && status.file !== null ? textOf((status.file as Status)[name]) : "";
}
const fileOf = (status: Status) => memberOf(status, "name");
const fixedOf = (status: Status) => memberOf(status, "fixed");

function Outcome({ status, groups }: { status: Status; groups?: string }) {
  const faults = faultsOf(status);
  const changes = list(status.changes);
  const patch = memberOf(status, "patch");
  const fixed = fixedOf(status);
  return (
    <>
      {faults.length > 0 ? <p class="loss">{text.faults(faults.length)}</p> : <p>{text.wouldDo(changes.length)}</p>}
      <ul class="changes">
        {changes.map((line) => (
          <li key={line}>{line}</li>
        ))}
        {faults.map((fault, index) => (
          <li key={index}>
            <code>{placeOf(fault)}</code> {prose(fault.text)}
          </li>
        ))}
      </ul>
      {patch && (
        <>
          <p>{fixed ? text.fixed(fileOf(status), fixed) : text.patch(fileOf(status))}</p>
          <pre class="content" tabIndex={0}>
            {patch}
          </pre>
          <div class="actions">
            <CopyButton text={patch} />
            {groups && (
              <button type="button" class="small" onClick={() => download(groupsName(patch), groups, "application/yaml")}>
                {text.groupFile}
              </button>
            )}
          </div>
        </>
      )}
    </>
  );
}

/** The name that the patch gives to the group file. */
function groupsName(patch: string): string {
  return /import: "?([^"\n]+)"?/.exec(patch)?.[1] ?? "groups.yaml";
}
