import { useMemo, useState } from "preact/hooks";
import { unitSign } from "../core/format";
import { chosen, type DataPointType, type ImportChoices, type ImportPoint, isUncertain } from "../core/knx_import";
import { matches } from "../core/text";
import { coarse, moreLines, phone } from "../parts/screen";
import { type Column, Table } from "../parts/table";
import { Empty } from "../parts/state";
import * as text from "../words/setup";

interface Props {
  /** Of the file; `points` are as they are after the choices. */
  base: Map<string, ImportPoint>;
  points: ImportPoint[];
  types: DataPointType[];
  choices: ImportChoices;
  search: string;
  onlyUncertain: boolean;
  onChoose(choices: ImportChoices): void;
}

function reasonOf(point: ImportPoint): string {
  const { dpt, notes = [] } = point;
  if (notes.length > 0) return notes.join("; ");
  if (dpt === "") return text.noType;
  return dpt.endsWith(".*") ? text.mainOnly : "";
}

/** What is typed stays until it is chosen: the table is drawn again meanwhile. */
function DptField({ address, value, onType }: { address: string; value: string; onType(dpt: string): void }) {
  const [draft, setDraft] = useState<string | null>(null);
  return (
    <input
      type="text"
      class="dpt"
      list="knx-types"
      aria-label={text.dptOf(address)}
      placeholder={text.noDpt}
      value={draft ?? value}
      onInput={(event) => setDraft(event.currentTarget.value)}
      onChange={(event) => {
        setDraft(null);
        onType(event.currentTarget.value.trim());
      }}
    />
  );
}

/** What each address becomes; types and kinds to be chosen. */
export function KnxPoints({ base, points, types, choices, search, onlyUncertain, onChoose }: Props) {
  const own = (address: string) => base.get(address) as ImportPoint;
  const choose = (address: string, change: Parameters<typeof chosen>[2]) => onChoose(chosen(choices, own(address), change));
  const columns: Column<ImportPoint>[] = [
    {
      id: "take",
      title: text.take,
      width: "48px",
      phone: "end",
      cell: ({ address }) => (
        <input
          type="checkbox"
          aria-label={text.takeOf(address)}
          checked={!choices[address]?.leave}
          onChange={(event) => choose(address, event.currentTarget.checked ? { leave: undefined } : { leave: true })}
        />
      ),
    },
    { id: "address", title: text.address, width: "72px", cell: ({ address }) => address },
    {
      id: "name",
      title: text.name,
      width: "minmax(130px,1.2fr)",
      phone: "main",
      cell: ({ address, name, state }) => (
        <span class="uncut">
          {phone.value ? `${address} ${name}` : name}
          {state && <span class="muted"> {text.state(state)}</span>}
        </span>
      ),
    },
    {
      id: "dpt",
      title: text.dpt,
      width: "92px",
      phone: "side",
      cell: ({ address, dpt }) => (
        <DptField address={address} value={choices[address]?.dpt ?? dpt} onType={(typed) => choose(address, { dpt: typed })} />
      ),
    },
    {
      id: "kind",
      title: text.kind,
      width: "92px",
      phone: "third",
      cell: ({ address, kind, state }) =>
        state ? (
          text.kinds[kind]
        ) : (
          <select
            aria-label={text.kindOf(address)}
            value={kind}
            onChange={(event) => choose(address, { kind: event.currentTarget.value as ImportPoint["kind"] })}
          >
            <option value="sensor">{text.kinds.sensor}</option>
            <option value="actuator">{text.kinds.actuator}</option>
          </select>
        ),
    },
    {
      id: "point",
      title: text.becomes,
      width: "minmax(170px,1.4fr)",
      phone: "sub",
      cell: ({ address, point, unit }) =>
        choices[address]?.leave ? (
          <span class="muted">{text.leftOut}</span>
        ) : (
          <span class="uncut">
            {point} <span class="unit">{unitSign(unit)}</span>
          </span>
        ),
    },
    {
      id: "why",
      title: text.why,
      width: "minmax(160px,1.6fr)",
      wide: true,
      cell: (point) => <span class="muted uncut">{reasonOf(point)}</span>,
    },
  ];
  const rows = useMemo(
    () =>
      points
        .filter((point) => !onlyUncertain || isUncertain(own(point.address)))
        .filter(({ address, name, point, room }) => search === "" || matches(search, `${address} ${name} ${point} ${room}`))
        .map((row) => ({ row })),
    [points, search, onlyUncertain],
  );
  const heightOf = ({ name, point, state, ...rest }: ImportPoint) =>
    phone.value
      ? 148
      : (coarse.value ? 48 : 34) +
        Math.max(
          moreLines(name.length + state.length + 8, 130),
          moreLines(point.length + 5, 170),
          moreLines(reasonOf({ name, point, state, ...rest }).length, 200),
        );
  return (
    <>
      <datalist id="knx-types">
        {types.map(({ dpt, meaning, unit }) => (
          <option key={dpt} value={dpt}>
            {`${meaning} ${unitSign(unit)}`}
          </option>
        ))}
      </datalist>
      {rows.length === 0 ? (
        <Empty title={text.filtered} />
      ) : (
        <Table
          label={text.importTitle}
          columns={columns}
          rows={rows}
          rowsVersion={rows}
          heightOf={heightOf}
          nameOf={({ address }) => address}
        />
      )}
    </>
  );
}
