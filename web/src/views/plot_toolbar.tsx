import { useState } from "preact/hooks";
import { fromLocalInput, localInput, spans, type TimeRange, zoomed } from "../core/plot_time";
import * as text from "../words/plots";
import type { Bounds } from "./plot_colours";

interface Props {
  range: TimeRange;
  bounds: Bounds;
  at: number;
  onRange(range: TimeRange): void;
  onBack(): void;
  onPick(): void;
  onSave(): void;
}

export function PlotToolbar({ range, bounds, at, onRange, onBack, onPick, onSave }: Props) {
  const [own, setOwn] = useState(false);
  const centre = at || (bounds.from + bounds.to) / 2;
  const length = bounds.to - bounds.from;
  const resume = spans.reduce((best, span) => (Math.abs(span - length) < Math.abs(best - length) ? span : best), spans[0] ?? 900);
  return (
    <div class="toolbar">
      <h1>{text.title}</h1>
      <span class="segments" role="group" aria-label={text.range}>
        {spans.map((span) => (
          <button key={span} type="button" aria-pressed={range.span === span} onClick={() => onRange({ span, from: 0, to: 0 })}>
            {text.span(span)}
          </button>
        ))}
        <button type="button" aria-pressed={range.span === 0} aria-expanded={own} onClick={() => setOwn(!own)}>
          {text.own}
        </button>
      </span>
      <button
        type="button"
        aria-pressed={range.span === 0}
        onClick={() => onRange(range.span ? { span: 0, ...bounds } : { span: resume, from: 0, to: 0 })}
      >
        {range.span ? text.pause : text.live}
      </button>
      <span class="segments" role="group" aria-label={text.zoom}>
        <button type="button" aria-label={text.zoomIn} title={`${text.zoomIn} (+)`} onClick={() => onRange(zoomed(bounds, centre, 0.5))}>
          +
        </button>
        <button type="button" aria-label={text.zoomOut} title={`${text.zoomOut} (-)`} onClick={() => onRange(zoomed(bounds, centre, 2))}>
          −
        </button>
        <button type="button" title={`${text.back} (0)`} onClick={onBack}>
          {text.back}
        </button>
      </span>
      <button type="button" onClick={onSave}>
        {text.csv}
      </button>
      <button type="button" class="primary" onClick={onPick}>
        {text.points}
      </button>
      {own && <OwnRange bounds={bounds} onRange={onRange} onClose={() => setOwn(false)} />}
    </div>
  );
}

function OwnRange({ bounds, onRange, onClose }: { bounds: Bounds; onRange(range: TimeRange): void; onClose(): void }) {
  const [from, setFrom] = useState(localInput(bounds.from));
  const [to, setTo] = useState(localInput(bounds.to));
  const start = fromLocalInput(from);
  const end = fromLocalInput(to);
  const wrong = !(end > start);
  return (
    <form
      class="own-range"
      onSubmit={(event) => {
        event.preventDefault();
        if (wrong) return;
        onRange({ span: 0, from: start, to: end });
        onClose();
      }}
    >
      <label class="field">
        <span>{text.from}</span>
        <input type="datetime-local" step="1" required value={from} onInput={(event) => setFrom(event.currentTarget.value)} />
      </label>
      <label class="field">
        <span>{text.to}</span>
        <input type="datetime-local" step="1" required value={to} onInput={(event) => setTo(event.currentTarget.value)} />
      </label>
      <button type="submit" class="primary" disabled={wrong}>
        {text.show}
      </button>
      {wrong && (
        <span class="error" role="alert">
          {text.wrongRange}
        </span>
      )}
    </form>
  );
}
