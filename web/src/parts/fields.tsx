import { setQuery } from "../core/router";
import * as words from "../words/frame";

/** The text that a list is filtered by; it is in the address. */
export function FilterField({ value, label = words.tableFilter }: { value: string; label?: string }) {
  return (
    <input
      type="search"
      aria-label={label}
      placeholder={label}
      value={value}
      onInput={(event) => setQuery({ q: event.currentTarget.value })}
    />
  );
}

interface ChoiceProps {
  label: string;
  /** What stands for no choice; without, there is always one. */
  none?: string;
  value: string;
  values: readonly string[];
  name?(value: string): string;
  onChange(value: string): void;
  /** The label is for screen readers only. */
  spoken?: boolean;
}

/** One of several values. A value that is none of them is offered, too. */
export function Choice({ label, none, value, values, name = (own) => own, onChange, spoken }: ChoiceProps) {
  return (
    <label class="field">
      <span class={spoken ? "spoken" : ""}>{label}</span>
      <select value={value} onChange={(event) => onChange(event.currentTarget.value)}>
        {none && <option value="">{none}</option>}
        {(value === "" || values.includes(value) ? values : [...values, value]).map((own) => (
          <option key={own} value={own}>
            {name(own)}
          </option>
        ))}
      </select>
    </label>
  );
}
