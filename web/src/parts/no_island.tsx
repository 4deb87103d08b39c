import { server } from "../app";
import * as words from "../words/frame";
import { CopyButton } from "./copy";
import { Empty } from "./state";

/** No island is there: the command that says why. */
export function NoIsland() {
  const place = server.value?.place;
  const command = words.noIslandCommand(place?.options ?? "");
  return (
    <Empty title={words.noIslandTitle} whole>
      <p>{words.noIslandText(place?.text ?? "")}</p>
      <p>
        <code>{command}</code> <CopyButton text={command} />
      </p>
    </Empty>
  );
}
