import { useEffect, useState } from "preact/hooks";
import { catalog } from "../app";
import type { Network } from "../core/catalog";
import { mapOf, type Node, type ZigbeeMap } from "../core/zigbee";
import { Dialog } from "../parts/dialog";
import * as text from "../words/zigbee";
import { readMap } from "./zigbee_tool";

/** Letters of a name in the picture; the table has it whole. */
const longest = 22;

/** Who reaches whom, as a picture and as a table. */
export function ZigbeeMapDialog({ network, onClose }: { network: Network; onClose(): void }) {
  const [map, setMap] = useState<ZigbeeMap | null>(null);
  const [why, setWhy] = useState("");
  useEffect(() => readMap(network, (nodes, links) => setMap(mapOf(nodes, links)), setWhy), [network]);
  return (
    <Dialog title={text.mapOf(network.id)} onClose={onClose} wide>
      {why && <p class="error">{text.failed(why)}</p>}
      {!map && !why && <p role="status">{text.mapReading}</p>}
      {map && <Picture map={map} nameOf={(node) => nameIn(network, node)} />}
    </Dialog>
  );
}

/** The name on the island, else that of the bridge. */
function nameIn(network: Network, { address, name }: Node): string {
  return catalog.device(network.owner, network.id, address)?.name ?? name;
}

function Picture({ map: { nodes, links, width, height }, nameOf }: { map: ZigbeeMap; nameOf(node: Node): string }) {
  const silent = nodes.filter(({ failed }) => failed.length > 0);
  const faint = [...links].sort((a, b) => Number(a.way) - Number(b.way));
  return (
    <>
      <div class="zigbee-map" tabIndex={0} role="region" aria-label={text.mapLabel(nodes.length, links.length)}>
        <svg width={width + 20} height={height + 20} viewBox={`-12 -20 ${width + 20} ${height + 20}`} aria-hidden="true">
          {faint.map(({ from, to, way }) => (
            <line key={from.address + to.address} class={way ? "way" : ""} x1={from.x} y1={from.y} x2={to.x} y2={to.y} />
          ))}
          {faint.map(({ from, to, way, quality }) =>
            way ? (
              <text
                key={from.address + to.address}
                class="quality"
                x={(from.x + to.x) / 2}
                y={(from.y + to.y) / 2 + 4}
                text-anchor="middle"
              >
                {quality}
              </text>
            ) : null,
          )}
          {nodes.map((node) => (
            <g key={node.address}>
              <circle
                class={node.failed.length > 0 ? "silent" : node.role}
                cx={node.x}
                cy={node.y}
                r={node.role === "coordinator" ? 8 : 6}
              />
              <text x={node.x} y={node.y - 9} text-anchor={node.x === 0 ? "start" : "middle"}>
                {nameOf(node).slice(0, longest)}
              </text>
            </g>
          ))}
        </svg>
      </div>
      <p class="muted">
        {text.mapLegend} {silent.length > 0 && text.silent(silent.map(nameOf).join(", "))}
      </p>
      <div class="wide-table">
        <table>
          <thead>
            <tr>
              <th scope="col">{text.from}</th>
              <th scope="col">{text.to}</th>
              <th scope="col">{text.quality}</th>
            </tr>
          </thead>
          <tbody>
            {links.map(({ from, to, quality }) => (
              <tr key={from.address + to.address}>
                <td>{nameOf(from)}</td>
                <td>{nameOf(to)}</td>
                <td>{quality}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </>
  );
}
