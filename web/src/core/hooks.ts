import { useEffect, useRef, useState } from "preact/hooks";
import { second } from "./redraw";
import { FrozenOrder, type OrderSpec } from "./order";

/**
 * The rows of a list that never move by themselves, and how many are out of date where filter or order depend on
 * values that change.
 */
export function useOrder<T>(all: () => Iterable<T>, structure: number, spec: OrderSpec<T>) {
  const order = useRef<FrozenOrder<T> | null>(null);
  order.current ??= new FrozenOrder<T>();
  const [outdated, setOutdated] = useState(0);
  const [, setRefreshed] = useState(0);
  order.current.update(all(), structure, spec);
  const tick = second.value;
  useEffect(() => setOutdated(order.current?.outdated(all(), spec) ?? 0), [spec.live && tick % 2, spec.name]);
  const refresh = () => {
    order.current?.refresh(all(), spec);
    setOutdated(0);
    setRefreshed((count) => count + 1);
  };
  return { rows: order.current.rows, version: order.current.version, outdated, refresh };
}
