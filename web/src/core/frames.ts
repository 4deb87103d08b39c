// The frames of the WebSocket, version 1 of the API: one JSON object each.

/** What a subscription with `full` adds to a tuple, or why its value is missing. */
export interface Extra {
  m?: string; // media type
  c?: number; // creator
  w?: number; // write time
  e?: number; // expiry time, 0 = never
  p?: boolean; // the owner is present
  size?: number; // the value is not text, or longer than 16 KiB: bytes
}

/** Key number, value, sequence, user time (write time if there is none). */
export type SetEntry = [number, string | null, number, number, Extra?];

/** What a subscription delivers. */
export interface Delivery {
  s: number;
  k?: Record<string, string>;
  set?: SetEntry[];
  gone?: [number, string][];
  snapshot?: number;
  absent?: number[];
  present?: number[];
}

export interface Component {
  id: number;
  name: string;
  host: string;
  program: string;
  version?: string;
  devices?: number; // of an island
  since: number;
}

export interface Message {
  from: number;
  network?: string;
  device?: string;
  type: string;
  value?: string;
  b64?: string;
}

export interface FrameError {
  code: string;
  text: string;
}

/** The answer to a request, and what follows on a command. */
export interface Answer {
  id: number;
  ok?: boolean;
  error?: FrameError;
  subscription?: number;
  verdict?: string;
  request?: number;
  state?: string;
  reason?: string;
  until?: number;
  final?: boolean;
  tuple?: Record<string, unknown>;
  role?: string;
}

/** Frames that answer no request. */
export interface Notice {
  alive?: number;
  slow?: boolean;
  lost?: { s: number; events: number };
  message?: Message;
  islands?: Component[];
  components?: Component[];
}

export type Frame = Partial<Delivery> & Partial<Answer> & Notice;

export function parseFrame(text: string): Frame | null {
  try {
    const frame: unknown = JSON.parse(text);
    return typeof frame === "object" && frame !== null && !Array.isArray(frame) ? (frame as Frame) : null;
  } catch {
    return null;
  }
}
