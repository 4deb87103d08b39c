import { useEffect, useRef, useState } from "preact/hooks";
import { redraw, second } from "./redraw";
import { FrozenOrder, type OrderSpec } from "./order";

/** Work may take this share of the time. */
const share = 0.1;

/**
 * Runs work when `version` changed, so that it never takes more than a tenth of the time: long lists that are arriving
 * are put in order now and then, short ones at each change. Another `urgent` is never late.
 */
function usePace(version: string, urgent: string): (work: () => void) => void {
  const done = useRef({ version: "", urgent: "", next: 0, timer: 0 });
  useEffect(() => () => clearTimeout(done.current.timer), []);
  return (work) => {
    const now = performance.now();
    const state = done.current;
    if (state.version === version) return;
    clearTimeout(state.timer);
    if (state.urgent === urgent && now < state.next) {
      state.timer = window.setTimeout(redraw, state.next - now);
      return;
    }
    work();
    const end = performance.now();
    done.current = { version, urgent, next: end + (end - now) / share, timer: 0 };
  };
}

/** What `make` makes of `version`, made again at most as often as it is cheap; at once for another `urgent`. */
export function usePaced<T>(version: string, make: () => T, urgent = ""): T {
  const made = useRef<{ value: T } | null>(null);
  const pace = usePace(`${version} ${urgent}`, urgent);
  pace(() => (made.current = { value: make() }));
  made.current ??= { value: make() };
  return made.current.value;
}

/** Every other second: what sorts all rows again is not worth more. */
function everyOther(seconds: number): number {
  return seconds >> 1;
}

/** The rows of a list that never move by themselves, and how many are out of date. */
export function useOrder<T>(all: () => Iterable<T>, structure: number, spec: OrderSpec<T>) {
  const kept = useRef<FrozenOrder<T> | null>(null);
  kept.current ??= new FrozenOrder<T>();
  const order = kept.current;
  const [, setDrawn] = useState(0);
  const drawAgain = () => setDrawn((count) => count + 1);
  const urgent = `${spec.complete} ${spec.name}`;
  const pace = usePace(`${structure} ${urgent}`, urgent);
  pace(() => order.update(all(), structure, spec));
  const tick = everyOther(second.value);
  useEffect(() => {
    if (!spec.live) return;
    order.count(all(), spec);
    drawAgain();
  }, [spec.live && tick, spec.name]);
  const refresh = () => {
    order.refresh(all(), spec);
    drawAgain();
  };
  return { rows: order.rows, version: order.version, outdated: order.outdated, refresh };
}
