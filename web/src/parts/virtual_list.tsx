import type { ComponentChildren } from "preact";
import { useEffect, useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";
import { type ActiveRow, activeNow } from "../core/active_row";
import { addShortcuts } from "../core/keyboard";
import { layoutOf, shownRows } from "../core/layout";
import { inFrame } from "../core/redraw";
import * as words from "../words/frame";

export interface ListProps {
  count: number;
  /** Pixels of all rows, or of each. */
  heights: number | ((index: number) => number);
  /** Changes when the heights of rows changed. */
  heightsVersion?: unknown;
  /** With names, the active row stays the same one where rows come, go or move. */
  nameAt?(index: number): string;
  row(index: number, attributes: RowAttributes): ComponentChildren;
  label: string;
  role: "grid" | "tree" | "listbox";
  columns?: number;
  head?(): ComponentChildren;
  /** The list keeps its place under this name when the user comes back. */
  place?: string;
  /** The active row, if the view knows it; where it is another one, the list scrolls there. */
  active?: number;
  onActive?(index: number): void;
  onOpen?(index: number): void;
  /** A click on a row, but not on a control in it, opens the row if this is not given. */
  onPress?(index: number, target: Element): void;
  /** The rows in the document, after scrolling has paused. */
  onWindow?(first: number, end: number): void;
  /** More keys of the active row. */
  keys?: Record<string, { what: string; run(index: number): void }>;
}

/** No handlers: the list handles the events of its rows. An element keeps its handlers when it leaves the document. */
export interface RowAttributes {
  id: string;
  style: string;
  active: boolean;
}

const places = new Map<string, { top: number; active: ActiveRow }>();
let lists = 0;

/** The index of the row in which an event happened, or -1. */
export function rowOf(target: Element): number {
  return Number(target.closest(".list-rows > *")?.id.replace(/^.*-/, "") ?? -1);
}

/**
 * A list of which only the visible rows exist in the document. Rows that do not exist are still counted.
 *
 * The functions of one call share their scope, and some live as long as the list. The scope may hold no element of
 * Preact (`props.head` is a function): an element leads to the tree of its call, and that to the rows of then.
 */
export function VirtualList(props: ListProps) {
  const { count, heights, place } = props;
  const box = useRef<HTMLDivElement>(null);
  const name = useMemo(() => `list${++lists}`, []);
  const before = place ? places.get(place) : undefined;
  const [view, setView] = useState({ top: before?.top ?? 0, height: 600 });
  const own = useRef<ActiveRow>(before?.active ?? { index: 0 });
  const [, setDrawn] = useState(0);
  if (props.active !== undefined) own.current = { index: props.active };
  own.current = activeNow(own.current, count, props.nameAt);
  const active = own.current.index;
  const layout = useMemo(() => layoutOf(count, heights), [count, typeof heights === "number" ? heights : null, props.heightsVersion]);

  const headHeight = () => (box.current?.querySelector(".list-head") as HTMLElement | null)?.offsetHeight ?? 0;
  const measure = () => {
    const element = box.current;
    if (element) setView({ top: element.scrollTop, height: element.clientHeight - headHeight() });
  };
  useLayoutEffect(() => {
    const element = box.current;
    if (!element) return undefined;
    if (before) element.scrollTop = before.top;
    const observer = new ResizeObserver(measure);
    observer.observe(element);
    measure();
    return () => observer.disconnect();
  }, []);
  useEffect(() => {
    if (place) places.set(place, { top: view.top, active: own.current });
  }, [place, view.top, active, own.current.name]);

  const drawn = useRef(props.active);
  const choose = (index: number) => {
    drawn.current = index; // it is in sight: rows must not move under the pointer
    own.current = { index, name: index < count ? props.nameAt?.(index) : undefined };
    setDrawn((drawn) => drawn + 1);
    props.onActive?.(index);
  };

  const show = (index: number) => {
    const element = box.current;
    if (!element) return;
    const top = layout.scrollOf(layout.offset(index));
    const bottom = top + layout.height(index);
    if (top < element.scrollTop) element.scrollTop = top;
    else if (bottom > element.scrollTop + view.height) element.scrollTop = bottom - view.height;
  };
  const move = (index: number) => {
    const next = Math.max(0, Math.min(count - 1, index));
    choose(next);
    show(next);
    if (!box.current?.contains(document.activeElement)) box.current?.focus({ preventScroll: true });
  };
  useLayoutEffect(() => {
    if (props.active !== undefined && props.active !== drawn.current) show(props.active);
    drawn.current = props.active;
  }, [props.active]);
  const press = (target: Element) => {
    const index = rowOf(target);
    if (index < 0 || target.closest("a, button, input, label")) return;
    if (props.onPress) props.onPress(index, target);
    else props.onOpen?.(index);
  };
  const page = Math.max(1, Math.floor(view.height / layout.height(0)) - 1);
  const latest = useRef({ move, choose, active, page, props });
  latest.current = { move, choose, active, page, props };
  useListKeys(latest);

  const shown = shownRows(layout, view.top, view.height);
  useEffect(() => {
    if (!props.onWindow) return undefined;
    const timer = setTimeout(() => props.onWindow?.(shown.first, shown.end), 150);
    return () => clearTimeout(timer);
  }, [shown.first, shown.end, props.heightsVersion]);
  const rows = [];
  for (let index = shown.first; index < shown.end; index++) {
    rows.push(
      props.row(index, {
        id: `${name}-${index}`,
        style: `transform:translateY(${shown.shift + layout.offset(index)}px);height:${layout.height(index)}px`,
        active: index === active,
      }),
    );
  }
  const grid = props.role === "grid" ? { "aria-rowcount": count + (props.head ? 1 : 0), "aria-colcount": props.columns } : {};
  return (
    <div
      ref={box}
      class="list"
      role={props.role}
      aria-label={props.label}
      aria-activedescendant={active >= shown.first && active < shown.end ? `${name}-${active}` : undefined}
      tabIndex={0}
      onScroll={() => inFrame(measure)}
      {...grid}
    >
      {props.head?.()}
      <div
        class="list-rows"
        role={props.role === "grid" ? "rowgroup" : "presentation"}
        style={`height:${layout.drawnTotal}px`}
        onPointerDown={(event) => {
          const index = rowOf(event.target as Element);
          if (index >= 0) choose(index);
        }}
        onClick={(event) => press(event.target as Element)}
      >
        {rows}
      </div>
    </div>
  );
}

interface Latest {
  move(index: number): void;
  choose(index: number): void;
  active: number;
  page: number;
  props: ListProps;
}

/** The list that was drawn last gets the keys of rows, wherever the focus is. */
function useListKeys(latest: { current: Latest }): void {
  const own = Object.keys(latest.current.props.keys ?? {}).join();
  useLayoutEffect(() => {
    const step = (by: (now: Latest) => number) => () => latest.current.move(latest.current.active + by(latest.current));
    const open = () => {
      const { props, active } = latest.current;
      if (active < props.count) props.onOpen?.(active);
    };
    const more = Object.entries(latest.current.props.keys ?? {}).map(([keys, { what }]) => ({
      keys,
      what,
      run: () => {
        const { props, active, choose } = latest.current;
        if (active >= props.count) return;
        choose(active);
        props.keys?.[keys]?.run(active);
      },
    }));
    return addShortcuts([
      { keys: "j", what: words.keyboardRowNext, run: step(() => 1) },
      { keys: "k", what: words.keyboardRowBefore, run: step(() => -1) },
      { keys: "ArrowDown", what: words.keyboardRowNext, run: step(() => 1) },
      { keys: "ArrowUp", what: words.keyboardRowBefore, run: step(() => -1) },
      { keys: "PageDown", what: words.keyboardPageDown, run: step((now) => now.page) },
      { keys: "PageUp", what: words.keyboardPageUp, run: step((now) => -now.page) },
      { keys: "Home", what: words.keyboardFirst, run: () => latest.current.move(0) },
      { keys: "End", what: words.keyboardLast, run: () => latest.current.move(latest.current.props.count - 1) },
      ...(latest.current.props.onOpen ? [{ keys: "Enter", what: words.keyboardOpen, run: open }] : []),
      ...more,
    ]);
  }, [own]);
}
