import { useEffect, useRef } from "preact/hooks";
import { type Bounds, colourOf, inkOf, isDark, useInk } from "./plot_colours";
import type { Plotted } from "./plot_tracks";

const laneHeight = 26;

interface Props {
  plotted: Plotted[];
  bounds: Bounds;
  now: number;
  left: number;
  width: number;
  at: number;
  onAt(time: number): void;
}

/** States over time: a band for each, with its words. */
export function PlotLanes({ plotted, bounds, now, left, width, at, onAt }: Props) {
  const canvas = useRef<HTMLCanvasElement>(null);
  useInk();
  const lanes = plotted.filter(({ track }) => track.kind === "state");
  const height = lanes.length * laneHeight;
  const scale = (time: number) => ((time - bounds.from) / (bounds.to - bounds.from)) * width;
  useEffect(() => {
    const element = canvas.current;
    const context = element?.getContext("2d");
    if (!element || !context || width <= 0) return;
    element.width = width * devicePixelRatio;
    element.height = height * devicePixelRatio;
    context.scale(devicePixelRatio, devicePixelRatio);
    context.font = "11px system-ui, sans-serif";
    lanes.forEach((lane, index) => drawLane(context, lane, plotted.indexOf(lane), index * laneHeight, bounds, now, scale));
  });
  if (lanes.length === 0) return null;
  const moved = (event: PointerEvent & { currentTarget: HTMLElement }) => {
    const x = event.clientX - event.currentTarget.getBoundingClientRect().left;
    onAt(bounds.from + (x / Math.max(width, 1)) * (bounds.to - bounds.from));
  };
  return (
    <div
      class="plot-lanes"
      style={`margin-left:${left}px;width:${width}px;height:${height}px`}
      onPointerMove={moved}
      onPointerLeave={() => onAt(0)}
    >
      <canvas ref={canvas} style={`width:${width}px;height:${height}px`} />
      {at >= bounds.from && at <= bounds.to && at > 0 && <div class="lane-cursor" style={`transform:translateX(${scale(at)}px)`} />}
    </div>
  );
}

/** The first word of a type (off, closed, none) is pale, the others stand out. */
function shadeOf(lane: Plotted, word: string): number {
  const place = lane.words.indexOf(word);
  if (place < 0 && word.includes(" … ")) return 0.38;
  if (place < 0) return word === "off" || word === "0" || word === "" ? 0.14 : 0.6;
  return lane.words.length === 1 ? 0.6 : 0.14 + (place / (lane.words.length - 1)) * 0.66;
}

function drawLane(
  context: CanvasRenderingContext2D,
  lane: Plotted,
  place: number,
  top: number,
  bounds: Bounds,
  now: number,
  scale: (time: number) => number,
): void {
  const colour = colourOf(place);
  const { text } = inkOf();
  const height = laneHeight - 6;
  for (const { from, to, word } of lane.track.spans(bounds.from, bounds.to, now)) {
    const x = scale(from);
    const width = Math.max(scale(to) - x, 1);
    if (word === "") {
      hatch(context, x, top, width, height);
      continue;
    }
    const shade = shadeOf(lane, word);
    context.globalAlpha = shade;
    context.fillStyle = colour;
    context.fillRect(x, top, width, height);
    context.globalAlpha = 1;
    if (width < context.measureText(word).width + 10) continue;
    context.fillStyle = shade > 0.5 ? (isDark() ? "#0b1a2b" : "#ffffff") : text;
    context.fillText(word, x + 5, top + height / 2 + 4);
  }
  context.fillStyle = text;
  for (const { t } of lane.track.ticksIn(bounds.from, bounds.to)) {
    const x = scale(t);
    context.beginPath();
    context.moveTo(x - 4, top - 1);
    context.lineTo(x + 4, top - 1);
    context.lineTo(x, top + 6);
    context.fill();
  }
}

/** Nothing was known. */
function hatch(context: CanvasRenderingContext2D, x: number, top: number, width: number, height: number): void {
  context.save();
  context.beginPath();
  context.rect(x, top, width, height);
  context.clip();
  context.strokeStyle = inkOf().surface;
  for (let at = x - height; at < x + width; at += 6) {
    context.beginPath();
    context.moveTo(at, top + height);
    context.lineTo(at + height, top);
    context.stroke();
  }
  context.restore();
}
