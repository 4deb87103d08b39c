import type { FrameError } from "./frames";
import * as words from "../words/frame";
import { heardAnswer } from "./server_time";

/** What `GET /api/v1` says. */
export interface ServerInfo {
  version: string;
  name: string;
  id: number;
  release: string;
  /** Where a server that belongs to no island looks for islands. */
  place?: { text: string; options: string };
  history: boolean;
  tokens: boolean;
  caller: { name: string; role: string };
}

export class RestError extends Error {
  constructor(
    readonly code: string,
    text: string,
    readonly status: number,
  ) {
    super(text);
  }
}

async function failure(response: Response): Promise<RestError> {
  try {
    const { error } = (await response.json()) as { error: FrameError };
    return new RestError(error.code, error.text, response.status);
  } catch {
    return new RestError("failed", words.lineAnswered(response.status), response.status);
  }
}

/** A request to the API of the page's own server; errors carry its code and text. */
export async function ask(path: string, init: RequestInit = {}): Promise<Response> {
  let response: Response;
  const since = Date.now() / 1000;
  try {
    response = await fetch(`/api/v1${path}`, { cache: "no-store", ...init });
  } catch {
    throw new RestError("unreachable", words.lineNoAnswer, 0);
  }
  heardAnswer(response.headers.get("date"), since);
  if (!response.ok) throw await failure(response);
  return response;
}

export async function askJson<T>(path: string, init: RequestInit = {}): Promise<T> {
  return (await (await ask(path, init)).json()) as T;
}

/** The path of a tuple: `/tuples/6541/proxy.x.y`. */
export function tuplePath(owner: number, key: string): string {
  return `/tuples/${owner}/${encodeURIComponent(key)}`;
}

/** The exact bytes of a tuple. */
export async function tupleBytes(owner: number, key: string): Promise<Uint8Array> {
  return new Uint8Array(await (await ask(`${tuplePath(owner, key)}?raw`)).arrayBuffer());
}
