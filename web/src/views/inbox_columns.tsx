import { useLayoutEffect, useRef } from "preact/hooks";
import { list, number, text as textOf } from "../core/catalog";
import type { Decision, Decisions, Verb } from "../core/decisions";
import type { Tuple } from "../core/store";
import { compareNatural } from "../core/text";
import { Age } from "../parts/age";
import { prose } from "../parts/prose";
import { phone } from "../parts/screen";
import type { Column } from "../parts/table";
import * as text from "../words/inbox";
import * as deviceText from "../words/device";
import * as devicesText from "../words/devices";

/** `wsn-1.7`: how decisions name a waiting device. */
export function nameOf(tuple: Tuple): string {
  return tuple.key.split(".").slice(2).join(".");
}

/** It is of the list of ignored devices, not one that waits. */
export function isIgnored(tuple: Tuple): boolean {
  return tuple.json.by !== undefined;
}

/** What the row says first. */
export function shownNameOf(tuple: Tuple): string {
  return textOf(tuple.json.name) || nameOf(tuple);
}

export function searchedOf(tuple: Tuple): string {
  const about = tuple.json;
  return [nameOf(tuple), about.name, about.model, about.type, about.address, about.why].map(textOf).join(" ") + ` ${nameOf(tuple)}`;
}

/** What the device says it is: model or type, and what it has. */
function saysOf(tuple: Tuple): string {
  const about = tuple.json;
  const parts = (["sensors", "actuators", "properties"] as const).flatMap((kind) => {
    const value = about[kind];
    const names = list(value);
    const count = Array.isArray(value) ? value.length : number(value);
    if (count === 0) return [];
    return names.length > 0 && names.length <= 3 ? [names.join(", ")] : [text.has(kind, count)];
  });
  return [textOf(about.model) || textOf(about.type), ...parts].filter(Boolean).join(" · ");
}

interface Use {
  chosen: ReadonlySet<string>;
  toggle(tuple: Tuple): void;
  decide(verb: Verb, tuples: Tuple[]): void;
  undo(decision: Decision): void;
  decisions: Decisions;
  mayDecide: boolean;
  /** The list is that of ignored devices. */
  ignoring: boolean;
}

export function inboxColumns(use: Use): Column<Tuple>[] {
  const { mayDecide, ignoring } = use;
  const about = (tuple: Tuple, member: string) => textOf(tuple.json[member]);
  const by = (member: string) => (a: Tuple, b: Tuple) => compareNatural(about(a, member), about(b, member));
  const columns: Column<Tuple>[] = [
    {
      id: "chosen",
      title: devicesText.select,
      spoken: true,
      width: "34px",
      cell: (tuple) => <Pick tuple={tuple} use={use} />,
    },
    {
      id: "name",
      title: text.device,
      width: "minmax(160px,1.2fr)",
      phone: "main",
      compare: (a, b) => compareNatural(shownNameOf(a), shownNameOf(b)) || compareNatural(nameOf(a), nameOf(b)),
      cell: (tuple) => (
        <span class="point-name">
          <span>
            {phone.value && mayDecide && <Pick tuple={tuple} use={use} />}
            {shownNameOf(tuple)}
          </span>
          <span class="muted">{[about(tuple, "name") && nameOf(tuple), addressOf(tuple)].filter(Boolean).join(" · ")}</span>
        </span>
      ),
    },
    {
      id: "says",
      title: text.says,
      width: "minmax(160px,1.4fr)",
      phone: "sub",
      compare: by("model"),
      cell: (tuple) => <span title={saysOf(tuple)}>{saysOf(tuple) || "–"}</span>,
    },
    {
      id: "why",
      title: ignoring ? text.ignoredBy : text.why,
      width: "minmax(160px,1.4fr)",
      phone: "fourth",
      compare: by("why"),
      cell: (tuple) => <span class="uncut">{prose(whyOf(tuple) || "–")}</span>,
    },
    {
      id: "since",
      title: text.since,
      width: "72px",
      numeric: true,
      phone: "side",
      compare: (a, b) => number(b.json.since) - number(a.json.since),
      cell: (tuple) => <Age time={number(tuple.json.since)} />,
    },
    { id: "decision", title: text.decision, width: "196px", phone: "third", cell: (tuple) => <Deciding tuple={tuple} use={use} /> },
  ];
  return mayDecide ? columns : columns.filter(({ id }) => id !== "chosen" && id !== "decision");
}

export function whyOf({ json }: Tuple): string {
  return [textOf(json.by), textOf(json.why)].filter(Boolean).join(": ");
}

function Pick({ tuple, use }: { tuple: Tuple; use: Use }) {
  return (
    <input
      type="checkbox"
      tabIndex={-1}
      aria-label={`${devicesText.select} ${nameOf(tuple)}`}
      checked={use.chosen.has(tuple.id)}
      onChange={() => use.toggle(tuple)}
    />
  );
}

function addressOf(tuple: Tuple): string {
  const address = textOf(tuple.json.address);
  return address && !nameOf(tuple).endsWith(`.${address}`) ? deviceText.address(address) : "";
}

/** The device whose button was used: the button that takes its place gets the focus. */
let used = "";

function Deciding({ tuple, use }: { tuple: Tuple; use: Use }) {
  const decision = use.decisions.of(tuple.id);
  const name = nameOf(tuple);
  const button = useRef<HTMLButtonElement>(null);
  useLayoutEffect(() => {
    if (used === tuple.id) button.current?.focus({ preventScroll: true });
    if (used === tuple.id) used = "";
  }, [decision]);
  const uses = (call: () => void) => () => {
    used = tuple.id;
    call();
  };
  if (decision) {
    return (
      <span class="decide">
        <span class="muted">{decision.until > 0 ? text.decided[decision.verb] : text.sending}</span>
        {decision.until > 0 && (
          <button ref={button} type="button" class="small" aria-label={`${text.undo} ${name}`} onClick={uses(() => use.undo(decision))}>
            {text.undo}
          </button>
        )}
      </span>
    );
  }
  return (
    <span class="decide">
      <button
        ref={button}
        type="button"
        class="small accent"
        aria-label={`${text.approve} ${name}`}
        onClick={uses(() => use.decide("approve", [tuple]))}
      >
        {text.approve}
      </button>
      {!use.ignoring && (
        <button type="button" class="small" aria-label={`${text.ignore} ${name}`} onClick={uses(() => use.decide("ignore", [tuple]))}>
          {text.ignore}
        </button>
      )}
    </span>
  );
}
