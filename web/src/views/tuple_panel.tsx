import { useEffect, useState } from "preact/hooks";
import { components, mayBe, store, useFeeds } from "../app";
import type { Subscription } from "../core/feed";
import { formatAge, formatFullTime, formatRate, hexDump, prettyJson } from "../core/format";
import type { Rates } from "../core/rates";
import { useFrame } from "../core/redraw";
import { RestError, tupleBytes } from "../core/rest";
import { hrefToList } from "../core/router";
import { pinnedBranches, togglePin } from "../core/settings";
import type { Tuple } from "../core/store";
import type { Branch } from "../core/tree";
import { Age } from "../parts/age";
import { CopyButton } from "../parts/copy";
import { Icon } from "../parts/icons";
import { MayNot } from "../parts/may_not";
import * as text from "../words/tuples";
import * as words from "../words/frame";
import { TupleForm } from "./tuple_form";
import { serverNow } from "../core/server_time";

/** One tuple whole: value, times, who made it, and a form to set it. */
export function TuplePanel({ id, rates, branch }: { id: string; rates: Rates; branch?: Branch }) {
  useFrame();
  const feeds = useFeeds(id.includes(":") ? [{ pattern: id, full: true }] : []);
  const tuple = store.get(id);
  const pinned = pinnedBranches.value.includes(id);
  return (
    <aside class="panel" aria-label={text.key}>
      <header>
        <a class="button" href={hrefToList("tuples")} aria-label={words.close} title={words.close}>
          <Icon name="back" size={16} />
        </a>
        <h2 class="key">{id}</h2>
      </header>
      <div class="actions">
        <CopyButton text={id} label={text.copyKey} />
        <CopyButton text={`rubicon get '${id}'`} label={text.copyGet} />
        <button type="button" class="small" aria-pressed={pinned} onClick={() => togglePin(pinnedBranches, id)}>
          {pinned ? text.unpin : text.pin}
        </button>
      </div>
      {tuple ? (
        <Facts tuple={tuple} rate={rates.of(tuple)} />
      ) : (
        <p class="muted">{branch ? text.branch : isComing(id, feeds) ? words.loading : text.missing}</p>
      )}
    </aside>
  );
}

/** Its owner is there and has not sent all yet, or it is not known yet who is there. */
function isComing(id: string, feeds: Subscription[]): boolean {
  const owner = Number(id.split(":", 1)[0]);
  const known = components.value.length > 0; // the server itself is one
  return !known || (components.value.some(({ id: other }) => other === owner) && !feeds.every((feed) => feed.complete([owner])));
}

function nameOf(component: number): string {
  const name = components.value.find(({ id }) => id === component)?.name;
  return name ? `${component} · ${name}` : String(component);
}

function Facts({ tuple, rate }: { tuple: Tuple; rate: number }) {
  return (
    <>
      <dl class="tuple-facts">
        <Fact name={text.media} value={tuple.media} />
        <Fact name={text.size} value={text.bytes(sizeOf(tuple))} />
        <Fact name={text.sequence} value={`@${tuple.sequence}`} />
        <Fact name={text.rate} value={`${formatRate(rate)}/s`} />
        <Fact name={text.creator} value={tuple.creator ? nameOf(tuple.creator) : ""} />
        <Fact
          name={text.owner}
          value={`${nameOf(tuple.owner)}, ${tuple.present ? text.present : text.absent(formatFullTime(tuple.absentSince))}`}
        />
        <Time name={text.write} time={tuple.write} />
        <Time name={text.user} time={tuple.time === tuple.write ? 0 : tuple.time} />
        <dt>{text.expires}</dt>
        <dd>{tuple.expire > 0 ? <Expiry time={tuple.expire} /> : text.never}</dd>
      </dl>
      <h3>{text.value}</h3>
      <TupleContent tuple={tuple} />
      {mayBe("command") ? <TupleForm tuple={tuple} /> : <MayNot needs="command" />}
    </>
  );
}

/** Bytes of the value. A text comes without its size. */
const sizeOf = (tuple: Tuple) => (tuple.value === null ? tuple.size : new TextEncoder().encode(tuple.value).length);

function Fact({ name, value }: { name: string; value: string }) {
  if (!value) return null;
  return (
    <>
      <dt>{name}</dt>
      <dd>{value}</dd>
    </>
  );
}

function Time({ name, time }: { name: string; time: number }) {
  if (time <= 0) return null;
  return (
    <>
      <dt>{name}</dt>
      <dd>
        {formatFullTime(time)}{" "}
        <span class="muted">
          (<Age time={time} />)
        </span>
      </dd>
    </>
  );
}

function Expiry({ time }: { time: number }) {
  const left = time - serverNow();
  return (
    <>
      {formatFullTime(time)} {left > 0 && <span class="muted">(in {formatAge(left)})</span>}
    </>
  );
}

function TupleContent({ tuple }: { tuple: Tuple }) {
  if (tuple.media.startsWith("image/")) return <Picture tuple={tuple} />;
  if (tuple.value === null) return <Bytes key={tuple.sequence} tuple={tuple} />;
  return (
    <>
      <Content>{prettyJson(tuple.value) ?? tuple.value}</Content>
      {tuple.value !== "" && (
        <div class="actions">
          <CopyButton text={tuple.value} />
        </div>
      )}
    </>
  );
}

/** A picture is fetched anew for each value. As an image it runs no script. */
function Picture({ tuple }: { tuple: Tuple }) {
  const [source, setSource] = useState("");
  const [error, setError] = useState("");
  useEffect(() => {
    let here = true;
    const reader = new FileReader();
    reader.onload = () => here && setSource(String(reader.result));
    tupleBytes(tuple.owner, tuple.key).then(
      (bytes) => reader.readAsDataURL(new Blob([bytes as BlobPart], { type: tuple.media })),
      (failure: unknown) => here && setError(failure instanceof RestError ? text.failed(failure.code, failure.message) : String(failure)),
    );
    return () => {
      here = false;
    };
  }, [tuple.sequence, tuple.media]);
  if (error) return <p class="error">{error}</p>;
  return source ? <img class="picture" alt={text.picture} src={source} /> : null;
}

/** Long values scroll; the keyboard reaches them. */
function Content({ children }: { children: string }) {
  return (
    <pre class="content" tabIndex={0} role="region" aria-label={text.value}>
      {children}
    </pre>
  );
}

/** Values that are not text, or long: the server sends them when asked. */
function Bytes({ tuple }: { tuple: Tuple }) {
  const [bytes, setBytes] = useState<Uint8Array | null>(null);
  const [error, setError] = useState("");
  const [asked, setAsked] = useState(false);
  useEffect(() => {
    if (!asked) return undefined;
    let here = true;
    tupleBytes(tuple.owner, tuple.key).then(
      (got) => here && setBytes(got),
      (failure: unknown) => here && setError(failure instanceof RestError ? text.failed(failure.code, failure.message) : String(failure)),
    );
    return () => {
      here = false;
    };
  }, [asked]);
  if (error) return <p class="error">{error}</p>;
  if (bytes) return <Content>{textOf(bytes) ?? hexDump(bytes)}</Content>;
  return (
    <div class="actions">
      <button type="button" class="small" onClick={() => setAsked(true)}>
        {text.load}
      </button>
    </div>
  );
}

const longestText = 200_000;

/** The bytes as text, JSON over several lines; null if they are none. */
function textOf(bytes: Uint8Array): string | null {
  try {
    const whole = new TextDecoder("utf-8", { fatal: true }).decode(bytes);
    return (prettyJson(whole) ?? whole).slice(0, longestText);
  } catch {
    return null;
  }
}
