import type { ComponentChildren } from "preact";
import { useMemo } from "preact/hooks";
import * as words from "../words/frame";
import { Choice } from "./fields";
import { normalSize, phone, rowHeight, scaled, wide } from "./screen";
import { type ListProps, rowOf, VirtualList } from "./virtual_list";

export interface Column<T> {
  id: string;
  title: string;
  /** The title is for screen readers only. */
  spoken?: boolean;
  /** A track of a CSS grid: `90px` or `minmax(90px,1fr)`. Each row is a grid of its own, so that nothing may depend on contents. */
  width: string;
  cell(row: T): ComponentChildren;
  compare?(a: T, b: T): number;
  /** Its content changes by itself: an order by it is frozen until asked again. */
  live?: boolean;
  numeric?: boolean;
  /** Where it goes in a row of two lines; without, it is left out there. */
  phone?: "main" | "side" | "sub" | "end" | "third" | "fourth";
  /** Left out on screens narrower than a desk's. */
  wide?: boolean;
}

/** `name`, or `-name` for descending. */
export interface Sorting {
  by: string;
  set(by: string): void;
}

export type TableRow<T> = { row: T } | { group: string; count: number };

interface TableProps<T> extends Pick<ListProps, "label" | "place"> {
  columns: Column<T>[];
  rows: TableRow<T>[];
  rowsVersion: unknown;
  /** Keeps its columns on a narrow screen, where it scrolls sideways beside the first one. */
  sideways?: boolean;
  /** Pixels of a row; all alike without. */
  heightOf?(row: T): number;
  nameOf(row: T): string;
  sorting?: Sorting;
  marked?(row: T): boolean;
  onOpen?(row: T): void;
  /** Its rows may be dragged: the row, and null when it is let go. */
  onDrag?(row: T | null): void;
  /** The rows in the document, after scrolling has paused. */
  onWindow?(rows: T[]): void;
  /** More keys of the active row. */
  keys?: Record<string, { what: string; run(row: T): void }>;
}

const groupHeight = 34;

function groupName(group: string): string {
  return `group ${group}`;
}

/** A table of fixed columns; on a narrow screen each row has two lines. */
export function Table<T>(props: TableProps<T>) {
  const { columns, rows, onOpen } = props;
  const twoLines = phone.value && !props.sideways;
  const shown = columns.filter((column) => (twoLines ? column.phone : wide.value || !column.wide));
  const grouped = useMemo(() => props.heightOf || rows.some((entry) => "group" in entry), [rows, props.heightOf]);
  const height = rowHeight(twoLines);
  const heightsVersion = useMemo(() => ({}), [props.rowsVersion, height, props.heightOf]);
  const heightOf = (index: number) => {
    const entry = rows[index];
    if (entry && "group" in entry) return scaled(groupHeight);
    const own = entry && props.heightOf?.(entry.row);
    return own ? scaled(own) : height;
  };
  const nameAt = (index: number) => {
    const entry = rows[index];
    if (!entry) return "";
    return "group" in entry ? groupName(entry.group) : props.nameOf(entry.row);
  };
  const at = (call: ((row: T) => void) | undefined) => (index: number) => {
    const entry = rows[index];
    if (entry && "row" in entry) call?.(entry.row);
  };
  const keys = Object.fromEntries(Object.entries(props.keys ?? {}).map(([key, { what, run }]) => [key, { what, run: at(run) }]));
  const rowsIn = (first: number, end: number) => rows.slice(first, end).flatMap((entry) => ("row" in entry ? [entry.row] : []));
  return (
    <div
      class={`table${twoLines ? " two-lines" : ""}${props.sideways ? " sideways" : ""}`}
      onDragStart={(event) => {
        const entry = rows[rowOf(event.target as Element)];
        if (!entry || !("row" in entry)) return;
        event.dataTransfer?.setData("text/plain", props.nameOf(entry.row)); // without it, Firefox drags nothing
        props.onDrag?.(entry.row);
      }}
      onDragEnd={() => props.onDrag?.(null)}
      style={`--columns:${inRem(shown.map((column) => column.width).join(" "))};--least:${inRem(`${leastWidth(shown)}px`)}`}
    >
      <VirtualList
        role="grid"
        label={props.label}
        count={rows.length}
        columns={shown.length}
        heights={grouped ? heightOf : height}
        heightsVersion={heightsVersion}
        place={props.place}
        nameAt={nameAt}
        onOpen={onOpen && at(onOpen)}
        onWindow={props.onWindow && ((first, end) => props.onWindow?.(rowsIn(first, end)))}
        keys={keys}
        head={() => <Head columns={shown} sorting={props.sorting} />}
        row={(index, attributes) => {
          const entry = rows[index];
          if (!entry) return null;
          const { active, ...rest } = attributes;
          if ("group" in entry) {
            return (
              <div
                key={groupName(entry.group)}
                role="row"
                aria-rowindex={index + 2}
                class={`row group${active ? " active" : ""}`}
                {...rest}
              >
                <div role="gridcell" aria-colspan={shown.length}>
                  {entry.group} <span class="count">{entry.count}</span>
                </div>
              </div>
            );
          }
          const { row } = entry;
          return (
            <div
              key={props.nameOf(row)}
              role="row"
              aria-rowindex={index + 2}
              draggable={props.onDrag ? true : undefined}
              aria-selected={props.marked ? props.marked(row) : active}
              class={`row${active ? " active" : ""}${props.marked?.(row) ? " marked" : ""}${onOpen ? " opens" : ""}`}
              {...rest}
            >
              {shown.map((column) => (
                <div
                  key={column.id}
                  role="gridcell"
                  class={`cell${column.numeric ? " numeric" : ""}${column.phone ? ` at-${column.phone}` : ""}`}
                >
                  {column.cell(row)}
                </div>
              ))}
            </div>
          );
        }}
      />
    </div>
  );
}

const gap = 12;
const padding = 16;

/** Columns grow with the letters. */
function inRem(widths: string): string {
  return widths.replace(/([\d.]+)px/g, (_, pixels) => `${pixels / normalSize}rem`);
}

/** Pixels below which the table scrolls sideways. */
function leastWidth<T>(columns: Column<T>[]): number {
  const tracks = columns.map((column) => Number.parseFloat(column.width.replace(/^minmax\(/, "")) || 0);
  return tracks.reduce((sum, track) => sum + track + gap, 2 * padding - gap);
}

function Head<T>({ columns, sorting }: { columns: Column<T>[]; sorting?: Sorting }) {
  return (
    <div role="rowgroup" class="list-head">
      <div role="row" aria-rowindex={1} class="row">
        {columns.map((column) => {
          const direction = sorting?.by === column.id ? "ascending" : sorting?.by === `-${column.id}` ? "descending" : undefined;
          return (
            <div key={column.id} role="columnheader" aria-sort={direction} class={`cell${column.numeric ? " numeric" : ""}`}>
              {sorting && column.compare ? (
                <button type="button" onClick={() => sorting.set(nextSorting(sorting.by, column.id))}>
                  {column.title}
                  <span aria-hidden="true" class="arrow">
                    {direction === "ascending" ? "↑" : direction === "descending" ? "↓" : ""}
                  </span>
                </button>
              ) : (
                <span class={column.spoken ? "spoken" : ""}>{column.title}</span>
              )}
            </div>
          );
        })}
      </div>
    </div>
  );
}

/** Says that rows are out of order, and puts them in order when asked. */
export function Outdated({ order }: { order: { outdated: number; refresh(): void } }) {
  if (order.outdated === 0) return null;
  return (
    <span class="outdated">
      {words.tableOutdated(order.outdated)}
      <button type="button" onClick={order.refresh}>
        {words.tableUpdate}
      </button>
    </span>
  );
}

export function nextSorting(now: string, column: string): string {
  return now === column ? `-${column}` : column;
}

/** Compares by the column that `sorting` names, then by `otherwise`. */
export function compareBy<T>(columns: Column<T>[], by: string, otherwise: (a: T, b: T) => number): (a: T, b: T) => number {
  const compare = columns.find((column) => column.id === by.replace(/^-/, ""))?.compare;
  if (!compare) return otherwise;
  const sign = by.startsWith("-") ? -1 : 1;
  return (a, b) => sign * compare(a, b) || otherwise(a, b);
}

/** The choice of an order where there are no column heads: on a narrow screen and for the keyboard. */
export function SortSelect<T>({ columns, sorting }: { columns: Column<T>[]; sorting: Sorting }) {
  const sorted = columns.filter((column) => column.compare);
  const name = (by: string) => `${sorted.find(({ id }) => id === by.replace(/^-/, ""))?.title} ${by.startsWith("-") ? "↓" : "↑"}`;
  return (
    <Choice
      label={words.tableSort}
      value={sorting.by}
      values={sorted.flatMap(({ id }) => [id, `-${id}`])}
      name={name}
      onChange={sorting.set}
    />
  );
}
