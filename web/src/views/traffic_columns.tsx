import { formatFullTime, formatTime, zoneName } from "../core/format";
import type { Passing, TrafficKind } from "../core/traffic";
import { phone } from "../parts/screen";
import type { Column } from "../parts/table";
import * as text from "../words/traffic";

/** 12:04:31.047 */
function Time({ time }: { time: number }) {
  const fraction = String(Math.floor((time % 1) * 1000)).padStart(3, "0");
  return <time title={formatFullTime(time)}>{`${formatTime(time)}.${fraction}`}</time>;
}

function Direction({ out }: { out: boolean }) {
  return (
    <span>
      <span aria-hidden="true" class="muted">
        {out ? "→ " : "← "}
      </span>
      {out ? text.outwards : text.inwards}
    </span>
  );
}

export function trafficColumns(kind: TrafficKind): Column<Passing>[] {
  const time: Column<Passing> = {
    id: "time",
    title: `${text.time}, ${zoneName()}`,
    width: "150px",
    phone: "side",
    cell: (one) => <Time time={one.time} />,
  };
  const direction: Column<Passing> = { id: "direction", title: text.direction, width: "72px", cell: (one) => <Direction out={one.out} /> };
  const hex: Column<Passing> = {
    id: "hex",
    title: text.hex,
    width: "minmax(110px,0.8fr)",
    cell: (one) => <code title={one.hex}>{one.hex}</code>,
  };
  if (kind === "zigbee") {
    return [
      time,
      direction,
      { id: "kind", title: text.kind, width: "92px", cell: (one) => one.kind },
      {
        id: "name",
        title: text.name,
        width: "minmax(120px,0.9fr)",
        phone: "main",
        cell: (one) => <span title={one.name}>{phone.value ? `${one.out ? "→" : "←"} ${one.kind} ${one.name}` : one.name}</span>,
      },
      {
        id: "text",
        title: text.content,
        width: "minmax(220px,2fr)",
        phone: "sub",
        cell: (one) => <code title={one.value}>{one.value}</code>,
      },
    ];
  }
  if (kind === "wsn") {
    return [
      time,
      direction,
      {
        id: "kind",
        title: text.kind,
        width: "104px",
        phone: "main",
        cell: (one) => (phone.value ? [one.out ? "→" : "←", one.kind, one.from || one.to].join(" ") : one.kind),
      },
      { id: "mote", title: text.mote, width: "58px", numeric: true, cell: (one) => one.from || one.to },
      {
        id: "text",
        title: text.decoded,
        width: "minmax(220px,1.6fr)",
        phone: "sub",
        cell: (one) => <span title={one.value}>{one.value || one.hex}</span>,
      },
      hex,
    ];
  }
  return [
    time,
    direction,
    { id: "kind", title: text.service, width: "78px", cell: (one) => one.kind },
    { id: "from", title: text.source, width: "82px", cell: (one) => one.from },
    {
      id: "to",
      title: text.group,
      width: "82px",
      phone: "main",
      cell: (one) => <strong class="name">{phone.value ? `${one.kind} ${one.to}` : one.to}</strong>,
    },
    {
      id: "name",
      title: text.name,
      width: "minmax(120px,1.2fr)",
      phone: "sub",
      cell: (one) => <span title={one.name}>{one.name || <span class="muted">{text.unknownGroup}</span>}</span>,
    },
    {
      id: "value",
      title: text.decoded,
      width: "minmax(90px,0.9fr)",
      phone: "end",
      cell: (one) => one.value || <span class="muted">–</span>,
    },
    hex,
  ];
}
