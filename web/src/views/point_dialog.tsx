import { useState } from "preact/hooks";
import { catalog, mayBe, nameOfPoint } from "../app";
import type { Point } from "../core/catalog";
import { arrangedIn, pinOf, toggled } from "../core/overview";
import { CopyButton } from "../parts/copy";
import { Dialog } from "../parts/dialog";
import { MayNot } from "../parts/may_not";
import * as text from "../words/commission";
import { arrange, mayArrange } from "./arrangement";

/** What people call a point, and whether its curve is on the overview. */
export function PointDialog({ point, onClose }: { point: Point; onClose(): void }) {
  const shown = nameOfPoint(point);
  const { owner } = point.device;
  const pin = pinOf(point);
  const { pins } = arrangedIn(catalog.overviews.get(owner));
  const [name, setName] = useState(shown === point.id ? "" : shown);
  const [pinned, setPinned] = useState(pins.includes(pin));
  const save = (event: Event) => {
    event.preventDefault();
    const given = name.trim();
    if (given !== (shown === point.id ? "" : shown)) arrange(owner, { names: { [pin]: given } });
    if (pinned !== pins.includes(pin)) arrange(owner, { pins: toggled(pins, pin) });
    onClose();
  };
  return (
    <Dialog title={text.pointTitle(`${point.device.name} · ${shown}`)} onClose={onClose}>
      <form class="form-grid" onSubmit={save}>
        {mayArrange() ? (
          <>
            <label class="field">
              <span>{text.name}</span>
              <input
                type="text"
                autofocus
                maxLength={100}
                disabled={!mayBe("admin")}
                placeholder={text.pointHint(point.id)}
                value={name}
                onInput={(event) => setName(event.currentTarget.value)}
              />
            </label>
            {!mayBe("admin") && <MayNot needs="admin" />}
            {point.kind !== "property" && (
              <label class="check">
                <input type="checkbox" checked={pinned} onChange={(event) => setPinned(event.currentTarget.checked)} />
                {text.pinned}
              </label>
            )}
          </>
        ) : mayBe("command") ? (
          <p class="muted">{text.noArrangement}</p>
        ) : (
          <MayNot needs="command" />
        )}
        <p>
          <code class="key">{point.path}</code> <CopyButton text={point.path} />
        </p>
        {mayArrange() && (
          <div class="actions">
            <button type="submit" class="primary">
              {text.save}
            </button>
          </div>
        )}
      </form>
    </Dialog>
  );
}
