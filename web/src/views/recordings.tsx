import { useMemo, useRef, useState } from "preact/hooks";
import { baseFeeds, catalog, chosenIsland, islands, loadingOf, mayBe, noIslands, ownerPattern, useFeeds } from "../app";
import { number, text as textOf } from "../core/catalog";
import { outcomeOf, toneOf, type Tone } from "../core/commands";
import { CounterRates } from "../core/counters";
import { formatBytes, formatCount, formatRate } from "../core/format";
import { useFrame, second } from "../core/redraw";
import { replayOf, type Replay } from "../core/replay";
import type { Tuple } from "../core/store";
import { compareNatural } from "../core/text";
import { Age } from "../parts/age";
import { MayNot } from "../parts/may_not";
import { NoIsland } from "../parts/no_island";
import { prose } from "../parts/prose";
import { Empty, Loaded, State } from "../parts/state";
import * as text from "../words/recordings";
import * as commandText from "../words/command";
import * as networksText from "../words/networks";
import { ReplayCard } from "./replay_card";
import { steer } from "./steer";
import type { View } from "./views";

function Recordings() {
  useFrame();
  const owner = ownerPattern();
  const feeds = useFeeds([
    { pattern: `${owner}:*.recorder.*.status`, min: 500 },
    { pattern: `${owner}:*.*.property.*.value`, min: 1000 },
    { pattern: `${owner}:*.*.property.*.status`, min: 250 },
  ]);
  const island = chosenIsland();
  const recorders = [...(feeds[0]?.held.tuples ?? [])].sort((a, b) => a.owner - b.owner || compareNatural(a.key, b.key));
  const replays = [...catalog.networks.values()]
    .filter((network) => !island || network.owner === island)
    .map(replayOf)
    .filter((replay): replay is Replay => replay !== null)
    .sort((a, b) => compareNatural(a.network.id, b.network.id));
  if (noIslands()) return <NoIsland />;
  return (
    <section class="overview recordings">
      <h1>{text.title}</h1>
      <MayNot needs="admin" />
      <Loaded state={loadingOf([...baseFeeds, ...feeds])} empty={recorders.length + replays.length === 0 && <Nothing />}>
        {recorders.length > 0 && <h2>{text.recorders}</h2>}
        <div class="cards">
          {recorders.map((tuple) => (
            <Recorder key={tuple.id} tuple={tuple} />
          ))}
        </div>
        {replays.length > 0 && <h2>{text.replays}</h2>}
        <div class="cards">
          {replays.map((replay) => (
            <ReplayCard key={replay.network.path} replay={replay} />
          ))}
        </div>
      </Loaded>
    </section>
  );
}

function Nothing() {
  return (
    <Empty title={text.none}>
      <p>{text.noneText}</p>
      <pre class="content">{text.example}</pre>
    </Empty>
  );
}

const tones: Record<string, Tone> = { recording: "good", dropping: "bad", stopped: "neutral" };

function Recorder({ tuple }: { tuple: Tuple }) {
  const status = tuple.json;
  const name = tuple.key.split(".")[2] ?? "";
  const state = textOf(status.state);
  const outcome = outcomeOf(status);
  const reason = textOf(status.reason);
  return (
    <section class="card" aria-label={text.recorder(name)}>
      <header>
        <h3>{name}</h3>
        <State word={state} tone={tones[state] ?? "neutral"} />
        <span class="muted">
          <Age time={number(status.since)} />
        </span>
        {islands.value.length > 1 && <span class="muted">{tuple.owner}</span>}
      </header>
      {reason && <p class={state === "dropping" ? "loss" : "muted"}>{prose(reason)}</p>}
      <dl class="tuple-facts">
        <dt>{text.file}</dt>
        <dd>{textOf(status.file) || "–"}</dd>
        <dt>{text.size}</dt>
        <dd>{formatBytes(number(status.size))}</dd>
        <dt>{text.records}</dt>
        <dd>
          {formatCount(number(status.records))} <RecordRate records={number(status.records)} running={state === "recording"} />
        </dd>
        <dt>{text.dropped}</dt>
        <dd class={number(status.dropped) > 0 ? "loss" : ""}>{formatCount(number(status.dropped))}</dd>
        <dt>{text.failures}</dt>
        <dd class={number(status.failures) > 0 ? "loss" : ""}>{formatCount(number(status.failures))}</dd>
      </dl>
      {outcome && (
        <p class="muted">
          {text.last(outcome.value)} <State word={outcome.state} tone={toneOf(outcome.state)} /> <Age time={outcome.since} />
          {[outcome.reason, outcome.commander && commandText.by(outcome.commander)].filter(Boolean).map((part) => prose(` · ${part}`))}
        </p>
      )}
      {mayBe("admin") && <RecorderControls name={name} command={tuple.id.replace(/status$/, "command")} running={state !== "stopped"} />}
    </section>
  );
}

function RecordRate({ records, running }: { records: number; running: boolean }) {
  void second.value;
  const rates = useMemo(() => new CounterRates(), []);
  const own = useRef({ id: "records", value: "" });
  own.current.value = String(records);
  const counter = own.current as Parameters<CounterRates["of"]>[0];
  if (counter) rates.sample([counter], Date.now() / 1000);
  const rate = rates.of(counter);
  return running && !Number.isNaN(rate) ? <span class="muted">{networksText.perSecond(formatRate(rate))}</span> : null;
}

function RecorderControls({ name, command, running }: { name: string; command: string; running: boolean }) {
  const [mark, setMark] = useState("");
  const send = (event: Event) => {
    event.preventDefault();
    steer(command, mark.trim() ? `mark ${mark.trim()}` : "mark");
    setMark("");
  };
  return (
    <form class="actions control" onSubmit={send}>
      <button
        type="button"
        class={running ? "" : "primary"}
        aria-label={`${running ? text.stop : text.start} ${name}`}
        onClick={() => steer(command, running ? "stop" : "start")}
      >
        {running ? text.stop : text.start}
      </button>
      {running && (
        <>
          <input
            type="text"
            maxLength={200}
            aria-label={text.markOf(name)}
            placeholder={text.markText}
            value={mark}
            onInput={(event) => setMark(event.currentTarget.value)}
          />
          <button type="submit">{text.mark}</button>
        </>
      )}
    </form>
  );
}

export const recordingsView: View = { id: "recordings", title: text.title, key: "r", icon: "recordings", show: () => <Recordings /> };
