import { nameOfPoint } from "../app";
import type { Point } from "../core/catalog";
import { number, text as textOf } from "../core/catalog";
import { typeWords } from "../core/format";
import { Age } from "../parts/age";
import { CommandControl, OutcomeMark } from "../parts/command";
import { isAsleep, MeasuredValue, whyAsleep } from "../parts/measure";
import { prose } from "../parts/prose";
import { State } from "../parts/state";
import type { Column } from "../parts/table";
import * as text from "../words/device";
import { type Hour, Sparkline } from "./sparkline";

function Name({ point }: { point: Point }) {
  const about = point.description?.json;
  const quantity = textOf(about?.quantity) || typeWords(point.type);
  return (
    <span class="point-name" title={`${point.path}\n${quantity}`}>
      <span>{nameOfPoint(point)}</span>
      <span class="muted">{quantity}</span>
    </span>
  );
}

function Quality({ point }: { point: Point }) {
  const reason = textOf(point.status?.json.reason);
  if (isAsleep(point)) return <span class="quality muted">{whyAsleep(point)}</span>;
  if (!point.quality) return <span class="muted">…</span>;
  return (
    <span class="quality" title={reason}>
      <State word={point.quality} />
      {reason && <span class="muted">{prose(reason)}</span>}
    </span>
  );
}

export function pointColumns(hour: Hour): Column<Point>[] {
  return [
    { id: "name", title: text.point, width: "minmax(150px,1fr)", phone: "main", cell: (point) => <Name point={point} /> },
    {
      id: "value",
      title: text.value,
      width: "minmax(90px,0.5fr)",
      phone: "side",
      cell: (point) => <MeasuredValue point={point} label={nameOfPoint(point)} />,
    },
    { id: "hour", title: text.hour, width: "124px", wide: true, cell: (point) => <Sparkline point={point} hour={hour} /> },
    { id: "quality", title: text.quality, width: "minmax(140px,0.7fr)", phone: "sub", cell: (point) => <Quality point={point} /> },
    {
      id: "heard",
      title: text.heard,
      width: "56px",
      phone: "end",
      numeric: true,
      cell: (point) => <Age time={number(point.status?.json.heard)} />,
    },
    {
      id: "changed",
      title: text.changed,
      width: "62px",
      wide: true,
      numeric: true,
      cell: (point) => <Age time={number(point.status?.json.changed)} />,
    },
    { id: "control", title: text.control, width: "minmax(230px,0.9fr)", phone: "third", cell: (point) => <CommandControl point={point} /> },
    { id: "outcome", title: text.outcome, width: "minmax(210px,1.3fr)", phone: "fourth", cell: (point) => <OutcomeMark point={point} /> },
  ];
}
