import type { ComponentChildren } from "preact";

/** What programs say: between backquotes stands an option or a command, which is shown as code. */
export function prose(text: string): ComponentChildren {
  const parts = text.split("`");
  if (parts.length === 1 || parts.length % 2 === 0) return text;
  return parts.map((part, at) => (at % 2 === 1 ? <code>{part}</code> : part));
}
