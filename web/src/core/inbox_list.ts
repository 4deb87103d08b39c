import type { Step } from "./decisions";
import type { Answer } from "./frames";

/** The server takes so many names in a list. */
export const longestList = 1000;

/** Decisions about one inbox, as `POST /api/v1/inbox` takes them. */
export interface InboxList {
  body: { island: number; approve?: string[]; ignore?: string[] };
  steps: Step[]; // in the order of the list
}

/** What the server did with one name of a list. */
export interface Decided {
  state: string;
  error?: { code: string; text: string };
}

/** The tuple of a device names it; the inbox itself is set to `approve PATTERN`. */
function nameIn({ key, value }: Step): string {
  const blank = value.indexOf(" ");
  if (blank >= 0) return value.slice(blank + 1);
  return key
    .slice(key.indexOf(":") + 1)
    .split(".")
    .slice(2)
    .join(".");
}

/** The same steps as few lists: one for each island, word and `longestList` names. */
export function listsOf(steps: Step[]): InboxList[] {
  const lists: InboxList[] = [];
  const open = new Map<string, InboxList>();
  for (const step of steps) {
    const island = Number(step.key.split(":", 1)[0]);
    const word = step.value.startsWith("ignore") ? "ignore" : "approve";
    let list = open.get(`${island} ${word}`);
    if (!list || list.steps.length === longestList) {
      list = { body: { island, [word]: [] }, steps: [] };
      lists.push(list);
      open.set(`${island} ${word}`, list);
    }
    list.body[word]?.push(nameIn(step));
    list.steps.push(step);
  }
  return lists;
}

/** Bytes of these requests. */
export function sizeOf(lists: InboxList[]): number {
  return lists.reduce((sum, { body }) => sum + new Blob([JSON.stringify(body)]).size, 0);
}

/** The answer of one name, in the form of the answer to a set. */
export function answerOf(decided: Decided | undefined): Answer {
  return { id: 0, ok: decided?.state === "applied", error: decided?.error };
}
