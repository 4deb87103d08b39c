import { signal } from "@preact/signals";
import { useRef, useState } from "preact/hooks";
import { catalog, chosenIsland } from "../app";
import { typeWords } from "../core/format";
import { roomNames } from "../core/rooms";
import { hrefTo } from "../core/router";
import { matches } from "../core/text";
import { views } from "../views/views";
import * as words from "../words/frame";
import { Dialog } from "./dialog";

const open = signal(false);
const longest = 40;

export function showSearch(): void {
  open.value = true;
}

interface Found {
  key: string;
  what: string;
  name: string;
  more: string;
  href: string;
}

/** As devices list what they can do: their points may not be known yet. */
function knownTypes(): Set<string> {
  const types = new Set<string>();
  for (const device of catalog.devices.values()) for (const type of device.capabilities) types.add(type);
  return types;
}

/** Views, types, rooms, devices and networks whose texts contain all words of the search. */
function find(search: string): { found: Found[]; more: number } {
  const all: Found[] = [];
  for (const view of views) {
    if (matches(search, view.title)) all.push({ key: view.id, what: words.searchView, name: view.title, more: "", href: hrefTo(view.id) });
  }
  if (search.trim() !== "") {
    const island = chosenIsland();
    for (const type of knownTypes()) {
      if (matches(search, `${type} ${typeWords(type)}`))
        all.push({ key: `t ${type}`, what: words.searchType, name: typeWords(type), more: "", href: hrefTo("devices", [], { type }) });
    }
    for (const room of roomNames(catalog.devices.values())) {
      if (matches(search, room))
        all.push({ key: `r ${room}`, what: words.searchRoom, name: room, more: "", href: hrefTo("overview", [room]) });
    }
    const there = ({ owner }: { owner: number }) => !island || owner === island;
    for (const { id, owner, path, line } of [...catalog.networks.values()].filter(there)) {
      if (matches(search, `${id} ${owner}`))
        all.push({ key: `n ${path}`, what: words.searchNetwork, name: id, more: line, href: hrefTo("networks", [path]) });
    }
    for (const { id, owner, path, name, network, area, model } of [...catalog.devices.values()].filter(there)) {
      const more = [network, area, model].filter(Boolean).join(" · ");
      if (matches(search, `${name} ${id} ${more} ${owner}`))
        all.push({ key: path, what: words.searchDevice, name, more, href: hrefTo("devices", path.split("/")) });
    }
  }
  return { found: all.slice(0, longest), more: all.length - longest };
}

export function Search() {
  return open.value ? <SearchDialog /> : null;
}

function SearchDialog() {
  const [text, setText] = useState("");
  const [at, setAt] = useState(0);
  const box = useRef<HTMLUListElement>(null);
  const { found, more } = find(text);
  const close = () => (open.value = false);
  const choose = (index: number) => {
    const entry = found[index];
    if (!entry) return;
    close();
    location.hash = entry.href;
  };
  const move = (index: number) => {
    const next = Math.max(0, Math.min(found.length - 1, index));
    setAt(next);
    box.current?.children[next]?.scrollIntoView({ block: "nearest" });
  };
  const keys = (event: KeyboardEvent) => {
    if (event.key === "ArrowDown") move(at + 1);
    else if (event.key === "ArrowUp") move(at - 1);
    else if (event.key === "Enter") choose(at);
    else return;
    event.preventDefault();
  };
  return (
    <Dialog title={words.searchLabel} onClose={close} bare>
      <input
        type="text"
        role="combobox"
        aria-expanded="true"
        aria-controls="search-results"
        aria-activedescendant={found.length > 0 ? `search-${at}` : undefined}
        aria-label={words.searchLabel}
        placeholder={words.searchHint}
        autofocus
        value={text}
        onInput={(event) => {
          setText(event.currentTarget.value);
          setAt(0);
        }}
        onKeyDown={keys}
      />
      {found.length === 0 && <p class="muted">{words.searchNothing}</p>}
      <ul ref={box} id="search-results" role="listbox" aria-label={words.searchResults} class="results">
        {found.map((entry, index) => (
          <li key={entry.key} id={`search-${index}`} role="option" aria-selected={index === at} onClick={() => choose(index)}>
            <span class="what">{entry.what}</span>
            <span>{entry.name}</span>
            <span class="muted">{entry.more}</span>
          </li>
        ))}
      </ul>
      {more > 0 && <p class="muted">{words.searchRest(more)}</p>}
    </Dialog>
  );
}
