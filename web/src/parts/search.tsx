import { signal } from "@preact/signals";
import { useRef, useState } from "preact/hooks";
import { catalog, chosenIsland } from "../app";
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

/** Views, devices and networks whose texts contain all words of the search. */
function find(search: string): Found[] {
  const found: Found[] = [];
  for (const view of views) {
    if (matches(search, view.title))
      found.push({ key: view.id, what: words.searchView, name: view.title, more: "", href: hrefTo(view.id) });
  }
  if (search.trim() === "") return found;
  const island = chosenIsland();
  for (const device of catalog.devices.values()) {
    if (found.length >= longest) break;
    if (island && device.owner !== island) continue;
    const more = [device.network, device.area, device.model].filter(Boolean).join(" · ");
    if (!matches(search, `${device.name} ${device.id} ${more} ${device.owner}`)) continue;
    found.push({ key: device.path, what: words.searchDevice, name: device.name, more, href: hrefTo("devices", device.path.split("/")) });
  }
  return found;
}

export function Search() {
  return open.value ? <SearchDialog /> : null;
}

function SearchDialog() {
  const [text, setText] = useState("");
  const [at, setAt] = useState(0);
  const box = useRef<HTMLUListElement>(null);
  const found = find(text);
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
    </Dialog>
  );
}
