import { signal } from "@preact/signals";
import { useEffect, useLayoutEffect, useRef } from "preact/hooks";
import {
  active,
  chooseIsland,
  chosenIsland,
  islands,
  line,
  loginNeeded,
  logout,
  lostSince,
  mayBe,
  mergedUntil,
  server,
  wokenSensors,
} from "../app";
import { formatAge } from "../core/format";
import { addShortcuts } from "../core/keyboard";
import { second } from "../core/redraw";
import { go, goToList, hrefTo, route } from "../core/router";
import { type Theme, theme } from "../core/settings";
import type { View } from "../views/views";
import * as words from "../words/frame";
import { Icon } from "./icons";
import { showHelp } from "./keyboard_help";
import { Notices } from "./notices";
import { phone } from "./screen";
import { showSearch } from "./search";

/** How many views the bar of a narrow screen has room for, beside `More`. */
const barRoom = 4;
const moreOpen = signal(false);

function markOf(view: View): number {
  void second.value;
  return view.mark?.() ?? 0;
}

function Entry({ view, current }: { view: View; current: boolean }) {
  const mark = markOf(view);
  return (
    <a href={hrefTo(view.id)} aria-current={current ? "page" : undefined} onClick={() => (moreOpen.value = false)}>
      <Icon name={view.icon} />
      <span>{view.title}</span>
      {mark > 0 && <span class="mark">{mark > 99 ? "99+" : mark}</span>}
    </a>
  );
}

function Rail({ views, current }: { views: View[]; current: string }) {
  const bar = phone.value ? views.slice(0, barRoom) : views;
  const rest = phone.value ? views.slice(barRoom) : [];
  return (
    <nav class="rail" aria-label={words.viewsLabel}>
      {bar.map((view) => (
        <Entry key={view.id} view={view} current={view.id === current} />
      ))}
      {rest.length > 0 && (
        <button type="button" aria-expanded={moreOpen.value} onClick={() => (moreOpen.value = !moreOpen.value)}>
          <Icon name="more" />
          <span>{words.more}</span>
        </button>
      )}
      {rest.length > 0 && moreOpen.value && (
        <div class="sheet">
          {rest.map((view) => (
            <Entry key={view.id} view={view} current={view.id === current} />
          ))}
          <Tools />
        </div>
      )}
    </nav>
  );
}

function IslandChooser() {
  return (
    <select
      class="islands"
      aria-label={words.islandsLabel}
      value={String(chosenIsland())}
      onChange={(event) => chooseIsland(Number(event.currentTarget.value))}
    >
      <option value="0">{words.islandsAll}</option>
      {islands.value.map((island) => (
        <option key={island.id} value={String(island.id)}>
          {`${island.name || "island"} · ${island.id}`}
        </option>
      ))}
    </select>
  );
}

function LineState() {
  const state = line.value;
  void second.value;
  const tone = state === "live" ? "good" : state === "lost" ? "bad" : "waiting";
  const age = lostSince.value ? formatAge((Date.now() - lostSince.value) / 1000) : "";
  const merged = mergedUntil.value > Date.now();
  const text =
    state === "lost" ? words.lineLostFor(age) : state === "live" ? (merged ? words.lineMerged : words.lineLive) : words.lineConnecting;
  return (
    <span class={`line state tone-${tone}`} title={merged ? words.lineSlow : text}>
      <span class="dot" aria-hidden="true" />
      <span class="line-text">{text}</span>
    </span>
  );
}

function ActiveSwitch({ view }: { view: View }) {
  const on = active.value;
  const waking = words.activeWaking(wokenSensors.value);
  const turn = () => (active.value = !active.value);
  const wakes = view.wakes?.(route.value) ?? false;
  useLayoutEffect(() => (wakes ? addShortcuts([{ keys: "a", what: words.keyboardActive, run: turn }]) : undefined), [wakes]);
  if (!wakes || !mayBe("view")) return null;
  return (
    <button
      type="button"
      class="active-switch"
      role="switch"
      aria-checked={on}
      aria-label={on ? `${words.activeActive} ${waking}` : words.activePassive}
      title={words.activeTitle}
      onClick={turn}
    >
      <span class="knob" aria-hidden="true" />
      {on ? words.activeActive : words.activePassive}
      {on && <span class="waking">{phone.value ? wokenSensors.value : waking}</span>}
    </button>
  );
}

const themes: Theme[] = ["system", "light", "dark"];

interface ToolProps {
  icon: string;
  label: string;
  run(): void;
  /** What stands below the icon among the views of a narrow screen. */
  short: string;
}

function Tool({ icon, label, run, short }: ToolProps) {
  return (
    <button type="button" class="plain" aria-label={label} title={label} onClick={run}>
      <Icon name={icon} />
      {phone.value && <span>{short}</span>}
    </button>
  );
}

/** Theme, keys, and whom the server takes us for, where it asks: in the head, or behind `More`. */
function Tools() {
  const known = server.value;
  const next = themes[(themes.indexOf(theme.value) + 1) % themes.length] ?? "system";
  const chosen = words.theme[theme.value];
  return (
    <>
      {known?.tokens && (
        <Tool
          icon="logout"
          label={words.loginLogout(known.caller.name, known.caller.role)}
          short={words.loginOut}
          run={() => void logout()}
        />
      )}
      <Tool icon="theme" label={`${words.theme.label}: ${chosen}`} short={chosen} run={() => (theme.value = next)} />
      <Tool icon="help" label={words.keyboardTitle} short={words.keyboardTitle} run={showHelp} />
    </>
  );
}

export function Shell({ views }: { views: View[] }) {
  const current = route.value;
  const view = views.find(({ id }) => id === current.view) ?? views[0];
  const main = useRef<HTMLElement>(null);
  useShellKeys(views);
  useFocusOfView(main, [current.view, ...current.parts].join("/"));
  useLayoutEffect(() => {
    if (view) document.title = `${view.title} – ${words.product}`;
  }, [view]);
  if (!view) return null;
  return (
    <div class={`shell line-${loginNeeded.value ? "lost" : line.value}`}>
      <button type="button" class="skip" onClick={() => main.current?.focus()}>
        {words.skip}
      </button>
      <header class="top">
        <a class="brand" href={hrefTo("overview")}>
          {words.product}
        </a>
        <IslandChooser />
        <button type="button" class="search-button" aria-label={words.searchLabel} onClick={showSearch}>
          <Icon name="search" size={16} />
          <span>{words.searchLabel}</span>
          <kbd>/</kbd>
        </button>
        <span class="space" />
        <ActiveSwitch view={view} />
        <LineState />
        {!phone.value && <Tools />}
      </header>
      <Rail views={views} current={view.id} />
      <main ref={main} tabIndex={-1} onPointerDown={() => (moreOpen.value = false)}>
        {view.show(current)}
      </main>
      <Notices />
    </div>
  );
}

/** Where another address left the focus nowhere, it goes to what is shown now. */
function useFocusOfView(main: { current: HTMLElement | null }, address: string): void {
  const before = useRef(address);
  useEffect(() => {
    if (before.current !== address && document.activeElement === document.body) main.current?.focus({ preventScroll: true });
    before.current = address;
  }, [address]);
}

function useShellKeys(views: View[]): void {
  useLayoutEffect(
    () =>
      addShortcuts([
        { keys: "/", what: words.keyboardSearch, run: showSearch },
        { keys: "?", what: words.keyboardHelp, run: showHelp },
        { keys: "Escape", what: words.keyboardBack, run: back },
        { keys: "c", what: words.keyboardCommand, run: focusControl },
        ...views.map((view) => ({ keys: `g ${view.key}`, what: words.keyboardGoTo(view.title), run: () => go(view.id) })),
      ]),
    [views],
  );
}

/** Leaves a field first, then the page of one thing for its list. */
function back(): void {
  moreOpen.value = false;
  const focused = document.activeElement;
  if (focused instanceof HTMLElement && focused !== document.body && focused.matches("input, textarea, select, button, a")) {
    focused.blur();
    return;
  }
  const { view, parts } = route.value;
  if (parts.length > 0) goToList(view);
}

/** The control of the active row, else the first one of the view. */
function focusControl(): void {
  const control = controlWithin("main .row.active") ?? controlWithin("main");
  control?.focus();
  control?.scrollIntoView({ block: "nearest" });
}

function controlWithin(place: string): HTMLElement | null {
  return document.querySelector(`${place} .control :is(button, input, select, textarea)`);
}
