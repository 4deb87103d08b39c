import { useEffect, useMemo, useState } from "preact/hooks";
import { chosenIsland, hasRoom, line, loadingOf, ownerPattern, store, useFeeds } from "../app";
import { formatRate } from "../core/format";
import { Rates } from "../core/rates";
import { second } from "../core/redraw";
import { hrefTo } from "../core/router";
import * as text from "../words/traffic";
import * as networksText from "../words/networks";

const most = 5;
/** Seconds until rates mean something. */
const settled = 4;

/** Which values are set most often: asked for only while it is open. */
export function Floods() {
  const [open, setOpen] = useState(false);
  return (
    <details class="floods" onToggle={(event) => setOpen(event.currentTarget.open)}>
      <summary>{text.floods}</summary>
      {open && (hasRoom(1) ? <Rated /> : <p class="muted">{text.tooMany}</p>)}
    </details>
  );
}

function Rated() {
  void second.value;
  const state = loadingOf(useFeeds([{ pattern: `${ownerPattern()}:*.*.*.*.*.value`, min: 1000 }]));
  const rates = useMemo(() => new Rates(store, performance.now()), []);
  useEffect(() => () => rates.end(), [rates]);
  const [samples, setSamples] = useState(0);
  useEffect(() => {
    rates.sample(performance.now());
    if (state === "ready" && samples < settled) setSamples(samples + 1);
  }, [second.value]);
  useEffect(() => {
    if (line.value === "lost") rates.interrupt();
  }, [line.value]);
  const island = chosenIsland();
  const top = rates
    .top(island ? 200 : most)
    .filter(({ tuple }) => !island || tuple.owner === island)
    .slice(0, most);
  if (top.length === 0) return <p class="muted">{samples < settled ? text.counting : text.quiet}</p>;
  return (
    <ul class="facts-list">
      {top.map(({ tuple, rate }) => (
        <li key={tuple.id}>
          <a class="key" href={hrefTo("tuples", [tuple.id])} title={tuple.id}>
            {tuple.key}
          </a>
          <span class="muted">{(tuple.value ?? "").slice(0, 40)}</span>
          <span class="rate">{networksText.perSecond(formatRate(rate))}</span>
        </li>
      ))}
      <li class="muted">
        <a href={hrefTo("tuples", [], { order: "rate" })}>{text.allByRate}</a>
      </li>
    </ul>
  );
}
