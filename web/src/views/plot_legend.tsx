import { formatTime, formatNumber, unitSign } from "../core/format";
import { hrefTo } from "../core/router";
import type { Sample } from "../core/track";
import * as text from "../words/plots";
import { type Bounds, colourOf, dashOf } from "./plot_colours";
import type { Plotted } from "./plot_tracks";

export function nameOf({ point, path }: Plotted): string {
  return point ? `${point.device.name} · ${point.id}` : (path.split(":")[1] ?? path);
}

/** A mean has no more digits than can be seen. */
function numberText(value: number, count = 1): string {
  return formatNumber(String(Number(value.toPrecision(count > 1 ? 4 : 6))));
}

/** What a point was at that time, with its unit; with the band where several values are drawn as one. */
export function readingOf({ unit, track }: Plotted, sample: Sample | undefined): string {
  if (!sample || sample.gap) return text.gap;
  if (track.kind === "state") return sample.text;
  const sign = unitSign(unit);
  const value = Number.isNaN(sample.value) ? sample.text : numberText(sample.value, sample.count);
  return sign ? `${value} ${sign}` : value;
}

function bandOf({ track }: Plotted, sample: Sample | undefined): string {
  if (!sample || sample.gap || track.kind === "state" || sample.low === sample.high) return "";
  return text.band(numberText(sample.low, 2), numberText(sample.high, 2));
}

interface Props {
  plotted: Plotted[];
  unknown: Plotted[];
  /** Time of the crosshair, or the end of what is shown. */
  at: number;
  bounds: Bounds;
  crossed: boolean;
  onRemove(path: string): void;
}

/** The points, with what they were at the crosshair. */
export function PlotLegend({ plotted, unknown, at, bounds, crossed, onRemove }: Props) {
  const near = (bounds.to - bounds.from) / 100;
  return (
    <div class="plot-legend">
      <table>
        <thead>
          <tr>
            <th scope="col">{text.point}</th>
            <th scope="col" class="reading">
              {crossed ? formatTime(at) : text.latest}
            </th>
            <th scope="col">{text.between}</th>
            <th scope="col">{text.commands}</th>
            <th scope="col">
              <span class="spoken">{text.remove}</span>
            </th>
          </tr>
        </thead>
        <tbody>
          {plotted.map((one, place) => {
            const sample = one.track.at(at);
            const ticks = one.track.ticksIn(bounds.from, bounds.to);
            const tick = crossed ? ticks.find(({ t }) => Math.abs(t - at) < near) : undefined;
            return (
              <tr key={one.path}>
                <th scope="row">
                  <Swatch one={one} place={place} />
                  {one.point ? <a href={hrefTo("devices", one.point.device.path.split("/"))}>{nameOf(one)}</a> : nameOf(one)}
                  {one.point && <span class="muted">{one.point.device.network}</span>}
                </th>
                <td class="reading">{unknown.includes(one) ? text.noPoint : readingOf(one, sample)}</td>
                <td class="muted">{bandOf(one, sample)}</td>
                <td class="muted">
                  {tick ? text.commanded(tick.text, formatTime(tick.t)) : ticks.length > 0 ? text.count(ticks.length) : ""}
                </td>
                <td>
                  <button
                    type="button"
                    class="small plain"
                    aria-label={`${text.remove} ${nameOf(one)}`}
                    title={text.remove}
                    onClick={() => onRemove(one.path)}
                  >
                    ×
                  </button>
                </td>
              </tr>
            );
          })}
        </tbody>
      </table>
    </div>
  );
}

function Swatch({ one, place }: { one: Plotted; place: number }) {
  const dash = dashOf(place)?.join(" ");
  return (
    <span class="swatch">
      <span class="place">{place + 1}</span>
      <svg width="22" height="10" aria-hidden="true">
        {one.track.kind === "state" ? (
          <rect x="0" y="1" width="22" height="8" fill={colourOf(place)} />
        ) : (
          <path d="M0 5H22" stroke={colourOf(place)} stroke-width="2.5" stroke-dasharray={dash} />
        )}
      </svg>
    </span>
  );
}
