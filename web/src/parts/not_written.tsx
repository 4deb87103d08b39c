import { catalog } from "../app";
import { text } from "../core/catalog";
import { notWritten } from "../words/plots";
import { prose } from "./prose";

type Owner = { id: number; name: string } | null;

/** Which of these owners' histories fail, and why; nothing while they are written. What other components say is not shown. */
export function NotWritten({ owners }: { owners: Owner[] }) {
  return [...catalog.histories.values()].map((tuple) => {
    const owner = owners.find((one) => one?.id === tuple.owner);
    return (
      owner &&
      tuple.json.state === "failing" && (
        <p key={tuple.id} class="strip bad">
          {prose(notWritten(owner.name, text(tuple.json.reason)))}
        </p>
      )
    );
  });
}
