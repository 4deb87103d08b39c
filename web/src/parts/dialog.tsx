import type { ComponentChildren } from "preact";
import { useLayoutEffect, useRef } from "preact/hooks";
import * as words from "../words/frame";

/** A modal dialog as long as it is in the document; Escape and a click beside it close it. */
export function Dialog({
  title,
  onClose,
  children,
  bare,
  wide,
}: {
  title: string;
  onClose(): void;
  children: ComponentChildren;
  bare?: boolean;
  wide?: boolean;
}) {
  const dialog = useRef<HTMLDialogElement>(null);
  // Before the next key arrives: what is typed after `/` is for the dialog.
  useLayoutEffect(() => {
    const element = dialog.current;
    element?.showModal();
    return () => element?.close();
  }, []);
  return (
    <dialog
      ref={dialog}
      aria-label={title}
      class={wide ? "wide" : undefined}
      onClose={onClose}
      onKeyDown={(event) => event.stopPropagation()}
      onClick={(event) => {
        if (event.target === dialog.current) onClose();
      }}
    >
      <div class="dialog-body">
        {!bare && (
          <header>
            <h2>{title}</h2>
            <button type="button" class="plain" onClick={onClose}>
              {words.close}
            </button>
          </header>
        )}
        {children}
      </div>
    </dialog>
  );
}
