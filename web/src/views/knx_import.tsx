import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { catalog, useFeeds } from "../app";
import { type ImportChoices, type ImportPreview, isUncertain, withChoices } from "../core/knx_import";
import { OneAtATime } from "../core/one_at_a_time";
import { useFrame } from "../core/redraw";
import { askJson } from "../core/rest";
import { goToList, hrefToList, setQuery, type Route } from "../core/router";
import { optionsText, scalar } from "../core/sample";
import { Choice, FilterField } from "../parts/fields";
import { Icon } from "../parts/icons";
import { MayNot } from "../parts/may_not";
import { prose } from "../parts/prose";
import { Skeleton } from "../parts/state";
import * as words from "../words/frame";
import * as text from "../words/setup";
import { type Change, ChangeDialog, mostGroups } from "./change_dialog";
import { KnxPoints } from "./knx_points";
import { IslandChoice, type Target, useTarget } from "./setup_target";
import { kindOf } from "./traffic_monitor";

const largest = 32 * 2 ** 20;

/** Bytes in the body, the password in the head: never in an address. */
function upload(file: File, password: string, network: string, guess: boolean): Promise<ImportPreview> {
  const query = new URLSearchParams({ name: file.name, network, ...(!guess && { "no-guess": "true" }) });
  const headers = { "content-type": "application/octet-stream", "rubicon-password": encodeURIComponent(password) };
  return askJson<ImportPreview>(`/import?${query.toString()}`, { method: "POST", headers, body: file });
}

function choose(groups: string, choices: ImportChoices): Promise<ImportPreview> {
  const headers = { "content-type": "application/json" };
  return askJson<ImportPreview>("/import", { method: "POST", headers, body: JSON.stringify({ groups, choices }) });
}

/** The preview with the choices of the user; null while there are none. The server reads one file at a time. */
function useChoices(groups: string, choices: ImportChoices, failed: (why: string) => void) {
  const [now, setNow] = useState<ImportPreview | null>(null);
  const [pending, setPending] = useState(false);
  const latest = useRef(choices);
  latest.current = choices;
  const asking = useMemo(
    () =>
      new OneAtATime(async () => {
        const wanted = latest.current;
        const none = Object.keys(wanted).length === 0;
        const answer = await (none ? Promise.resolve(null) : choose(groups, wanted)).catch((error: Error) => error);
        if (latest.current !== wanted) return;
        setPending(false);
        if (answer instanceof Error) failed(answer.message);
        else setNow(answer);
      }),
    [groups],
  );
  useEffect(() => () => asking.end(), [asking]);
  useEffect(() => {
    failed("");
    setPending(true);
    asking.ask();
  }, [choices]);
  return { now, pending };
}

/** A KNX project or export: what it becomes, the choices of the user, and the change of the file. */
export function KnxImport({ route }: { route: Route }) {
  useFrame();
  const target = useTarget();
  const [preview, setPreview] = useState<ImportPreview | null>(null);
  const [into, setInto] = useState<Into>({ network: "", id: "", via: "tunnel", host: "" });
  return (
    <section class="view setup">
      <div class="toolbar">
        <a class="button plain" href={hrefToList("networks")} aria-label={words.close}>
          <Icon name="back" size={16} />
        </a>
        <h1>{text.importTitle}</h1>
        <IslandChoice owner={target.owner} />
      </div>
      <MayNot needs="admin" />
      <UploadForm target={target} into={into} onInto={setInto} onPreview={setPreview} />
      {preview && <Preview target={target} first={preview} into={into} route={route} />}
    </section>
  );
}

/** Where the addresses go: a network that is there, or a new one. */
interface Into {
  network: string;
  id: string;
  via: string;
  host: string;
}

interface UploadProps {
  target: Target;
  into: Into;
  onInto(into: Into): void;
  onPreview(preview: ImportPreview | null): void;
}

function UploadForm({ target, into, onInto, onPreview }: UploadProps) {
  useFeeds([{ pattern: `${target.owner}:*.*.property.telegrams-received.value`, min: 1000 }]);
  const [file, setFile] = useState<File | null>(null);
  const [password, setPassword] = useState("");
  const [guess, setGuess] = useState(true);
  const [state, setState] = useState<"" | "busy" | Error>("");
  const there = [...catalog.networks.values()].filter((one) => one.owner === target.owner && kindOf(one) === "knx").map(({ id }) => id);
  const isNew = into.network === "";
  const look = (event: Event) => {
    event.preventDefault();
    if (!file) return;
    onPreview(null);
    if (file.size > largest) return setState(new Error(text.tooLarge(file.size)));
    setState("busy");
    upload(file, password, isNew ? into.id.trim() || "knx" : into.network, guess).then(
      (preview) => {
        setState("");
        onPreview(preview);
      },
      (error: Error) => setState(error),
    );
  };
  return (
    <form class="upload" onSubmit={look}>
      <label class="field">
        <span>{text.file}</span>
        <input
          type="file"
          required
          accept=".knxproj,.csv,.xml,.esf,.txt,.yaml"
          title={text.fileHint}
          onChange={(event) => setFile(event.currentTarget.files?.[0] ?? null)}
        />
      </label>
      {/\.knxproj$/i.test(file?.name ?? "") && (
        <label class="field">
          <span>{text.password}</span>
          <input
            type="password"
            autocomplete="off"
            placeholder={text.passwordHint}
            value={password}
            onInput={(event) => setPassword(event.currentTarget.value)}
          />
        </label>
      )}
      <Choice label={text.into} none={text.aNew} value={into.network} values={there} onChange={(network) => onInto({ ...into, network })} />
      {isNew && (
        <>
          <label class="field">
            <span>{text.network}</span>
            <input
              type="text"
              required
              maxLength={64}
              pattern="[A-Za-z0-9_\-]+"
              spellcheck={false}
              placeholder={text.networkHint}
              value={into.id}
              onInput={(event) => onInto({ ...into, id: event.currentTarget.value })}
            />
          </label>
          <Choice
            label={text.via}
            value={into.via}
            values={["tunnel", "tunnel-tcp", "routing"]}
            onChange={(via) => onInto({ ...into, via })}
          />
          {into.via !== "routing" && (
            <label class="field">
              <span>{text.host}</span>
              <input
                type="text"
                required
                spellcheck={false}
                placeholder="192.168.1.10"
                value={into.host}
                onInput={(event) => onInto({ ...into, host: event.currentTarget.value })}
              />
            </label>
          )}
        </>
      )}
      <label class="field">
        <input type="checkbox" checked={guess} onChange={(event) => setGuess(event.currentTarget.checked)} />
        <span>{text.names}</span>
      </label>
      <button type="submit" class="primary" disabled={state === "busy"}>
        {text.preview}
      </button>
      {state === "busy" && <span role="status">{text.reading}</span>}
      {state === "busy" && <Skeleton rows={2} />}
      <p role="alert" class="error">
        {prose(state instanceof Error ? state.message : "")}
      </p>
    </form>
  );
}

function changeOf({ network, id, via, host }: Into, groups: string): Change {
  if (network) return { do: "import", network, groups };
  const options = optionsText("knx", [["via", via], ...(via === "routing" ? [] : [["host", scalar(host.trim())] as [string, string]])], "");
  return { do: "add", network: id.trim(), options, groups };
}

function Preview({ target, first, into, route }: { target: Target; first: ImportPreview; into: Into; route: Route }) {
  const [choices, setChoices] = useState<ImportChoices>({});
  const [error, setError] = useState("");
  const [change, setChange] = useState<Change | null>(null);
  const { now, pending } = useChoices(first.groups, choices, setError);
  const base = useMemo(() => new Map(first.points.map((point) => [point.address, point])), [first]);
  const uncertain = useMemo(() => first.points.filter(isUncertain).length, [first]);
  const points = useMemo(() => withChoices(first.points, now?.points ?? null), [first, now]);
  const { q = "", only = "" } = route.query;
  const check = () => {
    const { groups } = now ?? first;
    if (!into.network && !into.id.trim()) return setError(text.noNetwork);
    if (!into.network && into.via !== "routing" && !into.host.trim()) return setError(text.noHost);
    const { size } = new Blob([groups]);
    if (size > mostGroups) return setError(text.tooMany(size));
    setChange(changeOf(into, groups));
  };
  return (
    <>
      <div class="strip">
        <strong>{first.form}</strong>
        <span>{text.counts(first.counts)}</span>
        {first.merged && <span>{text.merged}</span>}
      </div>
      {first.findings.length > 0 && (
        <details class="findings">
          <summary>{text.findings(first.findings.length)}</summary>
          <ul class="changes" tabIndex={0}>
            {first.findings.map((finding, index) => (
              <li key={index}>
                <span class={finding.level === "error" ? "loss" : "muted"}>{finding.level}</span> {finding.address}{" "}
                {prose(text.line(finding.line, finding.text))}
              </li>
            ))}
          </ul>
        </details>
      )}
      <div class="toolbar">
        <FilterField value={q} />
        {uncertain > 0 && (
          <label class="field">
            <input type="checkbox" checked={only !== ""} onChange={(event) => setQuery({ only: event.currentTarget.checked ? "1" : "" })} />
            <span>{text.uncertain(uncertain)}</span>
          </label>
        )}
        <span class="space" />
        <button type="button" class="primary" disabled={pending || target.base === ""} onClick={check}>
          {text.check}
        </button>
      </div>
      <p role="alert" class="error">
        {prose(error)}
      </p>
      <KnxPoints
        base={base}
        points={points}
        types={first.types ?? []}
        choices={choices}
        search={q}
        onlyUncertain={only !== "" && uncertain > 0}
        onChoose={setChoices}
      />
      {change && (
        <ChangeDialog
          owner={target.owner}
          base={target.base}
          change={change}
          onClose={() => setChange(null)}
          onDone={() => goToList("networks")}
        />
      )}
    </>
  );
}
