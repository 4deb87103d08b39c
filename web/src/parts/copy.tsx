import { useState } from "preact/hooks";
import * as words from "../words/frame";
import { announce } from "./notices";

/** Copies a text as it is. Browsers offer the clipboard only under TLS and on loopback; elsewhere a selection has to do. A long text may be made when it is wanted. */
export function CopyButton({ text, label = words.copy }: { text: string | (() => string); label?: string }) {
  const [done, setDone] = useState("");
  const copy = async () => {
    const result = (await copyText(typeof text === "string" ? text : text())) ? words.copied : words.notCopied;
    announce(result);
    setDone(result);
    setTimeout(() => setDone(""), 1500);
  };
  return (
    <button type="button" class="small" onClick={() => void copy()}>
      {done || label}
    </button>
  );
}

/** Whether it was copied: the user may have forbidden the clipboard. */
async function copyText(text: string): Promise<boolean> {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    return copySelected(text);
  }
}

function copySelected(text: string): boolean {
  const field = document.createElement("textarea");
  field.value = text;
  document.body.append(field);
  field.select();
  const copied = document.execCommand("copy");
  field.remove();
  return copied;
}
