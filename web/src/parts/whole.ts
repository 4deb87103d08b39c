import { useEffect, useState } from "preact/hooks";
import { OneAtATime } from "../core/one_at_a_time";
import { RestError, tupleBytes } from "../core/rest";
import type { Tuple } from "../core/store";

/**
 * The whole text of a tuple; subscriptions leave long values out. Null while it is being read. Of a tuple that changes
 * faster than it can be read, each text that was read is seen.
 */
export function useWhole(tuple: Tuple | undefined): { text: string | null; error: string } {
  const [read, setRead] = useState<{ text: string | null; error: string }>({ text: null, error: "" });
  const left = tuple !== undefined && tuple.value === null;
  const [reader, setReader] = useState<OneAtATime | null>(null);
  useEffect(() => {
    setRead({ text: null, error: "" });
    if (!tuple || !left) return undefined;
    let ended = false;
    const reading = new OneAtATime(() =>
      tupleBytes(tuple.owner, tuple.key).then(
        (bytes) => {
          if (!ended) setRead({ text: new TextDecoder().decode(bytes), error: "" });
        },
        (error: unknown) => {
          if (!ended) setRead({ text: "", error: error instanceof RestError ? `${error.code}: ${error.message}` : String(error) });
        },
      ),
    );
    setReader(reading);
    return () => {
      ended = true;
      reading.end();
      setReader(null);
    };
  }, [tuple, left]);
  useEffect(() => reader?.ask(), [reader, tuple?.sequence]);
  if (!tuple) return { text: null, error: "" };
  return left ? read : { text: tuple.value, error: "" };
}
