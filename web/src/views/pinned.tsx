import type { ComponentChildren } from "preact";
import { catalog, nameOfPoint } from "../app";
import type { Point } from "../core/catalog";
import { arrangedIn, pinOf, toggled } from "../core/overview";
import { useFrame } from "../core/redraw";
import { hrefTo } from "../core/router";
import { Icon } from "../parts/icons";
import { MeasuredValue } from "../parts/measure";
import * as text from "../words/overview";
import { arrange, mayArrange, pinnedPoints } from "./arrangement";
import { type Hour, Sparkline, useHourOf } from "./sparkline";

/** The points that are pinned and there. */
function pinned(): Point[] {
  const points = pinnedPoints().map((path) => {
    const [owner = "", key = ""] = path.split(":");
    const [, network = "", device = "", kind = "", id = ""] = key.split(".");
    return catalog.device(Number(owner), network, device)?.points.get(`${kind}.${id}`);
  });
  return points.filter((point) => point !== undefined);
}

/** The curves of the last hour that people want to see first. */
export function Pinned({ arranging }: { arranging: boolean }) {
  useFrame();
  const points = pinned();
  const hour = useHourOf("pinned", points);
  if (points.length === 0) return null;
  return (
    <ul class="pinned-plots" aria-label={text.pinned}>
      {points.map((point) => (
        <Curve key={point.path} point={point} hour={hour}>
          {arranging && <PinButton point={point} />}
        </Curve>
      ))}
    </ul>
  );
}

/** All that a room measures, each with its last hour and whether it is on the overview. */
export function Curves({ points }: { points: Point[] }) {
  const hour = useHourOf("curves", points);
  if (points.length === 0) return null;
  return (
    <ul class="pinned-plots">
      {points.map((point) => (
        <Curve key={point.path} point={point} hour={hour}>
          <PinButton point={point} />
        </Curve>
      ))}
    </ul>
  );
}

function Curve({ point, hour, children }: { point: Point; hour: Hour; children: ComponentChildren }) {
  return (
    <li class="card">
      <span class="pinned-name">
        <a href={hrefTo("plots", [], { k: point.path })}>{titleOf(point)}</a>
        <MeasuredValue point={point} label={titleOf(point)} />
        {children}
      </span>
      <Sparkline point={point} hour={hour} />
    </li>
  );
}

function isPinned(point: Point): boolean {
  return arrangedIn(catalog.overviews.get(point.device.owner)).pins.includes(pinOf(point));
}

/** Puts the curve of a point on the overview, or takes it off. */
export function PinButton({ point }: { point: Point }) {
  if (!mayArrange()) return null;
  const on = isPinned(point);
  const label = text.pin(titleOf(point));
  return (
    <button type="button" class="plain pin" aria-pressed={on} aria-label={label} title={label} onClick={() => togglePin(point)}>
      <Icon name="pin" size={16} />
    </button>
  );
}

/** Its given name, else that of the device and what it is. */
function titleOf(point: Point): string {
  const given = nameOfPoint(point);
  return given !== point.id ? given : `${point.device.name} · ${text.factName(point.type)}`;
}

function togglePin(point: Point): void {
  const { owner } = point.device;
  arrange(owner, { pins: toggled(arrangedIn(catalog.overviews.get(owner)).pins, pinOf(point)) });
}
