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

/**
 * The rows of a list that never move by themselves, and how many are out of date where filter or order depend on
 * values that change.
 */
export function useOrder<T>(all: () => Iterable<T>, structure: number, spec: OrderSpec<T>) {
  const order = useRef<FrozenOrder<T> | null>(null);
  order.current ??= new FrozenOrder<T>();
  const [outdated, setOutdated] = useState(0);
  const [, setRefreshed] = useState(0);
  const pace = usePace(`${structure} ${spec.name}`, spec.name);
  pace(() => order.current?.update(all(), structure, spec));
  const tick = second.value;
  useEffect(() => setOutdated(order.current?.outdated(all(), spec) ?? 0), [spec.live && tick % 2, spec.name]);
  const refresh = () => {
    order.current?.refresh(all(), spec);
    setOutdated(0);
    setRefreshed((count) => count + 1);
  };
  return { rows: order.current.rows, version: order.current.version, outdated, refresh };
}
