import { useState } from "preact/hooks";
import { catalog, mayBe } from "../app";
import { type Network, number } from "../core/catalog";
import type { Tone } from "../core/commands";
import { second, useFrame } from "../core/redraw";
import { hrefTo } from "../core/router";
import { serverNow } from "../core/server_time";
import type { Joining } from "../core/zigbee";
import { notify } from "../parts/notices";
import { State } from "../parts/state";
import * as text from "../words/zigbee";
import { ZigbeeMapDialog } from "./zigbee_map";
import { pairingOf, permit } from "./zigbee_tool";

/** How long devices may join, the longest that ZigBee permits. */
const seconds = 254;

/** Pairing with who joins, and the map. */
export function ZigbeePanel({ network }: { network: Network }) {
  useFrame();
  void second.value;
  const [mapped, setMapped] = useState(false);
  const pairing = pairingOf(network);
  const left = Math.max(0, Math.ceil(Math.max(pairing?.until ?? 0, permittedUntil(network)) - serverNow()));
  const failed = (why: string) => notify(text.failed(why), "bad");
  const joins = [...(pairing?.joins.values() ?? [])];
  return (
    <section class="zigbee" aria-label={text.title}>
      <h3>{text.title}</h3>
      <div class="actions">
        {mayBe("admin") && (
          <button type="button" class={left > 0 ? "" : "primary"} onClick={() => permit(network, left > 0 ? 0 : seconds, failed)}>
            {left > 0 ? text.stop : text.pair}
          </button>
        )}
        {mayBe("command") && (
          <button type="button" onClick={() => setMapped(true)}>
            {text.map}
          </button>
        )}
      </div>
      {left > 0 && (
        <>
          <p role="timer" class="countdown">
            {text.open(left)}
          </p>
          <progress max={seconds} value={left} aria-hidden="true" />
          <p class="muted">{text.pairText}</p>
        </>
      )}
      {pairing && left === 0 && pairing.until === 0 && <p class="muted">{pairing.why || text.ended(joins.length)}</p>}
      {left > 0 && joins.length === 0 && <p class="muted">{text.nobody}</p>}
      <ul class="joins" role="log">
        {joins.map((join) => (
          <Join key={join.address} network={network} join={join} />
        ))}
      </ul>
      {mapped && <ZigbeeMapDialog network={network} onClose={() => setMapped(false)} />}
    </section>
  );
}

/** Whoever permitted it: also another page, or the bridge's own. */
function permittedUntil(network: Network): number {
  const { permit_join, permit_join_end } = network.counters.get("bridge")?.json ?? {};
  return permit_join === true ? number(permit_join_end) : 0;
}

const tones: Record<string, Tone> = { interviewed: "good", failed: "bad", left: "neutral" };

function Join({ network, join: { address, name, model, state, why } }: { network: Network; join: Joining }) {
  const device = catalog.device(network.owner, network.id, address);
  return (
    <li>
      {device ? <a href={hrefTo("devices", device.path.split("/"))}>{device.name}</a> : <span>{name}</span>}
      <State word={text.states[state] ?? state} tone={tones[state] ?? "waiting"} />
      <span class="muted">{[model, why].filter(Boolean).join(" · ")}</span>
    </li>
  );
}
