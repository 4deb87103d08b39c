import { useState } from "preact/hooks";
import * as words from "../words/frame";
import { announce } from "./notices";

/** Copies a text as it is. Browsers offer the clipboard only under TLS and on loopback; elsewhere a selection has to do. A long text may be made when it is wanted. */
export function CopyButton({ text, label = words.copy }: { text: string | (() => string); label?: string }) {
  const [done, setDone] = useState(false);
  const copy = async () => {
    await copyText(typeof text === "string" ? text : text());
    announce(words.copied);
    setDone(true);
    setTimeout(() => setDone(false), 1500);
  };
  return (
    <button type="button" class="small" onClick={() => void copy()}>
      {done ? words.copied : label}
    </button>
  );
}

async function copyText(text: string): Promise<void> {
  if (navigator.clipboard) return navigator.clipboard.writeText(text);
  const field = document.createElement("textarea");
  field.value = text;
  document.body.append(field);
  field.select();
  document.execCommand("copy");
  field.remove();
  return undefined;
}
