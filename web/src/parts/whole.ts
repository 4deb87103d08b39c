import { useEffect, useState } from "preact/hooks";
import { RestError, tupleBytes } from "../core/rest";
import type { Tuple } from "../core/store";

/** The whole text of a tuple; subscriptions leave long values out. Null while it is being read. */
export function useWhole(tuple: Tuple | undefined): { text: string | null; error: string } {
  const [read, setRead] = useState({ sequence: -1, text: "", error: "" });
  const left = tuple !== undefined && tuple.value === null;
  useEffect(() => {
    if (!tuple || !left) return undefined;
    let ended = false;
    const { owner, key, sequence } = tuple;
    tupleBytes(owner, key).then(
      (bytes) => !ended && setRead({ sequence, text: new TextDecoder().decode(bytes), error: "" }),
      (error: unknown) =>
        !ended && setRead({ sequence, text: "", error: error instanceof RestError ? `${error.code}: ${error.message}` : String(error) }),
    );
    return () => {
      ended = true;
    };
  }, [tuple, left, tuple?.sequence]);
  if (!tuple) return { text: null, error: "" };
  if (!left) return { text: tuple.value, error: "" };
  return read.sequence < 0 ? { text: null, error: "" } : { text: read.text, error: read.error };
}
