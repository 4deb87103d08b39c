import { useEffect, useState } from "preact/hooks";
import { loadingOf, baseFeeds } from "../app";
import { useFrame } from "../core/redraw";
import { goToList, hrefToList } from "../core/router";
import { optionsText, readSample, type SampleField } from "../core/sample";
import { Choice } from "../parts/fields";
import { Icon } from "../parts/icons";
import { MayNot } from "../parts/may_not";
import { Empty, Loaded } from "../parts/state";
import { useWhole } from "../parts/whole";
import * as words from "../words/frame";
import * as text from "../words/setup";
import { type Change, ChangeDialog } from "./change_dialog";
import { IslandChoice, type Target, useTarget } from "./setup_target";

interface NetworkType {
  type: string;
  summary: string;
  sample: string;
}

function typesOf(json: string | null): NetworkType[] {
  try {
    const types: unknown = JSON.parse(json ?? "[]");
    return Array.isArray(types) ? (types as NetworkType[]) : [];
  } catch {
    return [];
  }
}

/** A form made of the sample of a type; the island checks what it says before anything is written. */
export function AddNetwork() {
  useFrame();
  const target = useTarget();
  const { text: json } = useWhole(target.networks);
  const types = typesOf(json);
  const loading = target.base === "" || (target.networks !== undefined && json === null) ? "loading" : loadingOf(baseFeeds);
  return (
    <section class="view setup">
      <div class="toolbar">
        <a class="button plain" href={hrefToList("networks")} aria-label={words.close}>
          <Icon name="back" size={16} />
        </a>
        <h1>{text.addTitle}</h1>
        <IslandChoice owner={target.owner} />
      </div>
      <MayNot needs="admin" />
      <Loaded state={loading} empty={types.length === 0 && <Empty title={text.noTypes} />}>
        <NetworkForm key={target.owner} target={target} types={types} />
      </Loaded>
    </section>
  );
}

function NetworkForm({ target, types }: { target: Target; types: NetworkType[] }) {
  const [type, setType] = useState(types.find((one) => one.type === "knx")?.type ?? types[0]?.type ?? "");
  const [id, setId] = useState("");
  const [values, setValues] = useState<Record<string, string>>({});
  const [more, setMore] = useState("");
  const [change, setChange] = useState<Change | null>(null);
  const chosen = types.find((one) => one.type === type);
  const { fields, blocks } = readSample(chosen?.sample ?? "");
  useEffect(() => {
    setValues({});
    setMore("");
  }, [type]);
  const valueOf = ({ key, value, optional }: SampleField) => values[key] ?? (optional ? "" : value);
  const check = (event: Event) => {
    event.preventDefault();
    const options = optionsText(
      type,
      fields.map((field) => [field.key, valueOf(field)]),
      more,
    );
    setChange({ do: "add", network: id.trim(), options });
  };
  const row = (field: SampleField) => (
    <label class="field" key={field.key}>
      <span>{field.key}</span>
      <input
        type="text"
        spellcheck={false}
        placeholder={field.value}
        value={valueOf(field)}
        onInput={(event) => setValues({ ...values, [field.key]: event.currentTarget.value })}
      />
      {field.about && <small class="muted">{field.about}</small>}
    </label>
  );
  const rare = fields.filter(({ optional }) => optional);
  return (
    <div class="setup-form">
      <form class="form-grid" onSubmit={check}>
        <Choice label={text.type} value={type} values={types.map((one) => one.type)} onChange={setType} />
        <p class="muted">{chosen?.summary}</p>
        <label class="field">
          <span>{text.network}</span>
          <input
            type="text"
            required
            maxLength={64}
            pattern="[A-Za-z0-9_\-]+"
            spellcheck={false}
            placeholder={text.networkHint}
            value={id}
            onInput={(event) => setId(event.currentTarget.value)}
          />
        </label>
        {fields.filter(({ optional }) => !optional).map(row)}
        {rare.length > 0 && (
          <details key={type}>
            <summary>{text.further(rare.length)}</summary>
            <div class="form-grid">{rare.map(row)}</div>
          </details>
        )}
        <label class="more-options">
          <span class="muted">{text.more}</span>
          <textarea rows={more ? 10 : 3} spellcheck={false} value={more} onInput={(event) => setMore(event.currentTarget.value)} />
        </label>
        <details>
          <summary>{text.sample}</summary>
          <pre class="content" tabIndex={0}>
            {chosen?.sample}
          </pre>
        </details>
        <div class="actions">
          <button type="submit" class="primary">
            {text.check}
          </button>
          {blocks && more === "" && (
            <button type="button" onClick={() => setMore(blocks)}>
              {text.blocks}
            </button>
          )}
        </div>
      </form>
      {change && (
        <ChangeDialog
          owner={target.owner}
          base={target.base}
          change={change}
          onClose={() => setChange(null)}
          onDone={() => goToList("networks")}
        />
      )}
    </div>
  );
}
