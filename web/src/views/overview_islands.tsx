import { catalog, chosenIsland, islands } from "../app";
import type { Component } from "../core/frames";
import { hrefTo } from "../core/router";
import { Age } from "../parts/age";
import * as text from "../words/overview";
import { reachableOf } from "./overview_facts";

export function Islands() {
  const island = chosenIsland();
  const rows = islands.value.filter(({ id }) => !island || id === island);
  return (
    <div class="wide-table">
      <table>
        <caption class="spoken">{text.islands}</caption>
        <thead>
          <tr>
            <th scope="col">{text.island}</th>
            <th scope="col" class="desk">
              {text.host}
            </th>
            <th scope="col" class="desk">
              {text.program}
            </th>
            <th scope="col">{text.up}</th>
            <th scope="col">{text.devices}</th>
          </tr>
        </thead>
        <tbody>
          {rows.map((row) => (
            <Island key={row.id} island={row} />
          ))}
        </tbody>
      </table>
    </div>
  );
}

function Island({ island }: { island: Component }) {
  const { reachable, all } = reachableOf(catalog, island.id);
  return (
    <tr>
      <th scope="row">
        <a href={hrefTo("devices", [], { island: String(island.id) })}>{island.name || island.id}</a> <span class="muted">{island.id}</span>
      </th>
      <td class="desk">{island.host}</td>
      <td class="desk">{[island.program, island.version].filter(Boolean).join(" ")}</td>
      <td>
        <Age time={island.since} />
      </td>
      <td>
        <meter min={0} max={Math.max(all, 1)} value={reachable} aria-label={text.reachable(reachable, all)} />
        {text.reachable(reachable, all)}
      </td>
    </tr>
  );
}
