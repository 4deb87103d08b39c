import * as words from "../words/frame";
import { CopyButton } from "./copy";
import { Empty } from "./state";

/** No island is there: the command that says why. */
export function NoIsland() {
  return (
    <Empty title={words.noIslandTitle} whole>
      <p>{words.noIslandText}</p>
      <p>
        <code>{words.noIslandCommand}</code> <CopyButton text={words.noIslandCommand} />
      </p>
    </Empty>
  );
}
