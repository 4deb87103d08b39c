import { words } from "../words";
import { CopyButton } from "./copy";
import { Empty } from "./state";

/** No island is there: the command that says why. */
export function NoIsland() {
  return (
    <Empty title={words.noIsland.title} whole>
      <p>{words.noIsland.text}</p>
      <p>
        <code>{words.noIsland.command}</code> <CopyButton text={words.noIsland.command} />
      </p>
    </Empty>
  );
}
