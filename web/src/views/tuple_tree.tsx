import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { components } from "../app";
import { formatCount, formatRate, formatTime } from "../core/format";
import type { Rates } from "../core/rates";
import { pinnedBranches } from "../core/settings";
import type { Tuple } from "../core/store";
import type { Branch, Tree, TreeRow } from "../core/tree";
import { Icon } from "../parts/icons";
import { phone, rowHeight, scaled } from "../parts/screen";
import { State } from "../parts/state";
import { VirtualList } from "../parts/virtual_list";
import * as text from "../words/tuples";
import * as words from "../words/frame";

const longest = 200;

interface Props {
  rows: TreeRow[];
  chosen: string;
  openBranches: ReadonlySet<string>;
  onToggle(branch: Branch, open?: boolean): void;
  onOpen(branch: Branch): void;
  onPin(branch: Branch): void;
  tree: Tree;
}

/** The tree by the WAI-ARIA tree pattern; rows that are not in the document are still counted. */
export function TupleTree({ rows, chosen, openBranches, onToggle, onOpen, onPin, tree }: Props) {
  const [at, setAt] = useState<Branch | undefined>(undefined);
  const active = useMemo(
    () =>
      Math.max(
        0,
        rows.findIndex(({ branch }) => branch === at),
      ),
    [rows, at],
  );
  // What the address names is shown once it is there.
  const shown = useRef("");
  useEffect(() => {
    const branch = tree.find(chosen);
    if (shown.current === chosen || !branch || !rows.some((row) => row.branch === branch)) return;
    shown.current = chosen;
    setAt(branch);
  }, [chosen, rows]);
  const rowAt = (index: number) => rows[index];
  const choose = (index: number) => setAt(rowAt(index)?.branch);
  const right = (index: number) => {
    const row = rowAt(index);
    if (!row || isLeaf(row.branch)) return;
    if (openBranches.has(row.branch.path)) choose(Math.min(index + 1, rows.length - 1));
    else onToggle(row.branch, true);
  };
  const left = (index: number) => {
    const row = rowAt(index);
    if (!row) return;
    if (!isLeaf(row.branch) && openBranches.has(row.branch.path)) onToggle(row.branch, false);
    else if (row.branch.parent) setAt(row.branch.parent);
  };
  const on = (call: (branch: Branch) => void) => (index: number) => {
    const row = rowAt(index);
    if (row) call(row.branch);
  };
  return (
    <VirtualList
      role="tree"
      label={text.label}
      count={rows.length}
      heights={phone.value ? scaled(48) : rowHeight()}
      place="tuples"
      active={active}
      onActive={choose}
      onOpen={on(onOpen)}
      onPress={(index, target) => {
        const row = rowAt(index);
        if (!row || row.pending) return;
        if (target.closest(".twisty")) onToggle(row.branch);
        else onOpen(row.branch);
      }}
      keys={{
        ArrowRight: { what: text.expand, run: right },
        ArrowLeft: { what: text.collapse, run: left },
        " ": { what: words.keyboardPin, run: on(onPin) },
      }}
      row={(index, attributes) => {
        const row = rowAt(index);
        if (!row) return null;
        const { branch, level, size, place } = row;
        const { active: isActive, ...rest } = attributes;
        if (row.pending) return <PendingRow key={`${branch.path} ${row.pending}`} row={row} id={rest.id} style={rest.style} />;
        const open = openBranches.has(branch.path);
        return (
          <div
            key={branch.path}
            role="treeitem"
            aria-level={level}
            aria-setsize={size}
            aria-posinset={place}
            aria-expanded={isLeaf(branch) ? undefined : open}
            aria-selected={branch.path === chosen}
            class={`row leaf${isActive ? " active" : ""}${branch.path === chosen ? " marked" : ""}${branch.tuple && !branch.tuple.present ? " absent" : ""}`}
            {...rest}
            style={`${rest.style};--level:${level}`}
          >
            <span class="branch" style={`padding-left:${(level - 1) * (phone.value ? 12 : 18)}px`}>
              <span class={`twisty${isLeaf(branch) ? " none" : ""}${open ? " open" : ""}`} aria-hidden="true" />
              <span class="part">{branch.parent ? branch.part : ownerName(branch)}</span>
              {pinnedBranches.value.includes(branch.path) && <Icon name="pin" size={14} />}
              {branch.children.size > 0 && <span class="muted count">{formatCount(branch.count)}</span>}
            </span>
            {branch.tuple && <TupleValue tuple={branch.tuple} />}
            <span class="rate muted">{branch.rate >= 0.05 ? `${formatRate(branch.rate)}/s` : ""}</span>
          </div>
        );
      }}
    />
  );
}

function PendingRow({ row, id, style }: { row: TreeRow; id: string; style: string }) {
  return (
    <div
      id={id}
      role="treeitem"
      aria-level={row.level}
      aria-setsize={row.size}
      aria-posinset={row.place}
      aria-busy="true"
      aria-label={words.loading}
      class="row leaf skeleton"
      style={style}
    >
      <div style={`width:${30 - 6 * row.place}%`} />
    </div>
  );
}

function isLeaf(branch: Branch): boolean {
  return branch.parent !== null && branch.children.size === 0;
}

function ownerName(branch: Branch): string {
  const component = components.value.find(({ id }) => id === Number(branch.part));
  return component?.name ? `${branch.part} · ${component.name}` : branch.part;
}

function TupleValue({ tuple }: { tuple: Tuple }) {
  if (!tuple.present) return <State word={text.absent(formatTime(tuple.absentSince))} tone="bad" />;
  if (tuple.value === null) return <span class="leaf-value muted">{`${tuple.media} · ${formatCount(tuple.size)} B`}</span>;
  return <span class="leaf-value value">{tuple.value.slice(0, longest)}</span>;
}

interface FoundProps {
  tuples: Tuple[];
  rates: Rates;
  chosen: string;
  onOpen(tuple: Tuple): void;
}

/** What a search found, as a flat list. */
export function FoundTuples({ tuples, rates, chosen, onOpen }: FoundProps) {
  const open = (index: number) => {
    const tuple = tuples[index];
    if (tuple) onOpen(tuple);
  };
  return (
    <VirtualList
      role="listbox"
      label={text.found}
      count={tuples.length}
      heights={phone.value ? scaled(48) : rowHeight()}
      onOpen={open}
      row={(index, attributes) => {
        const tuple = tuples[index];
        if (!tuple) return null;
        const { active, ...rest } = attributes;
        const rate = rates.of(tuple);
        return (
          <div
            key={tuple.id}
            role="option"
            aria-setsize={tuples.length}
            aria-posinset={index + 1}
            aria-selected={tuple.id === chosen}
            class={`row leaf${active ? " active" : ""}${tuple.id === chosen ? " marked" : ""}`}
            {...rest}
          >
            <span class="branch whole-key" title={tuple.id}>
              <span class="part">
                <bdi>{tuple.id}</bdi>
              </span>
            </span>
            <TupleValue tuple={tuple} />
            <span class="rate muted">{rate >= 0.05 ? `${formatRate(rate)}/s` : ""}</span>
          </div>
        );
      }}
    />
  );
}
