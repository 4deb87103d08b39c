import { catalog } from "../app";
import { notWritten } from "../words/plots";

/** What the user should know of the history; nothing while it is written. */
export function NotWritten() {
  const failing = [...catalog.histories.values()].find(({ json }) => json.state === "failing");
  return failing && <p class="strip bad">{`${notWritten}${failing.json.reason}`}</p>;
}
