import { useEffect, useRef, useState } from "preact/hooks";
import type uPlot from "uplot";
import { unitSign } from "../core/format";
import { timeLabels } from "../core/plot_time";
import { usePlotting } from "../parts/plotting";
import { phone } from "../parts/screen";
import { Empty } from "../parts/state";
import * as plotsText from "../words/plots";
import * as words from "../words/frame";
import { type Bounds, colourOf, dashOf, inkOf, useInk } from "./plot_colours";
import type { Plotted } from "./plot_tracks";

interface Props {
  plotted: Plotted[];
  bounds: Bounds;
  now: number;
  /** Time of the crosshair; 0 = none. */
  at: number;
  onAt(time: number): void;
  onZoom(from: number, to: number): void;
  onBack(): void;
  /** Where the drawing is within the element, in pixels. */
  onBox(left: number, width: number): void;
}

/** Units beyond get a scale of their own, but no axis. */
const mostAxes = 4;

function unitOf({ unit }: Plotted): string {
  return unit || "1";
}

/** Between two values of a real number there are others; a point that does not describe itself has a unit if it is one. */
function isReal({ point, unit }: Plotted): boolean {
  return point?.description ? point.description.json.data_type === "real" : unit !== "";
}

type Library = typeof uPlot;

/** Numbers over time. Three series a point: the value, and the bounds of the band behind it. */
export function PlotCanvas(props: Props) {
  const library = usePlotting();
  if (library === "failed") {
    return (
      <div class="plot-canvas">
        <Empty title={plotsText.notLoaded}>
          <button type="button" onClick={() => location.reload()}>
            {words.lineReload}
          </button>
        </Empty>
      </div>
    );
  }
  return library ? <Canvas {...props} library={library} /> : <div class="plot-canvas" aria-busy="true" />;
}

function Canvas(props: Props & { library: Library }) {
  const { plotted, library } = props;
  const box = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot | null>(null);
  const latest = useRef(props);
  latest.current = props;
  const ink = useInk();
  const [size, setSize] = useState({ width: 0, height: 0 });
  const numbers = plotted.filter(({ track }) => track.kind === "number");
  const name = JSON.stringify([numbers.map((one) => [one.path, unitOf(one)]), plotted.map(({ path }) => path), phone.value, ink]);
  useEffect(() => {
    const element = box.current;
    if (!element) return undefined;
    const observer = new ResizeObserver(() => setSize({ width: element.clientWidth, height: element.clientHeight }));
    observer.observe(element);
    return () => observer.disconnect();
  }, []);
  useEffect(() => {
    const element = box.current;
    if (!element) return undefined;
    const made = new library(
      optionsOf(library, numbers, latest, element.clientWidth, element.clientHeight),
      dataOf(library, numbers, latest.current),
      element,
    );
    plot.current = made;
    return () => {
      made.destroy();
      plot.current = null;
    };
  }, [name]);
  useEffect(() => {
    if (size.width > 0 && size.height > 0) plot.current?.setSize(size);
  }, [size.width, size.height, name]);
  useEffect(() => {
    plot.current?.setData(dataOf(library, numbers, props), false);
    plot.current?.setScale("x", { min: props.bounds.from, max: props.bounds.to });
  });
  useEffect(() => {
    const made = plot.current;
    if (!made) return;
    const left = props.at > 0 ? made.valToPos(props.at, "x") : -10;
    if (Math.abs((made.cursor.left ?? -10) - left) > 0.5) made.setCursor({ left, top: left < 0 ? -10 : 1 }, false);
  }, [props.at, props.bounds.from, props.bounds.to, name]);
  return <div ref={box} class={`plot-canvas${numbers.length === 0 ? " only-axis" : ""}`} />;
}

function dataOf(library: Library, numbers: Plotted[], { bounds, now }: Props): uPlot.AlignedData {
  if (numbers.length === 0) return [[bounds.from, bounds.to]];
  const tables = numbers.map(({ track }) => {
    const { t, value, low, high } = track.curve(bounds.from, bounds.to, now);
    return [t, value, high, low] as uPlot.AlignedData;
  });
  return library.join(tables);
}

function optionsOf(library: Library, numbers: Plotted[], latest: { current: Props }, width: number, height: number): uPlot.Options {
  const units = [...new Set(numbers.map(unitOf))];
  const plottedAt = (one: Plotted) => latest.current.plotted.indexOf(one);
  const series: uPlot.Series[] = [{}];
  const bands: uPlot.Band[] = [];
  for (const one of numbers) {
    const colour = colourOf(plottedAt(one));
    const first = series.length;
    const paths = isReal(one) ? library.paths.linear?.() : library.paths.stepped?.({ align: 1 });
    const edge = { scale: unitOf(one), stroke: "transparent", width: 0, paths, points: { show: false } };
    series.push({ scale: unitOf(one), stroke: colour, width: 1.6, dash: dashOf(plottedAt(one)), paths, points: { show: false } }, edge, {
      ...edge,
    });
    bands.push({ series: [first + 1, first + 2], fill: `${colour}33` });
  }
  return {
    width,
    height,
    series,
    bands,
    legend: { show: false },
    padding: [10, units.length === 1 ? 12 : 0, 0, units.length === 0 ? 12 : 0],
    scales: Object.fromEntries([
      ["x", { time: true, range: () => [latest.current.bounds.from, latest.current.bounds.to] as uPlot.Range.MinMax }],
      ...units.map((unit) => [unit, { range: rangeOf }]),
    ]),
    axes: [
      timeAxis(units.length === 0),
      ...units.slice(0, phone.value ? 2 : mostAxes).map((unit, index) => valueAxis(unit, index, numbers, plottedAt)),
    ],
    cursor: {
      y: false,
      points: { show: false },
      drag: { x: true, y: false, setScale: false, dist: 6 },
      bind: {
        dblclick: () => () => {
          latest.current.onBack();
          return null;
        },
      },
    },
    hooks: {
      setCursor: [(plot) => moved(plot, latest.current)],
      setSelect: [(plot) => selected(plot, latest.current)],
      draw: [(plot) => drawTicks(plot, latest.current)],
      setSize: [(plot) => tellBox(plot, latest.current)],
      ready: [(plot) => tellBox(plot, latest.current)],
    },
  };
}

function rangeOf(_plot: uPlot, low: number | null, high: number | null): uPlot.Range.MinMax {
  if (low === null || high === null) return [0, 1];
  const room = (high - low) * 0.08 || Math.abs(high) * 0.05 || 1;
  return [low - room, high + room];
}

function fontSize(): number {
  return Math.round(Number.parseFloat(getComputedStyle(document.documentElement).fontSize) * 0.92); // uPlot reads whole pixels only
}

function font(): string {
  return `${fontSize()}px system-ui, sans-serif`;
}

function timeAxis(top: boolean): uPlot.Axis {
  const { muted, edge } = inkOf();
  return {
    side: top ? 0 : 2,
    stroke: muted,
    grid: { stroke: edge, width: 1 },
    ticks: { stroke: edge, width: 1, size: 5 },
    size: 42,
    space: 70,
    font: font(),
    values: (_plot, splits, _axis, _space, step) => timeLabels(splits, step),
  };
}

function valueAxis(unit: string, index: number, numbers: Plotted[], placeOf: (one: Plotted) => number): uPlot.Axis {
  const { muted, edge } = inkOf();
  const own = numbers.filter((one) => unitOf(one) === unit);
  const [only] = own;
  const sign = unitSign(unit === "1" ? "" : unit);
  return {
    scale: unit,
    side: index % 2 === 0 ? 3 : 1,
    stroke: own.length === 1 && only && numbers.length > 1 ? colourOf(placeOf(only)) : muted,
    grid: { show: index === 0, stroke: edge, width: 1 },
    ticks: { stroke: edge, width: 1, size: 5 },
    size: (_plot, values) => Math.max(...(values ?? [""]).map((value) => String(value).length), 2) * fontSize() * 0.6 + 16,
    space: (_plot, _axis, _low, _high, pixels) => Math.max(36, pixels / 14),
    font: font(),
    label: phone.value ? undefined : sign || undefined,
    labelSize: phone.value || !sign ? 0 : 16,
    labelGap: 0,
  };
}

function tellBox(plot: uPlot, { onBox }: Props): void {
  const ratio = devicePixelRatio;
  onBox(plot.bbox.left / ratio, plot.bbox.width / ratio);
}

/** Only what the user does counts: the crosshair is also set from outside. */
function moved(plot: uPlot, { onAt }: Props): void {
  const { left = -10, event } = plot.cursor;
  if (event) onAt(left < 0 ? 0 : plot.posToVal(left, "x"));
}

function selected(plot: uPlot, { onZoom }: Props): void {
  const { left, width } = plot.select;
  if (width < 6) return;
  onZoom(plot.posToVal(left, "x"), plot.posToVal(left + width, "x"));
  plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
}

/** Commands: a line through the plot with a head, in the colour of the point. */
function drawTicks(plot: uPlot, { plotted, bounds }: Props): void {
  const { ctx } = plot;
  const { top, height } = plot.bbox;
  const head = 5 * devicePixelRatio;
  plotted.forEach(({ track }, index) => {
    if (track.kind !== "number") return;
    ctx.save();
    ctx.strokeStyle = ctx.fillStyle = colourOf(index);
    ctx.lineWidth = devicePixelRatio;
    ctx.setLineDash([2 * devicePixelRatio, 3 * devicePixelRatio]);
    for (const { t } of track.ticksIn(bounds.from, bounds.to)) {
      const x = Math.round(plot.valToPos(t, "x", true));
      ctx.beginPath();
      ctx.moveTo(x, top + head);
      ctx.lineTo(x, top + height);
      ctx.stroke();
      ctx.beginPath();
      ctx.moveTo(x - head, top);
      ctx.lineTo(x + head, top);
      ctx.lineTo(x, top + head * 1.6);
      ctx.fill();
    }
    ctx.restore();
  });
}
