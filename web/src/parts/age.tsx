import { useMemo } from "preact/hooks";
import { formatAge, formatFullTime } from "../core/format";
import { second } from "../core/redraw";
import { serverNow } from "../core/server_time";

/** How long ago that was; the exact time as tooltip. Nothing for 0. */
export function Age({ time }: { time: number }) {
  void second.value;
  const exact = useMemo(() => formatFullTime(time), [time]);
  if (time <= 0) return <span class="muted">–</span>;
  return (
    <time class="age" title={exact}>
      {formatAge(serverNow() - time)}
    </time>
  );
}
