import { mayBe, server } from "../app";
import * as words from "../words/frame";

/** Why nothing can be changed here, where the role does not permit it. */
export function MayNot({ needs }: { needs: "command" | "admin" }) {
  if (mayBe(needs)) return null;
  return <p class="may-not muted">{words.mayNot(server.value?.caller.role ?? "", needs)}</p>;
}
