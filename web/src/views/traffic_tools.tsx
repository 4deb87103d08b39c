import { useRef, useState } from "preact/hooks";
import type { Network } from "../core/catalog";
import { type CapturedFrame, isGroup, type Passing, pcapOf } from "../core/traffic";
import { announce, notify } from "../parts/notices";
import { Dialog } from "../parts/dialog";
import { download, fileStamp } from "../parts/download";
import * as text from "../words/traffic";
import * as words from "../words/frame";
import { requestOf, useReplies } from "./traffic_monitor";

const patience = 12_000;

let lastRequest = 0;

/** Replies reach every page of this server: the names of requests must differ. */
function newName(): string {
  return `page-${Math.random().toString(36).slice(2, 8)}-${++lastRequest}`;
}

/** One request at a time, and its reply. */
function useRequest(network: Network) {
  const open = useRef<{ id: string; done(reply: Record<string, unknown>): void; timer: number } | null>(null);
  useReplies(network, "knx", (reply) => {
    const request = open.current;
    if (!request || reply.id !== request.id) return;
    clearTimeout(request.timer);
    open.current = null;
    request.done(reply);
  });
  return (fields: Record<string, unknown>, done: (reply: Record<string, unknown>) => void) => {
    const id = newName();
    const fail = (why: string) => {
      if (open.current?.id !== id) return;
      clearTimeout(open.current.timer);
      open.current = null;
      done({ ok: false, why });
    };
    open.current = { id, done, timer: window.setTimeout(() => fail(text.noReply), patience) };
    requestOf(network, "knx", { id, ...fields }, fail);
  };
}

/** Saves what the network kept of the last minutes, for Wireshark. */
export function CaptureButton({ network }: { network: Network }) {
  const [busy, setBusy] = useState(false);
  const request = useRequest(network);
  const frames = useRef<(CapturedFrame & { number: number })[]>([]);
  const ask = (from: number) =>
    request({ do: "capture", from }, (reply) => {
      if (reply.ok !== true) {
        setBusy(false);
        notify(text.refused(String(reply.why ?? "")), "bad");
        return;
      }
      frames.current.push(...((reply.frames ?? []) as typeof frames.current));
      const last = frames.current[frames.current.length - 1];
      if (reply.more === true && last) {
        ask(last.number + 1);
        return;
      }
      setBusy(false);
      if (frames.current.length === 0) notify(text.nothingKept, "waiting");
      else download(`${fileStamp()}-${network.id}.pcap`, pcapOf(frames.current) as BlobPart, "application/vnd.tcpdump.pcap");
    });
  const start = () => {
    frames.current = [];
    setBusy(true);
    ask(0);
  };
  return (
    <button type="button" disabled={busy} title={text.captureTitle} onClick={start}>
      {text.capture}
    </button>
  );
}

interface Write {
  address: string;
  value: string;
  dpt: string;
}

/** Writes to a group of the bus: first what, then once more whether. */
export function WriteDialog({ network, seen, onClose }: { network: Network; seen: Passing[]; onClose(): void }) {
  const [write, setWrite] = useState<Write>({ address: "", value: "", dpt: "" });
  const [stage, setStage] = useState<"form" | "confirm" | "sent">("form");
  const [outcome, setOutcome] = useState("");
  const request = useRequest(network);
  const names = new Map(seen.filter(({ to }) => to !== "").map(({ to, name }) => [to, name]));
  const name = names.get(write.address) ?? "";
  const send = () => {
    setStage("sent");
    setOutcome(text.sending);
    request({ do: "write", address: write.address, value: write.value, ...(write.dpt ? { dpt: write.dpt } : {}) }, (reply) => {
      const result =
        reply.ok === true
          ? text.written(String(reply.address ?? write.address), String(reply.hex ?? ""))
          : text.notWritten(String(reply.why ?? ""));
      setOutcome(result);
      announce(result);
    });
  };
  return (
    <Dialog title={text.writeTitle(network.id)} onClose={onClose}>
      {stage === "form" ? (
        <WriteForm write={write} names={names} onInput={setWrite} onDone={() => setStage("confirm")} />
      ) : (
        <>
          <p class="question">{text.question(write.value, write.address, name, network.id)}</p>
          <p class="muted">{text.consequence}</p>
          {outcome && <p role="status">{outcome}</p>}
          <div class="actions">
            {stage === "confirm" && (
              <button ref={(button) => button?.focus()} type="button" class="primary" onClick={send}>
                {text.confirm}
              </button>
            )}
            <button type="button" onClick={() => (stage === "confirm" ? setStage("form") : onClose())}>
              {stage === "confirm" ? text.change : words.close}
            </button>
            {stage === "sent" && (
              <button
                type="button"
                onClick={() => {
                  setOutcome("");
                  setStage("form");
                }}
              >
                {text.another}
              </button>
            )}
          </div>
        </>
      )}
    </Dialog>
  );
}

function WriteForm({
  write,
  names,
  onInput,
  onDone,
}: {
  write: Write;
  names: Map<string, string>;
  onInput(write: Write): void;
  onDone(): void;
}) {
  const wrong = write.address !== "" && !isGroup(write.address);
  return (
    <form
      class="form-grid"
      onSubmit={(event) => {
        event.preventDefault();
        if (isGroup(write.address) && write.value !== "") onDone();
      }}
    >
      <label class="field">
        <span>{text.group}</span>
        <input
          type="text"
          autofocus
          required
          list="groups"
          spellcheck={false}
          placeholder="1/0/1"
          aria-invalid={wrong}
          value={write.address}
          onInput={(event) => onInput({ ...write, address: event.currentTarget.value.trim() })}
        />
      </label>
      <datalist id="groups">
        {[...names].map(([address, name]) => (
          <option key={address} value={address}>
            {name}
          </option>
        ))}
      </datalist>
      <label class="field">
        <span>{text.value}</span>
        <input
          type="text"
          required
          spellcheck={false}
          placeholder={text.valueHint}
          value={write.value}
          onInput={(event) => onInput({ ...write, value: event.currentTarget.value })}
        />
      </label>
      <label class="field">
        <span>{text.dpt}</span>
        <input
          type="text"
          spellcheck={false}
          placeholder={text.dptHint}
          value={write.dpt}
          onInput={(event) => onInput({ ...write, dpt: event.currentTarget.value.trim() })}
        />
      </label>
      {wrong && (
        <p class="error" role="alert">
          {text.wrongGroup}
        </p>
      )}
      <div class="actions">
        <button type="submit" class="primary" disabled={!isGroup(write.address) || write.value === ""}>
          {text.next}
        </button>
      </div>
    </form>
  );
}
