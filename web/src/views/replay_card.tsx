import { useState } from "preact/hooks";
import { mayBe, store } from "../app";
import { outcomeOf, toneOf, type Tone } from "../core/commands";
import { formatFullTime, formatTime } from "../core/format";
import { commandOf, formatOffset, readSeek, type Replay } from "../core/replay";
import { hrefTo } from "../core/router";
import { Choice } from "../parts/fields";
import { Age } from "../parts/age";
import { prose } from "../parts/prose";
import { State } from "../parts/state";
import * as text from "../words/recordings";
import * as commandText from "../words/command";
import { steer } from "./steer";

const tones: Record<string, Tone> = { playing: "good", paused: "waiting", ended: "neutral" };
const speeds = ["0.1", "0.5", "1", "2", "5", "10", "100", "1000", "max"];

function placeText({ absolute }: Replay, position: number): string {
  if (Number.isNaN(position)) return "…";
  return absolute ? formatTime(position) : formatOffset(position);
}

/** A network that plays a recording: where it is, and what steers it. */
export function ReplayCard({ replay }: { replay: Replay }) {
  const { network, state, position, end } = replay;
  return (
    <section class="card" aria-label={text.replay(network.id)}>
      <header>
        <h3>
          <a href={hrefTo("networks", [network.path])}>{network.id}</a>
        </h3>
        <State word={state} tone={tones[state] ?? "neutral"} />
        <span class="muted">{text.times(replay.speed)}</span>
      </header>
      <p class="replay-place">
        <strong title={replay.absolute ? formatFullTime(position) : ""}>{placeText(replay, position)}</strong>
        {!Number.isNaN(end) && <span class="muted">{text.until(placeText(replay, end))}</span>}
      </p>
      {mayBe("command") ? <Controls replay={replay} /> : <Bar replay={replay} />}
      <Outcomes replay={replay} />
    </section>
  );
}

function Bar({ replay: { begin, end, position } }: { replay: Replay }) {
  if (Number.isNaN(end) || Number.isNaN(begin)) return null;
  return <progress max={Math.max(end - begin, 1)} value={position - begin} aria-label={text.position} />;
}

function Controls({ replay }: { replay: Replay }) {
  const { network, state, speed } = replay;
  const playing = state === "playing";
  const jump = (by: string) => steer(commandOf(network, "position"), by);
  return (
    <>
      <SeekBar replay={replay} />
      <div class="actions control">
        <button
          type="button"
          class={playing ? "" : "primary"}
          onClick={() => steer(commandOf(network, "state"), playing ? "paused" : "playing")}
        >
          {playing ? text.pause : state === "ended" ? text.again : text.play}
        </button>
        <span class="segments" role="group" aria-label={text.jump}>
          {["-10min", "-30s", "+30s", "+10min"].map((by) => (
            <button key={by} type="button" onClick={() => jump(by.replace("10min", "600s"))}>
              {by.replace("-", "−").replace("min", " min").replace(/s$/, " s")}
            </button>
          ))}
        </span>
        <Choice
          label={text.speed}
          value={speed}
          values={speeds}
          name={text.times}
          onChange={(next) => steer(commandOf(network, "speed"), next)}
        />
      </div>
      <SeekForm replay={replay} />
    </>
  );
}

/** The place in the recording; what is dragged is set when it is let go. */
function SeekBar({ replay }: { replay: Replay }) {
  const { network, begin, end, position } = replay;
  const [draft, setDraft] = useState<number | null>(null);
  if (Number.isNaN(end) || Number.isNaN(begin)) return null;
  const at = draft ?? position;
  return (
    <label class="seek">
      <span class="spoken">{text.position}</span>
      <input
        type="range"
        min={begin}
        max={end}
        step={Math.max((end - begin) / 1000, 0.001)}
        value={at}
        aria-valuetext={placeText(replay, at)}
        onInput={(event) => setDraft(Number(event.currentTarget.value))}
        onChange={(event) => {
          steer(commandOf(network, "position"), String(Math.round(Number(event.currentTarget.value) * 1000) / 1000));
          setDraft(null);
        }}
      />
      {draft !== null && <span class="muted">{placeText(replay, draft)}</span>}
    </label>
  );
}

function SeekForm({ replay }: { replay: Replay }) {
  const [place, setPlace] = useState("");
  const known = readSeek(place);
  return (
    <form
      class="actions control"
      onSubmit={(event) => {
        event.preventDefault();
        if (!known) return;
        steer(commandOf(replay.network, "position"), known);
        setPlace("");
      }}
    >
      <input
        type="text"
        aria-label={text.seekTo}
        placeholder={text.seekHint}
        title={text.seekHint}
        value={place}
        onInput={(event) => setPlace(event.currentTarget.value)}
      />
      <button type="submit" disabled={!known}>
        {text.seek}
      </button>
    </form>
  );
}

/** The last command of each control that did not simply succeed. */
function Outcomes({ replay: { network } }: { replay: Replay }) {
  const outcomes = (["state", "speed", "position"] as const).flatMap((name) => {
    const outcome = outcomeOf(store.get(commandOf(network, name).replace(/command$/, "status"))?.json ?? {});
    return outcome && toneOf(outcome.state) !== "good" ? [{ name, outcome }] : [];
  });
  return (
    <>
      {outcomes.map(({ name, outcome }) => (
        <p key={name} class="muted">
          {text[name]} {commandText.commanded(outcome.value)}: <State word={outcome.state} tone={toneOf(outcome.state)} />{" "}
          <Age time={outcome.since} />
          {outcome.reason && prose(` · ${outcome.reason}`)}
        </p>
      ))}
    </>
  );
}
