import { useEffect, useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";
import { chosenIsland, islands, loadingOf, noIslands, ownerPattern, store, useFeeds } from "../app";
import type { Tone } from "../core/commands";
import { formatFullTime, formatTime, zoneName } from "../core/format";
import { addShortcuts } from "../core/keyboard";
import { atLeast, kept, levels, LogBook, type LogLine, lineText } from "../core/log_book";
import { useFrame } from "../core/redraw";
import { type Route, setQuery } from "../core/router";
import type { Tuple } from "../core/store";
import { matches } from "../core/text";
import { FilterField, Choice } from "../parts/fields";
import { CopyButton } from "../parts/copy";
import { useFollowing } from "../parts/following";
import { NoIsland } from "../parts/no_island";
import { phone } from "../parts/screen";
import { Empty, Loaded, State, NoneMatch } from "../parts/state";
import { type Column, Table } from "../parts/table";
import { useWhole } from "../parts/whole";
import * as text from "../words/log";
import * as words from "../words/frame";
import type { View } from "./views";

/** Lines stay while the user is in another view. */
const book = new LogBook();

const tones: Record<string, Tone> = { error: "bad", warning: "waiting" };

function columnsOf(several: boolean): Column<LogLine>[] {
  return [
    {
      id: "time",
      title: `${text.time}, ${zoneName()}`,
      width: phone.value ? "0" : "150px",
      phone: "side",
      cell: ({ time }) => <time title={formatFullTime(time)}>{formatTime(time)}</time>,
    },
    {
      id: "level",
      title: text.level,
      width: "92px",
      phone: "main",
      cell: ({ level, subject }) => (
        <>
          <State word={level} tone={tones[level] ?? "neutral"} />
          {phone.value && <span class="muted"> {subject}</span>}
        </>
      ),
    },
    ...(several ? [{ id: "island", title: text.island, width: "64px", cell: ({ owner }: LogLine) => owner }] : []),
    { id: "subject", title: text.subject, width: "minmax(90px,0.22fr)", cell: ({ subject }) => subject },
    {
      id: "text",
      title: text.text,
      width: "minmax(240px,1fr)",
      phone: "sub",
      cell: (line) => (
        <span class="log-text">
          {line.missed > 0 && <span class="missed">{text.missed(line.missed)}</span>}
          {line.text}
        </span>
      ),
    },
  ];
}

/** One island's lines, taken into the book as they come. */
function Source({ tuple, reading, taken }: { tuple: Tuple; reading: boolean; taken(): void }) {
  const { text: list, error } = useWhole(tuple);
  useEffect(() => {
    if (list === null || list === "") return;
    try {
      book.take(tuple.owner, JSON.parse(list), reading);
    } catch {
      return; // no JSON: another version of the island
    }
    taken();
  }, [list]);
  return error ? <div class="strip bad">{text.notRead(tuple.owner, error)}</div> : null;
}

function Log({ route }: { route: Route }) {
  useFrame();
  // An active subscription has the present lines at once; it wakes no sensor.
  const feeds = useFeeds([{ pattern: `${ownerPattern()}:*.log.lines`, min: 250, active: true }]);
  const [, setVersion] = useState(0);
  const [paused, setPaused] = useState<{ lines: LogLine[]; taken: number } | null>(null);
  const [following, setFollowing] = useState(true);
  const [chosen, setChosen] = useState<LogLine | null>(null);
  const { q = "", level = "" } = route.query;
  const island = chosenIsland();
  const all = paused?.lines ?? book.lines;
  const shown = useMemo(
    () =>
      all.filter(
        (line) =>
          (!island || line.owner === island) &&
          (level === "" || atLeast(line.level, level)) &&
          (q === "" || matches(q, `${line.subject} ${line.text} ${line.level}`)),
      ),
    [all, q, level, island],
  );
  const rows = useMemo(() => shown.map((row) => ({ row })), [shown]);
  const sources = feeds.flatMap((feed) => [...feed.held.tuples]).filter((tuple) => store.get(tuple.id) === tuple);
  const columns = useMemo(() => columnsOf(islands.value.length > 1 && !island), [islands.value.length > 1 && !island, phone.value]);
  const box = useFollowing(shown.length > 0, shown, following && !paused, setFollowing);
  const togglePause = () => setPaused(paused ? null : { lines: book.lines, taken: book.taken });
  const latest = useRef(togglePause);
  latest.current = togglePause;
  useLayoutEffect(() => addShortcuts([{ keys: "f", what: text.pauseKey, run: () => latest.current() }]), []);
  if (noIslands() && book.lines.length === 0) return <NoIsland />;
  return (
    <section class="view log">
      {sources.map((tuple) => (
        <Source key={tuple.id} tuple={tuple} reading={!following || paused !== null} taken={() => setVersion(book.version)} />
      ))}
      <div class="toolbar">
        <h1>{text.title}</h1>
        <FilterField value={q} />
        <Choice
          label={text.level}
          none={text.anyLevel}
          value={level}
          values={levels.slice(1)}
          name={text.atLeast}
          onChange={(next) => setQuery({ level: next })}
        />
        <button type="button" aria-pressed={paused !== null} onClick={togglePause}>
          {paused ? text.resume(book.taken - paused.taken) : text.pause}
        </button>
        <CopyButton text={() => shown.map(lineText).join("\n")} label={text.copy(shown.length)} />
        {!following && !paused && (
          <button type="button" class="small accent" onClick={() => setFollowing(true)}>
            {text.toEnd}
          </button>
        )}
        <span class="count">{words.tableShown(shown.length, all.length)}</span>
      </div>
      <Loaded state={book.lines.length > 0 ? "ready" : loadingOf(feeds)} empty={rows.length === 0 && <NoLines all={all.length} />}>
        <div class="log-lines" ref={box}>
          <Table
            label={text.title}
            columns={columns}
            rows={rows}
            rowsVersion={shown}
            nameOf={({ id }) => id}
            marked={(line) => line.id === chosen?.id}
            onOpen={(line) => {
              setFollowing(false);
              setChosen(line.id === chosen?.id ? null : line);
            }}
          />
        </div>
      </Loaded>
      {chosen && <WholeLine line={chosen} onClose={() => setChosen(null)} />}
    </section>
  );
}

function WholeLine({ line, onClose }: { line: LogLine; onClose(): void }) {
  return (
    <aside class="whole-line" tabIndex={0} aria-label={text.whole}>
      <p>
        <span class="muted">{formatFullTime(line.time)}</span> <State word={line.level} tone={tones[line.level] ?? "neutral"} />{" "}
        <strong>{line.subject}</strong>
      </p>
      <p class="whole-text">{line.text}</p>
      <div class="actions">
        <CopyButton text={lineText(line)} />
        <button type="button" class="small" onClick={onClose}>
          {words.close}
        </button>
      </div>
    </aside>
  );
}

function NoLines({ all }: { all: number }) {
  if (all === 0) {
    return (
      <Empty title={text.none}>
        <p>{text.noneText(kept)}</p>
      </Empty>
    );
  }
  return <NoneMatch title={text.filtered} clear={{ q: "", level: "" }} />;
}

export const logView: View = { id: "log", title: text.title, key: "l", icon: "log", show: (route) => <Log route={route} /> };
