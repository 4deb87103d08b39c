import { useState } from "preact/hooks";
import { catalog, chosenIsland } from "../app";
import { text as textOf } from "../core/catalog";
import { type Decisions, matchesPattern, type Verb } from "../core/decisions";
import type { Tuple } from "../core/store";
import { Choice } from "../parts/fields";
import { phone } from "../parts/screen";
import * as text from "../words/inbox";
import * as words from "../words/frame";
import { nameOf } from "./inbox_columns";

export function inboxesOf(island: number): Tuple[] {
  return [...catalog.inboxes.values()].filter(({ owner }) => !island || owner === island);
}

function fits(pattern: string, tuple: Tuple): boolean {
  const name = nameOf(tuple);
  const address = `${name.split(".", 1)[0]}.${textOf(tuple.json.address)}`;
  return matchesPattern(pattern, name) || matchesPattern(pattern, address);
}

interface Props {
  /** All that wait, of all islands. */
  waiting: Iterable<Tuple>;
  ignored: number;
  decisions: Decisions;
}

/**
 * Decides about all that a pattern names, whatever the filter of the list shows; an exact address also names an ignored
 * device.
 */
export function PatternForm({ waiting, ignored, decisions }: Props) {
  const [pattern, setPattern] = useState("");
  const [inbox, setInbox] = useState("");
  const inboxes = inboxesOf(chosenIsland());
  const target = inboxes.find(({ id }) => id === inbox) ?? inboxes[0];
  if (!target) return null;
  const own = [...waiting].filter(({ id }) => id.startsWith(`${target.id}.`));
  if (own.length === 0 && ignored === 0) return null;
  const matching = pattern === "" ? [] : own.filter((tuple) => !decisions.of(tuple.id) && fits(pattern, tuple));
  const exact = pattern.includes(".") && !/[*?]/.test(pattern);
  const decide = (verb: Verb) => {
    decisions.decide(
      verb,
      matching.map(({ id }) => id),
      [{ key: target.id, value: `${verb} ${pattern}` }],
    );
    setPattern("");
  };
  const usable = matching.length > 0 || exact;
  return (
    <details class="fold pattern-fold" open={!phone.value}>
      <summary hidden={!phone.value}>{text.pattern}</summary>
      <form
        class="pattern"
        onSubmit={(event) => {
          event.preventDefault();
          if (usable) decide("approve");
        }}
      >
        <label class="field">
          <span>{text.pattern}</span>
          <input
            type="text"
            spellcheck={false}
            placeholder="wsn-1.*"
            title={text.patternHint}
            value={pattern}
            onInput={(event) => setPattern(event.currentTarget.value.trim())}
          />
        </label>
        {inboxes.length > 1 && (
          <Choice
            label={words.islandsLabel}
            value={target.id}
            values={inboxes.map(({ id }) => id)}
            name={(id) => id.split(":", 1)[0] ?? ""}
            onChange={setInbox}
          />
        )}
        <button type="submit" disabled={!usable}>
          {matching.length > 0 ? text.approveMany(matching.length) : text.approve}
        </button>
        <button type="button" disabled={!usable} onClick={() => decide("ignore")}>
          {matching.length > 0 ? text.ignoreMany(matching.length) : text.ignore}
        </button>
        <span class="muted">
          {pattern === ""
            ? text.patternHint
            : matching.length === 0
              ? exact
                ? text.exactly
                : text.noMatch
              : text.matching(matching.length)}
        </span>
      </form>
    </details>
  );
}
